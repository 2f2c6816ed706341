"""Forces: derivatives of the energy, tips included; balance; the tangent; a slab's pressure."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.dielectric.charges import (
    Moments,
    electrodes_of_chains,
    facing_strips,
    forces,
    strip_points,
    tangent,
)
from msvalidate.problem import ProblemError
from tests.table import table

VOLTAGES = (1.3, -0.2)


def energy(electrodes, **how):
    return Moments(electrodes, **how).charges(VOLTAGES).energy


def of_differences(function, electrodes, step):
    """Central differences of a function of electrodes in every coordinate of its points (n·2,)."""
    points = electrodes.points
    rows = []
    for k in range(points.size):
        moves = step * np.eye(points.size)[k].reshape(points.shape)
        there, here = (function(electrodes.moved(points + sign * moves)) for sign in (1, -1))
        rows.append((there - here) / (2 * step))
    return np.array(rows)


def test_forces_are_slopes_of_the_energy_on_wavy_electrodes_tips_included(wavy):
    electrodes = wavy(16)
    found = forces(Moments(electrodes, permittivity=2.5).charges(VOLTAGES))
    step = 1e-3 * electrodes.length.min()
    expected = of_differences(lambda e: energy(e, permittivity=2.5), electrodes, step)
    worst = np.abs(found.ravel() - expected).max()
    assert worst <= 1e-6 * np.abs(found).max()
    tips = [0, 16, 17, 36]
    np.testing.assert_allclose(found[tips], expected.reshape(-1, 2)[tips], rtol=1e-4)


@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=20, deadline=None)
def test_forces_balance(seed):
    """No net force and no net moment, on electrodes of any shape and grading."""
    rng = np.random.default_rng(seed)
    x = np.cumsum(10 ** rng.uniform(-2, 0, (3, 15)), axis=1)
    y = rng.uniform(-0.3, 0.3, x.shape) + np.array([[0.0], [1.0], [2.5]])
    electrodes = electrodes_of_chains(*np.stack([x, y], axis=-1))
    pull = forces(Moments(electrodes).charges(rng.normal(size=3)))
    points = electrodes.points - electrodes.points.mean(axis=0)
    total = np.abs(pull).sum()
    assert np.abs(pull.sum(axis=0)).max() <= 1e-12 * total
    moment = points[:, 0] @ pull[:, 1] - points[:, 1] @ pull[:, 0]
    assert abs(moment) <= 1e-12 * total * electrodes.extent


def test_tangent_is_symmetric_and_that_of_differences(wavy):
    electrodes = wavy(8)
    charges = Moments(electrodes, permittivity=0.7).charges(VOLTAGES)
    found = tangent(charges)
    largest = np.abs(found).max()
    np.testing.assert_allclose(found, found.T, rtol=0, atol=1e-12 * largest)

    def pull(moved):
        return forces(Moments(moved, permittivity=0.7).charges(VOLTAGES)).ravel()

    expected = of_differences(pull, electrodes, 1e-4 * electrodes.length.min())
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-6 * largest)


def test_collocation_is_not_of_an_energy(wavy):
    """Its forces err by about as much as its charges: stated, and more than Galerkin's."""
    electrodes = wavy(16)
    step = 1e-3 * electrodes.length.min()
    errors = {}
    for weighting in ("galerkin", "collocation"):
        found = forces(Moments(electrodes, weighting=weighting).charges(VOLTAGES))
        slope = of_differences(lambda e, w=weighting: energy(e, weighting=w), electrodes, step)
        errors[weighting] = np.abs(found.ravel() - slope).max() / np.abs(found).max()
    assert errors["galerkin"] < 1e-6
    assert 1e-3 < errors["collocation"] < 1


@table("function", [forces, tangent])
def test_what_are_no_charges_is_refused(function):
    with pytest.raises(ProblemError, match="charges: None; give a Charges"):
        function(None)


def test_collocation_has_no_tangent(wavy):
    charges = Moments(wavy(6), weighting="collocation").charges(VOLTAGES)
    with pytest.raises(ProblemError, match="weighting is collocation; a tangent takes weighting="):
        tangent(charges)


def test_points_without_segments_feel_nothing():
    pair = facing_strips(2.0, 1.0, 6)
    with_more = type(pair)(
        np.concatenate([[[9.0, 9.0]], pair.points]), pair.segments + 1, pair.electrode
    )
    pull = forces(Moments(with_more).charges(VOLTAGES))
    np.testing.assert_array_equal(pull[0], 0)
    np.testing.assert_allclose(pull[1:], forces(Moments(pair).charges(VOLTAGES)), atol=1e-13)
    assert with_more.extent == pair.extent
    assert strip_points(1.0, 2.0, 2).shape == (3, 2)
