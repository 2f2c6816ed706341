"""Nested dissection: an order for any points, and the count of what a factor in it takes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate.lattice import fill, patterns
from msvalidate.linear_algebra.order import nested_dissection
from msvalidate.problem import Box


def joined_lattice(pattern, sides, cells):
    body = fill(pattern, Box(sides), cells)
    return body.points, body.springs


def tetrahedra(count):
    points = np.random.default_rng(3).uniform(size=(count, 3))
    corners = Delaunay(points).simplices
    pairs = np.concatenate([corners[:, [a, b]] for a in range(4) for b in range(a)])
    return points, pairs


BODIES = {
    "plate": lambda: joined_lattice(patterns.square(), (1.0, 1.0), (60, 60)),
    "cube": lambda: joined_lattice(patterns.cubic18(), (1.0, 1.0, 1.0), (12, 12, 12)),
    "bar": lambda: joined_lattice(patterns.cubic18(), (40.0, 1.0, 1.0), (120, 3, 3)),
    "random": lambda: tetrahedra(1500),
}


def test_growth_is_that_of_theory():
    """Products as n² in space: 8 times the cells of a cube, 64 times the products.

    Small cubes have less: their cuts' neighbours are few. A cube of twice the side comes between.
    """
    small, large = (
        nested_dissection(*joined_lattice(patterns.cubic18(), (1.0,) * 3, (n,) * 3))
        for n in (12, 24)
    )
    assert 5.5 < np.log2(large.products / small.products) < 6.6
    assert 3.7 < np.log2(large.entries / small.entries) < 4.4


def test_order_is_by_places_and_springs_not_by_numbers_or_units():
    """Far from the origin, in another unit, and with any point the first: as good an order."""
    points, pairs = BODIES["plate"]()
    whole = nested_dissection(points, pairs)
    turn = np.random.default_rng(0).permutation(len(points))
    place = np.empty_like(turn)
    place[turn] = np.arange(len(turn))
    for there, joined in (
        (1e-9 * points, pairs),
        (points + 1e6, pairs),
        (points[turn], place[pairs]),
    ):
        assert nested_dissection(there, joined).entries == pytest.approx(whole.entries, rel=0.05)


@pytest.mark.parametrize("count", [1, 2, 13])
def test_few_points_in_one_place_have_an_order(count):
    points = np.zeros((count, 2))
    pairs = np.array([[0, count - 1]])
    assert sorted(nested_dissection(points, pairs).order) == list(range(count))
