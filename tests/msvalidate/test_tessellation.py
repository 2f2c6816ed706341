"""Voronoi cells, springs across their facets, Delaunay simplices: identities and independent ways.

The independent ways are scipy's Voronoi diagram of 5^d images for periodic cells, and for boxes the
intersection of half-spaces, cell by cell.
"""

from __future__ import annotations

import math
import re
import time
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull, HalfspaceIntersection, QhullError, Voronoi

from msvalidate.lattice.point_sets import POINT_SETS, box_points, periodic_points
from msvalidate.lattice.tessellation import bounded_tessellation, periodic_tessellation, simplices
from msvalidate.problem import Box, ProblemError, SolverError

SIZES = [(1.0, 1.0), (3.0, 0.7), (2.0, 2.0, 2.0), (0.5, 1.3, 2.1)]
every_kind = pytest.mark.parametrize("kind", POINT_SETS)
every_size = pytest.mark.parametrize("size", SIZES, ids=str)
EXACT = {"rtol": 1e-12, "atol": 0}


def refused(message):
    return pytest.raises(ProblemError, match=re.escape(message))


def lengths(tessellation):
    return np.linalg.norm(tessellation.vectors, axis=1)


def coordination(tessellation):
    """Number of springs at each point; one to its own image counts twice."""
    return np.bincount(tessellation.springs.ravel(), minlength=len(tessellation.points))


def grid(*counts):
    """Points 1 m apart from the origin on."""
    return np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(
        -1, len(counts)
    ) * np.ones(len(counts))


def flat_area(corners, normal):
    """Area of the convex hull of points in the plane across a normal."""
    _, _, axes = np.linalg.svd(normal[None])
    flat = (corners - corners.mean(axis=0)) @ axes[1:].T
    if flat.shape[1] == 1:
        return float(np.ptp(flat))
    try:
        return float(ConvexHull(flat).volume)
    except QhullError:  # the points lie on a line
        return 0.0


def check_periodic(tessellation):
    """What holds for every periodic tessellation."""
    t, dim = tessellation, len(tessellation.size)
    assert (t.springs[:, 0] <= t.springs[:, 1]).all()
    named = np.column_stack([t.springs, t.image])
    own = t.springs[:, 0] == t.springs[:, 1]
    reverse = np.column_stack([t.springs[own], -t.image[own]])
    assert len(np.unique(np.concatenate([named, reverse]), axis=0)) == len(named) + len(reverse)
    assert (t.area > 0).all()
    np.testing.assert_allclose((t.area * lengths(t)).sum(), dim * math.prod(t.size), **EXACT)
    np.testing.assert_allclose(t.volume.sum(), math.prod(t.size), **EXACT)
    # A closed surface: facets times normals sum to zero at each point.
    push = (t.area / lengths(t))[:, None] * t.vectors
    total = np.zeros_like(t.points)
    np.add.at(total, t.springs[:, 0], push)
    np.add.at(total, t.springs[:, 1], -push)
    scale = (math.prod(t.size) / len(t.points)) ** ((dim - 1) / dim)
    assert np.abs(total).max() < 1e-9 * scale


# A periodic cell ------------------------------------------------------------------------------


@every_kind
@every_size
@pytest.mark.parametrize("count", [1, 2, 3, 7, 30, 300])
def test_areas_times_lengths_make_up_the_periodic_cell(kind, size, count):
    for seed in range(2 if count < 300 else 1):
        check_periodic(periodic_tessellation(periodic_points(kind, count, size, seed), size))


def brute_force(points, size):
    """Area of each facet by the springs' names, from scipy's Voronoi diagram of 5^d images."""
    n, dim = points.shape
    shifts = np.array(sorted(product(range(-2, 3), repeat=dim), key=lambda k: np.abs(k).sum()))
    diagram = Voronoi((points + (shifts * np.array(size))[:, None]).reshape(-1, dim))
    found = {}
    for (a, b), corners in zip(diagram.ridge_points, diagram.ridge_vertices, strict=True):
        if min(a, b) >= n:
            continue
        assert -1 not in corners
        across = diagram.points[b] - diagram.points[a]
        (i, s), (j, t) = (a % n, shifts[a // n]), (b % n, shifts[b // n])
        place = diagram.vertices[corners]
        place = place[np.unique(np.round(place, 11), axis=0, return_index=True)[1]]
        if len(place) < dim:
            continue
        area = flat_area(place, across)
        if area > 1e-9:
            found[i, j, *(t - s)] = found[j, i, *(s - t)] = area
    return found


@every_kind
@every_size
@pytest.mark.parametrize("count", [4, 7, 12])
def test_springs_and_areas_are_those_of_a_diagram_of_many_images(kind, size, count):
    if max(size) > 2.5:
        size = (1.4, 0.7)
    t = periodic_tessellation(periodic_points(kind, count, size, 11), size)
    known = brute_force(t.points, size)
    ours = {}
    for (i, j), shift, area in zip(t.springs, t.image, t.area, strict=True):
        ours[i, j, *shift] = ours[j, i, *(-shift)] = area
    assert ours.keys() == known.keys()
    for name, area in known.items():
        assert ours[name] == pytest.approx(area, rel=1e-8, abs=1e-10)


LATTICES = {
    "square": (grid(4, 3), (4.0, 3.0), {4: 1.0}),
    "cubic": (grid(2, 3, 2), (2.0, 3.0, 2.0), {6: 1.0}),
    "BCC": (
        np.concatenate([grid(2, 2, 2), grid(2, 2, 2) + 0.5]),
        (2.0, 2.0, 2.0),
        {8: 3 * math.sqrt(3) / 16, 6: 1 / 8},
    ),
    "FCC": (
        np.concatenate(
            [grid(2, 2, 2) + s for s in ([0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0, 0.5, 0.5])]
        ),
        (2.0, 2.0, 2.0),
        {12: math.sqrt(2) / 8},
    ),
    "triangular": (
        np.concatenate([grid(3, 2), grid(3, 2) + 0.5]) * [1, math.sqrt(3)],
        (3.0, 2 * math.sqrt(3)),
        {6: 1 / math.sqrt(3)},
    ),
}
"""Points, cell, and the number of facets of each area at a point."""


@pytest.mark.parametrize("name", LATTICES)
def test_lattices_have_their_neighbours_and_facets(name):
    points, size, facets = LATTICES[name]
    rng = np.random.default_rng(0)
    for shift in (0.0, *rng.uniform(-9, 9, (4, len(size)))):
        t = periodic_tessellation(points + shift, size)
        check_periodic(t)
        assert (coordination(t) == sum(facets)).all()
        expected = np.repeat(list(facets.values()), [n * len(points) // 2 for n in facets])
        np.testing.assert_allclose(np.sort(t.area), np.sort(expected), rtol=1e-12)
        np.testing.assert_allclose(t.volume, math.prod(size) / len(points), rtol=1e-12)


@pytest.mark.parametrize("size", [(1.0, 1.0), (2.0, 0.1), (1.0, 1.0, 1.0), (1.0, 0.2, 3.0)])
def test_one_point_has_springs_to_its_own_images(size):
    t = periodic_tessellation(np.full((1, len(size)), 0.3), size)
    check_periodic(t)
    np.testing.assert_array_equal(np.abs(t.image)[np.lexsort(t.image.T)], np.eye(len(size)))
    np.testing.assert_allclose(t.area * lengths(t), math.prod(size), rtol=1e-12)


def test_a_square_grid_slightly_jittered_has_about_six_neighbours():
    rng = np.random.default_rng(0)
    t = periodic_tessellation(grid(8, 8) + rng.uniform(-1e-3, 1e-3, (64, 2)), (8.0, 8.0))
    check_periodic(t)
    assert coordination(t).mean() == 6


@every_kind
def test_mean_coordination_in_the_plane_is_six(kind):
    for seed in range(3):
        t = periodic_tessellation(periodic_points(kind, 200, (3.0, 0.7), seed), (3.0, 0.7))
        assert 2 * len(t.springs) == 6 * 200


def test_mean_coordination_of_uniform_points_in_space_is_that_of_poisson_voronoi():
    # 2 + 48π²/35 = 15.54 (Meijering 1953); the mean over 2000 points scatters by about 0.05.
    size = (1.0, 1.0, 1.0)
    sets = [periodic_points("uniform", 500, size, seed) for seed in range(4)]
    mean = np.mean([2 * len(periodic_tessellation(p, size).springs) / 500 for p in sets])
    assert mean == pytest.approx(2 + 48 * math.pi**2 / 35, abs=0.2)


@settings(deadline=None, max_examples=25)
@given(
    count=st.integers(1, 25),
    size=st.lists(st.floats(0.3, 2), min_size=2, max_size=3).map(tuple),
    seed=st.integers(0, 2**32),
    unit=st.sampled_from([1e-30, 1e-3, 1.0, 1e40]),
)
def test_moving_all_points_or_another_unit_leaves_areas(count, size, seed, unit):
    rng = np.random.default_rng(seed)
    points = rng.random((count, len(size))) * size
    still = periodic_tessellation(points, size)
    moved = periodic_tessellation(
        (points + rng.uniform(-5, 5, len(size))) * unit, tuple(unit * edge for edge in size)
    )
    check_periodic(still)
    check_periodic(moved)
    a, b = np.sort(still.area), np.sort(moved.area / unit ** (len(size) - 1))
    some = max(len(a), len(b))  # a facet may be just negligible in one place
    a, b = (np.pad(x, (some - len(x), 0)) for x in (a, b))
    np.testing.assert_allclose(a, b, rtol=1e-8, atol=1e-9)


def check_springs_make_up_the_body(t):
    """Σ A L = d V over the springs that are kept, the sides' part too where there are sides."""
    total = (t.area * lengths(t)).sum()
    if hasattr(t, "side_area"):
        total += (t.side_area * t.side_distance).sum()
    np.testing.assert_allclose(total, len(t.size) * math.prod(t.size), **EXACT)
    np.testing.assert_allclose(t.volume.sum(), math.prod(t.size), **EXACT)
    assert (t.area > 0).all()


NOISE = [0.0, *(10.0**power for power in range(-15, -3))]


@pytest.mark.parametrize("noise", NOISE)
@pytest.mark.parametrize("name", LATTICES)
def test_nearly_regular_points_make_up_the_cell(name, noise):
    points, size, facets = LATTICES[name]
    for seed in range(4):
        moved = points + noise * np.random.default_rng(seed).standard_normal(points.shape)
        t = periodic_tessellation(moved, size)
        check_springs_make_up_the_body(t)
        assert (coordination(t) >= sum(facets)).all()
        # Edges of cells move by some times as much as points do, ten at four deviations, and so
        # do areas, whose edges are shorter than 1 m: those made one are no further apart.
        large = t.area[t.area > 1e-2 * t.area.max()]
        expected = np.repeat(list(facets.values()), [n * len(points) // 2 for n in facets])
        np.testing.assert_allclose(
            np.sort(large), np.sort(expected), rtol=0, atol=50 * noise + 1e-12
        )
        np.testing.assert_allclose(t.volume, t.volume.mean(), rtol=50 * noise + 1e-12)


@pytest.mark.parametrize("noise", NOISE)
@pytest.mark.parametrize("count", [(10, 10), (6, 6, 6)], ids=str)
def test_a_nearly_regular_grid_makes_up_its_cell_and_box(count, noise):
    dim, edge = len(count), 1 / count[0]
    points = grid(*count) * edge
    moved = points + noise * np.random.default_rng(0).normal(size=points.shape)
    check_springs_make_up_the_body(periodic_tessellation(moved, (1.0,) * dim))
    check_springs_make_up_the_body(bounded_tessellation(moved + edge / 2, Box((1.0,) * dim)))


@pytest.mark.parametrize(
    ("dim", "width"), [(2, 1e-2), (2, 1e-3), (2, 1e-4), (2, 1e-5), (3, 1e-2), (3, 1e-3)]
)
def test_crowded_points_make_up_the_cell(dim, width):
    points = 0.5 + width * np.random.default_rng(1).random((30, dim))
    check_springs_make_up_the_body(periodic_tessellation(points, (1.0,) * dim))
    if width >= 1e-3:
        check_springs_make_up_the_body(bounded_tessellation(points, Box((1.0,) * dim)))


def test_points_too_crowded_are_refused():
    points = 0.5 + 1e-5 * np.random.default_rng(1).random((30, 2))
    with pytest.raises(SolverError, match=r"cells of 30 points.*some are too close"):
        bounded_tessellation(points, Box((1.0, 1.0)))


@pytest.mark.parametrize(
    ("count", "size"),
    [
        (3, (1e-6, 1.0)),
        (3, (1e-4, 1.0)),
        (30, (1e5, 1.0)),
        (30, (1e3, 1.0, 1.0)),
        (30, (1e-3, 1.0, 1.0)),
        (3, (1e-3, 1.0, 1.0)),
        (1000, (1e3, 1.0, 1.0)),
    ],
)
def test_a_body_too_long_or_flat_for_its_points_is_refused(count, size):
    points = np.random.default_rng(0).random((count, len(size))) * size
    box = Box(size)
    ratio = f"{max(size) / min(size):.3g} times as long as thick: they need "
    for verb in (periodic_tessellation, lambda p, _: bounded_tessellation(p, box)):
        start = time.perf_counter()
        with refused(f"cells of {count} points in the {box}, {ratio}"):
            verb(points, size)
        assert time.perf_counter() - start < 2  # without a bound, minutes to hours


@pytest.mark.parametrize(
    ("points", "size", "message"),
    [
        ([[0.1, 0.2], [0.5, 0.5], [1.1, 0.2]], (1.0, 1.0), "points: 0 and 2 are one place"),
        ([[0.0, 0.2], [1 - 1e-12, 0.2]], (1.0, 1.0), "points: 0 and 1 are one place"),
        ([[0.1, np.nan]], (1.0, 1.0), "points: nan at index (0, 1); every value must be finite"),
        ([[0.1, 0.2, 0.3]], (1.0, 1.0), "points: shape (1, 3); give (n, 2), n at least 1"),
        (np.empty((0, 2)), (1.0, 1.0), "points: shape (0, 2); give (n, 2), n at least 1"),
        ([[0.1, 0.2]], (1.0, 0.0), "box size along y"),
        (
            [[0.1, 0.2]],
            (1.0, 1e-8),
            "cells of 1 points in the box 1 x 1e-08 m, 1e+08 times as long as thick: they need",
        ),
        (["a"], (1.0, 1.0), "points: expected numbers"),
    ],
)
def test_what_cannot_be_tessellated_is_refused(points, size, message):
    with refused(message):
        periodic_tessellation(points, size)


# A box ----------------------------------------------------------------------------------------


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


def cut_out(points, box):
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
            sides[i, 2 * (k % dim) + k // dim] = section(corners, plane)
        for plane, j in zip(bisectors, others, strict=True):
            area[i, j] = section(corners, plane)
    return area, sides, volume


def section(corners, plane):
    """Area of the corners of a cell that lie in a plane."""
    away = (corners @ plane[:-1] + plane[-1]) / np.linalg.norm(plane[:-1])
    there = corners[np.abs(away) < 1e-9]
    there = there[np.unique(np.round(there, 9), axis=0, return_index=True)[1]]
    return flat_area(there, plane[:-1]) if len(there) >= len(plane) - 1 else 0.0


@every_kind
@pytest.mark.parametrize("size", [(1.0, 1.0), (1.5, 0.7), (1.0, 1.0, 1.0), (0.7, 1.3, 1.1)])
def test_cells_in_a_box_are_those_cut_out_of_it(kind, size):
    box = Box(size)
    for points in (box_points(kind, box, 0.35, 2), periodic_points(kind, 12, size, 2)):
        t = bounded_tessellation(points, box)
        area, sides, volume = cut_out(points, box)
        ours = np.zeros_like(area)
        ours[tuple(t.springs.T)] = t.area
        np.testing.assert_allclose(ours + ours.T, area, atol=1e-8)
        np.testing.assert_allclose(t.side_area, sides, atol=1e-8)
        np.testing.assert_allclose(t.volume, volume, atol=1e-8)


@pytest.mark.parametrize("counts", [(2, 2), (4, 3), (2, 2, 2), (4, 3, 5)], ids=str)
def test_a_grid_with_its_boundary_has_whole_half_and_quarter_facets(counts):
    points = grid(*counts)
    size = tuple(float(n - 1) for n in counts)
    t = bounded_tessellation(points, Box(size))
    check_bounded(t)
    on = (points == 0) | (points == size)
    i, j = t.springs.T
    np.testing.assert_allclose(lengths(t), 1, rtol=1e-12)
    both = on[i] & on[j] & (points[i] == points[j])
    np.testing.assert_allclose(t.area, 0.5 ** both.sum(axis=1), rtol=1e-12)
    assert len(t.springs) == sum((n - 1) * math.prod(counts) // n for n in counts)
    np.testing.assert_allclose(t.volume, 0.5 ** on.sum(axis=1), rtol=1e-12)
    expected = np.where(on, 0.5 ** (on.sum(axis=1, keepdims=True) - 1), 0)
    np.testing.assert_allclose(t.side_area[:, ::2] + t.side_area[:, 1::2], expected, atol=1e-12)


def test_a_grid_inside_a_box_has_whole_facets_and_sides():
    t = bounded_tessellation(grid(4, 3) + 0.5, Box((4.0, 3.0)))
    check_bounded(t)
    np.testing.assert_allclose(t.area, 1, rtol=1e-12)
    assert len(t.springs) == 17
    np.testing.assert_allclose(np.sort(t.side_area.ravel())[-14:], 1, rtol=1e-12)
    assert (np.sort(t.side_area.ravel())[:-14] == 0).all()


@pytest.mark.parametrize("size", SIZES, ids=str)
def test_one_point_in_a_box_has_all_of_it(size):
    for place in (0.5, 0.1, 0.0, 1.0):
        t = bounded_tessellation(np.array([size]) * place, Box(size))
        check_bounded(t)
        assert len(t.springs) == 0


@settings(deadline=None, max_examples=25)
@given(
    count=st.integers(1, 20),
    size=st.lists(st.floats(0.3, 2), min_size=2, max_size=3).map(tuple),
    seed=st.integers(0, 2**32),
)
def test_points_anywhere_in_a_box_and_on_its_boundary_make_it_up(count, size, seed):
    rng = np.random.default_rng(seed)
    points = rng.random((count, len(size)))
    snapped = rng.random(points.shape) < 0.3
    points[snapped] = np.round(points[snapped])
    check_bounded(bounded_tessellation(np.unique(points, axis=0) * size, Box(size)))


def test_points_within_tolerance_of_a_side_are_put_on_it():
    box = Box((1.0, 1.0))
    near = np.array([[1e-11, 0.5], [1 + 1e-11, 0.4], [0.5, 0.5]])
    t = bounded_tessellation(near, box)
    np.testing.assert_array_equal(t.points, [[0, 0.5], [1, 0.4], [0.5, 0.5]])
    check_bounded(t)


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ([[0.5, 0.5], [0.5, 1.1]], "points: 1, at (0.5, 1.1), is outside the box 1 x 1 m"),
        ([[0.5, 0.5], [0.5, 0.5]], "points: 0 and 1 are one place, (0.5, 0.5); leave one out"),
        ([[0.5, np.inf]], "points: inf at index (0, 1)"),
        ([0.5, 0.5], "points: shape (2,); give (n, 2)"),
    ],
)
@pytest.mark.parametrize("verb", [bounded_tessellation, simplices])
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
    cells, facets = simplices(points, box)
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


@pytest.mark.parametrize("counts", [(2, 2), (5, 4), (2, 2, 2), (5, 4, 3)], ids=str)
def test_simplices_of_a_grid_have_none_that_is_flat(counts):
    points = grid(*counts) * 0.1
    cells, _ = check_simplices(points, Box(tuple(points.max(axis=0))))
    content = np.linalg.det(points[cells][:, 1:] - points[cells][:, :1]) / 0.1 ** len(counts)
    assert content.min() > 0.5


def test_edges_of_simplices_inside_are_the_springs():
    box = Box((1.0, 1.0))
    points = box_points("blue_noise", box, 0.1, 0)
    cells, _ = simplices(points, box)
    edges = np.concatenate([cells[:, [0, 1]], cells[:, [1, 2]], cells[:, [2, 0]]])
    edges = set(map(tuple, np.sort(edges, axis=1).tolist()))
    springs = set(map(tuple, bounded_tessellation(points, box).springs.tolist()))
    assert springs <= edges
    inner = (np.minimum(points, 1 - points) > 0.2).all(axis=1)
    assert {e for e in edges if inner[list(e)].all()} <= springs


def test_a_missing_corner_is_refused():
    with refused("points: none in the corner (1, 1) of the box 1 x 1 m; add it"):
        simplices([[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]], Box((1.0, 1.0)))
