"""The square lattice: its points, springs and cells, and the weights of boundary springs."""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.lattice import WEIGHTS, boundary_weights, square
from msvalidate.problem import Box, ProblemError
from msvalidate.stiffness import spring_tensor, square_tensor

SIZES = [(1, 1), (1, 3), (4, 1), (5, 4)]
SPACING = 0.25


@pytest.fixture(params=SIZES, ids=lambda size: f"{size[0]}x{size[1]}")
def counts(request):
    return request.param


@pytest.fixture
def lattice(counts):
    return square(Box((SPACING * counts[0], SPACING * counts[1])), counts)


def test_numbers_of_points_springs_cells_and_facets(lattice, counts):
    nx, ny = counts
    assert len(lattice.points) == (nx + 1) * (ny + 1)
    assert np.bincount(lattice.kind).tolist() == [nx * (ny + 1) + ny * (nx + 1), 2 * nx * ny]
    assert len(lattice.springs) == len(lattice.kind) == len(lattice.borders)
    assert len(lattice.cells) == nx * ny
    assert len(lattice.facets) == 2 * (nx + ny)


def test_coordination_is_8_inside_5_on_edges_3_at_corners(lattice):
    coordination = np.bincount(lattice.springs.ravel(), minlength=len(lattice.points))
    on_sides = ((lattice.points == 0) | (lattice.points == lattice.domain.size)).sum(axis=1)
    np.testing.assert_array_equal(coordination, np.array([8, 5, 3])[on_sides])


def test_springs_are_listed_once_the_lower_point_first(lattice):
    assert (lattice.springs[:, 0] < lattice.springs[:, 1]).all()
    assert len(np.unique(lattice.springs, axis=0)) == len(lattice.springs)


def test_axial_springs_are_one_spacing_long_and_diagonals_root_two(lattice):
    length = np.linalg.norm(lattice.vectors, axis=1)
    # Coordinates are rounded to an eps of the box.
    np.testing.assert_allclose(length, SPACING * np.sqrt([1, 2])[lattice.kind], rtol=1e-14)


def test_cells_are_squares_that_fill_the_box_x_fastest(lattice):
    corners = lattice.points[lattice.cells]
    steps = [[0, 0], [SPACING, 0], [0, SPACING], [SPACING, SPACING]]
    np.testing.assert_allclose(corners - corners[:, :1], np.tile(steps, (len(corners), 1, 1)))
    low_left, low_right, high_left, high_right = np.moveaxis(corners, 1, 0)
    across, up = high_right - low_left, high_left - low_right
    area = 0.5 * (across[:, 0] * up[:, 1] - across[:, 1] * up[:, 0])
    # Sums of a few tens of rounded areas.
    assert area.sum() == pytest.approx(lattice.domain.volume, rel=1e-13)
    assert lattice.cell_volume == pytest.approx(area[0], rel=1e-13)
    assert len(np.unique(lattice.cells, axis=0)) == len(lattice.cells)


def test_facets_are_the_edges_of_one_cell_only(lattice):
    edges = np.concatenate([lattice.cells[:, e] for e in ([0, 1], [2, 3], [0, 2], [1, 3])])
    edges, cells = np.unique(np.sort(edges, axis=1), axis=0, return_counts=True)
    facets = np.sort(lattice.facets, axis=1)
    np.testing.assert_array_equal(facets[np.lexsort(facets.T[::-1])], edges[cells == 1])


def test_borders_counts_the_cells_that_hold_both_ends(lattice):
    at_cell = np.zeros((len(lattice.points), len(lattice.cells)), dtype=bool)
    at_cell[lattice.cells.T, np.arange(len(lattice.cells))] = True
    i, j = lattice.springs.T
    np.testing.assert_array_equal(lattice.borders, (at_cell[i] & at_cell[j]).sum(axis=1))


def test_boundary_springs_are_as_many_as_the_boundary_has_cell_edges(lattice, counts):
    alone = lattice.borders < lattice.sharing[lattice.kind]
    assert alone.sum() == 2 * sum(counts)
    assert (lattice.kind[alone] == 0).all()


def test_every_point_has_its_share_of_the_area(lattice):
    on_sides = ((lattice.points == 0) | (lattice.points == lattice.domain.size)).sum(axis=1)
    np.testing.assert_allclose(lattice.point_volume, SPACING**2 / 2.0**on_sides, rtol=1e-13)
    assert lattice.point_volume.sum() == pytest.approx(lattice.domain.volume, rel=1e-13)


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


def test_shared_weights_give_the_closed_form_tensor_at_any_size(lattice):
    k = np.array([0.7, 0.2])[lattice.kind] * boundary_weights(lattice, "shared")
    tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
    np.testing.assert_allclose(tensor, square_tensor(0.7, 0.2), atol=1e-14)  # sums of a few tens


def test_equal_weights_stiffen_a_block_by_its_boundary():
    # N + 1 rows of N axial springs stand for N cells: C11 = k1 (N + 1)/N + k2.
    for n in (1, 2, 10):
        lattice = square(Box((1.0, 1.0)), n)
        k = np.array([0.7, 0.2])[lattice.kind] * boundary_weights(lattice, "equal")
        tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
        np.testing.assert_allclose(tensor, square_tensor(0.7 * (n + 1) / n, 0.2), atol=1e-13)


def test_per_cell_weights_give_every_cell_springs_of_its_own(lattice):
    k = np.array([0.7, 0.2])[lattice.kind] * boundary_weights(lattice, "per_cell")
    tensor = spring_tensor(lattice.vectors, k, lattice.domain.volume)
    np.testing.assert_allclose(tensor, square_tensor(2 * 0.7, 0.2), atol=1e-13)


def test_one_count_serves_both_axes():
    assert len(square(Box((3.0, 3.0)), 3).cells) == len(square(Box((3.0, 3.0)), (3, 3)).cells) == 9


def test_arrays_cannot_be_changed():
    lattice = square(Box((1.0, 1.0)), 1)
    for name in ("points", "springs", "kind", "cells", "facets", "borders", "sharing"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(lattice, name)[0] = 0


@pytest.mark.parametrize(
    ("size", "cells", "message"),
    [
        ((1.0, 1.0, 1.0), 2, "square lattice: a 3D box; give a plane one"),
        ((2.0, 1.0), 2, "2 x 2 cells of 1 m x 0.5 m; choose counts in the ratio 2 : 1"),
        ((1.0, 1.0), 0, "cells: 0; give a whole number, 1 or more"),
        ((1.0, 1.0), (2, -1), "cells: -1; give a whole number, 1 or more"),
        ((1.0, 1.0), 2.0, "cells: 2.0; give a whole number"),
        ((1.0, 1.0), float("nan"), "cells: nan; give a whole number"),
        ((1.0, 1.0), (2, 2, 2), "cells: (2, 2, 2); give one or two whole numbers"),
    ],
)
def test_bad_sizes_are_refused(size, cells, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        square(Box(size), cells)


def test_an_unknown_weight_rule_is_refused_with_the_known_ones():
    with pytest.raises(ProblemError, match=f"'halved'; choose {', '.join(WEIGHTS)}"):
        boundary_weights(square(Box((1.0, 1.0)), 1), "halved")
