"""The report's model against the plane model, Coulomb's law and its own energy."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.dielectric.charges import (
    electrodes_of_chains,
    facing_strips,
    strip_points,
)
from msvalidate.dielectric.charges.moments import Moments
from msvalidate.dielectric.charges.patches import (
    Patches,
    patch_charges,
)
from msvalidate.dielectric.charges.report_model import (
    KERNELS,
    PLACES,
    ReportModel,
    consistent_forces,
    report_forces,
    report_tangent,
)
from msvalidate.problem import ProblemError
from tests.table import table

EXACT = 1e-10  # rounding of 1e-16, times condition numbers of up to 1e5
VOLTS = (0.5, -0.5)
examples = settings(max_examples=15, deadline=None)
every_kernel = pytest.mark.parametrize("kernel", KERNELS)
every_place = pytest.mark.parametrize("charges_on", PLACES)


def wavy(seed, segments=5):
    """Two chains with kinks and springs of unlike length, a gap of 0.4 m or more between them."""
    rng = np.random.default_rng(seed)
    x = np.sort(rng.uniform(0.1, 0.9, segments - 1)) + np.linspace(0, 1, segments - 1)
    x = np.concatenate([[-0.2], x, [2.2]])
    top = np.column_stack([x, 1 + rng.uniform(-0.2, 0.2, len(x))])
    bottom = np.column_stack([x[::-1], rng.uniform(-0.2, 0.2, len(x))])
    return electrodes_of_chains(top, bottom)


def differences(energy, points, step=1e-5):
    """Central differences of an energy in all coordinates of points."""
    slope = np.empty_like(points)
    for at in np.ndindex(points.shape):
        moved = np.zeros_like(points)
        moved[at] = step
        slope[at] = (energy(points + moved) - energy(points - moved)) / (2 * step)
    return slope


def test_plane_kernel_on_springs_is_collocation():
    electrodes = wavy(1)
    ours = ReportModel(electrodes, permittivity=3.0, kernel="plane").charges((2.0, -1.0))
    theirs = Moments(electrodes, permittivity=3.0, weighting="collocation").charges((2.0, -1.0))
    assert ours.charge == pytest.approx(theirs.charge, rel=EXACT)
    assert ours.energy == pytest.approx(theirs.energy, rel=EXACT)


@pytest.mark.parametrize("depth", [1.0, 6.0, 24.0])
def test_springs_are_rectangles_in_space(depth):
    """By the sums over edges that serve polygons in space, one rectangle a spring."""
    electrodes = facing_strips(6.0, 1.0, 12)
    left, right = electrodes.start[:, 0], electrodes.start[:, 0] + electrodes.along[:, 0]
    x = np.column_stack([left, right, right, left])
    y = 0.5 * depth * np.broadcast_to([-1.0, -1.0, 1.0, 1.0], x.shape)
    z = np.broadcast_to(electrodes.start[:, 1:], x.shape)
    corners = np.stack([x, y, z], axis=-1)
    rectangles = Patches(corners, electrodes.electrode, corners.mean(axis=1))
    expected = patch_charges(rectangles, VOLTS) / depth
    measured = ReportModel(electrodes, depth=depth).charges(VOLTS).charge
    assert measured == pytest.approx(expected, rel=EXACT)


def test_deep_strips_tend_to_the_plane():
    electrodes = facing_strips(6.0, 1.0, 20)
    plane = ReportModel(electrodes, kernel="plane").charges(VOLTS).totals[0]
    ratios = [
        ReportModel(electrodes, depth=depth).charges(VOLTS).totals[0] / plane
        for depth in (1e2, 1e3, 1e4)
    ]
    assert ratios[0] > ratios[1] > ratios[2] > 1
    # Ends of the strips lie (depth/2)² away in the dipole's potential: 4·(w² + d²)/depth² or so.
    assert ratios[2] == pytest.approx(1.0, abs=4 * 37 / 1e8)


@every_kernel
@every_place
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=4, deadline=None)  # each some fifty models
def test_consistent_forces_are_the_energys_derivative(kernel, charges_on, seed):
    electrodes = wavy(seed)
    how = {"permittivity": 2.0, "depth": 1.5, "kernel": kernel, "charges_on": charges_on}

    def energy(points):
        return ReportModel(electrodes.moved(points), **how).charges((1.0, -0.6)).energy

    force = consistent_forces(ReportModel(electrodes, **how).charges((1.0, -0.6)))
    expected = differences(energy, electrodes.points)
    assert force == pytest.approx(expected, abs=1e-6 * np.abs(expected).max())


@every_kernel
@every_place
@pytest.mark.parametrize("seed", [0, 1])
def test_tangent_is_the_forces_derivative(kernel, charges_on, seed):
    electrodes = wavy(seed)
    how = {"permittivity": 2.0, "depth": 1.5, "kernel": kernel, "charges_on": charges_on}
    points, step = electrodes.points, 1e-6

    def charged(electrodes):
        return ReportModel(electrodes, **how).charges((1.0, -0.6))

    measured = report_tangent(charged(electrodes))
    size = np.abs(measured).max()
    for column in range(points.size):
        moved = (step * (np.arange(points.size) == column)).reshape(points.shape)
        there, back = (
            report_forces(charged(electrodes.moved(points + s * moved))) for s in (1, -1)
        )
        expected = ((there - back) / (2 * step)).ravel()
        assert measured[:, column] == pytest.approx(expected, abs=1e-6 * size)


@every_kernel
@every_place
@pytest.mark.parametrize("law", [report_forces, consistent_forces])
def test_forces_are_balanced(kernel, charges_on, law):
    electrodes = wavy(3)
    charges = ReportModel(electrodes, kernel=kernel, charges_on=charges_on).charges((1.0, -0.6))
    force, points = law(charges), electrodes.points
    size = np.abs(force).sum()
    assert force.sum(axis=0) == pytest.approx([0, 0], abs=1e-12 * size)
    moment = points[:, 0] * force[:, 1] - points[:, 1] * force[:, 0]
    assert moment.sum() == pytest.approx(0, abs=1e-12 * size * 3)


@every_kernel
def test_point_forces_follow_coulomb(kernel):
    """Two springs far apart: half of the force at each of their ends."""
    electrodes = electrodes_of_chains([(0.0, 0.0), (1.0, 0.0)], [(3.0, 4.0), (4.0, 4.0)])
    charges = ReportModel(electrodes, kernel=kernel, depth=2.0, permittivity=0.5).charges(VOLTS)
    one, other = charges.charge
    law = 1 / (2 * np.pi * 0.5 * 5) if kernel == "plane" else 2.0 / (4 * np.pi * 0.5 * 25)
    expected = one * other * law * np.array([-0.6, -0.8]) / 2
    assert report_forces(charges)[:2] == pytest.approx(np.array([expected, expected]), rel=EXACT)


def test_nodes_hold_lumps():
    electrodes = electrodes_of_chains(
        strip_points(1.0, 0.5, 4, grading="uniform"), strip_points(1.0, 0.0, 4, grading="uniform")
    )
    model = ReportModel(electrodes, charges_on="nodes")
    charges = model.charges(VOLTS)
    assert charges.places == pytest.approx(electrodes.points)
    assert model.spread().sum(axis=0) == pytest.approx(np.ones(10))
    seen = model.views().mean @ model.spread() @ charges.charge
    assert seen == pytest.approx(np.repeat(VOLTS, 5), rel=EXACT)


@every_kernel
@given(turn=st.floats(0, 2 * np.pi), scale=st.floats(0.1, 10))
@examples
def test_place_direction_and_unit_of_length_change_nothing(kernel, turn, scale):
    electrodes = wavy(4)
    c, s = np.cos(turn), np.sin(turn)
    moved = electrodes.moved(scale * electrodes.points @ np.array([[c, s], [-s, c]]) + [2.0, -3.0])
    here = ReportModel(electrodes, kernel=kernel, depth=1.0).charges(VOLTS)
    there = ReportModel(moved, kernel=kernel, depth=scale).charges(VOLTS)
    assert there.charge == pytest.approx(here.charge, rel=1e-8)


@table(
    ("how", "said"),
    [
        ({"kernel": "space"}, "kernel: 'space'; choose report or plane"),
        ({"charges_on": "points"}, "charges_on: 'points'; choose springs or nodes"),
        ({"depth": 0.0}, "depth: 0.0 m; it must be above zero"),
        ({"permittivity": -1.0}, "permittivity: -1.0 F/m; it must be above zero"),
    ],
)
def test_bad_options_are_refused(how, said):
    with pytest.raises(ProblemError) as refusal:
        ReportModel(wavy(1), **how)
    assert str(refusal.value) == said


def test_bad_questions_are_refused():
    with pytest.raises(ProblemError, match="one alone holds no charge in the plane"):
        ReportModel(electrodes_of_chains([(0.0, 0.0), (1.0, 0.0)]), kernel="plane")
    with pytest.raises(ProblemError, match=r"voltages: shape \(3,\); give \(2,\)"):
        ReportModel(wavy(1)).charges((1.0, 0.0, 0.0))
    with pytest.raises(ProblemError, match="give an Electrodes"):
        ReportModel([(0.0, 0.0)])
