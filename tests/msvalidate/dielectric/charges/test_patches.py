"""Patches in space: integrals against closed forms and quadrature, bodies of known capacitance."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial.legendre import leggauss

from msvalidate.dielectric.charges.exact import disc_capacitance, square_capacitance
from msvalidate.dielectric.charges.patches import (
    Patches,
    conductors,
    disc,
    patch_capacitance,
    patch_charges,
    plate,
)
from msvalidate.dielectric.charges.pieces import corner_potential
from msvalidate.dielectric.kernels.polygons import seen
from msvalidate.problem import ProblemError
from tests.table import table

EXACT = 1e-11  # rounding of 1e-16, lost to cancellation over distances of up to 1e3 sizes
examples = settings(max_examples=25, deadline=None)
SQUARE = np.array([[[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]])


def rectangle(left, right, low, high, z=0.0):
    return np.array([[[left, low, z], [right, low, z], [right, high, z], [left, high, z]]])


def by_quadrature(point, corners, order=60):
    """∫dA/r over a convex polygon that the point is well away from: Gauss on triangles."""
    x, weight = leggauss(order)
    x, weight = 0.5 * (x + 1), 0.5 * weight
    s, t = np.meshgrid(x, x, indexing="ij")
    total = 0.0
    for second, third in pairwise(corners[1:]):
        one, other = second - corners[0], third - corners[0]
        places = corners[0] + s[..., None] * (one + t[..., None] * (other - one))
        r = np.linalg.norm(places - point, axis=-1)
        twice = abs(one[0] * other[1] - one[1] * other[0])
        total += twice * np.einsum("i,j,ij->", weight, weight, s / r)
    return total


@given(
    st.tuples(*[st.floats(-2, 2)] * 2, st.sampled_from([0.0, 1e-9, 0.3, -2.0])),
    st.floats(0.01, 3),
    st.floats(0.01, 3),
)
@examples
def test_rectangles_by_edges_and_by_corners_agree(point, width, depth):
    left, low = 0.3, -0.4
    x, y = (
        np.array([start - c, start + size - c])
        for start, size, c in ((left, width, point[0]), (low, depth, point[1]))
    )
    at = corner_potential(x[:, None], y[None, :], np.full((2, 2), point[2]))
    by_corners = at[1, 1] - at[0, 1] - at[1, 0] + at[0, 0]
    corners = rectangle(left, left + width, low, low + depth)
    assert seen(np.array([point]), corners)[0, 0] == pytest.approx(by_corners, rel=1e-9)


@given(st.integers(0, 2**32 - 1))
@examples
def test_polygons_against_quadrature(seed):
    rng = np.random.default_rng(seed)
    angle = np.sort(rng.uniform(0, 2 * np.pi - 1, 4)) + np.linspace(0, 1, 4)
    corners = np.column_stack([np.cos(angle), 0.6 * np.sin(angle), np.full(4, 0.2)])
    point = np.append(rng.uniform(-1.5, 1.5, 2), 0.2 + rng.choice([-1, 1]) * rng.uniform(0.7, 3))
    assert seen(point[None], corners[None])[0, 0] == pytest.approx(
        by_quadrature(point, corners), rel=1e-10
    )


def test_order_of_corners_and_repeated_ones_change_nothing():
    middle = np.array([[0.3, 0.3, 0.0]])
    triangle = np.array([[[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 1, 0]]])
    plain = Patches(triangle[:, :3], np.array([0]), middle)
    for corners in (triangle, triangle[:, ::-1]):
        patches = Patches(corners, np.array([0]), middle)
        assert patch_capacitance(patches) == pytest.approx(patch_capacitance(plain), rel=EXACT)


# --- capacitances ---------------------------------------------------------------------------------


def orders(errors):
    """Observed orders, of errors on meshes twice as fine each time."""
    return np.log2(np.divide(errors[:-1], errors[1:]))


def test_square_plate():
    errors = [
        1 - patch_capacitance(plate((2.0, 2.0), n)) / square_capacitance(2.0) for n in (9, 18, 36)
    ]
    assert errors[-1] == pytest.approx(0, abs=1e-4)
    # Graded by fourth powers; even patches would leave order 1.
    assert (orders(errors) > 2.5).all()


def test_disc():
    errors = [
        1 - patch_capacitance(disc(2.0, rings)) / disc_capacitance(2.0) for rings in (6, 12, 24)
    ]
    assert errors[-1] == pytest.approx(0, abs=1e-4)
    assert orders(errors)[0] == pytest.approx(3.0, abs=0.3)


def love(gap, count=400):
    """Capacitance over the permittivity of two discs of 1 m, by Love's integral equation.

    [Love1949]: f(x) - ∫κ/(κ²+(x-t)²) f(t) dt/π = 1 over -1 < t < 1, C = 2∫f, for opposite
    potentials.
    """
    x, weight = leggauss(count)
    kernel = gap / (gap**2 + (x[:, None] - x) ** 2) / np.pi
    return 2 * weight @ np.linalg.solve(np.eye(count) - kernel * weight, np.ones(count))


@pytest.mark.parametrize("gap", [0.1, 1.0, 1e3])
def test_a_pair_of_discs_against_loves_equation(gap):
    flat = disc(1.0, 24)
    up = np.array([0.0, 0.0, gap])
    pair = conductors(replace(flat, corners=flat.corners + up, middle=flat.middle + up), flat)
    assert patch_capacitance(pair) == pytest.approx(love(gap), rel=1e-4)


@given(st.floats(0.1, 10), st.floats(0, 2 * np.pi))
@examples
def test_capacitance_goes_with_size(scale, turn):
    base = plate((1.0, 0.7), 3)
    c, s = np.cos(turn), np.sin(turn)
    rotation = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]])
    corners, middle = (
        scale * (places @ rotation) + [5.0, -3.0, 2.0] for places in (base.corners, base.middle)
    )
    moved = patch_capacitance(Patches(corners, base.conductor, middle))
    assert moved == pytest.approx(scale * patch_capacitance(base), rel=1e-8)


def test_potentials_are_met_at_middles():
    patches = conductors(plate((1.0, 1.0), 4, height=0.3), plate((1.0, 1.0), 4))
    density = patch_charges(patches, (3.0, -1.0)) / np.prod(
        np.ptp(patches.corners, axis=1)[:, :2], axis=1
    )
    at_middles = seen(patches.middle, patches.corners) @ density / (4 * np.pi)
    assert at_middles == pytest.approx(np.array([3.0, -1.0])[patches.conductor], rel=1e-10)


CENTRE = [[0.5, 0.5, 0.0]]
TILTED = SQUARE + np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.1], [0, 0, 0]])
TWICE = np.concatenate([SQUARE, np.add(SQUARE, [0.5, 0, 0])])
MIDDLES = np.concatenate([CENTRE, np.add(CENTRE, [0.5, 0, 0])])


@table(
    ("corners", "conductor", "middle", "said"),
    [
        (SQUARE[0], [0], CENTRE, r"give \(n, c, 3\), c above 2"),
        (SQUARE, [0], CENTRE[0], "middles of patches: shape"),
        (SQUARE, [1], CENTRE, r"conductor: \[1\]; count them 0, 1 and so on"),
        (TILTED, [0], CENTRE, "patch 0: its corners and middle differ in z"),
        (SQUARE[:, [0, 2, 1, 3]], [0], CENTRE, "patch 0: it has no area or crosses itself"),
        (SQUARE, [0], [[1.5, 0.5, 0.0]], "patch 0: its middle is beside it"),
        (TWICE, [0, 0], MIDDLES, "patches 0 and 1: they overlap"),
        (TWICE, [0, 1], MIDDLES, "patches 0 and 1: they touch, and are of two conductors"),
        (np.nan * SQUARE, [0], CENTRE, "every value must be finite"),
    ],
)
def test_bad_patches_are_refused(corners, conductor, middle, said):
    with pytest.raises(ProblemError, match=said):
        Patches(corners, conductor, middle)


def test_bad_questions_are_refused():
    one = plate((1.0, 1.0), 2)
    with pytest.raises(ProblemError, match="give a Patches"):
        patch_charges(one.corners, (1.0,))
    with pytest.raises(ProblemError, match=r"voltages: shape \(2,\); give \(1,\)"):
        patch_charges(one, (1.0, 0.0))
    for sides in (1.0, (1.0,), (1.0, 1.0, 1.0), None):
        with pytest.raises(ProblemError, match=r"sides: .*; give two lengths in m"):
            plate(sides, 2)
    for many in (lambda: plate((1.0, 1.0), 10**6), lambda: disc(1.0, 10**8)):
        with pytest.raises(ProblemError, match="patches, and the most is 2e"):
            many()
    with pytest.raises(ProblemError, match="radius: -1 m; it must be above zero"):
        disc(-1, 2)
