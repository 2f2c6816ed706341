"""Nested dissection: an order for any points, and the count of what a factor in it takes."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import csr_array, diags_array
from scipy.spatial import Delaunay

from msvalidate.linear_algebra.choice import choose
from msvalidate.linear_algebra.factor import factorise
from msvalidate.linear_algebra.order import free_unknowns, nested_dissection, pairs_in
from msvalidate.problem import Box, Isotropic
from msvalidate.springs.lattice import fill, patterns
from reference_fem import box_discretisation
from reference_fem.elasticity import stiffness
from reference_fem.systems.direct import elimination_order, factor_entries


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


def filled(body, ordering):
    """Entries of a factor of a clamped body of elements, in an order of ours or of the library."""
    held = np.repeat(body.points[:, :1] == 0, body.dim, axis=1)
    free = np.flatnonzero(~held.T.ravel())
    law = Isotropic(1.0, 0.3, "solid" if body.dim == 3 else "plane_stress")
    A = csr_array(stiffness(body, law)[free][:, free])
    order = elimination_order(body, held)
    assert sorted(order) == list(range(len(free)))
    by_layers = free_unknowns(np.lexsort(body.points.T), held, by_component=True)
    given = {"ours": order, "by layers": by_layers, "minimum degree": None}
    return factorise(A, given[ordering]).lu.nnz


@pytest.mark.parametrize(
    ("sides", "cells", "element"),
    [((1.0, 1.0), 60, "P1"), ((1.0, 1.0), 30, "Q2"), ((1.0,) * 3, 8, "T1"), ((1.0,) * 3, 5, "H2")],
)
def test_meshes_fill_in_as_little_as_by_minimum_degree(sides, cells, element):
    """Every unknown once; nodes between corners go with the piece that their corners are in."""
    body = box_discretisation(Box(sides), cells, element)
    assert filled(body, "ours") < 1.15 * filled(body, "minimum degree")
    assert filled(body, "ours") < 0.85 * filled(body, "by layers")
    assert factor_entries(body) == pytest.approx(filled(body, "ours") / 2, rel=0.35)


def test_a_count_that_is_broken_off_has_no_order():
    points, pairs = BODIES["cube"]()
    whole = nested_dissection(points, pairs)
    broken = nested_dissection(points, pairs, whole.products / 2)
    assert len(broken.order) == 0
    assert whole.products / 2 < broken.products < whole.products


def test_halves_share_no_spring_and_counts_are_of_the_factor():
    """A row of points: cut in the middle, in quarters …; each takes two numbers at the most."""
    points = np.arange(31.0)[:, None]
    pairs = np.stack([np.arange(30), np.arange(1, 31)], axis=1)
    found = nested_dissection(points, pairs)
    assert sorted(found.order) == list(range(31))
    assert found.order[-1] in (14, 15, 16)
    A = diags_array([-1.0, 2.1, -1.0], offsets=[-1, 0, 1], shape=(31, 31)).toarray()
    entries = np.count_nonzero(np.linalg.cholesky(A[found.order][:, found.order]))
    assert entries <= found.entries <= 1.6 * entries  # pieces that are cut no further are full


@pytest.mark.parametrize("way", [1, -1])
def test_a_cut_is_made_where_it_takes_fewer_points(way):
    """One point of a half, joined to all of the other: it alone is the cut, in either half."""
    pairs = [(i, i + 1) for i in range(9)] + [(9, j) for j in range(10, 20)]
    found = nested_dissection(way * np.arange(20.0)[:, None], np.array(pairs))
    assert found.order[-1] == 9


def test_unknowns_follow_their_points_by_point_or_by_component():
    held = np.array([[True, False], [False, False], [False, True]])
    order = np.array([2, 0, 1])
    assert free_unknowns(order, held).tolist() == [3, 0, 1, 2]
    assert free_unknowns(order, held, by_component=True).tolist() == [1, 2, 0, 3]


def test_pairs_in_cells_are_all_of_them():
    assert pairs_in(np.array([[0, 1, 2]])).tolist() == [[0, 1], [0, 2], [1, 2]]
    assert pairs_in(np.zeros((0, 4), dtype=int)).shape == (0, 2)


@pytest.mark.parametrize(("cells", "name"), [(10, "direct"), (14, "multigrid")])
def test_small_bodies_have_a_factor_large_ones_multigrid(cells, name):
    points, pairs = joined_lattice(patterns.cubic18(), (1.0,) * 3, (cells,) * 3)
    chosen, found = choose(points, pairs, 3, 9 * (len(points) + 2 * len(pairs)))
    assert chosen.name == name
    assert bool(len(found.order)) is (name == "direct")


def test_a_factor_that_takes_too_much_memory_is_not_chosen(monkeypatch):
    monkeypatch.setattr("msvalidate.linear_algebra.choice.MOST_ENTRIES", 1e3)
    points, pairs = joined_lattice(patterns.cubic18(), (1.0,) * 3, (5, 5, 5))
    assert choose(points, pairs, 3, 9 * (len(points) + 2 * len(pairs)))[0].name == "multigrid"
