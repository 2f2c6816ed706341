"""Irregular point sets: how many, where, how far apart, and the same again."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import KDTree

from msvalidate.lattice.point_sets import POINT_SETS, box_points, periodic_points
from msvalidate.problem import Box
from tests.table import refused, table

SIZES = [(1.0, 1.0), (3.0, 0.7), (2.0, 2.0, 2.0), (0.5, 1.3, 2.1)]
every_kind = pytest.mark.parametrize("kind", POINT_SETS)
every_size = pytest.mark.parametrize("size", SIZES, ids=str)


def nearest(points, period=None):
    """Distance of each point to the nearest other."""
    return KDTree(points, boxsize=period).query(points, k=2)[0][:, 1]


def even(size, count):
    """Edge of the cube that a point has."""
    return (math.prod(size) / count) ** (1 / len(size))


# A periodic cell ------------------------------------------------------------------------------


@every_kind
@every_size
@pytest.mark.parametrize("count", [1, 2, 3, 7, 30, 300])
def test_as_many_points_as_asked_for_inside_the_cell(kind, size, count):
    points = periodic_points(kind, count, size, 5)
    assert points.shape == (count, len(size))
    assert (points >= 0).all()
    assert (points < size).all()


@every_kind
def test_the_seed_decides(kind):
    first, again, other = (periodic_points(kind, 50, (1.0, 2.0), seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.isclose(first, other).any()


@pytest.mark.parametrize(("count", "size"), [(64, (1.0, 1.0, 1.0)), (18, (4.0, 2.0))])
def test_jittered_points_lie_one_in_each_cube_of_a_grid(count, size):
    h = even(size, count)
    for seed in range(3):
        points = periodic_points("jittered", count, size, seed)
        assert len(np.unique(np.floor(points / h), axis=0)) == count


@every_size
def test_jittered_points_fill_layers_evenly_whatever_their_number(size):
    # Layers, rows and bricks of equal volume: along x no stretch holds more than its share of
    # points, give or take those of the layers at its ends.
    for count in (7, 101, 500):
        x = np.sort(periodic_points("jittered", count, size, 1)[:, 0]) / size[0]
        layer = even(size, count) / size[0]
        assert np.abs(x - (np.arange(count) + 0.5) / count).max() < 1.5 * min(layer, 1) + 1 / count


def test_blue_noise_keeps_apart_and_uniform_points_do_not():
    for size in SIZES:
        h = even(size, 400)
        gap = {k: nearest(periodic_points(k, 400, size, 1), size).min() / h for k in POINT_SETS}
        assert gap["blue_noise"] > 0.6
        assert gap["uniform"] < 0.25


def test_blue_noise_keeps_its_distance_across_the_cell_boundary():
    # The most even pair in a square cell is half a diagonal apart; the worst of many is not bad.
    gaps = [nearest(periodic_points("blue_noise", 2, (1.0, 1.0), s), (1, 1))[0] for s in range(20)]
    assert min(gaps) > 0.4


def test_blue_noise_in_a_narrow_cell_is_even_along_it():
    points = periodic_points("blue_noise", 40, (40.0, 0.01), 2)
    assert nearest(points, (40.0, 0.01)).min() > 0.55


@table(
    ("arguments", "message"),
    [
        (("white", 3, (1.0, 1.0), 0), "point set: 'white'; choose uniform, jittered, blue_noise"),
        (("uniform", 0, (1.0, 1.0), 0), "number of points: 0; give a whole number, 1 or more"),
        (("uniform", 2.5, (1.0, 1.0), 0), "number of points: 2.5; give a whole number"),
        (("uniform", 10**8, (1.0, 1.0), 0), "uniform point set: 1e+08 points, and the most is"),
        (("uniform", 3, (1.0, -1.0), 0), "box size along y: -1.0 m; it must be above zero"),
        (("uniform", 3, (1.0,), 0), "box size: (1.0,); give a tuple of 2 or 3 lengths"),
        (("uniform", 3, (1.0, math.nan), 0), "box size along y: nan"),
        (("uniform", 3, (1.0, 1.0), -1), "seed: -1; give a whole number, 0 or more"),
    ],
)
def test_a_cell_without_points_is_refused(arguments, message):
    with refused(message):
        periodic_points(*arguments)


# A closed box ---------------------------------------------------------------------------------


@every_kind
@every_size
@pytest.mark.parametrize("spacing", [0.12, 0.173])
def test_box_points_lie_in_corners_on_sides_and_inside(kind, size, spacing):
    dim = len(size)
    points = box_points(kind, Box(size), spacing, 3)
    away = np.minimum(points, np.array(size) - points)
    assert ((away == 0) | (away >= 0.5 * spacing * (1 - 1e-12))).all()
    on = (away == 0).sum(axis=1)
    assert (on == dim).sum() == 2**dim
    # A point on a side counts half, on two a quarter, ...: one per spacing^d.
    wanted = math.prod(size) / spacing**dim
    rounded = 0.5 * (2 * dim if dim == 2 else 12 / 2 + 6)
    assert abs((0.5**on).sum() - wanted) <= max(0.5 * rounded, 2)
    assert len(np.unique(points, axis=0)) == len(points)


def test_box_points_that_divide_the_box_are_as_many_as_a_grids():
    assert len(box_points("jittered", Box((1.0, 0.5, 0.3)), 0.1, 0)) == 11 * 6 * 4


def test_a_box_thinner_than_the_spacing_has_points_in_its_corners_only_across():
    points = box_points("blue_noise", Box((1.0, 0.05)), 0.1, 0)
    assert set(points[:, 1]) == {0.0, 0.05}


def test_blue_noise_in_a_box_keeps_apart_from_the_boundary_too():
    for size in SIZES:
        assert nearest(box_points("blue_noise", Box(size), 0.13, 1)).min() > 0.4 * 0.13


@every_kind
def test_the_seed_decides_in_a_box(kind):
    box = Box((1.0, 1.0))
    first, again, other = (box_points(kind, box, 0.2, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.isclose(first[4:], other[4:]).all(axis=1).any()


@table(
    ("arguments", "message"),
    [
        (("white", Box((1.0, 1.0)), 0.1, 0), "point set: 'white'; choose"),
        (("uniform", (1.0, 1.0), 0.1, 0), "box: (1.0, 1.0); give a Box"),
        (("uniform", Box((1.0, 1.0)), 0.0, 0), "point set: spacing: 0.0 m; it must be above zero"),
        (("uniform", Box((1.0, 1.0)), math.nan, 0), "point set: spacing: nan"),
        (("uniform", Box((1.0, 1.0)), 1e-5, 0), "uniform point set: 1e+10 points"),
        (("uniform", Box((1.0, 1.0)), 0.1, 0.5), "seed: 0.5; give a whole number"),
    ],
)
def test_a_box_without_points_is_refused(arguments, message):
    with refused(message):
        box_points(*arguments)
