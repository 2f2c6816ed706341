"""Euler-Cromer: against independent trajectories, the exact linear map, and its own invariants."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import eigvals

from msvalidate.problem import ProblemError
from msvalidate.springs.dynamics.integrate import State, damping_rate, euler_cromer
from msvalidate.springs.dynamics.integrators import EULER_CROMER
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.network import spring_network, tangent
from tests.table import table

NAN = float("nan")
SMALL = 1e-9
"""Amplitude (m) of a motion that must stay linear: rounding is 1e-16 of the spring's metre."""
examples = settings(max_examples=25, deadline=None)


def oscillator(stiffness=4.0, mass=1.0):
    """One point on one spring along x: its frequency is √(k/m)."""
    held = [[True, True], [False, True]]
    return spring_network([[0, 0], [1, 0]], [[0, 1]], stiffness, mass=mass, fixed=held)


def along_x(value):
    """The oscillator's point by `value` along x, its fixed end by nothing."""
    return np.array([[0.0, 0.0], [value, 0.0]])


def one_step(omega, damping, dt):
    """Matrix of one Euler-Cromer step of (x, v) for x'' = -ω²x - damping·x'."""
    kick = np.array([[1.0, 0.0], [-dt * omega**2, 1 - dt * damping]])
    drift = np.array([[1.0, dt], [0.0, 1.0]])
    return drift @ kick


# Against independent trajectories -------------------------------------------------------------


@pytest.mark.parametrize("path", ["auto", "plain"])
@pytest.mark.parametrize("name", ["s1", "s2"])
def test_trajectories_are_those_of_an_independent_code(independent, name, path):
    network, record = independent(name)
    start = record["initial_velocity"]
    velocity = np.zeros(network.points.shape) if start == "zero" else np.array(start)
    damping = record["damping"] / network.mass  # a viscosity in N s/m, and ours is a rate
    for result in record["results_euler_cromer"]:
        state = State(network.points, velocity)
        end = euler_cromer(network, state, record["dt"], result["steps"], damping, path=path)
        # Positions of 0.1 m and velocities of 1 m/s, 2000 steps of rounding: 1e-15 and 1e-12.
        np.testing.assert_allclose(end.position, result["positions"], rtol=0, atol=1e-10)
        np.testing.assert_allclose(end.velocity, result["velocities"], rtol=0, atol=1e-9)


# Against theory -------------------------------------------------------------------------------


@pytest.mark.parametrize("damping", [0.0, 0.5, 4.0, 9.0])
@pytest.mark.parametrize("path", ["auto", "plain"])
def test_a_small_oscillation_is_the_exact_linear_map(damping, path):
    network = oscillator(stiffness=12.0, mass=3.0)
    start = State(network.points + along_x(SMALL), along_x(2 * SMALL))
    end = euler_cromer(network, start, 0.05, 30, damping, path=path)
    expected = np.linalg.matrix_power(one_step(2.0, damping, 0.05), 30) @ [SMALL, 2 * SMALL]
    # Positions near 1 m are rounded to 1e-16 at each of 30 steps.
    found = [end.position[1, 0] - 1, end.velocity[1, 0]]
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-14)


@examples
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_highest_frequency_and_largest_rate_bound_a_whole_network(networks, data, seed):
    network, _ = data.draw(networks(stressed=False))
    rng = np.random.default_rng(seed)
    rate = np.repeat(rng.uniform(0, 5, len(network.mass)), network.dim)
    scale = 1 / np.sqrt(np.repeat(network.mass, network.dim))
    K = scale[:, None] * tangent(network, network.points).toarray() * scale
    highest = np.sqrt(np.linalg.eigvalsh(K)[-1])
    dt = 0.99 * stability_limit(EULER_CROMER, highest, highest, rate.max())
    one, none = np.eye(len(K)), np.zeros_like(K)
    kick = np.block([[one, none], [-dt * K, np.diag(1 - dt * rate)]])
    drift = np.block([[one, dt * one], [none, one]])
    # Rigid motions keep a double eigenvalue 1, which splits by the root of rounding.
    assert np.abs(eigvals(drift @ kick)).max() <= 1 + 1e-6


def test_viscosity_is_a_rate_per_point():
    # Two free points without force between them: each velocity falls by (1 - c h) a step.
    network = spring_network([[0, 0], [1, 0]], [[0, 1]], [0.0], mass=[1.0, 7.0])
    start = State(network.points, np.array([[0, 1.0], [0, 1.0]]))
    end = euler_cromer(network, start, 0.1, 5, [1.0, 2.0])
    np.testing.assert_allclose(end.velocity[:, 1], [0.9**5, 0.8**5], rtol=1e-14)


def test_a_constant_force_accelerates_by_force_over_mass():
    network = spring_network([[0, 0], [1, 0]], [[0, 1]], [0.0], mass=[1.0, 4.0], force=[[0, 2]] * 2)
    end = euler_cromer(network, State(network.points, np.zeros((2, 2))), 0.1, 3)
    np.testing.assert_allclose(end.velocity[:, 1], [0.6, 0.15], rtol=1e-14)
    # x_n = (F/m) h² n (n + 1)/2: the position follows the new velocity.
    np.testing.assert_allclose(end.position[:, 1], [0.12, 0.03], rtol=1e-14)


# Bad input ------------------------------------------------------------------------------------


@table(
    ("change", "message"),
    [
        ({"dt": 0.0}, "time step dt: 0.0 s; it must be above zero"),
        ({"dt": -0.1}, "time step dt: -0.1 s; it must be above zero"),
        ({"dt": NAN}, "time step dt: nan"),
        ({"steps": -1}, "steps: -1; give a whole number, 0 or more"),
        ({"steps": 2.5}, "steps: 2.5; give a whole number, 0 or more"),
        ({"damping": -0.5}, "damping: -0.5 1/s; a negative rate feeds the motion"),
        ({"damping": [0.1, -0.5]}, "damping: -0.5 1/s; a negative rate feeds the motion"),
        ({"damping": NAN}, "damping: nan"),
        ({"damping": [0.1, 0.1, 0.1]}, "damping: shape (3,); give one number or 2 values"),
        ({"damping": np.zeros((2, 2))}, "damping: shape (2, 2); give one number or 2 values"),
        ({"state": State(np.zeros((3, 2)), np.zeros((2, 2)))}, "position: shape (3, 2); give"),
        ({"state": State(np.zeros((2, 2)), np.zeros(2))}, "velocity: shape (2,); give (2, 2)"),
        ({"state": State(np.full((2, 2), NAN), np.zeros((2, 2)))}, "position: nan at index (0, 0)"),
    ],
)
def test_bad_input_is_refused(change, message):
    usual = {"state": State(oscillator().points, np.zeros((2, 2))), "dt": 0.1, "steps": 1}
    with pytest.raises(ProblemError, match=re.escape(message)):
        euler_cromer(oscillator(), **(usual | change))


def test_one_rate_serves_for_all_points():
    np.testing.assert_array_equal(damping_rate(oscillator(), 0.3), [0.3, 0.3])
    np.testing.assert_array_equal(damping_rate(oscillator(), [0.3, 0.0]), [0.3, 0.0])
