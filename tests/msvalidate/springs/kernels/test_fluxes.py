"""Fluxes through segments against quadrature, the angles that they are, and differences."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss

from msvalidate.dielectric.kernels.fluxes import crossed, twisted

examples = settings(max_examples=25, deadline=None)
NODES, WEIGHTS = leggauss(40)
NODES, WEIGHTS = 0.5 * (NODES + 1), 0.5 * WEIGHTS


def loop(seed, sides=7):
    """Complex corners of a star-shaped polygon, and its edges' starts, vectors and ends."""
    rng = np.random.default_rng(seed)
    angle = 2 * np.pi * (np.arange(sides) + rng.uniform(-0.3, 0.3, sides)) / sides
    points = rng.uniform(0.7, 1.3, sides) * np.exp(1j * angle)
    first = np.arange(sides)
    ends = np.column_stack([first, np.roll(first, -1)])
    return points, ends


def edges(points, ends):
    return points[ends[:, 0]], points[ends[:, 1]] - points[ends[:, 0]]


@given(st.integers(0, 2**32 - 1))
@examples
def test_mean_of_the_field_against_quadrature(seed):
    rng = np.random.default_rng(seed)
    start = np.array([0, 1.5 + 1j]) + rng.uniform(-0.3, 0.3, 2)
    along = np.exp(2j * np.pi * rng.uniform(size=2)) * 10 ** rng.uniform(-2, -0.2, 2)
    apart = start[0] - start[1] + along[0] * NODES[:, None] - along[1] * NODES
    mean = WEIGHTS @ (1 / apart) @ WEIGHTS
    measured = crossed(start, along)
    assert measured[0, 1] == pytest.approx(along[0] * mean, rel=1e-11)
    assert measured[1, 0] == pytest.approx(-along[1] * mean, rel=1e-11)
    assert measured[0, 0] == measured[1, 1] == 0


@given(st.integers(0, 2**32 - 1))
@examples
def test_flux_through_a_segment_is_the_angle_that_it_takes(seed):
    """Averaged over the charge; neighbours too, where the field is infinite at one end."""
    points, ends = loop(seed)
    start, along = edges(points, ends)
    places = start[:, None] + along[:, None] * NODES
    angle = np.angle((start + along - places[..., None]) / (start - places[..., None]))
    np.einsum("jgj->jg", angle)[:] = 0  # a segment is not seen by itself
    expected = np.einsum("g,jgi->ij", WEIGHTS, angle)
    flux = crossed(start, along).imag
    # The angle of a neighbour is smooth but for its end, where it jumps to π less the corner's.
    assert flux == pytest.approx(expected, abs=1e-9)
    assert flux.sum(axis=0) == pytest.approx(np.full(len(points), np.pi), rel=1e-12)


@pytest.mark.parametrize("size", [1.0, 0.37])
def test_second_derivatives_in_nodes(size):
    """Of the fluxes segment by segment, and of all of them, by differences; neighbours touch."""
    points, ends = loop(5)
    points = size * points
    n = len(points)
    weight, charge = np.random.default_rng(5).normal(size=(2, n))
    through, sent, second = twisted(*edges(points, ends), ends, weight, charge, n)
    step = 1e-6 * size
    for node in range(n):
        for way in (1, 1j):
            moved = step * way * (np.arange(n) == node)
            ahead, behind = (edges(at, ends) for at in (points + moved, points - moved))
            change = (crossed(*ahead).imag - crossed(*behind).imag) / (2 * step)
            # A derivative in x is the real part, in y minus the imaginary part.
            for found, expected in (
                (through[:, node], change @ charge),
                (sent[:, node], weight @ change),
            ):
                measured = (way * found).real
                np.testing.assert_allclose(measured, expected, atol=1e-7 * np.abs(found).max())
            slopes = [weight @ twisted(*at, ends, weight, charge, n)[0] for at in (ahead, behind)]
            expected = (slopes[0] - slopes[1]) / (2 * step)
            scale = np.abs(second).max()
            np.testing.assert_allclose(way * second[:, node], expected, atol=1e-7 * scale)
