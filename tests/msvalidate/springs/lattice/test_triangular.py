"""The triangular lattice and its outlines: points, springs and cells, whichever way it lies."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, Polygon
from msvalidate.springs.constants.stiffness import spring_tensor
from msvalidate.springs.lattice import boundary_weights, trapezium, triangular, zigzag_block
from tests.table import refused, table

NAN = float("nan")
SPACING = 0.25
ROW = np.sqrt(3) / 2
BLOCKS = [(2, 2), (2, 3), (4, 2), (6, 5)]
BARS = [(1, 1), (3, 1), (1, 4), (5, 3)]
OUTLINES = {
    **{f"block {n[0]}x{n[1]}": (zigzag_block(SPACING * n[1], n), SPACING) for n in BLOCKS},
    **{f"bar {n[0]}x{n[1]}": (trapezium(SPACING, n), SPACING) for n in BARS},
    "one cell": (Polygon(((0.0, 0.0), (2.0, 0.0), (1.0, 2 * ROW))), 2.0),
    # Two triangles of three sides, one upside down: corners inside at 240 degrees.
    "star": (
        Polygon(
            (
                *((1.0, 0.0), (1.5, -ROW), (2.0, 0.0), (3.0, 0.0), (2.5, ROW), (3.0, 2 * ROW)),
                *((2.0, 2 * ROW), (1.5, 3 * ROW), (1.0, 2 * ROW), (0.0, 2 * ROW), (0.5, ROW)),
                (0.0, 0.0),
            )
        ),
        0.5,
    ),
}


@pytest.fixture(params=OUTLINES)
def triangles(request):
    outline, spacing = OUTLINES[request.param]
    return triangular(outline, spacing), spacing


def test_shared_weights_give_triangles_the_closed_form_tensor_at_any_size(triangles):
    # Three springs k a site of area √3/2·h²: C11 = 3√3k/4, C12 = C66 = √3k/4.
    lattice, _ = triangles
    k = 0.8 * boundary_weights(lattice, "shared")
    tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
    expected = 0.8 * np.sqrt(3) / 4 * np.array([[3, 1, 0], [1, 3, 0], [0, 0, 1]])
    np.testing.assert_allclose(tensor, expected, atol=1e-14)  # sums of a few tens


def strips(*shifts):
    """Strips four sides long, one above the other, each moved along by its shift."""
    right, left = [], []
    for row, shift in enumerate(shifts):
        low, high = row / 2 + shift, (row + 1) / 2 + shift
        right += [(4 + low, row * ROW), (4 + high, (row + 1) * ROW)]
        left += [(low, row * ROW), (high, (row + 1) * ROW)]
    return Polygon((*left[:1], *right, *left[:0:-1]))


@table(("outline", "spacing", "message"), [
    (zigzag_block(1.0, (4, 5)), 0.3, "side 0.3 m runs along edge 0 of the outline, from (0, 1)"),
    (zigzag_block(1.0, (4, 4)), 0.5, "side 0.5 m runs along edge 1 of the outline, from (0, 0)"),
    (zigzag_block(1.0, (4, 4)), 1e3, "side 1000 m runs along edge 0"),
    (trapezium(0.2, (3, 2)), 0.1999, "choose a spacing that divides every edge"),
    (trapezium(0.2, (3, 3)), 0.4, "along edge 1"),
    (Polygon(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))), 0.25,
        "along edge 1 of the outline, from (1, 0); choose a spacing that divides every"),
    # Whole rows of the right area, with straight ends; edges of a whole length off the rows.
    (Polygon(((0.0, 0.0), (4.0, 0.0), (4.0, 2 * ROW), (0.0, 2 * ROW))), 1.0, "along edge 1"),
    (Polygon(((0.0, 0.0), (8.0, 0.0), (2.5, 5 * ROW))), 1.0, "along edge 1"),
    # Whole sides along the rows, but not from point to point; the second has the very area
    # and perimeter of the triangles whose middles it holds.
    (strips(0, 0.5), 1.0, "along edge 2 of the outline, from (4.5, 0.866025)"),
    (strips(0, 0.25, 0, 0.5), 1.0, "along edge 2 of the outline, from (4.5, 0.866025)"),
    (trapezium(0.2, (3, 2)), -0.2, "triangular lattice: spacing: -0.2 m; it must be above zero"),
    (trapezium(0.2, (3, 2)), 0.0, "triangular lattice: spacing: 0.0 m"),
    (trapezium(0.2, (3, 2)), NAN, "triangular lattice: spacing: nan; every value must be"),
    (trapezium(0.2, (3, 2)), (0.2, 0.2),
        "triangular lattice: spacing: (0.2, 0.2) is a list; give one number"),
    (Box((1.0, 1.0)), 0.2, "triangular lattice: a box 1 x 1 m; give a Polygon, such as zigzag"),
])  # fmt: skip
def test_an_outline_that_is_no_union_of_triangles_is_refused(outline, spacing, message):
    with refused(message):
        triangular(outline, spacing)


@table(("make", "message"), [
    (lambda: zigzag_block(1.0, (3, 5)),
        "zigzag block: cells (3, 5); give an even number of strips, 2 sides"),
    (lambda: zigzag_block(1.0, (4, 1)), "cells (4, 1); give an even number of strips, 2 sides"),
    (lambda: zigzag_block(1.0, (0, 4)), "cells: 0; give a whole number, 1 or more"),
    (lambda: zigzag_block(1.0, (4, 2.0)), "cells: 2.0; give a whole number, 1 or more"),
    (lambda: zigzag_block(1.0, (4, 2, 2)), "cells: (4, 2, 2); give one or two whole numbers"),
    (lambda: zigzag_block(-1.0, (4, 2)), "zigzag block: height: -1.0 m; it must be above zero"),
    (lambda: zigzag_block(NAN, (4, 2)), "zigzag block: height: nan; every value must be finite"),
    (lambda: trapezium(-0.2, (3, 2)), "trapezium: spacing: -0.2 m; it must be above zero"),
    (lambda: trapezium(NAN, (3, 2)), "trapezium: spacing: nan; every value must be finite"),
    (lambda: trapezium(0.2, (0, 2)), "cells: 0; give a whole number, 1 or more"),
    (lambda: trapezium(0.2, (3, 1.5)), "cells: 1.5; give a whole number, 1 or more"),
])  # fmt: skip
def test_bad_outlines_are_refused_by_name(make, message):
    with refused(message):
        make()
