"""Meshes from files: each format, the names in it, and what no mesh can be made of."""

from __future__ import annotations

import os
import re
import signal
import sys
import threading
from types import SimpleNamespace

import meshio
import numpy as np
import pytest
from meshio.gmsh import meshio_to_gmsh_type

from msvalidate.problem import SHAPES, Box, Mesh, ProblemError
from msvalidate.springs.bodies import geometry_file, gmsh_mesher
from msvalidate.springs.bodies.mesh_file import read_mesh
from reference_fem import box_discretisation
from reference_fem.mesh import ELEMENTS
from tests.table import refused, stored_rows, table

# Gmsh lists the nodes of the others, solids with mid-sides, in an order of its own.
AS_IN_VTK = [name for name, kind in ELEMENTS.items() if kind.dim == 2 or kind.degree == 1]
FORMATS = ("gmsh22", "gmsh41", "vtu", "vtk", "vtk42", "abaqus")


def box_mesh(element, cells=(3, 2, 2)):
    """A box of 2 x 1 (x 0.5) m with its left and right sides named."""
    shape = ELEMENTS[element].shape
    d = SHAPES[shape].dim
    box = Box((2.0, 1.0, 0.5)[:d])
    body = box_discretisation(box, cells[:d], element)
    mesh = Mesh(body.points, body.cells, shape)
    sides = {
        name: mesh.surface[box.side(name).select(mesh.points, box.tolerance)[mesh.surface].all(1)]
        for name in ("left", "right")
    }
    return mesh.named(sides)


def in_space(points):
    return np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])


def written(mesh, folder, form, binary=False):
    """The mesh in a file of a format, and what its left and right sides are called there."""
    blocks = [(mesh.shape, mesh.cells)]
    blocks += [(SHAPES[mesh.shape].facet.name, facets) for facets in mesh.boundaries.values()]
    tags = [np.full(len(cells), tag) for tag, (_, cells) in zip((7, 1, 2), blocks, strict=True)]
    points, names = in_space(mesh.points), ("left", "right")
    if form == "gmsh41":
        return gmsh41(mesh, folder / "box.msh"), names
    if form == "gmsh22":
        path = folder / "box.msh"
        groups = {"left": [1, mesh.dim - 1], "right": [2, mesh.dim - 1], "all": [7, mesh.dim]}
        content = meshio.Mesh(
            points,
            blocks,
            cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
            field_data={name: np.array(group) for name, group in groups.items()},
        )
        content.write(path, file_format=form, binary=binary)
    elif form == "abaqus":
        path = folder / "box.inp"
        sets = {name: np.unique(facets) for name, facets in mesh.boundaries.items()}
        meshio.Mesh(points, blocks[:1], point_sets=sets).write(path)
    else:
        path = folder / f"box.{form[:3]}"
        content = meshio.Mesh(points, blocks, cell_data={"boundary": tags})
        content.write(path, file_format=form, binary=binary)
        names = ("boundary:1", "boundary:2")
    return path, names


def gmsh41(mesh, path):
    """A file of Gmsh's format 4.1 by its manual: ours, not meshio's."""
    d = mesh.dim
    low, high = (" ".join(map(str, x)) for x in in_space(np.array(mesh.span).T))
    counts = [2 if axis == d - 1 else int(axis == d) for axis in range(4)]
    lines = ["$MeshFormat", "4.1 0 8", "$EndMeshFormat", "$PhysicalNames", "3"]
    lines += [f'{d - 1} 1 "left"', f'{d - 1} 2 "right"', f'{d} 7 "all"', "$EndPhysicalNames"]
    lines += ["$Entities", " ".join(map(str, counts))]
    lines += [f"{tag} {low} {high} 1 {tag} 0" for tag in (1, 2)] + [f"1 {low} {high} 1 7 0"]
    n = len(mesh.points)
    lines += ["$EndEntities", "$Nodes", f"1 {n} 1 {n}", f"{d} 1 0 {n}"]
    lines += [str(i + 1) for i in range(n)]
    lines += [" ".join(map(repr, x)) for x in in_space(mesh.points).tolist()]
    blocks = [(d - 1, tag, facets) for tag, facets in enumerate(mesh.boundaries.values(), 1)]
    blocks += [(d, 1, mesh.cells)]
    total = sum(len(cells) for _, _, cells in blocks)
    lines += ["$EndNodes", "$Elements", f"3 {total} 1 {total}"]
    number = 0
    for dim, tag, cells in blocks:
        kind = mesh.shape if dim == d else SHAPES[mesh.shape].facet.name
        lines += [f"{dim} {tag} {meshio_to_gmsh_type[kind]} {len(cells)}"]
        for cell in cells:
            number += 1
            lines += [" ".join(map(str, (number, *(cell + 1))))]
    path.write_text("\n".join([*lines, "$EndElements", ""]), encoding="utf-8")
    return path


# --- what is read ---------------------------------------------------------------------------------


@pytest.mark.parametrize("form", FORMATS)
@pytest.mark.parametrize("element", AS_IN_VTK)
def test_every_format_gives_the_mesh_back(element, form, tmp_path, capfd):
    mesh = box_mesh(element)
    path, names = written(mesh, tmp_path, form, binary=form == "vtu")  # whose text has 12 digits
    capfd.readouterr()  # the writer's warnings
    again = read_mesh(path)
    assert again == mesh
    for name, side in zip(names, ("left", "right"), strict=True):
        found = again.side(name)
        assert np.array_equal(found.corners(again.span), mesh.side(side).corners(mesh.span))
        assert found.measure(again.span) == pytest.approx(mesh.side(side).measure(mesh.span))
    assert capfd.readouterr() == ("", "")


def test_parameters_of_nodes_are_left_out(tmp_path):
    """Gmsh writes them beside the coordinates if Mesh.SaveParametric is 1."""
    path, _ = written(box_mesh("Q1"), tmp_path, "gmsh22")
    plain = read_mesh(path)
    head, nodes, rest = re.split(r"\$(?:End)?Nodes\n", path.read_text(encoding="utf-8"))
    count, *lines = nodes.splitlines()
    nodes = "\n".join([count, *(f"{line} 2 1 0.5 1e9" for line in lines)])
    text = f"{head}$ParametricNodes\n{nodes}\n$EndParametricNodes\n{rest}"
    path.write_text(text, encoding="utf-8")
    mesh = read_mesh(path)
    assert np.array_equal(mesh.points, plain.points)
    assert np.array_equal(mesh.cells, plain.cells)
    path.write_text(text.replace("2.2 0", "2.2 1"), encoding="utf-8")
    with refused("Mesh.SaveParametric = 0"):
        read_mesh(path)


def test_gmsh_order_of_quadratic_cells(tmp_path):
    # Gmsh's manual, "Node ordering": its edges and faces are not in VTK's order.
    corners = SHAPES["hexahedron"].nodes
    edges = ["01", "03", "04", "12", "15", "23", "26", "37", "45", "47", "56", "67"]
    faces = ["0321", "0154", "0473", "1265", "2376", "4567"]
    groups = [[int(c) for c in group] for group in (*edges, *faces, "01234567")]
    points = np.vstack([corners, [corners[group].mean(axis=0) for group in groups]])
    assert read_mesh(one_cell(tmp_path, points, 12)).volume == pytest.approx(1)
    corners = SHAPES["tetra"].nodes
    groups = [[0, 1], [1, 2], [0, 2], [0, 3], [2, 3], [1, 3]]
    points = np.vstack([corners, [corners[group].mean(axis=0) for group in groups]])
    assert read_mesh(one_cell(tmp_path, points, 11)).volume == pytest.approx(1 / 6)


def one_cell(folder, points, kind):
    path = folder / "cell.msh"
    lines = ["$MeshFormat", "2.2 0 8", "$EndMeshFormat", "$Nodes", str(len(points))]
    lines += [f"{i + 1} {x} {y} {z}" for i, (x, y, z) in enumerate(points)]
    nodes = " ".join(str(i + 1) for i in range(len(points)))
    lines += ["$EndNodes", "$Elements", "1", f"1 {kind} 2 0 1 {nodes}", "$EndElements", ""]
    path.write_text("\n".join(lines), encoding="utf-8")
    return path


def test_unit_is_a_factor(tmp_path):
    mesh = box_mesh("Q1")
    path, _ = written(mesh, tmp_path, "vtu")
    small = read_mesh(path, unit=1e-3)
    assert small.volume == pytest.approx(1e-6 * mesh.volume)
    assert small.points == pytest.approx(mesh.points * 1e-3, abs=1e-14)  # 12 digits
    for wrong in (0.0, -1.0, float("nan"), "mm"):
        with refused("mesh file: unit"):
            read_mesh(path, unit=wrong)


@pytest.mark.parametrize("element", [name for name, kind in ELEMENTS.items() if kind.dim == 2])
def test_cells_that_all_run_clockwise_are_turned(element, tmp_path):
    mesh = box_mesh(element)
    mirrored = in_space(mesh.points * [1.0, -1.0])
    meshio.Mesh(mirrored, [(mesh.shape, mesh.cells)]).write(tmp_path / "a.vtu")
    assert read_mesh(tmp_path / "a.vtu").volume == pytest.approx(mesh.volume)
    some = mesh.cells.copy()
    some[0, [0, 1]] = some[0, [1, 0]]
    meshio.Mesh(in_space(mesh.points), [(mesh.shape, some)]).write(tmp_path / "b.vtu")
    with refused("mesh file 'b.vtu': mesh cells: cell 0 at"):
        read_mesh(tmp_path / "b.vtu")


def test_plane_mesh_at_any_height(tmp_path):
    mesh = box_mesh("P1")
    lifted = in_space(mesh.points)
    lifted[:, 2] = 3.0
    meshio.Mesh(lifted, [("triangle", mesh.cells)]).write(tmp_path / "a.vtu")
    assert read_mesh(tmp_path / "a.vtu") == mesh
    lifted[4, 2] = 3.5
    meshio.Mesh(lifted, [("triangle", mesh.cells)]).write(tmp_path / "b.vtu")
    with refused("'b.vtu': plane cells, but z = 3.5 at point 4 and 3 at point 0"):
        read_mesh(tmp_path / "b.vtu")


def test_points_that_are_marked_name_sides(tmp_path):
    mesh = box_mesh("Q1")
    mark = np.isin(np.arange(len(mesh.points)), mesh.boundaries["left"]).astype(int)
    other = {
        "left": mark,
        "corner": np.eye(len(mark), dtype=int)[0],
        "number": np.arange(len(mark)),
    }
    meshio.Mesh(in_space(mesh.points), [("quad", mesh.cells)], point_data=other).write(
        tmp_path / "a.vtk"
    )
    assert set(read_mesh(tmp_path / "a.vtk").boundaries) == {"left"}


ABAQUS = """*HEADING
*NODE
1, 0., 0.
2, 1., 0.
3, 1., 1.
4, 0., 1.
*ELEMENT, TYPE=T2D2{first}
11, 4, 1
*ELEMENT, TYPE=CPS4
12, 1, 2, 3, 4
*ELEMENT, TYPE=T2D2, ELSET=Right
13, 2, 3
*NSET, NSET=Bottom
1, 2
*NSET, NSET=Pin
1
*ELSET, ELSET=Both
11, 13
*ELSET, ELSET=Steel
12
"""


@pytest.mark.parametrize("first", ["", ", ELSET=Left"])
def test_sets_of_abaqus(first, tmp_path):
    # meshio gives the first set named by an *ELEMENT line to the first block, whichever it names.
    path = tmp_path / "square.inp"
    path.write_text(ABAQUS.format(first=first), encoding="utf-8")
    mesh = read_mesh(path)
    assert set(mesh.boundaries) == {"Right", "Bottom", "Both"} | ({"Left"} if first else set())
    assert mesh.side("Right").corners(mesh.span).tolist() == [[1, 0], [1, 1]]
    assert mesh.side("Bottom").corners(mesh.span).tolist() == [[0, 0], [1, 0]]
    assert mesh.side("Both").measure(mesh.span) == pytest.approx(2)
    with refused("boundary 'Pin': the mesh has"):
        mesh.side("Pin")


# --- what is refused ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        *stored_rows("unreadable_meshes"),
        ("none.msh", None, "No such file or directory; give a file to read"),
    ],
)
def test_files_that_hold_no_mesh(name, content, message, tmp_path, capfd):
    if content is not None:
        (tmp_path / name).write_bytes(content.encode("latin-1"))
    with refused(message) as caught:
        read_mesh(tmp_path / name)
    assert "\n" not in str(caught.value)
    assert capfd.readouterr() == ("", "")


def test_what_is_no_path(tmp_path):
    (tmp_path / "folder.msh").mkdir()
    with refused("Is a directory; give a file to read"):
        read_mesh(tmp_path / "folder.msh")
    with refused("mesh file: 3; give a path"):
        read_mesh(3)
    with refused("give a file to read"):
        read_mesh("a\0b.msh")


@pytest.mark.parametrize("form", ["gmsh22", "gmsh41", "vtu", "vtk", "vtk42", "abaqus"])
@pytest.mark.parametrize("binary", [False, True])
def test_half_a_file_is_refused(form, binary, tmp_path, capfd):
    mesh = box_mesh("P1", (2, 2))
    path, names = written(mesh, tmp_path, form, binary)
    whole = path.read_bytes()
    capfd.readouterr()
    said = []
    cuts = range(1, len(whole) - 1, max(1, len(whole) // 60))
    for cut in cuts:
        path.write_bytes(whole[:cut])
        try:
            found = read_mesh(path)
        except ProblemError as error:
            said.append(str(error))
            continue
        if form == "abaqus":  # has no mark at its end: a whole last line may be missing
            continue
        assert found == mesh  # only names are missing, which asking for them tells
        assert not set(names) & set(found.boundaries)
    assert len(said) > 0.85 * len(cuts)
    assert not any("\n" in line or len(line) > 300 for line in said)
    assert capfd.readouterr() == ("", "")


def bad(points, blocks, folder, **more):
    path = folder / "bad.vtu"
    meshio.Mesh(in_space(np.array(points, dtype=float)), [*map(tuple, blocks)], **more).write(path)
    return path


SQUARE = [[0, 0], [1, 0], [1, 1], [0, 1]]


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize(("points", "blocks", "message"), stored_rows("mesh_files"))
def test_bad_meshes_in_files(points, blocks, message, tmp_path):
    path = bad(points, blocks, tmp_path)
    with refused("mesh file 'bad.vtu': ") as caught:
        read_mesh(path)
    assert message in str(caught.value)


def test_a_body_without_physical_group_is_told_so(tmp_path):
    path, hint = tmp_path / "m.msh", r"give cells .*the body one, or Mesh.SaveAll = 1\)"
    lines = meshio.Mesh(SQUARE, [("line", [[0, 1]])], cell_data={"gmsh:physical": [[1]]})
    lines.write(path, file_format="gmsh22", binary=False)
    with pytest.raises(ProblemError, match=hint):
        read_mesh(path)


def test_hexahedra_with_twenty_nodes_are_refused(tmp_path):
    cube = SHAPES["hexahedron27"].nodes[:20]
    meshio.Mesh(cube, [("hexahedron20", [list(range(20))])]).write(tmp_path / "a.vtu")
    with refused("1 hexahedron20 cells; its middles are missing; write hexahedron27"):
        read_mesh(tmp_path / "a.vtu")


def test_names_inside_the_body_and_of_another_order_are_refused(tmp_path):
    blocks = [("triangle", [[0, 1, 2], [0, 2, 3]]), ("line", [[0, 2]])]
    with refused("boundary 'boundary:1': facet [0, 2] is not on the surface"):
        read_mesh(bad(SQUARE, blocks, tmp_path, cell_data={"boundary": [[0, 0], [1]]}))
    mesh = box_mesh("P2", (1, 1))
    blocks = [("triangle6", mesh.cells), ("line", mesh.boundaries["left"][:, :2])]
    with refused("boundary 'boundary:1': line cells on sides of triangle6 cells; mesh both to"):
        read_mesh(bad(mesh.points, blocks, tmp_path, cell_data={"boundary": [[0, 0], [1]]}))


def test_files_that_include_others_are_refused(tmp_path):
    """The reader follows any path."""
    (tmp_path / "secret.txt").write_text("*NODE\n1, 0, 0\n", encoding="utf-8")
    path = tmp_path / "part.inp"
    for line in ("*INCLUDE, INPUT=secret.txt", " *include,input=/etc/passwd", "*MANIFEST, INPUT=a"):
        path.write_text(f"*NODE\n1, 0, 0\n{line}\n", encoding="utf-8")
        with pytest.raises(ProblemError, match="line 3 includes another file; join the files"):
            read_mesh(path)


GMSH = """
import os, signal, time
def initialize(**_options):
    {}
class option:
    setNumber = lambda *_: None
"""


@pytest.fixture
def gmsh_that(tmp_path, monkeypatch):
    """Puts another library in the place of gmsh; returns a file for it."""

    def make(code):
        (tmp_path / "gmsh.py").write_text(GMSH.format(code), encoding="utf-8")
        file = tmp_path / "part.step"
        file.write_text("ISO-10303-21;", encoding="utf-8")
        return file

    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    return make


@table(
    "code, words",
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "it crashes (Segmentation fault)"),
        ("bytearray(3_000_000_000)", "in 2 s and 2 GB: MemoryError"),
        ("time.sleep(600)", "in 2 s and 2 GB: it takes longer"),
        ("print('x' * 9_999_999); raise OSError('no\\nlicence')", "no licence"),
    ],
)
def test_a_library_that_crashes_or_takes_all_is_one_line(gmsh_that, monkeypatch, code, words):
    monkeypatch.setattr(geometry_file, "LIMIT", 2.0)
    with refused(words) as refusal:
        read_mesh(gmsh_that(code))
    assert "\n" not in str(refusal.value)
    assert "'part.step': gmsh makes no mesh of it" in str(refusal.value)


@pytest.mark.skipif(sys.platform == "win32", reason="no signal can be sent to one process there")
def test_meshing_can_be_interrupted(gmsh_that):
    threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt):
        read_mesh(gmsh_that("time.sleep(600)"))


def test_a_vertex_far_from_all_others_is_refused():
    """A vertex at 1e6 took 7 GB; a plate of 300 facets is meshed."""
    x = np.linspace(0, 0.37, 211)
    grid = np.stack(np.meshgrid(x, x, [0.2]), axis=-1)[:, :, 0]
    facets = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:]], axis=2).reshape(-1, 3)
    model = SimpleNamespace()
    model.mesh = SimpleNamespace(getNodesByElementType=lambda _: ((), facets.ravel(), ()))
    gmsh_mesher._refuse_stray_vertices(model)
    facets[7] = (1e6, 0.0, 0.0)
    with pytest.raises(SystemExit, match=r"correct the vertex at \[1000000.0, 0.0, 0.0\]"):
        gmsh_mesher._refuse_stray_vertices(model)


def test_geometry_files_need_gmsh_and_say_so(tmp_path, gmsh_that):
    with refused("'part.step': gmsh makes meshes of .step files, and is not installed"):
        read_mesh(gmsh_that("0\nraise ImportError"))
    with refused("has cells of its own; leave out cell"):
        read_mesh(written(box_mesh("Q1"), tmp_path, "gmsh22")[0], cell=0.1)


def test_a_box_of_a_step_file_has_its_volume_and_faces(tmp_path):
    gmsh = pytest.importorskip("gmsh")
    for name in ("box.step", "box.stl"):
        gmsh.initialize(interruptible=False)
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.model.occ.addBox(0, 0, 0, 30, 20, 10)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        gmsh.write(str(tmp_path / name))
        gmsh.finalize()
        mesh = read_mesh(tmp_path / name, 1e-3, cell=5e-3)
        assert mesh.shape == ("tetra10" if name.endswith("step") else "tetra")
        assert mesh.volume == pytest.approx(6e-6)
        assert set(mesh.boundaries) >= {f"face {i}" for i in range(1, 7)}
        assert sum(mesh.side(n).measure(None) for n in mesh.boundaries) == pytest.approx(2.2e-3)
