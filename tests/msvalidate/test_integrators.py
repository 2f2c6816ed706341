"""Each scheme is held to what it says of itself: order, limit, areas; the misprints measured."""

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate import integrate
from msvalidate.integrate import (
    StabilityWarning,
    State,
    motion,
    recommended_time_step,
    staggered,
)
from msvalidate.integrators import (
    EULER_CROMER,
    INTEGRATORS,
    Moving,
    growth,
    one_step_matrix,
    stability_limit,
)
from msvalidate.network import energy, spring_network, tangent
from msvalidate.problem import ProblemError, SolverError
from msvalidate.spectrum import extreme_frequencies
from msvalidate.volumes import Volumes

TRUE = {name: scheme for name, scheme in INTEGRATORS.items() if not scheme.variant}
every_scheme = pytest.mark.parametrize("name", INTEGRATORS)
true_schemes = pytest.mark.parametrize("name", TRUE)
OMEGA = 2.0
ZETAS = (0.0, 0.05, 0.3, 0.7, 1.0, 1.5, 2.0, 10.0)
examples = settings(max_examples=25, deadline=None)


def end_of(scheme, steps, time=2.0, *, omega=OMEGA):
    """Position of x'' = -ω²x from (1, 0) after a time, by powers of the scheme's own matrix."""
    h = time / steps
    matrix = one_step_matrix(scheme, omega, h)
    start = [1.0, 0.5 * h * omega**2] if scheme.staggered else [1.0, 0.0]
    return (np.linalg.matrix_power(matrix, steps) @ start)[0]


@every_scheme
@pytest.mark.parametrize("zeta", ZETAS)
def test_limits_are_where_the_matrix_says(name, zeta):
    """Stable over the whole range below the limit, unstable just above it."""
    scheme, damping = INTEGRATORS[name], 2 * zeta * OMEGA
    limit = stability_limit(scheme, OMEGA, OMEGA, damping)
    # Undamped, a symplectic scheme's eigenvalues lie on the circle to rounding.
    for part in np.linspace(0.01, 0.999, 60):
        assert growth(scheme, OMEGA, part * limit, damping) <= 1 + 1e-12 if limit else True
    above = 1.01 * limit or 1e-3
    assert growth(scheme, OMEGA, above, damping) > 1 + 1e-7


@pytest.mark.parametrize(
    ("zeta", "limit"), [(0, 2), (0.05, 1.952), (0.3, 1.82), (1.0, 2.0), (2.0, 1.0)]
)
def test_velocity_verlet_under_damping(zeta, limit):
    found = stability_limit(INTEGRATORS["velocity_verlet"], 1.0, 1.0, 2 * zeta)
    assert found == pytest.approx(limit, abs=0.005)


@pytest.mark.parametrize("zeta", [5e-324, 1e-310, 1e-17, 1e-9, 1e300])
@every_scheme
def test_limits_at_the_ends_of_the_numbers(name, zeta):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        limit = INTEGRATORS[name].limit(zeta)
    nearly = INTEGRATORS[name].limit(1e-6 if zeta < 1 else 1e9)
    if zeta < 1:
        assert limit <= nearly * (1 + 1e-5)
    else:
        assert 0 <= limit <= nearly


def test_explicit_euler_needs_both_ends_of_the_spectrum():
    scheme, damping = INTEGRATORS["explicit_euler"], 1.0
    limit = stability_limit(scheme, 0.01, 1.5, damping)
    modes = np.geomspace(0.01, 1.5, 200)
    singly = [stability_limit(scheme, omega, omega, damping) for omega in modes]
    assert limit == pytest.approx(min(singly), rel=1e-12)
    assert stability_limit(scheme, 1e-6, 0.9, damping) == pytest.approx(damping / 0.9**2)
    assert stability_limit(scheme, 0.01, 0.6, damping) == pytest.approx(2 / damping, rel=1e-3)


@every_scheme
@pytest.mark.parametrize("damping", [0.05, 1.0, 7.0])
def test_the_ends_bound_every_mode_between(name, damping):
    scheme = INTEGRATORS[name]
    limit = stability_limit(scheme, 0.1, 5.0, damping)
    for omega in np.geomspace(0.1, 5.0, 60):
        assert growth(scheme, omega, 0.999 * limit, damping) <= 1 + 1e-12


@true_schemes
def test_orders(name):
    scheme = INTEGRATORS[name]
    steps = 100 * 2 ** np.arange(6)
    errors = [abs(end_of(scheme, n) - np.cos(2 * OMEGA)) for n in steps]
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.abs(orders - scheme.order).max() < 0.1


@every_scheme
@pytest.mark.parametrize("h", [0.01, 0.3])
def test_symplectic_schemes_keep_areas(name, h):
    scheme = INTEGRATORS[name]
    area = np.linalg.det(one_step_matrix(scheme, OMEGA, h))
    assert (abs(area - 1) < 1e-14) == scheme.symplectic


def test_euler_cromer_as_printed_is_explicit_euler():
    printed, euler = INTEGRATORS["euler_cromer_as_printed"], INTEGRATORS["explicit_euler"]
    for h, damping in ((0.1, 0.0), (0.3, 0.7)):
        found = one_step_matrix(printed, OMEGA, h, damping)
        np.testing.assert_array_equal(found, one_step_matrix(euler, OMEGA, h, damping))


def test_verlet_as_printed_moves_under_half_the_force():
    """It converges, with order 1, to the motion at ω/√2, and is stable to 2√2/ω."""
    scheme = INTEGRATORS["verlet_as_printed"]
    steps = 200 * 2 ** np.arange(5)
    errors = [abs(end_of(scheme, n) - np.cos(2 * OMEGA / np.sqrt(2))) for n in steps]
    np.testing.assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 1, atol=0.1)
    assert abs(end_of(scheme, steps[-1]) - np.cos(2 * OMEGA)) > 0.2, "not the motion itself"
    assert stability_limit(scheme, 1.0, 1.0) == pytest.approx(2 * np.sqrt(2))


def test_verlet_with_the_old_force_twice_is_never_stable_undamped():
    assert stability_limit(INTEGRATORS["verlet_lagged"], 1.0, 1.0) == 0


@pytest.mark.parametrize(
    ("arguments", "error", "message"),
    [
        ((2.0, 1.0), ProblemError, "from 2 to 1 rad/s; give the lowest first"),
        ((0.0, 1.0), ProblemError, "lowest frequency"),
        ((1.0, np.nan), ProblemError, "highest frequency"),
        ((1.0, 1.0, -1.0), ProblemError, "a negative rate feeds the motion"),
        ((1e-320, 1e-310), SolverError, "choose a unit of time"),
    ],
)
def test_limits_of_what_is_none(arguments, error, message):
    with pytest.raises(error, match=message):
        stability_limit(INTEGRATORS["leapfrog"], *arguments)


# --- on networks ----------------------------------------------------------------------------------


def rates(network, record):
    return record["damping"] / network.mass


def state_of(network, record):
    v = record["initial_velocity"]
    velocity = np.zeros(network.points.shape) if v == "zero" else np.array(v)
    return State(network.points, velocity)


both_records = pytest.mark.parametrize("record_name", ["s1", "s2"])
STORED_STEPS = [1, 100, 2000]
"""At which the records have results: with another recipe, the middle one is farthest off."""


def same(end, result):
    """Whether a state is the stored one: positions of 0.1 m and velocities of 1 m/s, rounded."""
    np.testing.assert_allclose(end.position, result["positions"], rtol=0, atol=1e-12)
    np.testing.assert_allclose(end.velocity, result["velocities"], rtol=0, atol=1e-11)


@both_records
def test_every_stored_trajectory_is_compared(independent, record_name):
    _, record = independent(record_name)
    for recipe in ("results", "results_euler_cromer"):
        assert [result["steps"] for result in record[recipe]] == STORED_STEPS


def test_velocity_verlet_is_that_of_an_independent_program(independent):
    network, record = independent("s1")
    for result in record["results"]:
        scheme = INTEGRATORS["velocity_verlet"]
        same(
            motion(network, state_of(network, record), scheme, record["dt"], result["steps"]),
            result,
        )


def test_undamped_leapfrog_has_the_positions_of_velocity_verlet(independent):
    network, record = independent("s1")
    start = staggered(network, state_of(network, record), record["dt"])
    for result in record["results"]:
        end = motion(network, start, INTEGRATORS["leapfrog"], record["dt"], result["steps"])
        np.testing.assert_allclose(end.position, result["positions"], rtol=0, atol=1e-12)


@both_records
def test_euler_cromer_is_that_of_an_independent_program(independent, record_name):
    network, record = independent(record_name)
    start, rate, dt = state_of(network, record), rates(network, record), record["dt"]
    for result in record["results_euler_cromer"]:
        same(motion(network, start, EULER_CROMER, dt, result["steps"], rate), result)


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
    """(dt/2)(a - c v), none at held points: half a kick less than a whole one, at the old place."""
    early = staggered(network, state, dt, rate).velocity
    return np.where(network.held, 0.0, state.velocity - early)


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


def angular_momentum(network, position, velocity):
    """Σ m x × v, of the plane as a space with z = 0."""
    in_space = [np.pad(values, ((0, 0), (0, 3 - network.dim))) for values in (position, velocity)]
    return network.mass @ np.cross(*in_space)


@pytest.mark.parametrize("name", [name for name, scheme in TRUE.items() if scheme.symplectic])
@examples
@given(data=st.data())
def test_angular_momentum_is_kept_without_supports(name, networks, data):
    """By the schemes that keep areas; explicit Euler adds v × a once in a step's square."""
    network, position = data.draw(networks(stressed=True))
    network = spring_network(network.points, network.springs, network.stiffness, mass=network.mass)
    velocity = np.random.default_rng(len(position)).normal(size=position.shape)
    end = motion(network, State(position, velocity), INTEGRATORS[name], 1e-3, 5)
    before = angular_momentum(network, position, velocity)
    after = angular_momentum(network, end.position, end.velocity)
    scale = network.mass.sum() * np.abs(position).max() + network.stiffness.sum()
    assert (np.abs(after - before) <= 1e-12 * scale).all()


def energies(scheme, steps, periods=3):
    """Energy (J) of the undamped oscillator of unit mass, from (1, 0), at synchronised velocity."""
    h = 2 * np.pi / OMEGA / steps
    matrix = one_step_matrix(scheme, OMEGA, h)
    state = np.array([1.0, 0.5 * h * OMEGA**2 if scheme.staggered else 0.0])
    found = []
    for _ in range(periods * steps):
        x, v = state
        v = v - 0.5 * h * OMEGA**2 * x if scheme.staggered else v
        found.append(0.5 * v * v + 0.5 * OMEGA**2 * x * x)
        state = matrix @ state
    return np.array(found)


@pytest.mark.parametrize(
    ("name", "power"), [("euler_cromer", 1), ("leapfrog", 2), ("velocity_verlet", 2)]
)
def test_energy_fluctuates_with_a_power_of_the_step(name, power):
    steps = 50 * 2 ** np.arange(5)
    spread = [np.ptp(energies(INTEGRATORS[name], n)) for n in steps]
    orders = np.log2(np.array(spread[:-1]) / spread[1:])
    assert np.abs(orders - power).max() < 0.1


@pytest.mark.parametrize("name", ["euler_cromer", "leapfrog", "velocity_verlet"])
def test_energy_does_not_drift(name):
    """h·ω = 2 sin(π/63) makes a period 63 steps, after which the state is back to rounding."""
    matrix = one_step_matrix(INTEGRATORS[name], OMEGA, 2 * np.sin(np.pi / 63) / OMEGA)
    after = np.linalg.matrix_power(matrix, 63)
    np.testing.assert_allclose(after, np.eye(2), atol=1e-13)
    # Ten thousand periods on, the rounding of 630 000 steps.
    far = np.linalg.matrix_power(matrix, 63 * 10_000)
    np.testing.assert_allclose(far, np.eye(2), atol=1e-9)


@pytest.mark.parametrize("name", ["velocity_verlet", "leapfrog"])
@examples
@given(data=st.data())
def test_motion_runs_backwards(name, networks, data):
    """Turned round, the undamped motion goes back where it came from."""
    network, position = data.draw(networks(stressed=True))
    scheme, dt = INTEGRATORS[name], 1e-3
    start = State(position, np.zeros_like(position))
    begin = staggered(network, start, dt) if scheme.staggered else start
    forth = motion(network, begin, scheme, dt, 8)
    turned = State(forth.position, -forth.velocity)
    if (
        scheme.staggered
    ):  # after the turn, the velocity half a step on is the one half a step before
        later = staggered(network, State(forth.position, np.zeros_like(position)), 2 * dt).velocity
        turned = State(forth.position, -(forth.velocity - later))
    back = motion(network, turned, scheme, dt, 8)
    np.testing.assert_allclose(back.position, position, atol=1e-12)


MIRRORED = {
    (2, 3): [0, 2, 1],
    (2, 4): [0, 3, 2, 1],
    (3, 4): [0, 2, 1, 3],
    (3, 8): [0, 3, 2, 1, 4, 7, 6, 5],
}
"""(axes, corners) of a cell -> its corners as VTK lists them after a reflection."""


@every_scheme
@examples
@given(data=st.data(), seed=st.integers(0, 2**32 - 1))
def test_numbering_place_and_direction_change_nothing(name, networks, data, seed):
    """In another order of points and springs, moved, turned and mirrored: the same motion."""
    network, position = data.draw(networks(stressed=True))
    rng = np.random.default_rng(seed)
    turn, _ = np.linalg.qr(rng.normal(size=(network.dim, network.dim)))
    away = rng.uniform(-3, 3, network.dim)
    order, springs = (rng.permutation(len(rows)) for rows in (position, network.springs))
    number = np.argsort(order)
    points, cells = network.points[order] @ turn + away, network.volumes
    if cells is not None:  # in a mirror what was counter-clockwise is clockwise
        corners = number[cells.cells]
        if np.linalg.det(turn) < 0:
            corners = corners[:, MIRRORED[network.dim, corners.shape[1]]]
        cells = Volumes(points, corners, cells.stiffness)
    other = spring_network(
        points,
        number[network.springs[springs]],
        network.stiffness[springs],
        rest_length=network.rest_length[springs],
        mass=network.mass[order],
        force=network.force[order] @ turn,
        volumes=cells,
    )
    velocity, rate = rng.normal(size=position.shape), rng.uniform(0, 1, len(position))
    one, two = (
        motion(n, State(x, v), INTEGRATORS[name], 1e-3, 8, c, warn=False)
        for n, x, v, c in (
            (network, position, velocity, rate),
            (other, position[order] @ turn + away, velocity[order] @ turn, rate[order]),
        )
    )
    np.testing.assert_allclose(two.position, one.position[order] @ turn + away, atol=1e-12)
    np.testing.assert_allclose(two.velocity, one.velocity[order] @ turn, atol=1e-10)


@true_schemes
@pytest.mark.parametrize("zeta", [0.01, 0.1])
def test_under_viscosity_the_mean_energy_of_a_cycle_falls(name, zeta):
    """Cycle after cycle, at the damped motion's own rate, while h·ω ≤ 0.1; a step may rise."""
    scheme, per_cycle, cycles = INTEGRATORS[name], 100, 20
    h, damping = 2 * np.pi / OMEGA / per_cycle, 2 * zeta * OMEGA
    matrix = one_step_matrix(scheme, OMEGA, h, damping)
    state, found = np.array([1.0, 0.0]), []
    for _ in range(cycles * per_cycle):
        state = matrix @ state
        found.append(0.5 * state[1] ** 2 + 0.5 * (OMEGA * state[0]) ** 2)
    means = np.array(found).reshape(cycles, per_cycle).mean(axis=1)
    growing = name == "explicit_euler" and stability_limit(scheme, OMEGA, OMEGA, damping) < h
    assert (np.diff(means) > 0).all() if growing else (np.diff(means) < 0).all()


def string(n=12):
    points = np.column_stack([np.arange(n), np.zeros(n)]).astype(float)
    held = np.ones((n, 2), dtype=bool)
    held[1:-1, 0] = False
    return spring_network(
        points, [[i, i + 1] for i in range(n - 1)], 3.0, mass=np.linspace(1, 2, n), held=held
    )


@true_schemes
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


@every_scheme
def test_steps_beyond_the_limit_are_warned_of_before_they_are_taken(name):
    network, scheme, damping = string(), INTEGRATORS[name], 0.2
    start = State(network.points, np.zeros((12, 2)))
    limit = recommended_time_step(network, scheme, safety=1.0, damping=damping)
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


def test_the_bound_bounds_and_is_near():
    network = string()
    _, highest = extreme_frequencies(network)
    assert highest <= network.frequency_bound < 1.2 * highest


@examples
@given(data=st.data())
def test_the_bound_holds_for_any_network(networks, data):
    network, _ = data.draw(networks(stressed=False))
    assert highest_or_rigid(network) <= network.frequency_bound * (1 + 1e-12)


def highest_or_rigid(network):
    mass = np.repeat(network.mass, network.dim)
    K = tangent(network, network.points).toarray() / np.sqrt(np.outer(mass, mass))
    return np.sqrt(np.linalg.eigvalsh(K)[-1])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"safety": 0.0}, "safety: 0; give a part of the limit"),
        ({"safety": 1.5}, "safety: 1.5; give a part of the limit"),
        ({"integrator": INTEGRATORS["explicit_euler"]}, "explicit_euler: unstable at any step"),
        (
            {"integrator": INTEGRATORS["explicit_euler"], "damping": np.linspace(0, 1, 12)},
            "give one rate for all points",
        ),
    ],
)
def test_no_step_to_recommend(change, message):
    usual = {"integrator": INTEGRATORS["leapfrog"]} | change
    with pytest.raises(ProblemError, match=message):
        recommended_time_step(string(), **usual)


@pytest.mark.parametrize("name", ["euler_cromer", "leapfrog", "velocity_verlet"])
@pytest.mark.parametrize("most", [1.1, 1.6, 3.0])
def test_recommended_steps_are_stable_with_a_rate_a_point(name, most):
    """By the spectral radius of the whole network's step; Verlet's limit is lowest in between."""
    network = string()
    rates = np.linspace(0.0, most * 2.0, 12)
    free = np.flatnonzero(~network.held.ravel())
    K = tangent(network, network.points).toarray()[np.ix_(free, free)]
    mass, c = np.repeat(network.mass, 2)[free], np.repeat(rates, 2)[free]
    h = recommended_time_step(network, INTEGRATORS[name], safety=1.0, damping=rates)
    size = len(free)
    columns = []
    for unit in np.eye(2 * size):
        x, v = unit[:size], unit[size:]
        end = INTEGRATORS[name].step(
            lambda x: -(K @ x) / mass, Moving(x, v, -(K @ x) / mass), 0.999 * h, c
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


@every_scheme
def test_a_single_step_beyond_all_numbers_is_the_motions_failure(name):
    """A body that is free to fly, and does: 1e260 m in one step."""
    pair = spring_network([[0, 0], [1, 0]], [[0, 1]], 1.0)
    start = State(pair.points, np.full((2, 2), 1e60))
    with pytest.raises(SolverError, match=f"{name}: the motion grew beyond all bounds"):
        motion(pair, start, INTEGRATORS[name], 1e200, 3, warn=False)


@pytest.mark.parametrize("compiled", [True, False])
def test_a_run_a_little_beyond_its_limit_stops_where_it_has_blown_up(compiled):
    """Five per cent beyond, it doubles in a step or two: a million times its size is refused."""
    network, kick = string(), np.zeros((12, 2))
    kick[3, 0] = 1e-9
    start, dt = State(network.points, kick), recommended_time_step(string(), EULER_CROMER, safety=1)
    with pytest.raises(SolverError, match="euler_cromer: the motion grew beyond all bounds"):
        integrate.euler_cromer(network, start, 1.05 * dt, 400, compiled=compiled, warn=False)
