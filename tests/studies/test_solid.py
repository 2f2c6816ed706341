"""Solids of the study `displacement`: symmetry, closed forms, the bent bar, faults."""

import numpy as np
import pytest
from msvalidate.studies.displacement import bent_bar, displacement_controls, solid, solid_bodies
from msvalidate.studies.displacement.solid_bodies import CASES, MODELS

import reference_fem
from msvalidate.bench.judging.candidate import solve_springs
from msvalidate.bench.judging.evidence import all_passed, judge
from msvalidate.bench.judging.singularity import clamped_edge_exponent, clamped_free_exponent
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import ProblemError

QUICK = Setting(quick=True)


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_a_quarter_stands_for_the_body(case):
    """Folded out it is what the whole gives, on a mesh with the same elements."""
    tensor = MODELS["cubic 26"].tensor
    points = solid_bodies.grid(MODELS["cubic 26"], case, 4).points
    cells = tuple(round(4 * edge) for edge in case.box.size)
    mesh = reference_fem.box_discretisation(case.box, cells, "H1")
    whole = reference_fem.solve_problem(solid_bodies.problem(case, tensor), mesh).at(points)
    place, sign = solid_bodies.folded(case, points)
    part = solid_bodies.quarter(case, tensor)
    cells = tuple(round(4 * edge) for edge in part.domain.size)
    mesh = reference_fem.box_discretisation(part.domain, cells, "H1")
    folded = sign * reference_fem.solve_problem(part, mesh).at(place)
    np.testing.assert_allclose(folded, whole, atol=1e-8 * np.abs(whole).max())


def test_edges_are_corners_in_plane_strain():
    """An isotropic solid at nu = 1/4 is the plane at nu = 1/3 across its edges (Williams 1952)."""
    plane = np.array([[3.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 1.0]])
    want = clamped_free_exponent(plane, np.pi / 2)
    assert clamped_edge_exponent(MODELS["cubic 18"].tensor) == pytest.approx(want, abs=1e-12)
    assert 2 * want == pytest.approx(1.489, abs=1e-3)
    with pytest.raises(ProblemError, match="give a solid's"):
        clamped_edge_exponent(plane)


def test_springs_of_a_cube_by_hand():
    """One cell, clamped below, under shear: its four upper points are free.

    By symmetry they move alike along the load, u, up on its far side and down on the near one, ±v,
    and apart along z on one side and together on the other, ±w. Springs along the cell's edges
    count 1/4 and diagonals of its faces 1/2.
    """
    case, model = CASES["cube, shear"], MODELS["cubic 18"]
    k1, k2 = model.constants
    stiff = np.zeros((3, 3))
    for side in (-1, 1):
        springs_of_side = [
            (2, k1 / 4, (0, side, 0)),  # uprights
            (1, k1 / 4, (0, 0, 2 * side)),  # the upper one along z
            (2, k2 / 2, np.array([side, side, 0]) / np.sqrt(2)),  # that lean along x and end here
            (2, k2 / 2, np.array([0, side, side]) / np.sqrt(2)),  # that lean along z
        ]
        for many, k, stretch in springs_of_side:
            stiff += many * k * np.outer(stretch, stretch)
    move = np.linalg.solve(stiff, (case.traction[0], 0.0, 0.0))
    seen = solid_bodies.spring_body(solve_springs, model, case, 1)
    assert seen.mean == pytest.approx(move[0], rel=1e-12)


@pytest.mark.parametrize(("cells", "want"), [(1, 9 / 5), (2, 171 / 140)])
def test_bent_sections_in_fractions(cells, want):
    """By hand: β = 1/2 and energy 3/8 of E/12 = 5/24; at N = 2 the system [[3, 1], [1, 5]]/2."""
    assert bent_bar.section_stiffness(cells) == pytest.approx(want, abs=1e-12)
    assert bent_bar.bending_bound(cells) == pytest.approx(want, abs=1e-12)


def test_a_section_may_move_more_freely_than_its_bound():
    for cells in (3, 5, 9):
        section, bound = bent_bar.section_stiffness(cells), bent_bar.bending_bound(cells)
        assert 1 < section < bound
        assert (bound - section) * cells**4 < np.log(cells)


def test_the_bar_notices_small_faults():
    for kind, size in (("stiffness of every spring", 1e-7), ("boundary weights", 1e-7)):
        verdict = judge(bent_bar.run(displacement_controls.candidate_with(kind, size), QUICK))
        assert not all_passed(verdict), kind


def test_solids_against_fem_of_any_answer():
    """FEM in the springs' place: on a fine mesh nearer to itself than the springs are."""
    case, model = CASES["cube, pressure"], MODELS["cubic 18"]

    def elements(problem, network, _):
        mesh = reference_fem.box_discretisation(case.box, 8, "H1")
        return reference_fem.solve_problem(problem, mesh).at(network.points)

    own = solid_bodies.elastic_body(2, (case.name, model.tensor))
    solid_mean, spring_mean = (
        solid_bodies.spring_body(c, model, case, 8).mean for c in (elements, solve_springs)
    )
    assert abs(solid_mean / own.mean - 1) < abs(spring_mean / own.mean - 1)
    assert own.uncertainty / own.mean < solid.CONVERGED
