"""Voronoi cells in a box, springs across their facets, Delaunay simplices.

They are held to identities, and to the intersection of half-spaces, cell by cell.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from scipy.spatial import ConvexHull, HalfspaceIntersection

from msvalidate.problem import Box
from msvalidate.springs.lattice.point_sets import POINT_SETS, box_points, periodic_points
from msvalidate.springs.lattice.tessellation import bounded_tessellation, delaunay_simplices
from tests.table import refused, table

SIZES = [(1.0, 1.0), (3.0, 0.7), (2.0, 2.0, 2.0), (0.5, 1.3, 2.1)]
every_kind = pytest.mark.parametrize("kind", POINT_SETS)
every_size = pytest.mark.parametrize("size", SIZES, ids=str)
EXACT = {"rtol": 1e-12, "atol": 0}


def lengths(tessellation):
    return np.linalg.norm(tessellation.vectors, axis=1)


def check_bounded(t):
    """What holds for every tessellation of a box."""
    size, dim = np.array(t.size), len(t.size)
    total = (t.area * lengths(t)).sum() + (t.side_area * t.side_distance).sum()
    np.testing.assert_allclose(total, dim * size.prod(), **EXACT)
    np.testing.assert_allclose(t.volume.sum(), size.prod(), **EXACT)
    np.testing.assert_allclose(t.side_area.sum(axis=0), np.repeat(size.prod() / size, 2), **EXACT)
    assert (t.side_area >= 0).all()
    assert (t.volume > 0).all()
    assert (t.springs[:, 0] < t.springs[:, 1]).all()
    assert len(np.unique(t.springs, axis=0)) == len(t.springs)
    assert not t.image.any()


@every_kind
@every_size
def test_areas_times_lengths_make_up_the_box(kind, size):
    for spacing in (0.4, 0.21):
        check_bounded(bounded_tessellation(box_points(kind, Box(size), spacing, 1), Box(size)))
    for count in (1, 2, 3, 7, 30, 200):
        check_bounded(bounded_tessellation(periodic_points(kind, count, size, 1), Box(size)))


def cut_out(points, box, flat_area):
    """Facets, side areas and volumes of cells by the intersection of half-spaces."""
    n, dim = points.shape
    edges = np.array(box.size)
    walls = np.concatenate(
        [np.column_stack([-np.eye(dim), np.zeros(dim)]), np.column_stack([np.eye(dim), -edges])]
    )
    inside = 0.5 * edges
    area, sides, volume = np.zeros((n, n)), np.zeros((n, 2 * dim)), np.zeros(n)
    for i in range(n):
        others = np.delete(np.arange(n), i)
        apart = points[others] - points[i]
        middle = 0.5 * (points[others] + points[i])
        bisectors = np.column_stack([apart, -(apart * middle).sum(axis=1)])
        # A point on the boundary is pulled inwards a little to lie within its cell.
        start = points[i] + 1e-6 * (inside - points[i])
        corners = HalfspaceIntersection(np.concatenate([walls, bisectors]), start).intersections
        volume[i] = ConvexHull(corners).volume
        for k, plane in enumerate(walls):  # all low ends first
            sides[i, 2 * (k % dim) + k // dim] = section(corners, plane, flat_area)
        for plane, j in zip(bisectors, others, strict=True):
            area[i, j] = section(corners, plane, flat_area)
    return area, sides, volume


def section(corners, plane, flat_area):
    """Area of the corners of a cell that lie in a plane."""
    away = (corners @ plane[:-1] + plane[-1]) / np.linalg.norm(plane[:-1])
    there = corners[np.abs(away) < 1e-9]
    there = there[np.unique(np.round(there, 9), axis=0, return_index=True)[1]]
    return flat_area(there, plane[:-1]) if len(there) >= len(plane) - 1 else 0.0


@every_kind
@pytest.mark.parametrize("size", [(1.0, 1.0), (1.5, 0.7), (1.0, 1.0, 1.0), (0.7, 1.3, 1.1)])
def test_cells_in_a_box_are_those_cut_out_of_it(kind, size, flat_area):
    box = Box(size)
    for points in (box_points(kind, box, 0.35, 2), periodic_points(kind, 12, size, 2)):
        t = bounded_tessellation(points, box)
        area, sides, volume = cut_out(points, box, flat_area)
        ours = np.zeros_like(area)
        ours[tuple(t.springs.T)] = t.area
        np.testing.assert_allclose(ours + ours.T, area, atol=1e-8)
        np.testing.assert_allclose(t.side_area, sides, atol=1e-8)
        np.testing.assert_allclose(t.volume, volume, atol=1e-8)


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_one_point_in_a_box_has_all_of_it(size):
    for place in (0.5, 0.1, 0.0, 1.0):
        t = bounded_tessellation(np.array([size]) * place, Box(size))
        check_bounded(t)
        assert len(t.springs) == 0


def test_two_points_and_their_reflections_may_be_on_one_circle():
    """With the images of the first margin the simplex between them is flat; with more it is not."""
    size = (7.0, 7.0, 7.0)
    points = periodic_points("uniform", 343, size, 40973523)
    check_bounded(bounded_tessellation(points, Box(size)))


@table(
    ("points", "message"),
    [
        ([[0.5, 0.5], [0.5, 1.1]], "points: 1, at (0.5, 1.1), is outside the box 1 x 1 m"),
        ([[0.5, 0.5], [0.5, 0.5]], "points: 0 and 1 are one place, (0.5, 0.5); leave one out"),
        ([[0.5, np.inf]], "points: inf at index (0, 1)"),
        ([0.5, 0.5], "points: shape (2,); give (n, 2)"),
    ],
)
@table("verb", [bounded_tessellation, delaunay_simplices])
def test_points_that_are_not_in_the_box_are_refused(verb, points, message):
    with refused(message):
        verb(points, Box((1.0, 1.0)))


def test_no_box_is_refused():
    with refused("box: (1.0, 1.0); give a Box"):
        bounded_tessellation([[0.5, 0.5]], (1.0, 1.0))


# Simplices ------------------------------------------------------------------------------------


def check_simplices(points, box):
    """They fill the box, meet face to face, and their boundary is the box's, turned outwards."""
    dim, size = box.dim, np.array(box.size)
    cells, facets = delaunay_simplices(points, box)
    content = np.linalg.det(points[cells][:, 1:] - points[cells][:, :1]) / math.factorial(dim)
    assert content.min() > 0
    np.testing.assert_allclose(content.sum(), box.volume, **EXACT)
    np.testing.assert_array_equal(np.unique(cells), np.arange(len(points)))
    faces = np.concatenate([np.delete(cells, k, axis=1) for k in range(dim + 1)])
    faces, times = np.unique(np.sort(faces, axis=1), axis=0, return_counts=True)
    assert times.max() == (2 if len(cells) > 1 else 1)
    np.testing.assert_array_equal(np.unique(np.sort(facets, axis=1), axis=0), faces[times == 1])
    place = points[facets]
    along = place[:, 1:] - place[:, :1]
    if dim == 2:
        normal = along[:, 0] @ np.array([[0.0, -1.0], [1.0, 0.0]])
    else:
        normal = 0.5 * np.cross(along[:, 0], along[:, 1])
    for axis, end in product(range(dim), (0, 1)):
        there = (place[:, :, axis] == end * size[axis]).all(axis=1)
        assert (normal[there][:, axis] * (2 * end - 1) > 0).all()
        covered = np.abs(normal[there][:, axis]).sum()
        np.testing.assert_allclose(covered, box.volume / size[axis], **EXACT)
    np.testing.assert_allclose(np.abs(normal).sum(), (2 * box.volume / size).sum(), **EXACT)
    return cells, facets


@every_kind
@every_size
@pytest.mark.parametrize("spacing", [0.9, 0.4, 0.17])
def test_simplices_fill_the_box(kind, size, spacing):
    check_simplices(box_points(kind, Box(size), spacing, 4), Box(size))


def test_a_missing_corner_is_refused():
    with refused("points: none in the corner (1, 1) of the box 1 x 1 m; add it"):
        delaunay_simplices([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], Box((1.0, 1.0)))
