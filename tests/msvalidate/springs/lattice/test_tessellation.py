"""Voronoi cells of a periodic cell, springs across their facets: identities and an independent way.

That is scipy's Voronoi diagram of 5^d images.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import Voronoi

from msvalidate.problem import Box, SolverError
from msvalidate.springs.lattice import triangulation
from msvalidate.springs.lattice.point_sets import POINT_SETS, periodic_points
from msvalidate.springs.lattice.tessellation import bounded_tessellation, periodic_tessellation
from tests.table import refused, table

SIZES = [(1.0, 1.0), (3.0, 0.7), (2.0, 2.0, 2.0), (0.5, 1.3, 2.1)]
every_kind = pytest.mark.parametrize("kind", POINT_SETS)
every_size = pytest.mark.parametrize("size", SIZES, ids=str)
EXACT = {"rtol": 1e-12, "atol": 0}


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


def brute_force(points, size, flat_area):
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
def test_springs_and_areas_are_those_of_a_diagram_of_many_images(kind, size, count, flat_area):
    if max(size) > 2.5:
        size = (1.4, 0.7)
    t = periodic_tessellation(periodic_points(kind, count, size, 11), size)
    known = brute_force(t.points, size, flat_area)
    ours = {}
    for (i, j), shift, area in zip(t.springs, t.image, t.area, strict=True):
        ours[i, j, *shift] = ours[j, i, *(-shift)] = area
    assert ours.keys() == known.keys()
    for name, area in known.items():
        assert ours[name] == pytest.approx(area, rel=1e-8, abs=1e-10)


LATTICES = {
    "square": (grid(4, 3), (4.0, 3.0), {4: 1.0}),
    "cubic": (grid(2, 3, 2), (2.0, 3.0, 2.0), {6: 1.0}),
    "BCC": (np.concatenate([grid(2, 2, 2), grid(2, 2, 2) + 0.5]), (2.0, 2.0, 2.0),
        {8: 3 * math.sqrt(3) / 16, 6: 1 / 8}),
    "FCC": (np.concatenate([grid(2, 2, 2) + s for s in ([0, 0, 0], [0.5, 0.5, 0], [0.5, 0, 0.5], [0,
        0.5, 0.5])]), (2.0, 2.0, 2.0), {12: math.sqrt(2) / 8}),
    "triangular": (np.concatenate([grid(3, 2), grid(3, 2) + 0.5]) * [1, math.sqrt(3)], (3.0,
        2 * math.sqrt(3)), {6: 1 / math.sqrt(3)}),
}  # fmt: skip
"""Points, cell, and the number of facets of each area at a point."""


@pytest.mark.parametrize("size", [(1.0, 1.0), (2.0, 0.1), (1.0, 1.0, 1.0), (1.0, 0.2, 3.0)])
def test_one_point_has_springs_to_its_own_images(size):
    t = periodic_tessellation(np.full((1, len(size)), 0.3), size)
    check_periodic(t)
    np.testing.assert_array_equal(np.abs(t.image)[np.lexsort(t.image.T)], np.eye(len(size)))
    np.testing.assert_allclose(t.area * lengths(t), math.prod(size), rtol=1e-12)


@settings(deadline=None, max_examples=25)
@given(
    count=st.integers(1, 25),
    size=st.lists(st.floats(0.3, 2), min_size=2, max_size=3).map(tuple),
    seed=st.integers(0, 2**32),
    unit=st.sampled_from([1e-3, 1.0]),
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
def test_a_body_too_long_or_flat_for_its_points_is_refused(count, size, monkeypatch):
    """Before anything is triangulated: without a bound, that takes minutes to hours."""

    def triangulated(x, *_, **__):
        pytest.fail(f"{len(x)} points are triangulated")

    monkeypatch.setattr(triangulation, "triangulation", triangulated)
    points = np.random.default_rng(0).random((count, len(size))) * size
    box = Box(size)
    ratio = f"{max(size) / min(size):.3g} times as long as thick: they need "
    for verb in (periodic_tessellation, lambda p, _: bounded_tessellation(p, box)):
        with refused(f"cells of {count} points in the {box}, {ratio}"):
            verb(points, size)


@table(("points", "size", "message"), [
    ([[0.1, 0.2], [0.5, 0.5], [1.1, 0.2]], (1.0, 1.0), "points: 0 and 2 are one place"),
    ([[0.0, 0.2], [1 - 1e-12, 0.2]], (1.0, 1.0), "points: 0 and 1 are one place"),
    ([[0.1, np.nan]], (1.0, 1.0), "points: nan at index (0, 1); every value must be finite"),
    ([[0.1, 0.2, 0.3]], (1.0, 1.0), "points: shape (1, 3); give (n, 2), n at least 1"),
    (np.empty((0, 2)), (1.0, 1.0), "points: shape (0, 2); give (n, 2), n at least 1"),
    ([[0.1, 0.2]], (1.0, 0.0), "box size along y"),
    ([[0.1, 0.2]], (1.0, 1e-8),
        "cells of 1 points in the box 1 x 1e-08 m, 1e+08 times as long as thick: they need"),
    (["a"], (1.0, 1.0), "points: expected numbers"),
])  # fmt: skip
def test_what_cannot_be_tessellated_is_refused(points, size, message):
    with refused(message):
        periodic_tessellation(points, size)
