"""The study `damping`: its closed forms, its resolution."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from msvalidate.studies.damping import (
    advice,
    bodies,
    damping_controls,
    decay,
    direction,
    figure2,
    rest,
    stop_rule,
    wave,
)
from scipy.linalg import eigh

from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import SolverError
from msvalidate.springs.dynamics.integrate import State, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.statics.equilibrium import equilibrium

QUICK = Setting(quick=True)


@pytest.fixture(scope="module")
def plate():
    return bodies.loaded("plate", (3, 3), "across")


# --- bodies ---------------------------------------------------------------------------------------


def test_modes_diagonalise(plate):
    M = np.repeat(plate.network.mass, 2)
    assert plate.shapes * M @ plate.shapes.T == pytest.approx(
        np.eye(len(plate.frequencies)), abs=1e-9
    )
    assert np.linalg.norm(plate.shares) == pytest.approx(1)
    assert plate.norm(plate.rest) == pytest.approx(np.linalg.norm(plate.amplitudes(plate.rest)))
    assert plate.error(plate.start) == 1


def test_rest_is_the_equilibrium_and_small(plate):
    linear = equilibrium(plate.network).displacement
    assert np.abs(plate.rest - linear).max() < 1e-5 * np.abs(linear).max()
    assert np.abs(linear).max() == pytest.approx(bodies.LOAD)


def test_symmetric_load_hides_the_lowest_mode():
    pulled = bodies.loaded("plate", (4, 4), "along")
    assert pulled.lowest_excited(rest.VISIBLE) == 1
    assert pulled.shares[0] < 1e-8
    assert bodies.loaded("plate", (4, 4), "across").lowest_excited(rest.VISIBLE) == 0


def test_left_bounds_what_is_to_come(plate):
    omega = float(plate.frequencies[0])
    state, c = plate.start, 0.2 * omega
    dt = plate.time_step(c, 0.2)
    bounds, errors = [], []
    for _ in range(300):
        state = euler_cromer(plate.network, state, dt, 1, c)
        bounds.append(plate.left(state))
        errors.append(plate.error(state))
    worst_to_come = np.maximum.accumulate(errors[::-1])[::-1]
    assert (worst_to_come <= np.array(bounds) * (1 + 1e-2)).all()


# --- rest -----------------------------------------------------------------------------------------


def test_steps_are_counted_to_the_look(plate):
    omega = float(plate.frequencies[0])
    c, look = 2 * omega, 3
    dt = plate.time_step(c)
    found = rest.count_steps(euler_cromer, plate, c, dt, look, (1e-2,))[1e-2]
    state = euler_cromer(plate.network, plate.start, dt, found, c)
    before = euler_cromer(plate.network, plate.start, dt, found - look, c)
    assert plate.error(state) <= 1e-2 < plate.error(before)
    assert found == rest.steps_of_modes(plate, c, dt, look, (1e-2,))[1e-2]


def test_a_run_that_never_rests_is_refused(plate):
    def frozen(_network, state, _dt, _steps, _damping):
        return state

    with pytest.raises(SolverError, match="no rest"):
        rest.count_steps(frozen, plate, 1.0, 0.01, 1000, (1e-2,))


# --- figure 2, stop rule --------------------------------------------------------------------------


def test_peaks_of_a_known_curve():
    t = np.arange(60)
    way = pd.Series(1 - np.exp(-0.02 * t) * np.cos(0.2 * t))
    found = figure2.peaks(way)
    first = (np.pi - np.arctan(0.02 / 0.2)) / 0.2
    assert found[0][0] == pytest.approx(first, abs=0.05)
    assert found[1][0] - found[0][0] == pytest.approx(2 * np.pi / 0.2, abs=0.05)
    assert figure2.peaks(pd.Series(1 - np.exp(-0.1 * t))) == []


def test_overshoots_in_theory():
    assert figure2.theory(1.0, 0.1, 1000) == []
    (step, height), *_ = figure2.theory(0.2, 0.1, 1000)
    omega = figure2.block().frequencies[0]
    assert step * 0.1 == pytest.approx(np.pi / (omega * np.sqrt(0.96)))
    assert height == pytest.approx(np.exp(-0.2 * np.pi / np.sqrt(0.96)))


def test_printed_loop_never_starts(plate):
    assert stop_rule.printed_rule(euler_cromer, plate, 0.01, 1.0, 1e-9) == 0


def test_stops_of_modes_are_those_of_the_run(plate):
    omega = float(plate.frequencies[0])
    dt, c = plate.time_step(omega), omega
    speeds = [part * omega * stop_rule.largest(plate.rest) for part in (0.1, 0.01)]
    for eps, told in zip(speeds, stop_rule.stops_of_modes(plate, c, dt, speeds), strict=True):
        state, steps = euler_cromer(plate.network, plate.start, dt, 1, c), 1
        while stop_rule.largest(state.velocity) > eps:
            state, steps = euler_cromer(plate.network, state, dt, 1, c), steps + 1
        assert told == steps


def test_stop_step_notices_another_damping():
    faulty = stop_rule.run(damping_controls.apply_fault("damping", 0.05), QUICK)
    quantity = stop_rule.RULES[0].quantity
    assert faulty.observed[quantity].error > stop_rule.RULES[0].limit


def test_a_rule_that_never_holds_is_refused():
    assert stop_rule.first(np.array([False, True, False])) == 1
    with pytest.raises(SolverError, match="does not hold"):
        stop_rule.first(np.array([False, False]))


def test_wrong_stops_are_counted_once_each():
    seen = stop_rule.Watch(
        speed=np.array([1.0, 0.05, 0.05, 1.0, 0.05, 1.0, 0.01]),
        error=np.array([2.0, 1.0, 1.0, 0.9, 0.1, 0.5, 0.01]),
        way=np.zeros(7),
        moving=np.zeros(7),
        pulling=np.zeros(7),
    )
    # At index 4 the error itself is small, but larger than three times 0.1 soon after.
    assert stop_rule.wrong_stops(seen, 0.1) == 2


# --- waves ----------------------------------------------------------------------------------------


def strip(cells, k):
    """Lowest symmetric frequency of a wave e^(ikx) on a strip of unit spacing, by its columns."""
    k1, k2 = bodies.ISOTROPIC
    rows = cells + 1
    K = np.zeros((2 * rows, 2 * rows), dtype=complex)
    M = np.ones(2 * rows)
    M[[0, 1, -2, -1]] = 0.5

    def spring(i, j, step, direction, stiffness):
        n = np.array(direction) / np.linalg.norm(direction)
        row = np.zeros(2 * rows, dtype=complex)
        row[2 * j : 2 * j + 2] += n * np.exp(1j * k * step)
        row[2 * i : 2 * i + 2] -= n
        K.__iadd__(stiffness * np.outer(row.conj(), row))

    for i in range(rows):
        spring(i, i, 1, (1, 0), k1 * (0.5 if i in (0, rows - 1) else 1))
        if i < cells:
            spring(i, i + 1, 0, (0, 1), k1)
            spring(i, i + 1, 1, (1, 1), k2)
            spring(i + 1, i, 1, (1, -1), k2)
    squares, vectors = eigh(K, np.diag(M))
    along = np.abs(M[::2] @ vectors[::2])
    return np.sqrt(squares[along.argmax()])


@pytest.mark.parametrize("cells", [1, 2, 4])
def test_dispersion_of_the_slender_bar(cells):
    # The terms that `wave` predicts, against the exact waves of the strip's columns.
    k = 0.02
    body = wave.bar("free", wave.CELLS_A_STEP * cells)
    assert round(body.height / body.spacing) == cells
    exact = strip(cells, k) / (body.speed * k)
    beta = body.beta / body.spacing**2
    assert (1 - exact) / k**2 == pytest.approx(beta, rel=2e-3)


def test_dispersion_of_the_held_bar():
    body = wave.bar("held", 100)
    k = 0.02
    exact = 2 * np.sin(k / 2) / k
    assert (1 - exact) / k**2 == pytest.approx(body.beta / body.spacing**2, rel=1e-4)


def test_peak_of_a_gaussian():
    t = np.linspace(0, 10, 41)
    assert wave.peak(t, 3 * np.exp(-((t - 4.33) ** 2) / 2)) == pytest.approx((4.33, 3.0))


# --- controls -------------------------------------------------------------------------------------


def test_new_velocity_is_what_it_says(plate):
    dt, c = 0.01, 3.0
    kicked = State(plate.network.points, 1e-6 * (1.0 - plate.network.fixed))
    found = damping_controls.apply_fault("viscous force from the new velocity", 1.0)(
        plate.network, kicked, dt, 1, c
    )
    undamped = motion(plate.network, kicked, INTEGRATORS["euler_cromer"], dt, 1, 0.0)
    wanted = undamped.velocity / (1 + dt * c)
    assert found.velocity == pytest.approx(wanted, rel=1e-9)
    assert found.position - plate.network.points == pytest.approx(dt * wanted, abs=1e-15)


def test_other_kick_is_lighter_masses(plate):
    found = damping_controls.apply_fault("kick", 0.2)(plate.network, plate.start, 0.02, 7, 0.5)
    lighter = replace(plate.network, mass=plate.network.mass / 1.2)
    wanted = euler_cromer(lighter, plate.start, 0.02, 7, 0.5)
    assert found.position - plate.network.points == pytest.approx(
        wanted.position - plate.network.points, rel=1e-6, abs=1e-14
    )
    assert found.velocity == pytest.approx(wanted.velocity, rel=1e-6, abs=1e-13)


@pytest.mark.parametrize("kind", damping_controls.KINDS)
def test_stated_resolution_is_the_real_one(kind):
    noticed = damping_controls.smallest(kind)["smallest_noticed"]

    def largest(size):
        return max(damping_controls.excesses(damping_controls.apply_fault(kind, size)).values())

    # Rounding is a tenth of a limit: what the extrapolation from a large fault cannot know.
    assert largest(1.3 * noticed) > 1
    assert largest(0.7 * noticed) < 1


# --- other questions ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("under", "said"),
    [([1.0, 1.5], "too little"), ([3.0, 4.0], "too much"), ([1.0, 3.0], "depends on the body")],
)
def test_advice_follows_the_prices(under, said):
    on = pd.MultiIndex.from_product([["plate"], rest.ERRORS], names=advice.ON)
    assert said in advice.finding(pd.Series(under, on), pd.Series([2.0, 2.0], on))


def test_free_pair_moves_as_one():
    pair = decay.free_pair()
    start = State(pair.points, np.full(pair.points.shape, 1e-3))
    end = euler_cromer(pair, start, 0.1, 3, 2.0)
    assert end.velocity == pytest.approx(1e-3 * 0.8**3)


def test_seed_changes_the_random_start_only():
    rows = [direction.try_direction(euler_cromer, seed, ("plate", 0.5)) for seed in (0, 1)]
    assert rows[0]["factor"] != rows[1]["factor"]
    for row in rows:
        assert row["factor"] == pytest.approx(row["factor_predicted"], rel=1e-7)
