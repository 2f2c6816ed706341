"""What anybody's candidate may answer: displacements, or one line that says what it is instead."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from msvalidate.bench.judging.candidate import (
    check_actuator,
    check_displacements,
    check_motion,
    solve_springs,
)
from msvalidate.problem import (
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.lattice import square
from msvalidate.studies import poisson

SIDES = (0.74, 0.37)
"""Of the body (m), 0.2 m thick."""


def body(held, origin=(0.0, 0.0)):
    """Problem and network: a plate pulled along x, its supports as asked."""
    box = Box(SIDES)
    (x0, x1), (y0, _) = box.span
    wall, end = Region((x0, None)), Region((x1, None))
    pull = (Traction(end, (250.0, 0.0)),)
    supports = {
        "clamped": (Support(wall, (0.0, 0.0)),),
        "sliding": (Support(wall, (0.0, None)), Support(Region((None, y0)), (None, 0.0))),
        "moved": (Support(wall, (0.0, 0.0)), Support(end, (1e-3 * SIDES[0], 0.0))),
    }[held]
    material = Isotropic(1.3e6, 1 / 3, thickness=0.2)
    problem = Problem(box, material, supports, () if held == "moved" else pull)
    network = lattice_network(problem, square(box, (8, 4)))
    return problem, replace(network, points=network.points + origin)


BODIES = {
    "clamped": body("clamped"),
    "sliding": body("sliding"),  # supports at coordinates of 0 tell nothing: the energy does
    "moved": body("moved"),
    "far away": body("clamped", (400.0, -300.0)),
}
every_body = pytest.mark.parametrize("name", BODIES)


def refusal(change, name="clamped"):
    """What is said of a candidate whose answer is a change of the right one."""
    problem, network = BODIES[name]
    wrong = check_displacements(lambda *asked: change(solve_springs(*asked), network))
    with pytest.raises((ProblemError, SolverError)) as refused:
        wrong(problem, network, "linear")
    assert "\n" not in str(refused.value)
    return str(refused.value)


@every_body
@pytest.mark.parametrize("factor", [-2.0, 0.0, 0.02, 1.0, 40.0])
def test_a_wrong_answer_is_judged_not_refused(name, factor):
    problem, network = BODIES[name]
    wanted = factor * solve_springs(problem, network)
    found = check_displacements(lambda *_: wanted.tolist())(problem, network, "linear")
    np.testing.assert_array_equal(found, wanted)


@every_body
def test_positions_for_displacements(name):
    said = refusal(lambda move, network: network.points + move, name)
    assert "displacements (45, 2) that" in said
    assert "positions; take network.points off" in said


@pytest.mark.parametrize(("factor", "unit"), [(1000.0, "mm"), (0.001, "km")])
@pytest.mark.parametrize("name", ["clamped", "sliding", "moved"])
def test_another_unit(name, factor, unit):
    assert f"give m (are they {unit}?)" in refusal(lambda move, _: factor * move, name)


@pytest.mark.parametrize(("change", "said"), [
    (lambda move, _: move.T, "shape (2, 45); give displacements (45, 2) in m at network.points"),
    (lambda move, _: move.T, "(this is the transpose)"),
    (lambda move, _: move.ravel(), "(this is flat; reshape it to (45, 2))"),
    (lambda move, n: move[~n.fixed], "(these are free components alone)"),
    (lambda move, _: np.pad(move, ((0, 0), (0, 1))), "(leave the third component out)"),
    (lambda move, _: move[:-1], "shape (44, 2); give displacements (45, 2) in m"),
    (lambda *_: None, "None; return displacements (45, 2) in m at network.points"),
    (lambda *_: [[0.0, 1.0], [0.0]], "rows of different length"),
    (lambda *_: "moved", "expected numbers, got 'moved'"),
    (lambda move, _: move + 0j, "expected numbers"),
    (lambda move, _: move * np.nan, "nan at index (0, 0), 90 in all; give displacements"),
    (lambda move, _: move + np.inf, "inf at index (0, 0)"),
])  # fmt: skip
def test_what_is_no_displacement(change, said):
    assert said in refusal(change)


def test_answers_that_are_nothing_end_a_study_in_one_line():
    with pytest.raises(SolverError, match=r"^candidate: nan at index"):
        poisson.run(candidate=lambda _, network, __: np.full(network.points.shape, np.nan))
    with pytest.raises(ProblemError, match=r"positions; take network\.points off"):
        poisson.run(
            candidate=lambda problem, network, a: (
                network.points + solve_springs(problem, network, a)
            )
        )


def test_an_actuators_answer_is_looked_at_too():
    _, network = BODIES["clamped"]
    actuator = SimpleNamespace(network=network)
    wrong = check_actuator(lambda given, _: given.network.points)
    with pytest.raises(ProblemError, match=r"positions; take network\.points off"):
        wrong(actuator, 1.0)


@pytest.mark.parametrize(("change", "said"), [
    (lambda s, n: State(s.position - n.points, s.velocity), "displacements; add network.points"),
    (lambda s, _: s.position, "give a State, of position and velocity"),
    (lambda s, _: State(s.position, s.velocity[:, 0]), "give velocities (45, 2) in m/s"),
    (lambda s, _: State(s.position * np.nan, s.velocity), "nan at index (0, 0)"),
])  # fmt: skip
def test_a_motions_state_is_looked_at_too(change, said):
    _, network = BODIES["far away"]
    start = State(network.points, 0 * network.points)
    assert (
        check_motion(lambda _, state, *__: state)(network, start, 1e-3, 1, 0.0).position is not None
    )
    with pytest.raises((ProblemError, SolverError)) as refused:
        check_motion(lambda net, state, *_: change(state, net))(network, start, 1e-3, 1, 0.0)
    assert said in str(refused.value)
