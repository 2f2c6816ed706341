"""The study `electrostatics`: its own formulas, its resolution."""

import numpy as np
import pytest
from msvalidate.studies.electrostatics import (
    common,
    derivatives,
    edge,
    electrostatics_controls,
    in_air,
    models,
    nodes,
    shortcuts,
)
from msvalidate.studies.electrostatics.common import MOMENTS

from msvalidate.bench.judging.evidence import judge
from msvalidate.bench.judging.sweep import Setting
from msvalidate.dielectric.charges import (
    capacitance,
    facing_strips,
    facing_strips_capacitance,
    strip_points,
)
from msvalidate.studies import electrostatics

QUICK = Setting(quick=True)


@pytest.fixture(scope="module")
def tables(small_tables):
    return small_tables("electrostatics")


# --- the study's own formulas ---------------------------------------------------------------------


def test_differences_are_exact_for_quartics():
    found = derivatives.differences(
        lambda x: np.array([x[0] ** 4 - x[1] ** 3, x[0] * x[1]]),
        np.array([1.0, 2.0]),
        np.array([0.1, 0.2]),
    )
    assert found == pytest.approx(np.array([[4.0, -12.0], [2.0, 1.0]]))


@pytest.mark.parametrize("ratio", [1.0, 6.0, 10.0])
def test_growth_of_the_closed_form(ratio):
    """Beside that of wide plates, and a chord."""
    step = 1e-4
    chord = facing_strips_capacitance(ratio + step) - facing_strips_capacitance(ratio - step)
    assert derivatives.growth(ratio) == pytest.approx(chord / (2 * step), rel=1e-6)
    if ratio == 10.0:
        assert derivatives.growth(ratio) == pytest.approx(1 + 1 / (np.pi * ratio), rel=5e-3)


def test_circle_does_not_change_how_a_strip_shares_its_charge():
    line = strip_points(2.0, 0.0, 20)
    shares = []
    for radius in (30.0, edge.RADIUS):
        electrodes = edge.in_a_circle(line)
        points = electrodes.points.copy()
        points[len(line) :] *= radius / edge.RADIUS
        found = common.charges(electrodes.moved(points))
        shares.append(found.charge[:20] / found.totals[0])
    assert shares[0] == pytest.approx(shares[1], abs=1e-5)


@pytest.mark.parametrize("ratio", edge.PERMITTIVITY_RATIOS)
def test_exponent_at_a_corner_fits_both_sides(ratio, tables):
    """Potential and flux are continuous across the bare face, sin λθ on both sides of it."""
    rows = tables["corner"].set_index("permittivity_ratio")
    power = rows["exponent_expected"][ratio] + 1
    slab, air = np.pi / 2, 3 * np.pi / 2
    inside, outside = np.sin(power * slab), np.sin(power * air)
    flux = ratio * np.cos(power * slab) * outside + np.cos(power * air) * inside
    assert flux == pytest.approx(0, abs=1e-12)


def test_fitted_exponent_is_that_of_given_charges():
    ends = np.linspace(0.1, 0.5, 12) ** 2
    start, end = ends[:-1], ends[1:]
    for power in (0.5, 0.634):
        charge = sum(
            c * (end**p - start**p) for c, p in ((2.0, power), (-1.0, 1.0), (0.3, 2 - power))
        )
        assert edge.fitted_exponent(start, end, charge) == pytest.approx(power, abs=1e-4)


def test_expected_growth_of_both_faces_by_another_route(tables):
    """K² from the charge near the edge of a fine strip, Q(s) = 2K·√s."""
    electrodes = facing_strips(shortcuts.RATIO, 1.0, 400)
    found = common.charges(electrodes)
    s = electrodes.points[12, 0] - electrodes.points[0, 0]
    squared = (found.charge[:12].sum() / 2) ** 2 / s
    pull = shortcuts.HALF * derivatives.growth(shortcuts.RATIO) * shortcuts.RATIO
    told = 2 * np.log(2) / (np.pi * shortcuts.RATIO)
    # σ²/(2ε) over both edges: K²·ln 2, over the pull.
    assert squared * np.log(2) / pull == pytest.approx(told, rel=0.02)
    faces = tables["both_faces"]
    for _, rows in faces.groupby("grading"):
        assert rows["faces_over_exact"].is_monotonic_increasing


def test_halves_lose_nothing_of_the_pull():
    found = common.charges(facing_strips(4.0, 1.0, 40))
    halves, right = (
        part[:41].sum(axis=0) for part in (shortcuts.halve_to_ends(found), MOMENTS.forces(found))
    )
    assert halves == pytest.approx(right, rel=1e-3, abs=1e-12)


def test_forces_count_less_away_from_the_electrode():
    points = np.array([[1.0, 0.0], [1.25, 0.0], [0.5, 0.0], [-0.5, 0.0], [0.0, -0.6]])
    forces = np.array([[1.0, -2.0], [10.0, -4.0], [3.0, -4.0], [5.0, -6.0], [7.0, 7.0]])
    found = in_air.sum_forces(points, forces, in_air.Case(1 / 3, 1.0))
    share = (1 - 0.5**2) ** 2
    assert found["pull"] == pytest.approx(2 + 4 * share + 4 + 6)
    assert found["edge_work"] == pytest.approx((1 + 10 * share) / 0.25)
    assert found["stretch"] == pytest.approx((1 + 10 + 3) / 0.5)


def test_squeeze_counts_half_of_the_border():
    x = np.linspace(-3, 3, 61)
    even = models.Upper(1.0, np.column_stack([x, 0 * x]), np.column_stack([x, -0.1 + 0 * x]))
    assert models.squeeze(even, 1.0) == pytest.approx(1.0)
    assert models.squeeze(even, 0.5, margin=True) == pytest.approx(0.5)


# --- controls -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("fault", "noticing"),
    [
        ("half of the charge lost at edges, on both faces", [0, 2]),
        ("segments seen as points", [1]),
        ("halves along half a strip", [2]),
        ("equations taken for symmetric", [0]),
        ("the kernel of space in the plane's place", [1, 2]),
    ],
)
def test_each_tolerance_of_a_table_notices_a_fault(fault, noticing):
    """Of `shortcuts` and `nodes`: none of their observations is asked in vain."""
    verdict = judge(electrostatics.run(**electrostatics.FAULTS[fault], setting=QUICK))["verdict"]
    assert [i for i, word in enumerate(verdict) if word == "fail"] == noticing


@pytest.mark.parametrize("shape", ["flat", "wavy"])
def test_sums_over_points_times_their_places(shape):
    """Σx·F of charges in the plane is Σqq'/(2πε) over pairs, wherever they are."""
    given = common.pair(shape, 4.0, 5)
    found = nodes.charge_nodes(MOMENTS, "springs", given)
    q = found.charge
    pairs = sum(q[i] * q[j] for i in range(len(q)) for j in range(i)) / (2 * np.pi)
    assert pairs == pytest.approx(-(q**2).sum() / (4 * np.pi), rel=1e-12)
    force = nodes.FORCES["point sums"](found)
    assert (given.points * force).sum() == pytest.approx(pairs, rel=1e-12)
    right = nodes.FORCES["derivatives"](found)
    assert abs((given.points * right).sum()) < 1e-13 * np.abs(pairs)


def test_field_of_points_is_that_of_segments_far_away():
    electrodes = common.pair("wavy", 4.0, 10)
    far = np.array([[40.0, 30.0], [-70.0, 5.0]])
    seen = electrostatics_controls.of_points(electrodes)
    assert seen.field(far) == pytest.approx(MOMENTS.charges(electrodes).field(far), rel=2e-3)
    assert np.isfinite(seen.field(electrodes.middle)).all()


def test_no_fault_is_the_solver_itself():
    electrodes = common.pair("wavy", 4.0, 10)
    for weighting in ("galerkin", "collocation"):
        right = MOMENTS.charges(electrodes, weighting=weighting)
        same = electrostatics_controls.perturb_potentials(0.0, electrodes, weighting=weighting)
        assert same.charge == pytest.approx(right.charge, rel=1e-9)
        assert same.floating == pytest.approx(right.floating, rel=1e-9)
    assert MOMENTS.charges(electrodes).totals.sum() == pytest.approx(0, abs=1e-12)
    alone = electrostatics_controls.perturb_potentials(0.0, electrodes, neutral=False)
    assert abs(alone.totals.sum()) > 1e-2


def test_without_neutrality_the_unit_of_length_matters():
    def found(unit):
        electrodes = facing_strips(6.0 * unit, unit, 20)
        return electrostatics_controls.perturb_potentials(0.0, electrodes, neutral=False).totals[0]

    assert abs(found(1000.0) / found(1.0) - 1) > 0.01
    small, large = (capacitance(facing_strips(6.0 * u, u, 20)) for u in (1.0, 1000.0))
    assert small == pytest.approx(large, rel=1e-10)


@pytest.mark.parametrize("kind", electrostatics_controls.KINDS)
def test_stated_resolution_is_the_real_one(kind):
    faulty, error, _ = electrostatics_controls.KINDS[kind]
    noticed = electrostatics_controls.smallest(kind)["smallest_noticed"]
    assert abs(error(faulty(1.3 * noticed))) > 1
    assert abs(error(faulty(0.7 * noticed))) < 1
