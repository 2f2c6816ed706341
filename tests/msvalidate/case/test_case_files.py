"""Case files: what they mean, and one line with file, line, key and remedy for what they cannot."""

from __future__ import annotations

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import msgspec
import numpy as np
import pytest

from msvalidate.case.building import read_case
from msvalidate.case.case import Case, make_lattice, spacing_of
from msvalidate.case.comparison import compare_case
from msvalidate.case.reading import CaseError, key_lines
from msvalidate.case.results import read_result
from msvalidate.case.run import case_files, judged_files
from msvalidate.case.schema import CaseFile
from msvalidate.case.springs import make_network, solve_finer
from msvalidate.cli.program import main
from msvalidate.problem import (
    Box,
    Isotropic,
    PointForce,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
)
from tests.msvalidate.case import mutated
from tests.table import table

GOOD = """\
schema = 1
name = "beam"
[body]
box = [4.0, 1.0]
[material]
E = 1e5
nu = 0.3
state = "plane_stress"
[[support]]
on = "left"
[[load]]
on = "right"
traction = [0, -1]
"""
MESH = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
1
1 1 "clamp"
$EndPhysicalNames
$Nodes
4
1 0 0 0
2 2 0 0
3 2 1 0
4 0 1 0
$EndNodes
$Elements
3
1 1 2 1 1 4 1
2 2 2 2 1 1 2 3
3 2 2 2 1 1 3 4
$EndElements
"""


def write(folder, text):
    path = folder / "beam.toml"
    path.write_text(text, encoding="utf-8")
    (folder / "part.msh").write_text(MESH, encoding="utf-8")
    return path


def changed(*changes):
    text = GOOD
    for old, new in changes:
        assert old in text, old
        text = text.replace(old, new)
    return text


BOX, LOAD, HELD = "box = [4.0, 1.0]", 'on = "right"\ntraction = [0, -1]', 'on = "left"'
PRESSED = LOAD + '\n[[contact]]\non = "top"\ndisc = { at = [3.0, 2.0], radius = 1.0 }'
BAD = [
    ((("schema = 1", ""),), "no schema; begin the file with schema = 1"),
    ((("schema = 1", "schema = 2"),), "line 1: schema: 2; this program reads schema = 1"),
    ((("schema = 1", "schema = true"),), "line 1: schema: True"),
    ((("[body]", "[body"),), "not TOML"),
    ((("[body]", "[bdy]"),), "line 3: bdy: no such key; did you mean body?"),
    (((BOX, ""),), "line 3: body: no shape; give one of box, polygon, mesh"),
    (((BOX, BOX + '\nmesh = "part.msh"'),), "line 4: body: box and mesh; give one"),
    (((BOX, "box = 4"),), "line 4: body.box: 4; give a list"),
    (((BOX, "box = [4.0]"),), "line 4: body.box"),
    (((BOX, "box = [4.0, -1.0]"),), "line 4: body.box"),
    (((BOX, "box = [4.0, nan]"),), "every value must be finite"),
    (((BOX, "box = [4.0, 1e-12]"),), "thinner than"),
    (((BOX, BOX + '\nunit = "mmm"'),), "line 5: body.unit: unit: 'mmm'; choose m, km, cm, mm"),
    (((BOX, BOX + "\nunit = -1"),), "in, ft, or a number in m above zero"),
    (((BOX, BOX + '\nunit = "mm"'),), "material.thickness: missing; give it in the unit"),
    (((BOX, "polygon = [[0, 0], [0, 1], [1, 0]]"),), "line 4: body.polygon"),
    (((BOX, "polygon = [[0, 0], [1, 0], [0, 1], [1, 1]]"),), "cross or touch"),
    (((BOX, 'mesh = "../part.msh"'),), "outside the case's own folder"),
    (((BOX, 'mesh = "/etc/passwd"'),), "outside the case's own folder"),
    (((BOX, 'mesh = "none.msh"'),), "No such file"),
    (((BOX, 'mesh = "beam.toml"'),), "give one of .msh"),
    (((BOX, 'mesh = "a\\u0000b.msh"'),), "line 4: body.mesh"),
    ((("E = 1e5", "E = -1"),), "line 6: material: Young's modulus E: -1.0 Pa; it must be above"),
    ((("E = 1e5", "E = '1e5'"),), "line 6: material.E: '1e5'; give a number"),
    ((("E = 1e5", "E = inf"),), "every value must be finite"),
    ((("E = 1e5\n", ""),), "line 5: material.E: missing; give it"),
    ((("nu = 0.3", "nu = 0.6"),), "line 7: material: Poisson's ratio nu: 0.6"),
    ((("nu = 0.3", "nuu = 0.3"),), "line 7: material.nuu: no such key; did you mean nu?"),
    ((('state = "plane_stress"', ""),), "material.state: missing; a plane body is in plane_stress"),
    ((("plane_stress", "plane"),), "line 8: material.state: 'plane'; choose plane_stress"),
    ((("plane_stress", "solid"),), "line 8: material.state: 'solid'; choose plane_stress"),
    (((BOX, "box = [4, 1, 1]"),), "line 8: material.state: 'plane_stress'; a body in space"),
    ((('state = "plane_stress"', 'state = "plane_stress"\nthickness = 0'),), "line 9: material"),
    ((('state = "plane_stress"', 'state = "plane_stress"\ndensity = -1'),), "line 9: material"),
    ((('state = "plane_stress"', 'state = "plane_stress"\nlaw = "hooke"'),),
        "line 9: material: law: 'hooke'; choose st-venant-kirchhoff or neo-hookean"),
    ((("[[support]]", '[compare]\ngeometry = "full"\n[[support]]'),),
        "line 10: compare: geometry: 'full'; choose linear or nonlinear"),
    ((("[[support]]\n" + HELD + "\n", ""),), "support: missing; give it"),
    ((("[[support]]\n" + HELD + "\n", ""), ("[body]", "support = []\n[body]")),
        "line 3: support: none"),
    ((("[[support]]", "[support]"),), "line 9: support: one table; write [[support]]"),
    (((HELD, 'on = "lft"'),), "line 10: support 1.on: 'lft': did you mean left?"),
    (((HELD, ""),), "line 9: support 1: no place; give one of on and at"),
    (((HELD, HELD + "\nat = { x = 0 }"),), "both on and at"),
    (((HELD, "at = { x = 9 }"),), "reaches outside the body"),
    (((HELD, "at = { x = [1, 0] }"),), "must be a number, (low, high)"),
    (((HELD, "at = { x = [0] }"),), "line 10: support 1.at.x"),
    (((HELD, "at = { w = 0 }"),), "line 10: support 1.at.w: no such key; choose x, y, z"),
    (((HELD, "at = { z = 0 }"),), "z: the body is plane; leave it out"),
    (((HELD, HELD + '\ncomponents = ["z"]'),), "support 1.components: component: 'z'; choose x or"),
    (((HELD, HELD + '\ncomponents = ["x", "x"]'),), "once or not at all"),
    (((HELD, HELD + "\nvalue = [1, 2, 3]"),), "3 values for 2 components, x, y; give one each"),
    (((HELD, HELD + "\nvalue = nan"),), "line 11: support 1.value"),
    (((HELD, "nodes = [1]"),), "nodes are a mesh's"),
    (((HELD, HELD + '\ncomponents = ["x"]'),),
        "support: all together: the supports leave the body free: tr"),
    (((LOAD, "traction = [0, 1]"),), "load 1: no place; give one of on and at"),
    (((LOAD, 'on = "right"'),), "load 1: no load; give one of traction, pressure, force, gravity"),
    (((LOAD, LOAD + "\npressure = 1"),), "traction and pressure; give one"),
    (((LOAD, 'on = "right"\ntraction = [1]'),), "give 2 components"),
    (((LOAD, 'on = "right"\ntraction = [0, "a"]'),), "load 1.traction 2: 'a'; give a number"),
    (((LOAD, 'on = "right"\nforce = [1, 2]'),), "goes with no force: it acts at point or node"),
    (((LOAD, "force = [1, 2]"),), "give its place, by point or by node"),
    (((LOAD, "force = [1, 2]\npoint = [9, 9]"),), "line 11: load 1"),
    (((LOAD, "gravity = [0, -9.81]\npoint = [0, 0]"),), "it acts on the whole body"),
    (((LOAD, "gravity = [0, 0, 1]"),), "load 1"),
    (((LOAD, 'on = "right"\npressure = inf'),), "load 1.pressure"),
    (((LOAD, PRESSED),), "line 14: contact 1: neither depth nor force; give one of them"),
    (((LOAD, PRESSED + "\ndepth = 1\nforce = 1"),), "depth and force both; give one"),
    (((LOAD, PRESSED.replace("disc", "ball") + "\ndepth = 1"),), "ball: at (3.0, 2.0): shape (2,)"),
    (((LOAD, PRESSED + "\ndepth = 1\nhalf_space = { at = [0, 0] }"),), "half_space and disc; give"),
    (((LOAD, PRESSED + "\nforce = 1\n" + PRESSED[PRESSED.index("[[") :] + "\nforce = 1"),),
        "contact 2: a second one; elements meet one obstacle"),
    (((LOAD, PRESSED + '\ndepth = 1\n[compare]\ngeometry = "nonlinear"'),), "to first order"),
    (((LOAD, LOAD + "\n[fracture]\nraised = 2"),), "critical_stretch and G_c: give one of them"),
    (((LOAD, LOAD + "\n[fracture]\nG_c = 1\ncritical_stretch = 1"),), "G_c: give one of them"),
    (((LOAD, LOAD + "\n[fracture]\nG_c = -1"),), "G_c: -1.0 J/m²; it must be above zero"),
    (((LOAD, LOAD + "\n[fracture]\nG_c = 1\ndirection = [1]"),), "fracture.direction"),
    (((LOAD, LOAD + '\n[fracture]\nG_c = 1\nrule = "x"'),), "rule: 'x'; choose growth or springs"),
    (((LOAD, PRESSED + "\ndepth = 1\n[fracture]\nG_c = 1"),), "with an obstacle or geometry"),
    (((LOAD, LOAD + '\n[springs]\nlattice = "sq"'),), "line 15: springs: lattice: 'sq'; choose"),
    (((LOAD, LOAD + '\n[springs]\nlattice = "mesh edges"'),), "has none; give a mesh file"),
    (((LOAD, LOAD + "\n[springs]\nspacing = 0"),), "line 15: springs: spacing"),
    (((LOAD, LOAD + "\n[springs]\nspacing = 1\ncells = 2"),), "give one of them"),
    (((LOAD, LOAD + "\n[springs]\ncells = 1.5"),), "springs.cells: 1.5; give a whole number"),
    (((LOAD, LOAD + '\n[springs]\nroute = "magic"'),), "route: 'magic'; choose springs, volume"),
    (((LOAD, LOAD + '\n[springs]\nroute = "shear springs"'),), "is gone; take 'volume energy'"),
    (((LOAD, LOAD + "\n[springs]\nvolume = 1"),), "it goes with constants"),
    (((LOAD, LOAD + "\n[springs]\nconstants = [-1, 2]"),),
        "line 15: springs: constants: -1 N/m; each must be 0 or more"),
    (((LOAD, LOAD + "\n[springs]\nconstants = [1]"),), "square has springs of 2 kinds, give one"),
    (((LOAD, LOAD + '\n[compare]\npoints = "all"'),), "points: 'all'; choose lattice or mesh"),
    (((LOAD, LOAD + '\n[compare]\npoints = "mesh"'),), "give points, or 'lattice'"),
    (((LOAD, LOAD + "\n[compare]\npoints = [[1, 2, 3]]"),), "give 2 numbers each"),
    (((LOAD, LOAD + "\n[compare]\npoints = []"),), "line 15: compare"),
    (((LOAD, LOAD + "\n[compare]\nquantities = []"),), "quantities: none"),
    (((LOAD, LOAD + '\n[compare]\nquantities = ["x"]'),), "quantity: 'x'; choose displacement"),
    (((LOAD, LOAD + "\n[compare]\nband = 0"),), "line 15: compare: band"),
    (((LOAD, LOAD + "\n[reference]\naccuracy = 1"),), "line 15: reference: accuracy: 1.0; give a"),
    (((LOAD, LOAD + "\n[compare]\nmemory = 0"),), "compare: memory: 0.0; give a number"),
    ((('name = "beam"', 'name = ""'),), "line 2: name: problem name"),
    ((('name = "beam"', "name = 3"),), "line 2: name: 3; give a text"),
]  # fmt: skip


@table(("changes", "said"), BAD)
def test_bad_files_are_told_in_one_line(tmp_path, changes, said):
    path = write(tmp_path, changed(*changes))
    with pytest.raises(ProblemError) as told:
        read_case(path)
    message = str(told.value)
    assert message.startswith("case beam.toml")
    assert said in message
    assert "\n" not in message


@pytest.mark.parametrize("given", [5, None, b"beam.toml", [1]])
def test_what_is_no_case_is_told_in_one_line(given):
    acts = (read_case, compare_case, case_files, lambda case: judged_files(case, case))
    for act in (*acts, lambda path: read_result(path, 2)):
        with pytest.raises(ProblemError, match=r"; give a"):
            act(given)


def test_changed_files_are_read_or_refused():
    """A look; the module itself tries a hundred thousand."""
    told = mutated.try_all(1500)
    assert told["read"] > 10
    assert told["in several lines"] == 0


def test_files_that_are_none(tmp_path):
    for content, said in ((b"\xff\xfe\x00", "is no UTF-8"), (b"", "no schema")):
        path = tmp_path / "odd.toml"
        path.write_bytes(content)
        with pytest.raises(CaseError, match=said):
            read_case(path)
    with pytest.raises(CaseError, match="No such file"):
        read_case(tmp_path / "none.toml")
    with pytest.raises(CaseError, match="Is a directory"):
        read_case(tmp_path)


def test_lengths_are_in_the_unit(tmp_path):
    text = changed(
        (BOX, BOX + '\nunit = "cm"'),
        ("state", "thickness = 1\nstate"),
        (HELD, HELD + '\ncomponents = ["y", "x"]\nvalue = [1, 2]'),
        (
            LOAD,
            "force = [1, 2]\npoint = [4, 0.5]\n[springs]\nspacing=0.25\n[compare]\npoints=[[1,1]]",
        ),
    )
    case = read_case(write(tmp_path, text))
    assert case.problem.supports[0].displacement == pytest.approx((0.02, 0.01))
    assert case.problem.loads == (PointForce((0.04, 0.005), (1.0, 2.0)),)
    assert spacing_of(case) == pytest.approx(2.5e-3)
    np.testing.assert_allclose(case.points, [[0.01, 0.01]])


def test_sides_of_outlines_and_meshes(tmp_path):
    outline = "polygon = [[0, 0], [4, 0], [4, 2], [0, 1]]"
    text = changed(
        (BOX, outline), ('on = "right"\ntraction = [0, -1]', 'on = "edge 3"\npressure = 2')
    )
    problem = read_case(write(tmp_path, text)).problem
    assert isinstance(problem.domain, Polygon)
    normal = np.array([-1, 4]) / np.sqrt(17)
    np.testing.assert_allclose(problem.loads[0].traction, -2 * normal)
    mesh = changed(
        (BOX, 'mesh = "part.msh"'),
        (HELD, 'on = "clamp"'),
        ('on = "right"\ntraction = [0, -1]', "node = 2\nforce = [0, -1]"),
    )
    problem = read_case(write(tmp_path, mesh)).problem
    assert problem.supports[0].region.name == "clamp"
    assert problem.loads[0].at == (2.0, 1.0)


def test_the_template_is_a_case(tmp_path):
    assert main(["case", "new", str(tmp_path / "new")]) == 0
    case = read_case(tmp_path / "new.toml")
    assert case.name == "new"
    assert spacing_of(case) == 0.05


def test_slender_bodies_have_few_cells_across():
    box = Box((1e4, 1.0))
    held = Support(box.side("left"), (0.0, 0.0))
    case = Case(Problem(box, Isotropic(1e5, 1 / 3), (held,)))
    assert spacing_of(case) == 0.5
    assert len(make_lattice(case, 0.5).points) == 3 * 20_001


def test_cells_that_are_no_squares_fill_boxes_of_their_proportions():
    sides = (1.0, 1.73205080757)  # as a file has it
    box = Box(sides)
    problem = Problem(box, Isotropic(1e5, 1 / 3), (Support(box.side("left"), (0.0, 0.0)),))
    case = Case(problem, lattice="triangular", cells=10)
    assert spacing_of(case) == pytest.approx(0.1)
    assert len(make_lattice(case, 0.1).points) == 11 * 11 + 10 * 10


MISFITS = [
    ("triangular", Box((4.0, 1.0)), 0.05, "give a box of 4 x 1.03923048454 m, or a lattice that"),
    ("triangular", Box((1.0, 1.73205080757)), 0.06, "do not fill the box 1 x 1.73205 m; give a b"),
    ("honeycomb", Polygon(((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))), 0.1, "only square, square4 can"),
    ("bcc", Box((1.0, 1.0, 1.03)), 0.125, "give a box of 1 x 1 x 1 m, or a lattice that"),
]  # fmt: skip


@table(("lattice", "body", "spacing", "said"), MISFITS)
def test_what_would_fit_is_told(lattice, body, spacing, said):
    plane = body.dim == 2
    below = Segment((0.0, 0.0), (1.0, 0.0)) if plane else body.side("bottom")
    law = Isotropic(1e5, 0.3, "plane_stress" if plane else "solid")
    case = Case(Problem(body, law, (Support(below, (0.0,) * body.dim),)), lattice=lattice)
    with pytest.raises(ProblemError, match=f"^lattice {lattice}: ") as told:
        make_lattice(case, spacing)
    assert said in str(told.value)


def plane_box(size, supports, loads=(), **options):
    held = [Support(Region(at), value) for at, value in supports]
    pulled = [Traction(Region(at), (1.0, -2.0)) for at in loads]
    law = Isotropic(1e5, 0.3, "plane_strain")
    return Case(Problem(Box(size), law, tuple(held), tuple(pulled)), **options)


ENDS = [((0.0, None), (0.0, 0.0)), ((5.6, None), (None, 0.1))]


def test_lines_of_cells_run_through_supports_and_where_they_end():
    apart = spacing_of(plane_box((5.6, 1.9), ENDS, cells=8))
    assert round(5.6 / apart, 9).is_integer()
    assert apart == pytest.approx(1.9 / 8, rel=0.02)
    part = spacing_of(plane_box((4.2, 0.8), [((0.0, (0.0, 0.284)), (0.0, 0.0))], cells=8))
    assert part == pytest.approx(0.284 / 3)
    told = plane_box((5.6, 1.9), ENDS, spacing=0.25)
    with pytest.raises(ProblemError, match=r"along x = 5.6 m; .*; cells = 8 \(spacing") as refused:
        solve_finer(told)
    many = int(re.search(r"cells = (\d+)", str(refused.value))[1])
    assert make_network(replace(told, spacing=None, cells=many), apart)
    assert "origin" not in str(refused.value)
    turned = plane_box((1.0, 1.73205080757), ENDS[:1], lattice="triangular", spacing=0.06)
    with pytest.raises(
        ProblemError, match=r"do not fill.*; cells = 17 \(spacing 0.0588235 m\) does"
    ):
        solve_finer(turned)


@pytest.mark.parametrize("cells", [8, None])
def test_few_ordinary_boxes_are_refused(cells):
    draw = np.random.default_rng(7)
    for number in range(40):
        a, b = round(draw.uniform(1, 6), 1), round(draw.uniform(0.5, 2), 1)
        end = round(b * draw.uniform(0.3, 0.8), 3)
        held = [
            [((0.0, (0.0, end)), (0.0, 0.0))],
            [((None, 0.0), (0.0, 0.0)), ((None, b), (0.01, -0.01))],
            [((0.0, None), (0.0, None)), ((None, 0.0), (None, 0.0))],
            [((0.0, None), (0.0, 0.0)), ((a, None), (None, 0.01))],
        ][number % 4]
        case = plane_box((a, b), held, [(a, (0.0, end))] if number % 4 == 2 else (), cells=cells)
        make_network(case, spacing_of(case))


def test_lines_of_keys():
    text = 'a = 1\n[t]\nb = [\n  1, # x = 2\n]\n"c d" = { e = 1, f = [2] }\n'
    text += '[[r]]\n[[r]]\ng.h = """\ni = 3\n"""\nj = 1\n'
    tomllib.loads(text)
    lines = key_lines(text)
    assert lines[("a",)] == 1
    assert lines[("t", "b")] == 3
    assert lines[("t", "c d", "e")] == 6
    assert lines[("r", 1)] == 8
    assert lines[("r", 1, "g", "h")] == 9
    assert lines[("r", 1, "j")] == 12
    assert ("i",) not in lines


def test_the_schema_names_every_table():
    tables = msgspec.json.schema(CaseFile)["$defs"]["CaseFile"]["properties"]
    assert set(tables) >= {"schema", "body", "material", "support", "load", "springs", "compare"}


@pytest.mark.parametrize("path", sorted((Path(__file__).parents[3] / "examples").glob("*.toml")))
def test_examples_are_cases(path):
    case = read_case(path)
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 22
    assert case.problem.supports
