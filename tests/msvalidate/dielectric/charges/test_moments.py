"""Charges: orders, limits, and what no choice of numbers, places, units or directions changes."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import null_space

from msvalidate.dielectric.charges import (
    Electrodes,
    Moments,
    capacitance,
    electrodes_of_chains,
    facing_strips,
    facing_strips_capacitance,
    forces,
    strip_points,
)
from msvalidate.dielectric.charges.moments import WEIGHTINGS, coefficients, factorise
from msvalidate.problem import SolverError

X, W = np.polynomial.legendre.leggauss(20)
VOLTAGES = (0.7, -0.4)
few = settings(max_examples=25, deadline=None)


def charged(electrodes, **how):
    return Moments(electrodes, **how).charges(VOLTAGES)


@pytest.mark.parametrize("weighting", WEIGHTINGS)
@pytest.mark.parametrize(("grading", "order"), [("uniform", 1.0), ("cosine", 2.0)])
@pytest.mark.parametrize("ratio", [1.0, 6.0])
def test_orders_of_convergence(ratio, grading, order, weighting):
    exact = facing_strips_capacitance(ratio)
    counts = np.array([40, 80, 160])
    errors = [
        capacitance(facing_strips(ratio, 1.0, n, grading=grading), weighting=weighting) / exact - 1
        for n in counts
    ]
    observed = -np.diff(np.log(np.abs(errors))) / np.diff(np.log(counts))
    np.testing.assert_allclose(observed, order, atol=0.1)


def test_galerkin_holds_less_than_the_truth(wavy):
    """Charges that are even on segments are some of all charges, and cost more energy."""
    for n in (10, 40):
        pair = facing_strips(3.0, 1.0, n)
        assert capacitance(pair) < facing_strips_capacitance(3.0)
    assert capacitance(wavy(12)) < capacitance(wavy(24)) < capacitance(wavy(48))


def test_coefficients_are_symmetric_and_positive(wavy):
    P = coefficients(wavy(40), 2.0, "galerkin")
    np.testing.assert_array_equal(P, P.T)
    neutral = null_space(np.ones((1, len(P))))
    assert np.linalg.eigvalsh(neutral.T @ P @ neutral).min() > 0
    assert np.linalg.eigvalsh(P).min() > 0


def on_segments(electrodes):
    """Points (m, k, 2) and weights (k,) for means over segments, fine towards the ends."""
    edges = 0.5 ** np.arange(1, 40)
    edges = np.unique([0, *edges, *(1 - edges), 1])
    half = 0.5 * np.diff(edges)
    s = ((edges[:-1] + half)[:, None] + half[:, None] * X).ravel()
    return electrodes.start[:, None] + s[:, None] * electrodes.along[:, None], np.outer(half, W)


def test_potential_on_electrodes_is_the_voltage_in_the_mean(wavy):
    charges = charged(wavy(10), permittivity=3.0)
    electrodes = charges.moments.electrodes
    points, weight = on_segments(electrodes)
    potential = charges.potential(points.reshape(-1, 2)).reshape(points.shape[:2])
    expected = charges.voltages[electrodes.electrode]
    np.testing.assert_allclose(potential @ weight.ravel(), expected, atol=1e-11)


def test_potential_at_middles_is_the_voltage_under_collocation(wavy):
    charges = charged(wavy(10), weighting="collocation")
    electrodes = charges.moments.electrodes
    potential = charges.potential(electrodes.middle)
    np.testing.assert_allclose(potential, charges.voltages[electrodes.electrode], atol=1e-12)


def test_field_is_minus_the_slope_of_the_potential_and_jumps_by_the_charge(wavy):
    charges = charged(wavy(12), permittivity=2.0)
    points = np.random.default_rng(1).uniform((-3, -2), (4, 3), (40, 2))
    step = 1e-5
    for axis in range(2):
        move = step * np.eye(2)[axis]
        slope = (charges.potential(points + move) - charges.potential(points - move)) / (2 * step)
        np.testing.assert_allclose(charges.field(points)[:, axis], -slope, atol=1e-7)
    electrodes = charges.moments.electrodes
    along = electrodes.along / electrodes.length[:, None]
    normal = np.column_stack([-along[:, 1], along[:, 0]])
    sides = [charges.field(electrodes.middle + s * 1e-9 * normal) for s in (1, -1)]
    jump = 2.0 * ((sides[0] - sides[1]) * normal).sum(axis=1)
    np.testing.assert_allclose(jump, charges.density, rtol=1e-6, atol=1e-7)
    mean = charges.field(electrodes.middle)
    np.testing.assert_allclose(mean, 0.5 * (sides[0] + sides[1]), atol=1e-7)


@given(seed=st.integers(0, 2**32 - 1), weighting=st.sampled_from(WEIGHTINGS))
@few
def test_numbers_and_directions_make_no_difference(wavy, seed, weighting):
    rng = np.random.default_rng(seed)
    given_ = wavy(9)
    place, order = rng.permutation(len(given_.points)), rng.permutation(len(given_.segments))
    points = np.empty_like(given_.points)
    points[place] = given_.points
    segments = place[given_.segments[order]]
    turned = rng.random(len(segments)) < 0.5
    segments[turned] = segments[turned, ::-1]
    other = charged(Electrodes(points, segments, given_.electrode[order]), weighting=weighting)
    charges = charged(given_, weighting=weighting)
    scale = np.abs(charges.charge).max()
    np.testing.assert_allclose(other.charge, charges.charge[order], rtol=0, atol=1e-11 * scale)
    pull = forces(charges)
    within = 1e-11 * np.abs(pull).max()
    np.testing.assert_allclose(forces(other)[place], pull, rtol=0, atol=within)


@given(
    angle=st.floats(0, 2 * np.pi),
    shift=st.tuples(st.floats(-20, 20), st.floats(-20, 20)),
    size=st.floats(-4, 4).map(lambda power: 10**power),
    voltage=st.floats(0.1, 1e4),
    permittivity=st.floats(1e-12, 1e3),
)
@few
def test_place_turn_and_units_make_no_difference(wavy, angle, shift, size, voltage, permittivity):
    """Q = εV, per depth, at any size; F = εV²/size, turned with the electrodes."""
    given_ = wavy(9)
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    there = given_.moved(size * (given_.points @ turn.T + shift))
    charges = charged(given_)
    other = Moments(there, permittivity=permittivity).charges(voltage * np.array(VOLTAGES))
    scale = np.abs(charges.charge).max()
    expected = other.charge / (permittivity * voltage)
    np.testing.assert_allclose(expected, charges.charge, rtol=0, atol=1e-10 * scale)
    assert other.energy == pytest.approx(permittivity * voltage**2 * charges.energy, rel=1e-10)
    pull = forces(other) @ turn * size / (permittivity * voltage**2)
    expected = forces(charges)
    np.testing.assert_allclose(pull, expected, rtol=0, atol=1e-9 * np.abs(expected).max())


def test_a_constant_added_to_voltages_makes_no_difference(wavy):
    moments = Moments(wavy(15))
    one, other = moments.charges(VOLTAGES), moments.charges(np.array(VOLTAGES) + 1000)
    np.testing.assert_allclose(one.charge, other.charge, atol=1e-10)


def test_three_electrodes_obey_reciprocity():
    """Charge on i at 1 V on j is that on j at 1 V on i."""
    three = electrodes_of_chains(
        strip_points(1.0, 0.0, 20),
        strip_points(2.0, 0.6, 20),
        strip_points(0.5, -1.0, 20, centre=2.0),
    )
    moments = Moments(three)
    held = np.array([moments.charges(row).totals for row in np.eye(3)])
    np.testing.assert_allclose(held, held.T, atol=1e-12)
    np.testing.assert_allclose(held.sum(axis=0), 0, atol=1e-12)
    assert (np.diag(held) > 0).all()
    assert (held[~np.eye(3, dtype=bool)] < 0).all()


def test_an_energy_without_a_minimum_is_refused():
    with pytest.raises(SolverError, match="lie on each other; move them apart"):
        factorise(np.array([[1.0, 2.0], [2.0, 1.0]]), symmetric=True)
