"""Sums over pairs of segments: what they are made of, and points on a segment."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad

from msvalidate.dielectric.kernels import charges as integrals

B = 0.6 - 0.3j


def test_means_are_symmetric_with_those_of_one_segment_on_the_diagonal():
    start = np.array([0, 1 + 0.2j, 3j])
    along = np.array([1, 0.5j, 2 + 1j])
    mean = integrals.means(start, along)
    np.testing.assert_array_equal(mean, mean.T)
    np.testing.assert_allclose(np.diag(mean), np.log(np.abs(along)) - 1.5)


@pytest.mark.parametrize("point", [0.5, 0.25, 1e-9, 0.0, 1.0, 1.5, -3.0, 0.5 + 0.01j, 40 + 30j])
def test_seen_is_the_mean_of_the_logarithm(point):
    def log(t):
        return np.log(abs((point - t) * B)) if t != point else 0.0

    ends = sorted({0.0, min(max(np.real(point), 0.0), 1.0), 1.0})
    parts = [quad(log, *part, epsabs=1e-13)[0] for part in pairwise(ends)]
    seen = integrals.seen(np.array([1j + point * B]), np.array([1j]), np.array([B]))
    assert seen[0, 0] == pytest.approx(sum(parts), abs=1e-11)


@pytest.mark.parametrize("point", [1.5, -3.0, 0.5 + 0.1j, 0.2 - 1e-3j, 40 + 30j])
def test_field_is_the_mean_of_its_points(point):
    def one(t):
        return 1 / ((point - t) * B)

    near = [np.real(point)] if 0 < np.real(point) < 1 else None
    expected = quad(one, 0, 1, complex_func=True, points=near)[0]
    found = integrals.fields(np.array([1j + point * B]), np.array([1j]), np.array([B]))[0, 0]
    assert abs(found - expected) <= 1e-9 * abs(expected)


def test_a_field_at_the_end_of_one_segment_is_none_there_alone():
    points = np.array([5 + 1j, -2j, 1 + 0.2j])
    start, along = np.array([0, 1 + 0.2j]), np.array([0.37, 0.5j])
    ends = np.isnan(integrals.fields(points, start, along))
    np.testing.assert_array_equal(ends, [[False, False], [False, False], [False, True]])
