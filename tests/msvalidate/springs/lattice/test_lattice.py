"""Square lattices: points, springs and cells, and the weights of boundary springs."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, ProblemError
from msvalidate.springs.lattice import WEIGHTS, boundary_weights, diagonal_square, square, trapezium
from tests.table import refused, table

SIZES = [(1, 1), (1, 3), (4, 1), (5, 4)]
SPACING = 0.25


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def counts(request):
    return request.param


@pytest.fixture
def lattice(counts):
    return square(Box((SPACING * counts[0], SPACING * counts[1])), counts)


# The square lattice ---------------------------------------------------------------------------


def test_borders_counts_the_cells_that_hold_both_ends(lattice):
    at_cell = np.zeros((len(lattice.points), len(lattice.cells)), dtype=bool)
    at_cell[lattice.cells.T, np.arange(len(lattice.cells))] = True
    i, j = lattice.springs.T
    np.testing.assert_array_equal(lattice.borders, (at_cell[i] & at_cell[j]).sum(axis=1))


@table(
    ("size", "cells", "message"),
    [
        ((1.0, 1.0, 1.0), 2, "square lattice: a box 1 x 1 x 1 m; give a plane box"),
        ((2.0, 1.0), (2, 2), "2 x 2 cells of 1 m x 0.5 m; choose counts in the ratio 2 : 1"),
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
