"""Problems stated on bodies with a straight-edged outline: supports and loads on their edges."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import (
    Box,
    Isotropic,
    PointForce,
    Polygon,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
    prescribed_displacements,
)
from tests.table import refused, table

NAN = float("nan")
ELL = Polygon(((0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)))
BAR = Polygon(((0.0, 0.0), (4.0, 0.0), (3.0, 1.0), (1.0, 1.0)))
"""A trapezium: the ends slope at 45 degrees."""
NOTCHED = Polygon(((0.0, 0.0), (1.0, 1.0), (2.0, 0.0), (3.0, 0.0), (3.0, 2.0), (0.0, 2.0)))
SLOPE = Segment((0.0, 0.0), (1.0, 1.0))
SHEET = Isotropic(E=1e6, nu=0.3)
CLAMP = Support(SLOPE, (0.0, 0.0))


def bar(*, supports=(CLAMP,), loads=()):
    return Problem(BAR, SHEET, supports, loads)


POINTS = np.array(
    [[x, y] for y in (0.0, 0.5, 1.0) for x in np.arange(0.0, 4.5, 0.5) if y <= x <= 4 - y]
)


def test_a_support_on_a_slope_holds_its_points_and_no_others():
    far = Support(Segment((3.0, 1.0), (4.0, 0.0)), (0.25, None))
    middle = Support(Region((2.0, 0.0)), (None, lambda p: -p[:, 0]))
    held, value = prescribed_displacements(bar(supports=(CLAMP, far, middle)), POINTS)
    x, y = POINTS.T
    left, right, below = x == y, x == 4 - y, (x == 2) & (y == 0)
    np.testing.assert_array_equal(held, np.stack([left | right, left | below], axis=1))
    np.testing.assert_array_equal(value, np.stack([0.25 * right, -2.0 * below], axis=1))


@table(
    ("segment", "ends"),
    [
        (Segment((0.0, 0.0), (0.7, 0.7)), "x = 0 to 0.5 m there, not at its ends"),
        (Segment((0.25, 0.25), (1.0, 1.0)), "x = 0.5 to 1 m there, not at its ends"),
        (Segment((4.0, 0.0), (3.3, 0.7)), "x = 3.5 to 4 m there, not at its ends"),
    ],
)
def test_a_support_that_ends_between_the_points_is_refused(segment, ends):
    with refused(ends):
        prescribed_displacements(bar(supports=(Support(segment, (0.0, 0.0)),)), POINTS)


def test_a_support_beside_the_points_is_refused():
    problem = bar(supports=(CLAMP, Support(Segment((2.1, 0.0), (2.2, 0.0)), (0.0, None))))
    with refused("support on ((2.1, 0) to (2.2, 0)): no point of the discretised body lies"):
        prescribed_displacements(problem, POINTS)


def test_a_side_that_a_region_takes_from_the_span_is_refused():
    # y = 1 spans 0 <= x <= 4, the body is there from 1 to 3 only.
    with refused("(y = 1): from (0, 1) to (4, 1) m it is not on one side"):
        bar(supports=(CLAMP, Support(Region((None, 1.0)), (None, 0.0))))
    top = Support(Region(((1.0, 3.0), 1.0)), (None, 0.0))
    held, _ = prescribed_displacements(bar(supports=(CLAMP, top)), POINTS)
    assert held[:, 1].sum() == 3 + 5 - 1


@table(
    ("domain", "part"),
    [
        (BAR, Segment((1.0, 0.0), (2.0, 1.0))),
        (BAR, Segment((1.0, 1.0), (1.0, 0.0))),
        (BAR, Segment((0.0, 0.0), (3.0, 1.0))),  # from corner to corner
        (BAR, Segment((0.0, 0.0), (1.0, 0.9))),
        (BAR, Region((2.0, None))),
        (ELL, Region((1.0, (0.0, 3.0)))),  # a side above y = 1 only
        (ELL, Segment((2.0, 1.0), (0.0, 1.0))),
        (NOTCHED, Segment((1.0, 0.0), (3.0, 0.0))),  # a side right of x = 2 only
        (NOTCHED, Region(((1.0, 3.0), 0.0))),
        (Box((2.0, 1.0)), Segment((0.0, 0.0), (2.0, 1.0))),
    ],
)
def test_a_support_or_a_traction_inside_the_body_is_refused(domain, part):
    held = (Support(Region((0.0, 0.0)), (0.0, 0.0)), Support(Region((2.0, 0.0)), (None, 0.0)))
    there = Support(part, (0.0, 0.0))
    for supports, loads in ((held, (Traction(part, (1.0, 0.0)),)), ((there,), ())):
        with refused("it is not on one side of the body all the way; give a part of a side, such"):
            Problem(domain, SHEET, supports, loads)


@table(("make", "message"), [
    (lambda: bar(loads=(Traction(Segment((3.0, 1.0), (5.0, -1.0)), (1.0, 0.0)),)),
        "region ((3, 1) to (5, -1)) reaches outside the body, 0 <= x <= 4"),
    (lambda: bar(loads=(PointForce((2.0, 1.5), (1.0, 0.0)),)), "reaches outside the body"),
    (lambda: Traction(SLOPE, (1.0, 0.0, 0.0)), "traction on ((0, 0) to (1, 1)): (1.0, 0.0, 0.0)"),
    (lambda: Traction(SLOPE, (NAN, 0.0)), "traction on ((0, 0) to (1, 1)): nan at index 0"),
    (bar(supports=()).refuse_free_body, "the supports leave the body free: translation along x"),
    (lambda: Support(SLOPE, (0.0,)), "support on ((0, 0) to (1, 1)): 1 components for 2 axes"),
    (lambda: Support(((0, 0), (1, 1)), (0.0, 0.0)), "give a Region, such as box.side('left')"),
    (lambda: bar(loads=Traction("left", (0.0, 0.0))), "a polygon has no names; give a Segment"),
    (lambda: Problem(BAR, Isotropic(1.0, 0.3, "solid"), (CLAMP,)),
        "problem: a 3D material in a 2D domain"),
    (lambda: Problem(BAR.vertices, SHEET, (CLAMP,)), "give a Box or a Polygon"),
])  # fmt: skip
def test_a_problem_that_does_not_fit_a_polygon_is_refused(make, message):
    with refused(message):
        make()
