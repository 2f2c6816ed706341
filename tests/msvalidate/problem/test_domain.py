"""Bodies with a straight-edged outline: segments and polygons."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from matplotlib.path import Path

from msvalidate.problem import Box, Polygon, Region, Segment, corners_of
from tests.table import refused, stored_rows, table

NAN = float("nan")
ELL = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)))
BAR = Polygon(((0.0, 0.0), (4.0, 0.0), (3.0, 1.0), (1.0, 1.0)))
"""A trapezium: the ends slope at 45 degrees."""
NOTCHED = Polygon(((0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)))
SLOPE = Segment((0.0, 0.0), (1.0, 1.0))
examples = settings(max_examples=50, deadline=None)
seeds = st.integers(0, 2**32 - 1)


def star(seed):
    """Vertices (n, 2) of a polygon that can be seen whole from the origin, and their angles.

    Neighbours are less than 180 degrees apart, so every triangle with the origin is upright.
    """
    rng = np.random.default_rng(seed)
    n = rng.integers(3, 13)
    angle = 2 * np.pi / n * (np.arange(n) + rng.uniform(-0.2, 0.2, n))
    radius = rng.uniform(0.5, 2.0, n)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1), angle, radius


def polygon(vertices):
    return Polygon(tuple((float(x), float(y)) for x, y in vertices))


# Segments -------------------------------------------------------------------------------------


@table(("make", "message"), [
    (lambda: Segment([0.0, 0.0], (1.0, 0.0)), "segment start: [0.0, 0.0]; give a tuple of 2"),
    (lambda: Segment((0.0, 0.0), (1.0, 0.0, 0.0)), "segment end: (1.0, 0.0, 0.0); give a tuple"),
    (lambda: Segment((0.0, NAN), (1.0, 0.0)), "segment start: nan at index 1; every value must"),
    (lambda: Segment((0.0, 0.0), (np.inf, 0.0)), "segment end: inf at index 0"),
    (lambda: Segment((0.0, "a"), (1.0, 0.0)), "segment start: expected numbers, got (0.0, 'a')"),
    (lambda: Segment((0.0, 0.0), None), "segment end: None; give a tuple of 2 coordinates"),
    (lambda: Segment((1.0, 2.0), (1.0, 2.0)), "starts and ends at (1.0, 2.0); give two places"),
    (lambda: corners_of(Segment((0.0, 0.0), (5.0, 0.0)), BAR),
        "region ((0, 0) to (5, 0)) reaches outside the body, 0 <= x <= 4"),
    (lambda: corners_of(SLOPE, Box((1.0, 1.0, 1.0))), "has 2 axes, the body 3"),
    (lambda: corners_of(Region((0.0, 0.0, 0.0)), BAR), "has 3 axes, the body 2"),
    (lambda: corners_of(Region((None, 1.5)), BAR), "reaches outside the body, 0 <= y <= 1"),
])  # fmt: skip
def test_bad_segments_are_refused_by_name(make, message):
    with refused(message):
        make()


# Polygons -------------------------------------------------------------------------------------


def test_measures_of_a_polygon():
    assert (ELL.volume, ELL.span, ELL.dim) == (4.0, ((0.0, 2.0), (0.0, 3.0)), 2)
    assert ELL.tolerance == pytest.approx(3e-9)
    assert ELL.reentrant.tolist() == [[1.0, 1.0]]
    assert str(ELL) == "polygon of 6 vertices, 2 x 3 m"
    assert (BAR.volume, len(BAR.reentrant)) == (3.0, 0)
    assert NOTCHED.reentrant.tolist() == [[1.0, 1.0]]


@examples
@given(seed=seeds)
def test_a_polygon_contains_what_another_library_says(seed):
    vertices, _, _ = star(seed)
    points = np.random.default_rng(seed).uniform(-2, 2, (500, 2))
    found = polygon(vertices).contains(points)
    np.testing.assert_array_equal(found, Path(vertices).contains_points(points))


@examples
@given(seed=seeds, edge=st.integers(0, 12), t=st.floats(0, 1))
def test_places_on_one_edge_are_on_the_boundary(seed, edge, t):
    vertices, _, _ = star(seed)
    body, n = polygon(vertices), len(vertices)
    a, b, c = (vertices[(edge + k) % n] for k in range(3))
    place = a + t * (b - a)
    assert body.on_boundary(np.array([a, b, place]))
    assert body.on_boundary(place[None])
    # Not two edges at a time, not inside, not beyond an end.
    assert not body.on_boundary(np.array([a, b, c]))
    assert not body.on_boundary(0.999 * place[None])
    assert not body.on_boundary(np.array([a, a - 1e-3 * (b - a)]))


def test_corners_cannot_be_changed():
    with pytest.raises(ValueError, match="read-only"):
        ELL.corners[0] = 1.0


@table(
    ("vertices", "message"),
    [
        *((tuple(map(tuple, row)), message) for row, message in stored_rows("outlines")),
        ([(0, 0), (1, 0), (0, 1)], "polygon: [(0, 0), (1, 0), (0, 1)]; give a tuple of 3 or more"),
        (((0, 0), [1, 0], (0, 1)), "polygon: vertex 1 is [1, 0]; give 2 coordinates"),
    ],
)
def test_an_outline_that_is_no_polygon_is_refused(vertices, message):
    with refused(message):
        Polygon(vertices)
