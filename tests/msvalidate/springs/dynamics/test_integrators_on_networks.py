"""Schemes on networks: stored trajectories, momenta, recommended steps, warnings, refusals."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm

from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs.dynamics import integrate
from msvalidate.springs.dynamics.divergence import StabilityWarning
from msvalidate.springs.dynamics.implicit import NetworkAcceleration
from msvalidate.springs.dynamics.integrate import State, motion, recommended_time_step
from msvalidate.springs.dynamics.integrators import EULER_CROMER, INTEGRATORS
from msvalidate.springs.dynamics.scheme import MotionState
from msvalidate.springs.dynamics.step_limits import SAFETY
from msvalidate.springs.network import energy, spring_network, tangent

TRUE = {name: scheme for name, scheme in INTEGRATORS.items() if not scheme.variant}
LIMITED = [name for name, scheme in INTEGRATORS.items() if scheme.limit(0.0) < np.inf]
limited_schemes = pytest.mark.parametrize("name", LIMITED)
true_schemes = pytest.mark.parametrize("name", TRUE)
examples = settings(max_examples=25, deadline=None)


def rates(network, record):
    return record["damping"] / network.mass


def state_of(network, record):
    v = record["initial_velocity"]
    velocity = np.zeros(network.points.shape) if v == "zero" else np.array(v)
    return State(network.points, velocity)


both_records = pytest.mark.parametrize("record_name", ["s1", "s2"])


def same(end, result):
    """Whether a state is the stored one: positions of 0.1 m and velocities of 1 m/s, rounded."""
    np.testing.assert_allclose(end.position, result["positions"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(end.velocity, result["velocities"], rtol=0, atol=1e-11)


@pytest.mark.parametrize("name", ["velocity_verlet", "leapfrog"])
def test_velocity_verlet_is_that_of_an_independent_program(independent, name):
    """Without damping leapfrog is velocity Verlet."""
    network, record = independent("s1")
    for result in record["results"]:
        start, scheme = state_of(network, record), INTEGRATORS[name]
        same(motion(network, start, scheme, record["dt"], result["steps"]), result)


@both_records
def test_its_damped_recipe_is_euler_cromer_after_half_a_kick(independent, record_name):
    """One damping value a point: the record's viscosity over each mass."""
    network, record = independent(record_name)
    start, rate, dt = state_of(network, record), rates(network, record), record["dt"]
    for result in record["results"]:
        same(after_half_kicks(network, start, rate, dt, result["steps"]), result)


def after_half_kicks(network, start, rate, dt, steps):
    """Half a kick, Euler-Cromer's steps, half a kick."""
    velocity = start.velocity + half_kick(network, start, rate, dt)
    first = State(start.position + dt * velocity, velocity)
    end = integrate.euler_cromer(network, first, dt, steps - 1, rate)
    return State(end.position, end.velocity + half_kick(network, end, rate, dt))


def half_kick(network, state, rate, dt):
    """(dt/2)(a - c v), zero at held points."""
    a = NetworkAcceleration(network)(state.position - network.points)
    return np.where(network.fixed, 0.0, 0.5 * dt * (a - rate[:, None] * state.velocity))


@true_schemes
@examples
@given(data=st.data())
def test_momentum_is_kept_without_supports(name, networks, data):
    network, position = data.draw(networks(stressed=True))
    network = spring_network(network.points, network.springs, network.stiffness, mass=network.mass)
    velocity = np.random.default_rng(len(position)).normal(size=position.shape)
    end = motion(network, State(position, velocity), INTEGRATORS[name], 1e-3, 5, warn=False)
    moved = network.mass @ (end.velocity - velocity)
    scale = network.mass @ np.abs(velocity) + 1e-2 * network.stiffness.sum()
    assert (np.abs(moved) <= 1e-12 * scale).all()


def string(n=12):
    points = np.column_stack([np.arange(n), np.zeros(n)]).astype(float)
    held = np.ones((n, 2), dtype=bool)
    held[1:-1, 0] = False
    return spring_network(
        points, [[i, i + 1] for i in range(n - 1)], 3.0, mass=np.linspace(1, 2, n), fixed=held
    )


TIME, STEPS = 4.0, 200
"""Duration (s) of a motion and its number of steps: h·ω is at most 0.05, so that the next term of
an error is less than a tenth of the first, and halving the step shows the order to 0.15."""


def exact_motion(network, state, rate, dt):
    """Positions and velocities (2, f) along x of a linear string, one step after the other."""
    free = ~network.fixed[:, 0]
    K = tangent(network, network.points).toarray()[::2, ::2][np.ix_(free, free)]
    zero, one = np.zeros_like(K), np.eye(len(K))
    matrix = np.block([[zero, one], [-K / network.mass[free, None], -rate * one]])
    now, propagator = along(network, state).ravel(), expm(dt * matrix)
    while True:
        now = propagator @ now
        yield now.reshape(2, -1)


def along(network, state):
    """Displacements and velocities (2, f) along x of the free points."""
    both = np.array([state.position - network.points, state.velocity])
    return both[:, ~network.fixed[:, 0], 0]


@pytest.mark.parametrize(("points", "rate"), [(3, 0.0), (6, 0.3)])
@pytest.mark.parametrize("speed", [0.0, 0.1])
@true_schemes
def test_positions_and_velocities_have_the_order_that_is_claimed(name, speed, points, rate):
    """By the largest error of a motion that is continued half-way; Euler-Cromer has order one."""
    network, scheme = string(points), INTEGRATORS[name]
    aside = 0.1 * np.arange(points)[:, None] * ~network.fixed
    state, errors = State(network.points + aside, speed * np.cos(aside) * ~network.fixed), []
    for steps in (STEPS, 2 * STEPS):
        dt, error = TIME / steps, np.zeros(2)
        exact = exact_motion(network, state, rate, dt)

        def look(_, now, exact=exact, error=error):
            error[:] = np.maximum(error, np.abs(along(network, now) - next(exact)).max(axis=1))

        middle = motion(network, state, scheme, dt, steps // 2, rate, look, warn=False)
        motion(network, middle, scheme, dt, steps // 2, rate, look, warn=False)
        errors.append(error)
    order = np.log2(np.divide(*errors)).min()
    assert abs(order - (scheme.damped_order if rate else scheme.order)) < 0.15


@pytest.mark.parametrize("name", [name for name in LIMITED if name in TRUE])
def test_recommended_steps_are_stable_and_twice_the_limit_is_not(name):
    network, damping = string(), 0.2
    dt = recommended_time_step(network, INTEGRATORS[name], damping=damping)
    kick = np.zeros(network.points.shape)
    kick[3, 0] = 1e-3
    start = State(network.points, kick)
    end = motion(network, start, INTEGRATORS[name], dt, 400, damping)
    assert energy(network, end.position) < energy(network, network.points + kick) + 1e-5
    with np.errstate(all="ignore"), pytest.raises(SolverError, match=f"{name}: the motion grew"):
        motion(network, start, INTEGRATORS[name], 4 * dt, 20000, damping, warn=False)


@limited_schemes
def test_steps_beyond_the_limit_are_warned_of_before_they_are_taken(name):
    network, scheme, damping = string(), INTEGRATORS[name], 0.2
    start = State(network.points, np.zeros((12, 2)))
    limit = recommended_time_step(network, scheme, damping=damping) / SAFETY
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion(network, start, scheme, 0.999 * limit, 1, damping)
        motion(network, start, scheme, 1.01 * limit, 1, damping, warn=False)
    said = f"{name}: steps of .* s are beyond the stability limit, {limit:.4g} s at damping 0.2"
    with pytest.warns(StabilityWarning, match=said):
        motion(network, start, scheme, 1.01 * limit, 1, damping)


@pytest.mark.parametrize("name", ["explicit_euler", "verlet_lagged"])
def test_a_scheme_that_needs_damping_is_warned_of_without(name):
    start = State(string().points, np.zeros((12, 2)))
    with pytest.warns(StabilityWarning, match="beyond the stability limit, 0 s at damping 0"):
        motion(string(), start, INTEGRATORS[name], 1e-6, 1)


@pytest.mark.parametrize(("change", "message"), [
    ({"integrator": INTEGRATORS["explicit_euler"]}, "explicit_euler: unstable at any step"),
    ({"integrator": INTEGRATORS["explicit_euler"], "damping": np.linspace(0, 1, 12)},
        "give one rate for all points"),
])  # fmt: skip
def test_no_step_to_recommend(change, message):
    usual = {"integrator": INTEGRATORS["leapfrog"]} | change
    with pytest.raises(ProblemError, match=message):
        recommended_time_step(string(), **usual)


@pytest.mark.parametrize(
    "name", [name for name, scheme in INTEGRATORS.items() if 0 < scheme.limit(0.0) < np.inf]
)
@pytest.mark.parametrize("most", [1.1, 1.6, 3.0])
def test_recommended_steps_are_stable_with_a_rate_a_point(name, most):
    """By the spectral radius of the whole network's step; Verlet's limit is lowest in between."""
    network = string()
    rates = np.linspace(0.0, most * 2.0, 12)
    free = np.flatnonzero(~network.fixed.ravel())
    K = tangent(network, network.points).toarray()[np.ix_(free, free)]
    mass, c = np.repeat(network.mass, 2)[free], np.repeat(rates, 2)[free]
    h = recommended_time_step(network, INTEGRATORS[name], damping=rates) / SAFETY
    size = len(free)
    columns = []
    for unit in np.eye(2 * size):
        x, v = unit[:size], unit[size:]
        end = INTEGRATORS[name].step(
            lambda x: -(K @ x) / mass, MotionState(x, v, -(K @ x) / mass), 0.999 * h, c
        )
        columns.append(np.concatenate([end.x, end.v]))
    assert np.abs(np.linalg.eigvals(np.array(columns).T)).max() <= 1 + 1e-9


def test_a_watcher_sees_every_step():
    seen = []
    start = State(string().points, np.zeros((12, 2)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion(string(), start, INTEGRATORS["leapfrog"], 0.1, 3, watch=lambda n, _: seen.append(n))
    assert seen == [1, 2, 3]


def test_a_step_beyond_all_numbers_is_told_how_long_it_may_be():
    """Of a scheme without a limit, in flight; what is told can be taken."""
    pair, scheme = (
        spring_network([[0, 0], [1, 0]], [[0, 1]], 1.0),
        INTEGRATORS["average_acceleration"],
    )
    start = State(pair.points, np.full((2, 2), 0.1))
    told = "stable at any step, but digits are lost beyond .* s: take smaller ones"
    with pytest.raises(SolverError, match=told) as error:
        motion(pair, start, scheme, 1e12, 3)
    most = float(str(error.value).split()[-5])
    assert 6e6 < most < 7.2e6
    motion(pair, start, scheme, 0.99 * most, 3)


def test_a_motion_that_grows_below_the_limit_of_small_ones_is_told_so():
    """A string that is a hundredth too short: aside by ten lengths it is ten times as fast."""
    points, held = [[-1, 0], [0, 0], [1, 0]], [[1, 1], [1, 0], [1, 1]]
    tight = spring_network(points, [[0, 1], [1, 2]], 3.0, mass=2.0, rest_length=0.99, fixed=held)
    dt = recommended_time_step(tight, EULER_CROMER)
    aside = State(tight.points + np.array([[0, 0], [0, 10.0], [0, 0]]), np.zeros((3, 2)))
    with pytest.raises(SolverError, match="s, is that of small motions: take smaller"):
        motion(tight, aside, EULER_CROMER, dt, 100)


@pytest.mark.parametrize("path", ["auto", "plain"])
def test_a_run_a_little_beyond_its_limit_stops_where_it_has_blown_up(path):
    """Five per cent beyond, it doubles in a step or two: a million times its size is refused."""
    network, kick = string(), np.zeros((12, 2))
    kick[3, 0] = 1e-9
    start, dt = State(network.points, kick), recommended_time_step(string(), EULER_CROMER) / SAFETY
    with pytest.raises(SolverError, match="euler_cromer: the motion grew beyond all bounds"):
        integrate.euler_cromer(network, start, 1.05 * dt, 400, path=path, warn=False)
