"""Springs on a part's own mesh: elements node for node, on its curves, beside the lattice's."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import build_case
from msvalidate.case.file.case import Case, spacing_of
from msvalidate.case.file.part_mesh import count_one_cell_thick, straighten
from msvalidate.case.file.reading import parse_source
from msvalidate.case.report.page import sentences
from msvalidate.case.springs.lattice_springs import solve_springs
from msvalidate.case.springs.mesh_springs import mesh_warning, one_cell_deflection, springs_alone
from msvalidate.problem import (
    Box,
    Isotropic,
    Mesh,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
    Zone,
)
from msvalidate.problem.normals import pressure
from msvalidate.problem.records import replace
from msvalidate.simulators.exchange.export import nearest_case
from reference_fem.body import solve_problem
from reference_fem.converged import converge
from reference_fem.mesh.boxes import box_discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation

EXAMPLES = Path(__file__).parents[4] / "examples"
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
    rim = mesh.points[found.network.fixed.all(axis=1)]
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


def test_springs_alone_on_the_edges_are_compared_near_their_own_ratio():
    ring = sector("P2", turn=0.0)
    held = Support(ring.side("low"), (None, 0.0)), Support(ring.side("high"), (0.0, None))
    pressed = (pressure(ring.side("inner"), ring, 1e3),)

    def both(nu):
        problem = Problem(ring, Isotropic(1e6, nu, "plane_strain"), held, pressed)
        return Case(problem, cells=4), converge(problem, ring.points)

    case, reference = both(0.25)
    springs = solve_springs(replace(case, lattice="mesh edges", route="springs"), ring.mean_edge)
    points = np.asarray(springs.lattice.points)
    exact = replace(reference, points=points).displacement.value
    own = np.linalg.norm(springs.at(points) - exact, axis=1).max()
    own /= np.linalg.norm(exact, axis=1).max()
    assert springs_alone(case, reference) == pytest.approx(own, rel=1e-9)
    assert springs_alone(*both(0.2595)) == pytest.approx(own, abs=0.02)
    assert math.isnan(springs_alone(*both(0.2605)))


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


def one_wall(thick: int, nu: float, unit: float, *, dim: int = 3, state: str = "solid") -> Problem:
    """A cantilever of square or cubic cells, 0.2 units thick and twelve times as long."""
    counts = (12 * thick, *[thick] * (dim - 1))
    size = [0.2 * unit * count / thick for count in counts]
    mesh = box_discretisation(Box(tuple(size)), counts, "H1" if dim == 3 else "Q1")
    body = Mesh(mesh.points, mesh.cells, "hexahedron" if dim == 3 else "quad")
    root, tip = (Region((x, *[None] * (dim - 1))) for x in body.span[0])
    shear = Traction(tip, (*[0.0] * (dim - 1), -1.0))
    return Problem(body, Isotropic(1e6, nu, state), (Support(root, (0.0,) * dim),), (shear,))


WALLS = [(n, unit, 3, "solid") for n in (1, 2, 3) for unit in (1.0, 1e-3)]
WALLS += [(1, SIZE, 2, "plane_stress"), (1, SIZE, 2, "plane_strain")]


@pytest.mark.parametrize(("thick", "unit", "dim", "state"), WALLS)
def test_cells_one_thick_bend_too_far_and_the_run_warns_of_them_alone(thick, unit, dim, state):
    """Two cells or more are within 5 % (linear theory of a slender beam) and have no warning."""
    nu = float(np.random.default_rng(thick).uniform(0.05, 0.45))
    problem = one_wall(thick, nu, unit, dim=dim, state=state)
    case = Case(problem, lattice="mesh edges", route="neo-Hookean")
    springs = solve_springs(case, spacing_of(case))
    tip = problem.domain.points[:, 0] > (1 - 1e-9) * problem.domain.span[0][1]
    at = problem.domain.points[tip]
    coarse = one_wall(1, nu, unit, dim=dim, state=state)  # whose quadratic cells are enough
    elements = mesh_discretisation(coarse.domain, "H2" if dim == 3 else "Q2")
    wanted = solve_problem(coarse, elements).at(at)[:, -1].mean()
    times = springs.at(at)[:, -1].mean() / wanted
    # The two ends hold their cells' section over about a thickness, a twelfth of the length each.
    expected = one_cell_deflection(problem.material) if thick == 1 else 1.0
    assert times == pytest.approx(expected, rel=1 / 12)
    cause, remedy = mesh_warning(springs.problem)
    assert ("hourglass mode" in cause, "two cells" in remedy) == (thick == 1, thick == 1)
    assert (f"up to {expected:.2f} times too soft" in cause) == (thick == 1)


def test_the_walls_of_a_part_with_a_hole_are_counted_by_cells():
    """A tube: nine cells less the middle one have walls one thick; cut in half, none has."""
    body = box_discretisation(Box((0.06, 0.06, 0.2)), (3, 3, 4), "H1")
    middle = body.points[body.cells].mean(axis=1)
    kept = body.cells[(np.abs(middle[:, :2] - 0.03) > 1e-3).any(axis=1)]
    used, cells = np.unique(kept, return_inverse=True)
    tube = Mesh(body.points[used], cells.reshape(kept.shape), "hexahedron")
    assert count_one_cell_thick(tube) == 4 * 4  # corners of the section have but adjacent facets
    end = Support(Region((None, None, 0.0)), (0.0,) * 3)
    cut = straighten(Problem(tube, Isotropic(1.0, 0.3, "solid"), (end,)), 1).domain
    assert count_one_cell_thick(cut) == 0
    assert count_one_cell_thick(sector("T2")) == 0


@pytest.mark.parametrize(
    "springs",
    [{"cells": 1}, {"lattice": "mesh edges", "route": "neo-Hookean"}],
    ids=["beside the lattice", "on the mesh"],
)
def test_a_run_names_the_hourglass_mode_and_the_remedy(springs):
    wall = one_wall(1, 0.3, 1.0, dim=2, state="plane_strain")
    found = compare_case(Case(wall, quantities=("displacement",), **springs))
    said = " ".join(sentences(found)[1])
    assert "hourglass mode, up to 1.43 times too soft" in said
    assert "two cells or more through each wall" in said
