"""The study `stability`: the search for limits, its controls."""

from dataclasses import replace

import numpy as np
import pytest
from msvalidate.studies.stability import (
    bounded,
    common,
    cost,
    drift,
    figure3,
    misprints,
    networks,
    order,
    oscillator,
    passing,
    runs,
    stability_controls,
)
from msvalidate.studies.stability import (
    growth as growing,
)
from msvalidate.studies.stability.networks import OSCILLATOR, Body, clamped, linear

from msvalidate.bench.judging.evidence import all_passed, judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.problem import ProblemError
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import MotionState
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.step_limits import one_step_matrix
from msvalidate.springs.network import tangent
from msvalidate.studies import stability
from tests.table import table

QUICK = Setting(quick=True)
REPORTED = {name: INTEGRATORS[name] for name in common.REPORTED}


@pytest.fixture(scope="module")
def tables(small_tables):
    return small_tables("stability")


def test_seed_changes_the_start_and_no_limit():
    body = linear(Body("square", 6))
    assert (body.start(0) != body.start(1)).any()
    assert all_passed(judge(stability.run(REPORTED, Setting(quick=True, seed=1), ("limits",))))


@pytest.mark.parametrize("question", ["limits", "growth", "misprints", "drift", "cost"])
def test_a_missing_scheme_is_refused(question):
    with pytest.raises(ProblemError, match="no scheme explicit_euler"):
        stability.run({"leapfrog": INTEGRATORS["leapfrog"]}, QUICK, (question,))


def test_another_scheme_is_held_to_its_claims():
    """A user's scheme beside ours: judged, and drawn."""
    mine = replace(INTEGRATORS["leapfrog"], name="mine")
    boastful = replace(mine, limit=lambda _: 2.1)
    for scheme, passes in ((mine, True), (boastful, False)):
        found = stability.run(REPORTED | {"mine": scheme}, QUICK, ("limits",))
        assert all_passed(judge(found)) == passes
        assert found.figures["atlas"](found.tables)


# --- the search for a limit -----------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", [name for name, scheme in INTEGRATORS.items() if scheme.limit(0.0) < np.inf]
)
def test_search_finds_the_limit_from_any_bracket(name):
    scheme, body = INTEGRATORS[name], linear(OSCILLATOR)
    zetas = np.array([z for z in (0.0, 0.05, 0.47, 0.56, 1.0, 2.0) if scheme.limit(z) > 0])
    expected = [scheme.limit(z) for z in zetas]
    for search in (bounded.Search(), bounded.Search(0.07, 5.0), bounded.Search(0.03, 9, 7, 4)):
        found = bounded.measured_limit(scheme, body, 2 * zetas, search, 0)
        np.testing.assert_allclose(found, expected, rtol=4 * search.resolution)
        for h, zeta in zip(found, zetas, strict=True):
            matrix = one_step_matrix(scheme, 1.0, 1.01 * h, 2 * zeta)
            assert np.abs(np.linalg.eigvals(matrix)).max() > 1


def test_search_ends_at_its_bracket_when_nothing_or_everything_grows():
    scheme, body = INTEGRATORS["leapfrog"], linear(OSCILLATOR)
    for low, high, end in ((0.1, 1.0, 1.0), (3.0, 5.0, 3.0)):
        search = bounded.Search(low, high)
        found = bounded.measured_limit(scheme, body, np.array([0.2]), search, 0)
        assert found[0] == pytest.approx(end, rel=2 * search.resolution)


def test_resolution_is_half_the_last_gap():
    assert bounded.Search(1.0, np.e, 3, 2).resolution == pytest.approx(1 / 32)


@pytest.mark.parametrize("lattice", ["square", "triangular"])
def test_linear_motion_is_the_networks(lattice):
    body = Body(lattice, 6)
    _, network = clamped(body)
    moving = linear(body)
    free = networks.free_components(network)
    assert moving.omega == pytest.approx(extreme_frequencies(network), rel=1e-6)
    x = np.random.default_rng(0).normal(size=(len(free), 1))
    whole = np.zeros((network.points.size, 1))
    whole[free] = x
    force = -(tangent(network, network.points) @ whole)[free, 0]
    mass = np.repeat(network.mass, 2)[free]
    np.testing.assert_allclose(moving.acceleration(x)[:, 0], force / mass, rtol=1e-9, atol=1e-12)
    for mode, omega in zip((moving.lowest, moving.highest), moving.omega, strict=True):
        np.testing.assert_allclose(
            moving.acceleration(mode), -(omega**2) * mode, atol=1e-6 * np.abs(mode).max()
        )
        still = MotionState(mode, np.zeros_like(mode), moving.acceleration(mode))
        assert bounded.energy(moving, still)[0] == pytest.approx(1.0)


def test_dense_and_sparse_modes_agree(monkeypatch):
    _, network = clamped(Body("square", 6))
    free = networks.free_components(network)
    stiffness = tangent(network, network.points)[free][:, free]
    mass = np.repeat(network.mass, 2)[free]
    dense = networks.modes(stiffness, mass)
    monkeypatch.setattr(networks, "DENSE", 0)
    for one, other in zip(dense, networks.modes(stiffness, mass), strict=True):
        np.testing.assert_allclose(np.abs(one), np.abs(other), atol=1e-5 * np.abs(one).max())


# --- closed forms of the study's own --------------------------------------------------------------


@pytest.mark.parametrize("ratio", order.RATIOS)
@pytest.mark.parametrize("share", [0.5, 1.0])
def test_exact_motion(share, ratio):
    """Against leapfrog with small steps, under a share of spring and viscous force."""
    scheme = INTEGRATORS["leapfrog"]
    root = np.sqrt(share)
    found = oscillator.swing(scheme, 20_000, order.ANGLE * root, ratio * root)
    assert order.exact_swing(share, ratio) == pytest.approx(found, abs=1e-7)


def test_oscillator_is_the_network_in_its_mode():
    for name in ("leapfrog", "velocity_verlet"):
        scheme = INTEGRATORS[name]
        assert order.swing(order.lowest_mode(), scheme, 100, 0.3) == pytest.approx(
            oscillator.swing(scheme, 100, order.ANGLE, 0.3), abs=1e-6
        )


# --- work for an accuracy -------------------------------------------------------------------------

QUARTER = 0.5 * np.pi
WORK = 0.05
"""Largest part by which work may depend on when errors are sampled: a quarter of a period more is
1/40 of ten periods, and the ellipse of Verlet's states is an eighth of its error there."""


def work():
    """Force evaluations for an error of 1e-3, by scheme."""
    needed = cost.run(INTEGRATORS, QUICK).tables["cost_needed"]
    return needed[needed["wanted"] == 1e-3].set_index("scheme")["evaluations_needed"].astype(float)


@pytest.mark.parametrize("later", [-QUARTER, QUARTER])
def test_a_motion_that_ends_a_quarter_of_a_period_later_takes_the_same_work(monkeypatch, later):
    before = work()
    assert set(before.index) == set(common.TRUE)
    monkeypatch.setattr(cost, "ANGLE", cost.ANGLE + later)
    np.testing.assert_allclose(work(), before, rtol=WORK)


LEADING = {
    "explicit_euler": cost.ANGLE / 2,
    "euler_cromer": 1 / 2,
    "leapfrog": cost.ANGLE / 24,
    "velocity_verlet": cost.ANGLE / 24,
    "runge_kutta": cost.ANGLE / 120,
    "average_acceleration": cost.ANGLE / 12,
}
"""Scheme -> error over (h·ω)^order, by growth, ellipse and phase on paper."""


@pytest.mark.parametrize("name", common.TRUE)
def test_work_is_that_of_the_leading_term(name):
    """The ellipse of Verlet's states adds 1.3 % to the error of their phase."""
    scheme = INTEGRATORS[name]
    h = cost.step_size(scheme, cost.needed_for(scheme, 1e-5))
    assert LEADING[name] * h**scheme.order == pytest.approx(1e-5, rel=0.02)


def test_a_scheme_without_a_closed_form_is_refused():
    silent = replace(INTEGRATORS["leapfrog"], undamped_motion=None)
    with pytest.raises(ProblemError, match="leapfrog: no closed form"):
        stability.run(INTEGRATORS | {"leapfrog": silent}, QUICK, ("cost",))


def forest_ruth(acceleration, now, h, c):
    """Three velocity Verlet steps of fourth order together."""
    outer = 1 / (2 - 2 ** (1 / 3))
    for part in (outer, 1 - 2 * outer, outer):
        now = INTEGRATORS["velocity_verlet"].step(acceleration, now, part * h, c)
    return now


def position_first(acceleration, now, h, c):
    """Symplectic Euler in the other order."""
    x = now.x + h * now.v
    a = acceleration(x)
    return MotionState(x, now.v + h * (a - c * now.v), a)


FOREST_RUTH = replace(
    INTEGRATORS["velocity_verlet"],
    name="forest_ruth",
    order=4,
    step=forest_ruth,
    undamped_motion=None,
)
POSITION_FIRST = replace(
    INTEGRATORS["euler_cromer"], name="position_first", step=position_first, undamped_motion=None,
    factors=None,
)  # fmt: skip


def test_any_symplectic_scheme_passes():
    """Each with a period of its own, and not that of velocity Verlet."""
    mine = {scheme.name: scheme for scheme in (FOREST_RUTH, POSITION_FIRST)}
    found = stability.run(REPORTED | mine, QUICK, ("drift", "order"))
    assert all_passed(judge(found))
    for name in ("drift", "fluctuation_powers", "orders"):
        assert set(mine) < set(found.tables[name]["scheme"])
    assert all(draw(found.tables) for draw in found.figures.values())


@table("false_claim", [
    replace(INTEGRATORS["runge_kutta"], name="mine", symplectic=True),
    replace(FOREST_RUTH, name="mine", symplectic=False),
    replace(FOREST_RUTH, name="mine", order=2),
    replace(POSITION_FIRST, name="mine", order=2),
])  # fmt: skip
def test_a_false_claim_of_a_scheme_fails(false_claim, monkeypatch):
    monkeypatch.setattr(drift, "QUICK_PERIODS", 100)
    scheme = {"mine": false_claim}
    assert not all_passed(judge(stability.run(REPORTED | scheme, QUICK, ("drift",))))


# --- runs of the block ----------------------------------------------------------------------------


def test_areas_are_signed():
    grid, network = runs.block((0.0, 0.1))
    np.testing.assert_allclose(passing.areas(grid, network.points), 0.04)
    np.testing.assert_allclose(passing.areas(grid, network.points * [-1, 1]), -0.04)
    assert passing.areas(grid, np.array([network.points] * 3)).shape == (3, 25)


def test_a_run_ends_where_it_leaves():
    _, network = runs.block((0.1, 0.0))
    scheme = INTEGRATORS["explicit_euler"]
    gone = runs.release_network(network, scheme, 2.0, 500, 0.0, 0.5)
    assert 0 < gone.left == len(gone.positions) < 500
    assert np.abs(gone.positions - network.points).max() <= 0.5
    calm = runs.release_network(network, INTEGRATORS["leapfrog"], 0.5, 20, 0.0, 0.5)
    assert calm.left == 0
    assert len(calm.positions) == 21


def test_findings_follow_the_tables(tables):
    table = tables["growth"]
    assert "grows at every step" in growing.finding(table)
    assert "grows at none" in growing.finding(table.assign(growth_measured=0.0))
    table = tables["misprints"]
    assert "Euler-Cromer is explicit Euler" in misprints.finding(table)
    other = misprints.finding(table.assign(difference=0.5))
    assert "is not explicit Euler" in other
    assert "does not move" in other


def test_no_number_is_missing_where_schemes_leave():
    """With the report's "Euler-Cromer", which is explicit Euler, in the place of the true one."""
    printed = replace(INTEGRATORS["euler_cromer"], step=INTEGRATORS["euler_cromer_as_printed"].step)
    for question in ("figure3", "passing"):
        found = stability.run(INTEGRATORS | {"euler_cromer": printed}, QUICK, (question,))
        assert not all_passed(judge(found))
        for draw in found.figures.values():
            assert draw(found.tables)


# --- controls -------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", stability_controls.FAULTS)
def test_stated_resolution_is_the_real_one(name):
    """On the questions themselves, of which two run a network, whose rounding is half a limit."""
    noticed = stability_controls.smallest(name)["smallest_noticed"]
    question, apart = (cost, 0.1) if "kick" in name else (order, 0.5)
    for part, passes in ((1 + apart, False), (1 - apart, True)):
        scheme = stability_controls.FAULTS[name][0](part * noticed)
        found = question.run(INTEGRATORS | {scheme.name: scheme}, QUICK)
        assert all_passed(judge(found)) == passes


def test_no_fault_is_the_scheme_itself():
    for name in ("euler_cromer", "leapfrog"):
        same = stability_controls.with_weak_damping(name, 0.0)
        assert oscillator.swing(same, 50, 2.0, 0.3) == oscillator.swing(
            INTEGRATORS[name], 50, 2.0, 0.3
        )
    same = stability_controls.with_weak_kick(0.0)
    assert oscillator.swing(same, 50, 2.0, 0.3) == oscillator.swing(
        INTEGRATORS["velocity_verlet"], 50, 2.0, 0.3
    )


def test_reference_of_figure_3_is_fine():
    scheme = INTEGRATORS["velocity_verlet"]
    block = figure3.pulled_block()
    time, x, _ = figure3.displacement(block, scheme, figure3.FINE)
    finer_time, finer, _ = figure3.displacement(block, scheme, figure3.FINE / 2)
    assert np.abs(x - np.interp(time, finer_time, finer)).max() < 2e-3 * np.ptp(x)
