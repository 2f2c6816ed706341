"""Springs on a part's own mesh: elements node for node, on its curves, beside the lattice's."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.building import build_case
from msvalidate.case.case import Case, spacing_of
from msvalidate.case.comparison import compare_case
from msvalidate.case.page import sentences
from msvalidate.case.part_mesh import straighten
from msvalidate.case.reading import parse_source
from msvalidate.case.springs import solve_springs
from msvalidate.problem import Box, Isotropic, Mesh, Problem, ProblemError, Support, Traction, Zone
from msvalidate.problem.normals import pressure
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.export import nearest_case
from reference_fem.body import solve_problem
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

EXAMPLES = Path(__file__).parents[3] / "examples"
SIZE, THICK = 0.37, 0.2
SHAPES = {"P2": "triangle6", "Q2": "quad9", "T2": "tetra10", "H2": "hexahedron27"}


def sector(element: str, turn: float = 0.1) -> Mesh:
    """A quarter of a ring, .37 m wide, of curved cells; its ends and rims, and some cells, named.

    No node lies where the inner rim is lowest: finer cells reach beyond those of the file.
    """
    solid = element in ("T2", "H2")
    box = Box((1.0, 1.0, 0.4)[: 2 + solid])
    flat = box_discretisation(box, (2, 4, 1)[: 2 + solid], element)
    r, angle = SIZE * (1 + flat.points[:, 0]), np.pi / 2 * flat.points[:, 1] - turn
    x = np.column_stack([r * np.cos(angle), r * np.sin(angle), *SIZE * flat.points.T[2:]])
    mesh = Mesh(x, flat.cells, SHAPES[element])
    s, middle = mesh.surface, flat.points[flat.cells].mean(axis=1)
    at = {"inner": (0, 0.0), "outer": (0, 1.0), "low": (1, 0.0), "high": (1, 1.0)}
    names = {
        name: s[(np.abs(flat.points[s][..., axis] - value) < 1e-9).all(axis=1)]
        for name, (axis, value) in at.items()
    }
    return mesh.named(names, {"stiff": np.flatnonzero(middle[:, 1] < 0.5)})


def loaded(mesh: Mesh, nu: float = 0.3) -> Problem:
    """Held at its inner rim, pulled outside and at an end; of two materials."""
    state = "solid" if mesh.dim == 3 else "plane_strain"
    law, other = (Isotropic(e, nu, state, 1e3, THICK ** (mesh.dim == 2)) for e in (1e6, 5e6))
    held = (Support(mesh.side("inner"), (0.0,) * mesh.dim),)
    pulled = Traction(mesh.side("high"), (0.0, -1e3, 5e2)[: mesh.dim])
    loads = (Traction(mesh.side("outer"), (2e3, 1e3, 0.0)[: mesh.dim]), pulled)
    return Problem(mesh, law, held, loads, "sector", (Zone(mesh.zone("stiff"), other),))


@pytest.mark.parametrize("element", ["P2", "T2"])
def test_cut_cells_are_of_the_region_of_the_cell_that_is_cut(element):
    mesh = sector(element)
    cut = straighten(loaded(mesh), 2).domain
    share = len(mesh.zones["stiff"]) / len(mesh.cells)
    assert len(cut.zones["stiff"]) / len(cut.cells) == share


@pytest.mark.parametrize("element", ["P2", "T2"])
def test_springs_on_cut_cells_are_linear_elements_node_for_node(element):
    case = Case(loaded(sector(element)), lattice="mesh edges", route="neo-Hookean")
    for times in (1, 2):
        found = solve_springs(case, spacing_of(case) / times)
        mesh = found.problem.domain
        assert isinstance(mesh, Mesh)
        elements = solve_problem(found.problem, mesh_discretisation(mesh))
        middles = mesh.points[mesh.cells].mean(axis=1)  # between points as elements do
        for places in (mesh.points, middles):
            wanted = elements.at(places)
            assert np.abs(found.at(places) - wanted).max() <= 1e-11 * np.abs(wanted).max()
        assert (found.network.stiffness < 0).any()
    # Corners of cut cells lie on the file's own circles.
    radius = np.linalg.norm(mesh.points[:, :2], axis=1) / SIZE
    rim = mesh.points[found.network.held.all(axis=1)]
    assert np.linalg.norm(rim[:, :2], axis=1) == pytest.approx(SIZE, rel=1e-4)
    assert radius.min() == pytest.approx(1.0, rel=1e-4)


@pytest.mark.parametrize("element", ["P2", "Q2"])
def test_they_stand_beside_the_lattice_and_close_in_with_order_two(element):
    ring = sector(element, turn=0.0)  # a quarter, pressed from inside: smooth up to its sides
    held = Support(ring.side("low"), (None, 0.0)), Support(ring.side("high"), (0.0, None))
    pressed = pressure(ring.side("inner"), ring, 1e3)
    problem = Problem(ring, Isotropic(1e6, 0.3, "plane_strain"), held, (pressed,))
    found = compare_case(Case(problem, cells=4, quantities=("displacement",)))
    own = found.on_mesh
    assert own is not None
    assert own.order > 1.7
    assert own.table["difference"].iloc[-1] < 0.01
    said = " ".join(sentences(found)[1])
    assert "Springs on the part's own mesh" in said
    assert ("push" in said) == bool(own.table["pushing"].iloc[0])


def test_on_mesh_is_refused_where_there_is_none():
    text = (EXAMPLES / "box.toml").read_text(encoding="utf-8") + '[springs]\non = "mesh"\n'
    with pytest.raises(ProblemError, match="has no mesh: give a file of one, or on = 'lattice'"):
        build_case(parse_source("a.toml", text, EXAMPLES))
    with pytest.raises(ProblemError, match="choose lattice or mesh"):
        build_case(parse_source("a.toml", text.replace('"mesh"', '"grid"'), EXAMPLES))
    with pytest.raises(ProblemError, match=r"cell: of a box; it is of \.step"):
        build_case(parse_source("a.toml", text.replace("[body]", "[body]\ncell = 1"), EXAMPLES))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        ('lattice = "square"', "leave lattice out"),
        ("constants = [1.0]", "leave constants out"),
        ("[fracture]\ncritical_stretch = 0.1", "springs that break rest at a length"),
        ("spacing = 1e9", ""),
    ],
)
def test_what_these_springs_have_not_is_refused(more, words):
    text = (EXAMPLES / "ring.toml").read_text(encoding="utf-8") + f'[springs]\non = "mesh"\n{more}'
    if words:
        with pytest.raises(ProblemError, match=words):
            build_case(parse_source("a.toml", text, EXAMPLES))
        return
    case = build_case(parse_source("a.toml", text, EXAMPLES))
    assert spacing_of(case) < 0.2  # never coarser than the file
    with pytest.raises(ProblemError, match="LAMMPS has bonds alone"):
        nearest_case(case)
    box = build_case(parse_source("b.toml", (EXAMPLES / "box.toml").read_text("utf-8"), EXAMPLES))
    assert nearest_case(replace(box, route="neo-Hookean")).route == "springs"  # squares have them
