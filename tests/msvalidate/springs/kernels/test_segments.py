"""Integrals of the logarithm over pairs of segments: against quadrature, identities, differences.

The quadrature shares no formula with the code: the inner integral is the real one of the textbooks,
by logarithms and an angle, and the outer one is by Gauss points on panels that shrink towards every
place where the inner one bends.
"""

from __future__ import annotations

import cmath

import numpy as np
import pytest
import shapely
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from msvalidate.dielectric.kernels import segments as integrals

X, W = np.polynomial.legendre.leggauss(20)
PANELS = 0.5 ** np.arange(1, 40)


def outer(a, b, z):
    """Points and weights on 0 ... 1 of p + s·a, refined towards the ends of q + t·b."""
    marks = [0.0, 1.0, *np.clip([((-z + end) / a).real for end in (0, b, b / 2)], 0, 1)]
    around = [mark + side * PANELS for mark in marks for side in (-1, 1)]
    edges = np.unique(np.clip(np.concatenate([marks, *around]), 0, 1))
    half = 0.5 * np.diff(edges)
    return ((edges[:-1] + half)[:, None] + half[:, None] * X).ravel(), np.outer(half, W).ravel()


def distance(x, y):
    """From an end, which rounding must not make 0."""
    return np.maximum(np.hypot(x, y), 1e-17)


def inner_log(w, b):
    """Mean of ln r over q + t·b as seen from q + w: u·ln r + y·(angle) - u between its ends."""
    u, y = (w / b).real, (w / b).imag
    r0, r1 = distance(u, y), distance(u - 1, y)
    angle = np.arctan2(y, u * (u - 1) + y * y)
    return u * np.log(r0) - (u - 1) * np.log(r1) - 1 + y * angle + np.log(abs(b))


def inner_field(w, b):
    """Mean of 1/R, by the two components of the field of a line."""
    u, y = (w / b).real, (w / b).imag
    along = np.log(distance(u, y) / distance(u - 1, y))
    return (along - 1j * np.arctan2(y, u * (u - 1) + y * y)) / b


def by_quadrature(z, a, b):
    """Mean of ln r; derivatives of Q in Z and A."""
    s, weight = outer(a, b, z)
    field = inner_field(z + s * a, b)
    mean = weight @ inner_log(z + s * a, b)
    if abs(a) > abs(b):  # seen from afar the ends of a short segment cancel
        mean = by_quadrature(-z, b, a)[0]
    return mean, weight @ field, weight @ (s * field)


PAIRS = {
    "apart": (2.0 + 0.5j, 1.0 + 0.2j, 0.7 - 0.6j),
    "facing, a gap of a ten-thousandth": (1e-4j, 1.0, 1.0),
    "facing, turned the other way": (1 + 1e-4j, -1.0, 1.0),
    "collinear neighbours": (-1.0, 1.0, 0.8),
    "collinear with a gap": (-1.1, 1.0, 0.8),
    "a right angle": (0.0, 1.0, 1.0j),
    "an angle of half a degree": (0.0, 1.0, cmath.exp(0.0087j)),
    "nearly straight on": (0.0, 1.0, cmath.exp(3.14j)),
    "end to the middle": (0.5 + 1e-3j, 1j, 1.0),
    "a small one touching": (0.0, 1.0, -1e-4j),
    "a small neighbour": (-1.0, 1.0, 1e-4),
    "a small one at its side": (0.3j, 1.0 + 0.1j, 1e-4 + 2e-5j),
    "a small one hard by": (-0.4 - 1e-5j, 1.0, 1e-4),
    "a large one far away": (30.0 + 8j, 5.0, 1e-3j),
    "as far as the series goes": (6.1, 1.0, 1.0),
    "just nearer": (5.9, 1.0, 1.0),
}


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.2, np.pi, 4.4])
@pytest.mark.parametrize("name", PAIRS)
def test_integrals_are_those_of_quadrature(name, turn):
    z, a, b = (complex(x) * cmath.exp(1j * turn) for x in PAIRS[name])
    mean, in_z, in_a = by_quadrature(z, a, b)
    found = integrals.jet(z, a, b)
    assert integrals.mean_log(z, a, b) == pytest.approx(mean, abs=2e-13)
    assert found[0].real == pytest.approx(mean, abs=2e-13)
    largest = abs(in_z) + 1 / max(abs(a), abs(b))
    assert abs(found[1] - in_z) <= 1e-11 * largest
    assert abs(found[2] - in_a) <= 1e-11 * largest
    mirrored = by_quadrature(-z, b, a)
    assert abs(found[3] - mirrored[2]) <= 1e-11 * (largest + abs(mirrored[2]))


@st.composite
def pairs(draw):
    """Pairs that do not meet; lengths over five decades, gaps from a hundredth of the shorter."""
    angle = st.floats(0, 2 * np.pi)
    a = cmath.rect(1.0, draw(angle))
    b = cmath.rect(10 ** draw(st.floats(-4, 1)), draw(angle))
    z = cmath.rect(10 ** draw(st.floats(-3, 2)), draw(angle))
    one, other = (
        shapely.LineString([(p.real, p.imag) for p in (start, start + along)])
        for start, along in ((z, a), (0j, b))
    )
    assume(one.distance(other) > 0.01 * min(abs(a), abs(b)))
    return z, a, b


@given(pairs())
@settings(deadline=None)  # a busy machine is no failure
def test_mean_is_that_of_quadrature(pair):
    assert integrals.mean_log(*pair) == pytest.approx(by_quadrature(*pair)[0], abs=1e-12)


@given(pairs())
@settings(deadline=None)  # a busy machine is no failure
def test_derivatives_are_those_of_differences(pair):
    step = 1e-5 * min(abs(pair[2]), 1, abs(pair[0]))
    step *= 0.1  # of gaps of a hundredth of the shorter
    found = integrals.jet(*pair)
    rows = [found[4:7], (found[5], *found[7:9]), (found[6], *found[8:])]
    for k in range(3):
        there, here = (
            integrals.jet(*(x + (sign * step if i == k else 0) for i, x in enumerate(pair)))
            for sign in (1, -1)
        )
        for i in range(3):
            largest = max(abs(found[1 + i]), abs(rows[k][i]) * abs(pair[2]))
            difference = (there[1 + i] - here[1 + i]) / (2 * step)
            assert abs(difference - rows[k][i]) <= 1e-6 * abs(rows[k][i]) + 1e-9 * largest / step
