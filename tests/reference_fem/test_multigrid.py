"""The iterative solver: agrees with the direct one, and refuses what it cannot solve."""

from __future__ import annotations

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import (
    Anisotropic,
    BodyForce,
    Box,
    Isotropic,
    Problem,
    ProblemError,
    SolverError,
    Support,
    Traction,
)
from reference_fem.discretisation import discretise
from reference_fem.multigrid import in_one_piece

# A library's warning on the way to an answer is a failure here.
pytestmark = pytest.mark.filterwarnings("error")

BOX = Box((1.2, 0.8, 1.0))
SKEW = np.diag([3.0, 2.0, 2.5, 1.1, 0.9, 1.3]) + 0.2
CLAMP = (Support(BOX.side("left"), (0.0, 0.0, 0.0)),)
# No node wholly held on two sides of three, and displacements that are not zero.
ROLLERS = (
    Support(BOX.side("left"), (1e-2, None, None)),
    Support(BOX.side("bottom"), (None, -1e-2, None)),
    Support(BOX.side("back"), (None, None, lambda x: 1e-2 * x[:, 0])),
)
PULL = Traction(BOX.side("right"), lambda x: x[:, [1, 2, 0]])
WEIGHT = BodyForce((0.0, -1.0, 0.3))
SOFT = Isotropic(1.0, 0.3, "solid")


def answer(problem, body, most, monkeypatch):
    monkeypatch.setattr("reference_fem.elasticity.MOST_DIRECT", most)
    return reference_fem.solve_problem(problem, body).displacement


def refused(*_):
    raise AssertionError("the other solver was asked")


@pytest.mark.parametrize("supports", [CLAMP, ROLLERS], ids=["clamp", "rollers"])
@pytest.mark.parametrize(
    ("element", "grading", "material"),
    [
        ("H1", 1.0, SOFT),
        ("T1", 1.0, SOFT),
        ("H1", 2.0, SOFT),
        ("H1", 1.0, Isotropic(1.0, 0.49, "solid")),
        ("H1", 1.5, Anisotropic(SKEW)),
        ("T1", 1.5, Anisotropic(SKEW)),
    ],
)
def test_both_solvers_agree(element, grading, material, supports, monkeypatch):
    problem = Problem(BOX, material, supports, (PULL, WEIGHT))
    body = reference_fem.box_discretisation(BOX, 7, element, grading)
    with monkeypatch.context() as only:
        only.setattr("reference_fem.elasticity.multigrid", refused)
        direct = answer(problem, body, 10**9, only)
    monkeypatch.setattr("reference_fem.elasticity._direct", refused)
    iterated = answer(problem, body, 0, monkeypatch)
    assert np.abs(direct).max() > 0.1
    assert np.abs(iterated - direct).max() <= 1e-9 * np.abs(direct).max()
    np.testing.assert_array_equal(answer(problem, body, 0, monkeypatch), iterated)  # no chance


def test_large_bodies_in_space_are_iterated_and_others_are_not(monkeypatch):
    large = reference_fem.box_discretisation(BOX, 12, "H1")
    monkeypatch.setattr("reference_fem.elasticity._direct", refused)
    found = reference_fem.solve_problem(Problem(BOX, SOFT, CLAMP, (PULL,)), large)
    assert np.isfinite(found.displacement).all()
    monkeypatch.undo()
    monkeypatch.setattr("reference_fem.elasticity.multigrid", refused)
    plate = Box((1.0, 1.0))
    held = (Support(plate.side("left"), (0.0, 0.0)),)
    flat = Problem(plate, Isotropic(1.0, 0.3), held, (BodyForce((0.0, -1.0)),))
    body = reference_fem.box_discretisation(plate, 50, "Q1")
    assert body.points.size > reference_fem.elasticity.MOST_DIRECT
    assert reference_fem.solve_problem(flat, body).displacement.any()


@pytest.mark.parametrize("E", [1e-200, 1e200])
def test_unit_of_the_modulus_does_not_matter(E, monkeypatch):
    body = reference_fem.box_discretisation(BOX, 4, "H1")
    unit, other = (
        answer(Problem(BOX, Isotropic(e, 0.3, "solid"), CLAMP, (PULL,)), body, 0, monkeypatch)
        for e in (1.0, E)
    )
    assert np.abs(E * other - unit).max() <= 1e-9 * np.abs(unit).max()


def test_a_body_without_loads_stays_where_it_is(monkeypatch):
    body = reference_fem.box_discretisation(BOX, 4, "H1")
    assert not answer(Problem(BOX, SOFT, CLAMP), body, 0, monkeypatch).any()


@pytest.mark.parametrize(
    ("E", "force"), [(1.0, 1.7e308), (1e-320, 1.0), (1.7e308, 1.0)], ids=["force", "soft", "stiff"]
)
def test_numbers_beyond_all_are_a_solver_error(E, force, monkeypatch):
    loads = (BodyForce((force, 0.0, 0.0)),) * 4
    body = reference_fem.box_discretisation(BOX, 4, "H1")
    with pytest.raises(SolverError, match="residual"):
        answer(Problem(BOX, Isotropic(E, 0.3, "solid"), CLAMP, loads), body, 0, monkeypatch)


def test_no_convergence_is_a_solver_error(monkeypatch):
    monkeypatch.setattr("reference_fem.multigrid.MOST_STEPS", 3)
    body = reference_fem.box_discretisation(BOX, 4, "H1")
    with pytest.raises(SolverError, match=r"after 3 steps of conjugate gradients; take cells of"):
        answer(Problem(BOX, SOFT, CLAMP, (PULL,)), body, 0, monkeypatch)


def test_too_little_memory_is_told(monkeypatch):
    def no_memory(*_args, **_options):
        raise MemoryError

    monkeypatch.setattr("pyamg.smoothed_aggregation_solver", no_memory)
    body = reference_fem.box_discretisation(BOX, 4, "H1")
    with pytest.raises(SolverError, match="300 unknowns take more memory than there is; take few"):
        answer(Problem(BOX, SOFT, CLAMP, (PULL,)), body, 0, monkeypatch)


def test_a_free_body_is_refused(monkeypatch):
    monkeypatch.setattr("reference_fem.elasticity.MOST_DIRECT", 0)
    body = reference_fem.box_discretisation(BOX, 3, "H1")
    edge = np.flatnonzero((body.points[:, :2] == 0).all(axis=1))
    fixed = [(node, axis, 0.0) for node in edge for axis in range(3)]
    with pytest.raises(ProblemError, match="rotation about the axis along z"):
        reference_fem.solve(body.points, body.cells, "H1", SOFT, fixed, [])


@pytest.mark.parametrize("element", ["H1", "T1"])
def test_one_piece_is_told_from_several(element):
    body = reference_fem.box_discretisation(BOX, (3, 2, 2), element)
    assert in_one_piece(body)
    # Without the cells between the two ends along x there are two pieces.
    middle = body.points[body.cells].mean(axis=1)[:, 0]
    cells = body.cells[(middle < 0.4) | (middle > 0.8)]
    used, kept = np.unique(cells, return_inverse=True)
    assert not in_one_piece(discretise(body.points[used], kept.reshape(cells.shape), element))
    # A chessboard's cells meet in edges only.
    alone = np.round(body.points[body.cells].min(axis=1) / [0.4, 0.4, 0.5]).sum(axis=1) % 2 == 0
    cells = body.cells[alone]
    used, kept = np.unique(cells, return_inverse=True)
    assert not in_one_piece(discretise(body.points[used], kept.reshape(cells.shape), element))
