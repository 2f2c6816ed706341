"""Motions that rounding of positions would hide: right to the last digits, or refused."""

from __future__ import annotations

from functools import partial

import numpy as np
import pytest

from msvalidate.problem import SolverError
from msvalidate.springs.dynamics.integrate import State, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.laws.volumes import Volumes

DT, STEPS = 0.01, 250
FORMS = {
    "compiled": partial(euler_cromer, path="auto"),
    "plain": partial(euler_cromer, path="plain"),
    "verlet": lambda network, state, *rest, **_: motion(
        network, state, INTEGRATORS["velocity_verlet"], *rest
    ),
}
every_form = pytest.mark.parametrize("form", FORMS)


def loaded(force, x=0.0):
    """One mass on one spring along x, whose held end is at (x, x), under a load (N)."""
    held = [[True, True], [False, True]]
    return spring_network(
        [[x, x], [x + 1, x]], [[0, 1]], 1.0, fixed=held, force=[[0, 0], [force, 0]]
    )


def still(network):
    return State(network.points, np.zeros(network.points.shape))


@every_form
@pytest.mark.parametrize(("x", "force"), [(5.2e6, 1e-8), (0.0, 1e-17)])
def test_a_motion_below_rounding_of_positions_is_refused(form, x, force):
    network = loaded(force, x)
    with pytest.raises(
        SolverError, match=r"where rounding of positions and lengths is .* m; move the body"
    ):
        FORMS[form](network, still(network), DT, STEPS)


@every_form
def test_a_kick_below_rounding_of_positions_is_refused(form):
    network = loaded(0.0, 5.2e6)
    kicked = State(network.points, np.array([[0, 0], [1e-8, 0]]))
    with pytest.raises(SolverError, match="rounding of positions"):
        FORMS[form](network, kicked, DT, STEPS)


def test_a_point_at_the_origin_on_a_long_spring_is_refused_by_the_compiled_form():
    network = loaded(1e-17, -1.0)
    with pytest.raises(SolverError, match=r"displacements of about 3e-17 m where rounding of"):
        euler_cromer(network, still(network), DT, STEPS)


@every_form
def test_loads_raised_as_told_are_answered(form):
    with pytest.raises(SolverError) as told:
        FORMS[form](loaded(4e-15), still(loaded(0.0)), DT, STEPS)
    times = float(str(told.value).split()[-2])
    FORMS[form](loaded(times * 4e-15), still(loaded(0.0)), DT, STEPS)


def test_uneven_springs_do_not_make_a_motion_too_small():
    """Displacements of 3e-14 m have two digits beside 1 m, however short a spring is."""
    held = [[True, True], [False, True], [False, True]]
    network = spring_network(
        [[0, 0], [1e-3, 0], [1, 0]],
        [[0, 1], [1, 2]],
        1.0,
        fixed=held,
        force=[[0, 0]] * 2 + [[3e-14, 0]],
    )
    end = euler_cromer(network, still(network), DT, 1)
    assert end.velocity[2, 0] == pytest.approx(3e-16, rel=1e-9)


# What is not refused -------------------------------------------------------------------------


def rotated_square(x=0.0):
    """Points of a square with diagonals and an area, turned so that no length is exact."""
    turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
    points = np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]]) @ turn + x
    springs = [[0, 1], [2, 3], [0, 2], [1, 3], [0, 3], [1, 2]]
    return points, springs


@every_form
@pytest.mark.parametrize("cells", [False, True])
@pytest.mark.parametrize("x", [0.0, 5.2e6])
def test_a_body_at_rest_stays_there_call_after_call(form, cells, x):
    points, springs = rotated_square(x)
    volumes = Volumes(points, [[0, 1, 2], [1, 3, 2]], np.ones(2)) if cells else None
    network = spring_network(points, springs, 3.0, volumes=volumes)
    state = still(network)
    for _ in range(3):
        state = FORMS[form](network, state, DT, 20)
    np.testing.assert_array_equal(state.position, points)
    np.testing.assert_array_equal(state.velocity, 0.0)


@every_form
def test_what_decays_comes_to_rest_in_many_calls(form):
    network = loaded(0.0)
    state = State(network.points + np.array([[0, 0], [1e-9, 0]]), np.zeros((2, 2)))
    for _ in range(40):
        state = FORMS[form](network, state, 0.1, 100, 1.0)
    np.testing.assert_allclose(state.position, network.points, rtol=0, atol=1e-15)


@every_form
def test_a_first_step_of_a_motion_with_digits_is_none_too_small(form):
    network = loaded(1e-3)
    end = FORMS[form](network, still(network), 1e-9, 1)
    assert end.velocity[1, 0] == pytest.approx(1e-12, rel=1e-9)
