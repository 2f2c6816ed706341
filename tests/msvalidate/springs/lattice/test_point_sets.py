"""Irregular point sets: how many, where, how far apart, and the same again."""

from __future__ import annotations

import math

import numpy as np
import pytest

from msvalidate.problem import Box
from msvalidate.springs.lattice.point_sets import POINT_SETS, box_points, periodic_points
from tests.table import refused, table

every_kind = pytest.mark.parametrize("kind", POINT_SETS)


# A periodic cell ------------------------------------------------------------------------------


@every_kind
def test_the_seed_decides(kind):
    first, again, other = (periodic_points(kind, 50, (1.0, 2.0), seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(first, again)
    assert not np.isclose(first, other).any()


@table(
    ("arguments", "message"),
    [
        (("white", 3, (1.0, 1.0), 0), "point set: 'white'; choose uniform, jittered, blue_noise"),
        (("uniform", 0, (1.0, 1.0), 0), "number of points: 0; give a whole number, 1 or more"),
        (("uniform", 2.5, (1.0, 1.0), 0), "number of points: 2.5; give a whole number"),
        (("uniform", 10**8, (1.0, 1.0), 0), "uniform point set: 1e+08 points, and the most is"),
        (("uniform", 3, (1.0, -1.0), 0), "box size along y: -1.0 m; it must be above zero"),
        (("uniform", 3, (1.0,), 0), "box size: (1.0,); give 2 or 3 lengths"),
        (("uniform", 3, (1.0, math.nan), 0), "box size along y: nan"),
        (("uniform", 3, (1.0, 1.0), -1), "seed: -1; give a whole number, 0 or more"),
    ],
)
def test_a_cell_without_points_is_refused(arguments, message):
    with refused(message):
        periodic_points(*arguments)


# A closed box ---------------------------------------------------------------------------------


def test_a_box_thinner_than_the_spacing_has_points_in_its_corners_only_across():
    points = box_points("blue_noise", Box((1.0, 0.05)), 0.1, 0)
    assert set(points[:, 1]) == {0.0, 0.05}


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
