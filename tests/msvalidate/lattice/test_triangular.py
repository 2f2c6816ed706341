"""The triangular lattice and its outlines: points, springs and cells, whichever way it lies."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.constants.stiffness import spring_tensor
from msvalidate.lattice import boundary_weights, trapezium, triangular, zigzag_block
from msvalidate.problem import Box, Polygon
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


@pytest.mark.parametrize("size", BLOCKS)
@pytest.mark.parametrize("finer", [1, 2, 3])
def test_numbers_of_a_zigzag_block(size, finer):
    strips, sides = size
    outline = zigzag_block(1.3, size)
    assert outline.volume == pytest.approx(
        strips * (2 * sides - 1) * ROW / 2 * (1.3 / sides) ** 2, rel=1e-13
    )
    assert outline.span[0] == pytest.approx((0.0, strips * ROW * 1.3 / sides), rel=1e-15)
    assert outline.span[1] == (0.0, 1.3)
    assert len(outline.reentrant) == strips
    lattice = triangular(outline, 1.3 / sides / finer)
    around = finer * (2 * sides + 2 * strips)
    cells = finer**2 * strips * (2 * sides - 1)
    assert (len(lattice.cells), len(lattice.facets)) == (cells, around)
    # Every cell has three springs, of which the inner ones are shared; and Euler's formula.
    assert len(lattice.springs) == (3 * cells + around) / 2
    assert len(lattice.points) == len(lattice.springs) - cells + 1
    if finer == 1:  # columns of sides + 1 points and of one fewer, in turn
        assert len(lattice.points) == (strips // 2 + 1) * (sides + 1) + strips // 2 * sides


@pytest.mark.parametrize("size", BARS)
@pytest.mark.parametrize("finer", [1, 2])
def test_numbers_of_a_trapezium(size, finer):
    top, rows = size
    outline = trapezium(0.2, size)
    assert outline.volume == pytest.approx(rows * (2 * top + rows) * ROW / 2 * 0.04, rel=1e-13)
    assert len(outline.reentrant) == 0
    lattice = triangular(outline, 0.2 / finer)
    top, rows = finer * top, finer * rows
    assert len(lattice.cells) == rows * (2 * top + rows)
    assert len(lattice.points) == sum(top + row + 1 for row in range(rows + 1))
    assert len(lattice.facets) == 2 * top + 3 * rows
    assert len(lattice.springs) == (3 * len(lattice.cells) + len(lattice.facets)) / 2


def test_every_triangular_spring_is_one_spacing_long_and_listed_once(triangles):
    lattice, spacing = triangles
    np.testing.assert_allclose(np.linalg.norm(lattice.vectors, axis=1), spacing, rtol=1e-13)
    assert (lattice.springs[:, 0] < lattice.springs[:, 1]).all()
    assert len(np.unique(lattice.springs, axis=0)) == len(lattice.springs)
    assert not lattice.kind.any()


def test_inner_points_have_six_neighbours_and_boundary_ones_what_the_corner_leaves(triangles):
    lattice, _ = triangles
    on_boundary = np.zeros(len(lattice.points), dtype=bool)
    on_boundary[lattice.facets] = True
    found = np.bincount(lattice.springs.ravel(), minlength=len(lattice.points))
    assert (found[~on_boundary] == 6).all()
    # One spring more than cells of 60 degrees at a point of the boundary.
    cells = np.bincount(lattice.cells.ravel())
    np.testing.assert_array_equal(found, cells + on_boundary)


def test_triangular_cells_fill_the_outline_counter_clockwise(triangles):
    lattice, spacing = triangles
    a, b, c = np.moveaxis(lattice.points[lattice.cells], 1, 0)
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    np.testing.assert_allclose(area, np.sqrt(3) / 4 * spacing**2, rtol=1e-12)
    assert area.sum() == pytest.approx(lattice.domain.volume, rel=1e-13)
    assert lattice.point_volume.sum() == pytest.approx(lattice.domain.volume, rel=1e-13)
    assert len(np.unique(np.sort(lattice.cells, axis=1), axis=0)) == len(lattice.cells)


def test_facets_of_triangles_lie_on_the_outline_and_their_springs_count_half(triangles):
    lattice, spacing = triangles
    ends = lattice.points[lattice.facets]
    assert all(lattice.domain.on_boundary(pair) for pair in ends)
    sides = np.roll(lattice.domain.corners, -1, axis=0) - lattice.domain.corners
    around = np.linalg.norm(sides, axis=1).sum()
    assert len(lattice.facets) * spacing == pytest.approx(around, rel=1e-13)
    weight = boundary_weights(lattice, "shared")
    np.testing.assert_array_equal(lattice.springs[weight == 0.5], lattice.facets)
    assert set(weight.tolist()) <= {0.5, 1.0}
    np.testing.assert_array_equal(2 * weight, lattice.borders)


def test_shared_weights_give_triangles_the_closed_form_tensor_at_any_size(triangles):
    # Three springs k a site of area √3/2·h²: C11 = 3√3k/4, C12 = C66 = √3k/4.
    lattice, _ = triangles
    k = 0.8 * boundary_weights(lattice, "shared")
    tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
    expected = 0.8 * np.sqrt(3) / 4 * np.array([[3, 1, 0], [1, 3, 0], [0, 0, 1]])
    np.testing.assert_allclose(tensor, expected, atol=1e-14)  # sums of a few tens


def test_a_zigzag_block_is_symmetric_about_its_middle_line():
    lattice = triangular(zigzag_block(1.0, (4, 5)), 0.2)
    mirrored = lattice.points * [1, -1] + [0, 1]
    for points in (mirrored, lattice.points * [-1, 1] + [lattice.domain.span[0][1], 0]):
        apart = np.linalg.norm(points[:, None] - lattice.points, axis=2)
        assert apart.min(axis=1).max() < 1e-15


@settings(max_examples=25, deadline=None)
@given(
    name=st.sampled_from(sorted(OUTLINES)),
    angle=st.floats(-np.pi, np.pi),
    shift=st.tuples(*[st.floats(-5, 5)] * 2),
)
def test_a_moved_outline_has_the_moved_lattice(name, angle, shift):
    outline, spacing = OUTLINES[name]
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    moved = Polygon(tuple(map(tuple, (outline.corners @ turn.T + shift).tolist())))
    here, there = triangular(outline, spacing), triangular(moved, spacing)
    # Coordinates up to 10 m, rounded, and up to a dozen steps of a spacing from the first corner.
    np.testing.assert_allclose(there.points, here.points @ turn.T + shift, rtol=0, atol=1e-13)
    for array in ("springs", "cells", "facets", "borders", "kind"):
        np.testing.assert_array_equal(getattr(there, array), getattr(here, array))


@pytest.mark.parametrize("first", range(12))
@pytest.mark.parametrize("name", ["star", "block 6x5", "bar 5x3"])
def test_any_vertex_may_come_first(name, first):
    outline, spacing = OUTLINES[name]
    again = Polygon(tuple(map(tuple, np.roll(outline.corners, first, axis=0).tolist())))
    here, there = triangular(outline, spacing), triangular(again, spacing)
    apart = np.linalg.norm(here.points[:, None] - there.points, axis=2)
    assert apart.min(axis=1).max() < 1e-13
    assert len(here.points) == len(there.points)
    assert len(here.cells) == len(there.cells)


def strips(*shifts):
    """Strips four sides long, one above the other, each moved along by its shift."""
    right, left = [], []
    for row, shift in enumerate(shifts):
        low, high = row / 2 + shift, (row + 1) / 2 + shift
        right += [(4 + low, row * ROW), (4 + high, (row + 1) * ROW)]
        left += [(low, row * ROW), (high, (row + 1) * ROW)]
    return Polygon((*left[:1], *right, *left[:0:-1]))


def test_strips_moved_by_whole_sides_are_triangles():
    assert len(triangular(strips(0, 1, -1), 1.0).cells) == 24


@table(
    ("outline", "spacing", "message"),
    [
        (
            zigzag_block(1.0, (4, 5)),
            0.3,
            "side 0.3 m runs along edge 0 of the outline, from (0, 1)",
        ),
        (
            zigzag_block(1.0, (4, 4)),
            0.5,
            "side 0.5 m runs along edge 1 of the outline, from (0, 0)",
        ),
        (zigzag_block(1.0, (4, 4)), 1e3, "side 1000 m runs along edge 0"),
        (trapezium(0.2, (3, 2)), 0.1999, "choose a spacing that divides every edge"),
        (trapezium(0.2, (3, 3)), 0.4, "along edge 1"),
        (
            Polygon(((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))),
            0.25,
            "along edge 1 of the outline, from (1, 0); choose a spacing that divides every",
        ),
        # Whole rows of the right area, with straight ends; edges of a whole length off the rows.
        (Polygon(((0.0, 0.0), (4.0, 0.0), (4.0, 2 * ROW), (0.0, 2 * ROW))), 1.0, "along edge 1"),
        (Polygon(((0.0, 0.0), (8.0, 0.0), (2.5, 5 * ROW))), 1.0, "along edge 1"),
        # Whole sides along the rows, but not from point to point; the second has the very area
        # and perimeter of the triangles whose middles it holds.
        (strips(0, 0.5), 1.0, "along edge 2 of the outline, from (4.5, 0.866025)"),
        (strips(0, 0.25, 0, 0.5), 1.0, "along edge 2 of the outline, from (4.5, 0.866025)"),
        (
            trapezium(0.2, (3, 2)),
            -0.2,
            "triangular lattice: spacing: -0.2 m; it must be above zero",
        ),
        (trapezium(0.2, (3, 2)), 0.0, "triangular lattice: spacing: 0.0 m"),
        (trapezium(0.2, (3, 2)), NAN, "triangular lattice: spacing: nan; every value must be"),
        (
            trapezium(0.2, (3, 2)),
            (0.2, 0.2),
            "triangular lattice: spacing: (0.2, 0.2) is a list; give one number",
        ),
        (Box((1.0, 1.0)), 0.2, "triangular lattice: a box 1 x 1 m; give a Polygon, such as zigzag"),
    ],
)
def test_an_outline_that_is_no_union_of_triangles_is_refused(outline, spacing, message):
    with refused(message):
        triangular(outline, spacing)


@table(
    ("make", "message"),
    [
        (
            lambda: zigzag_block(1.0, (3, 5)),
            "zigzag block: cells (3, 5); give an even number of strips, 2 sides",
        ),
        (lambda: zigzag_block(1.0, (4, 1)), "cells (4, 1); give an even number of strips, 2 sides"),
        (lambda: zigzag_block(1.0, (0, 4)), "cells: 0; give a whole number, 1 or more"),
        (lambda: zigzag_block(1.0, (4, 2.0)), "cells: 2.0; give a whole number, 1 or more"),
        (lambda: zigzag_block(1.0, (4, 2, 2)), "cells: (4, 2, 2); give one or two whole numbers"),
        (lambda: zigzag_block(-1.0, (4, 2)), "zigzag block: height: -1.0 m; it must be above zero"),
        (
            lambda: zigzag_block(NAN, (4, 2)),
            "zigzag block: height: nan; every value must be finite",
        ),
        (lambda: trapezium(-0.2, (3, 2)), "trapezium: spacing: -0.2 m; it must be above zero"),
        (lambda: trapezium(NAN, (3, 2)), "trapezium: spacing: nan; every value must be finite"),
        (lambda: trapezium(0.2, (0, 2)), "cells: 0; give a whole number, 1 or more"),
        (lambda: trapezium(0.2, (3, 1.5)), "cells: 1.5; give a whole number, 1 or more"),
    ],
)
def test_bad_outlines_are_refused_by_name(make, message):
    with refused(message):
        make()
