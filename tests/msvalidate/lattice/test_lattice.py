"""Square lattices: points, springs and cells, and the weights of boundary springs."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.constants.directions import rotate_tensor
from msvalidate.constants.stiffness import spring_tensor, square_tensor
from msvalidate.lattice import WEIGHTS, boundary_weights, diagonal_square, square, trapezium
from msvalidate.problem import Box, ProblemError
from tests.table import refused, table

SIZES = [(1, 1), (1, 3), (4, 1), (5, 4)]
SPACING = 0.25


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def counts(request):
    return request.param


@pytest.fixture
def lattice(counts):
    return square(Box((SPACING * counts[0], SPACING * counts[1])), counts)


def coordination(lattice):
    """Number of springs at each point."""
    return np.bincount(lattice.springs.ravel(), minlength=len(lattice.points))


# The square lattice ---------------------------------------------------------------------------


def test_cells_are_squares_that_fill_the_box_counter_clockwise(lattice):
    corners = lattice.points[lattice.cells]
    steps = [[0, 0], [SPACING, 0], [SPACING, SPACING], [0, SPACING]]
    np.testing.assert_allclose(corners - corners[:, :1], np.tile(steps, (len(corners), 1, 1)))
    low_left, low_right, high_right, high_left = np.moveaxis(corners, 1, 0)
    across, up = high_right - low_left, high_left - low_right
    area = 0.5 * (across[:, 0] * up[:, 1] - across[:, 1] * up[:, 0])
    # Sums of a few tens of rounded areas.
    assert area.sum() == pytest.approx(lattice.domain.volume, rel=1e-13)
    assert len(np.unique(lattice.cells, axis=0)) == len(lattice.cells)


def test_borders_counts_the_cells_that_hold_both_ends(lattice):
    at_cell = np.zeros((len(lattice.points), len(lattice.cells)), dtype=bool)
    at_cell[lattice.cells.T, np.arange(len(lattice.cells))] = True
    i, j = lattice.springs.T
    np.testing.assert_array_equal(lattice.borders, (at_cell[i] & at_cell[j]).sum(axis=1))


@pytest.mark.parametrize(
    ("rule", "inner_axial", "outer_axial", "diagonal"),
    [("shared", 1.0, 0.5, 1.0), ("equal", 1.0, 1.0, 1.0), ("per_cell", 2.0, 1.0, 1.0)],
)
def test_boundary_weights(rule, inner_axial, outer_axial, diagonal):
    lattice = square(Box((3.0, 2.0)), (3, 2))
    middle = lattice.points[lattice.springs].mean(axis=1)
    outer = ((middle == 0) | (middle == lattice.domain.size)).any(axis=1)
    expected = np.where(lattice.kind == 1, diagonal, np.where(outer, outer_axial, inner_axial))
    np.testing.assert_array_equal(boundary_weights(lattice, rule), expected)


def test_equal_weights_stiffen_a_block_by_its_boundary():
    # N + 1 rows of N axial springs stand for N cells: C11 = k1 (N + 1)/N + k2.
    for n in (1, 2, 10):
        lattice = square(Box((1.0, 1.0)), n)
        k = np.array([0.7, 0.2])[lattice.kind] * boundary_weights(lattice, "equal")
        tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
        np.testing.assert_allclose(tensor, square_tensor(0.7 * (n + 1) / n, 0.2), atol=1e-13)


def test_one_count_serves_both_axes():
    assert len(square(Box((3.0, 3.0)), 3).cells) == len(square(Box((3.0, 3.0)), (3, 3)).cells) == 9


def test_arrays_cannot_be_changed():
    lattice = square(Box((1.0, 1.0)), 1)
    for name in ("points", "springs", "kind", "cells", "facets", "share", "sharing"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(lattice, name)[0] = 0


@table(
    ("size", "cells", "message"),
    [
        ((1.0, 1.0, 1.0), 2, "square lattice: a box 1 x 1 x 1 m; give a plane box"),
        ((2.0, 1.0), 2, "2 x 2 cells of 1 m x 0.5 m; choose counts in the ratio 2 : 1"),
        ((1.0, 1.0), 0, "cells: 0; give a whole number, 1 or more"),
        ((1.0, 1.0), (2, -1), "cells: -1; give a whole number, 1 or more"),
        ((1.0, 1.0), 2.0, "cells: 2.0; give a whole number"),
        ((1.0, 1.0), float("nan"), "cells: nan; give a whole number"),
        ((1.0, 1.0), (2, 2, 2), "cells: (2, 2, 2); give one or two whole numbers"),
    ],
)
@table("build", [square, diagonal_square])
def test_bad_sizes_are_refused(build, size, cells, message):
    with refused(message):
        build(Box(size), cells)


@pytest.mark.parametrize("build", [square, diagonal_square])
def test_squares_do_not_fill_a_polygon(build):
    with refused("square lattice: a polygon of 4 vertices, 1 x 0.433013 m; give a plane box"):
        build(trapezium(0.5, (1, 1)), 2)


def test_an_unknown_weight_rule_is_refused_with_the_known_ones():
    with pytest.raises(ProblemError, match=f"'halved'; choose {', '.join(WEIGHTS)}"):
        boundary_weights(square(Box((1.0, 1.0)), 1), "halved")


# The square lattice cut at 45 degrees ---------------------------------------------------------


@pytest.fixture
def diagonal(counts):
    return diagonal_square(Box((SPACING * counts[0], SPACING * counts[1])), counts)


def test_numbers_of_the_square_lattice_at_45_degrees(diagonal, counts):
    nx, ny = counts
    assert len(diagonal.points) == (nx + 1) * (ny + 1) + nx * ny
    sides, between = nx * (ny + 1) + ny * (nx + 1), (nx - 1) * ny + nx * (ny - 1)
    assert np.bincount(diagonal.kind).tolist() == [4 * nx * ny, sides + between]
    assert len(diagonal.springs) == len(diagonal.kind) == len(diagonal.borders)
    assert len(np.unique(diagonal.springs, axis=0)) == len(diagonal.springs)
    assert (diagonal.springs[:, 0] < diagonal.springs[:, 1]).all()
    assert len(diagonal.cells) == 4 * nx * ny
    assert len(diagonal.facets) == 2 * (nx + ny)


def test_springs_at_45_degrees_have_the_lengths_and_directions_of_their_kind(diagonal):
    along, across = np.abs(diagonal.vectors).T
    axial = diagonal.kind == 0
    np.testing.assert_allclose(along[axial], SPACING / 2, rtol=1e-14)
    np.testing.assert_allclose(across[axial], SPACING / 2, rtol=1e-14)
    np.testing.assert_allclose(np.maximum(along, across)[~axial], SPACING, rtol=1e-14)
    np.testing.assert_allclose(np.minimum(along, across)[~axial], 0, atol=1e-15)


def test_every_place_at_45_degrees_has_the_neighbours_that_the_cut_leaves(diagonal, counts):
    # Corners and centres of squares: 8 inside; a cut takes what reaches over it.
    nx, ny = counts
    grid = (nx + 1) * (ny + 1)
    on_sides = ((diagonal.points == 0) | (diagonal.points == diagonal.domain.size)).sum(axis=1)
    found = coordination(diagonal)
    np.testing.assert_array_equal(found[:grid], np.array([8, 5, 3])[on_sides[:grid]])
    column, row = np.tile(np.arange(nx), ny), np.repeat(np.arange(ny), nx)
    lost = sum((place == end).astype(int) for place, end in ((column, 0), (row, 0)))
    lost += sum((place == end).astype(int) for place, end in ((column, nx - 1), (row, ny - 1)))
    np.testing.assert_array_equal(found[grid:], 8 - lost)


def test_quarters_fill_the_box_counter_clockwise(diagonal):
    a, b, c = np.moveaxis(diagonal.points[diagonal.cells], 1, 0)
    area = 0.5 * ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0])
    np.testing.assert_allclose(area, SPACING**2 / 4, rtol=1e-13)


def test_places_at_45_degrees_share_the_area_alike_where_none_is_cut_off(diagonal):
    on_sides = ((diagonal.points == 0) | (diagonal.points == diagonal.domain.size)).sum(axis=1)
    np.testing.assert_allclose(diagonal.point_volume, SPACING**2 / 2 / 2.0**on_sides, rtol=1e-13)
    assert diagonal.point_volume.sum() == pytest.approx(diagonal.domain.volume, rel=1e-13)


def test_springs_at_45_degrees_border_the_quarters_that_hold_both_ends(diagonal, counts):
    nx, ny = counts
    at_cell = np.zeros((len(diagonal.points), len(diagonal.cells)), dtype=bool)
    at_cell[diagonal.cells.T, np.arange(len(diagonal.cells))] = True
    i, j = diagonal.springs.T
    held = (at_cell[i] & at_cell[j]).sum(axis=1)
    crossing = held == 0  # from centre to centre: a quarter on either side
    assert crossing.sum() == (nx - 1) * ny + nx * (ny - 1)
    np.testing.assert_array_equal(diagonal.borders, np.where(crossing, 2, held))
    alone = boundary_weights(diagonal, "shared") == 0.5
    facets = {tuple(sorted(pair)) for pair in diagonal.facets.tolist()}
    assert {tuple(pair) for pair in diagonal.springs[alone].tolist()} == facets


@pytest.mark.parametrize("place", [(0.5, 0.5), (0.625, 0.375)], ids=["corner", "centre"])
def test_an_inner_place_at_45_degrees_is_the_turned_material(place):
    lattice = diagonal_square(Box((1.0, 1.0)), 4)
    (here,) = np.flatnonzero(np.isclose(lattice.points, place).all(axis=1))
    ours = (lattice.springs == here).any(axis=1)
    k = np.array([0.7, 0.2])[lattice.kind] * boundary_weights(lattice, "shared")
    volume = 2 * lattice.point_volume[here]  # every spring stands at its other end too
    tensor = spring_tensor(lattice.vectors[ours], k[ours], volume)
    np.testing.assert_allclose(
        tensor, rotate_tensor(square_tensor(0.7, 0.2), np.pi / 4), atol=1e-14
    )
