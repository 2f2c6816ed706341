"""Ties: what is alike but for rounding is alike, however points are numbered and rounded.

Each body is made again with its points, cells or springs in another order and with coordinates off
by a few roundings, which is all that one processor's results differ from another's by.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from msvalidate.problem import Box, Isotropic, Polygon, Problem, Segment, Support, Traction
from msvalidate.springs.bodies.cut_network import cut_network
from msvalidate.springs.bodies.fit import fitted_constants
from msvalidate.springs.lattice import cut_lattice, fill, fill_rotated, patterns
from msvalidate.springs.lattice.pattern import pattern_by_shells
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.layout import cuthill_mckee
from msvalidate.springs.statics.equilibrium import equilibrium

EPS = float(np.finfo(float).eps)
LATTICES = patterns.all_patterns()
draws = settings(max_examples=12, deadline=None)
seeds = st.integers(0, 2**32 - 1)
MATERIAL = Isotropic(E=2e5, nu=1 / 3, thickness=0.2)


def rounded(rng, values):
    """The values with a few roundings of the largest more or less."""
    x = np.asarray(values, dtype=float)
    return x + EPS * np.abs(x).max() * rng.integers(-2, 3, x.shape)


def along(points, springs, *values, digits=7):
    """Springs as sorted rows of both ends' places, the lower first, and values."""
    scale = np.abs(points).max()
    ends = np.round(points[springs] / scale, digits) + 0.0
    first = np.lexsort(np.moveaxis(ends, 2, 0)[::-1], axis=1)
    ends = np.take_along_axis(ends, first[:, :, None], axis=1).reshape(len(springs), -1)
    values = [np.round(np.asarray(v) / max(np.abs(v).max(), EPS), digits) + 0.0 for v in values]
    rows = np.column_stack([ends, *values])
    return rows[np.lexsort(rows.T[::-1])]


# Fits ---------------------------------------------------------------------------------------------


def test_fitted_constants_are_those_of_renumbered_networks():
    order = np.random.default_rng(3).permutation(28)
    lattice = fill(patterns.square(), Box((0.74, 0.37)), (6, 3))
    n = len(lattice.points)
    held = np.repeat(lattice.points[:, :1] == 0, 2, axis=1)
    force = np.where(lattice.points[:, :1] == 0.74, [0.3, 0.1], 0.0)

    def network(order, stiffness):
        springs, given = np.argsort(order)[lattice.springs], {"fixed": held, "force": force}
        given = {name: array[order] for name, array in given.items()}
        return spring_network(lattice.points[order], springs, stiffness * lattice.share, **given)

    # Not all alike, so that no constants fit: the nearest are known to the root of rounding.
    stiffness = np.array([3e3, 2e3])[lattice.kind] * (
        1 + 0.1 * np.sin(np.arange(len(lattice.kind)))
    )
    wanted = equilibrium(network(np.arange(n), stiffness)).displacement
    usual, found = (
        fitted_constants([network(each, np.ones(1))], [wanted[each]], lattice.kind)
        for each in (np.arange(n), order)
    )
    np.testing.assert_allclose(found.constants, usual.constants, rtol=1e-6)
    assert usual.residual > 1e-3
    assert found.residual == pytest.approx(usual.residual, rel=1e-9)


# Cuts ---------------------------------------------------------------------------------------------


def diamond(rng=None, size=0.37):
    """A square on its corner whose sides run through points of a lattice of size/8."""
    corners = size * np.array([[1.0, 0.0], [2.0, 1.0], [1.0, 2.0], [0.0, 1.0]])
    if rng is not None:
        corners = rounded(rng, corners)
    return Polygon(tuple(tuple(corner) for corner in corners.tolist()))


@draws
@given(seed=seeds)
def test_a_cut_body_is_the_same_whatever_its_outline_rounds_to(seed):
    def body(domain):
        lattice = cut_lattice(patterns.square(), domain, 0.37 / 8)
        low, left = domain.corners[0], domain.corners[-1]
        side = Segment(tuple(low.tolist()), tuple(domain.corners[1].tolist()))
        other = Segment(tuple(domain.corners[2].tolist()), tuple(left.tolist()))
        loads = (Traction(other, (20.0, 30.0)),)
        problem = Problem(domain, MATERIAL, (Support(side, (0.0, 0.0)),), loads)
        network = cut_network(problem, lattice)
        return lattice, network

    lattice, network = body(diamond())
    other, again = body(diamond(np.random.default_rng(seed)))
    assert len(other.points) == len(lattice.points)
    np.testing.assert_array_equal(again.fixed, network.fixed)
    np.testing.assert_array_equal(again.springs, network.springs)
    np.testing.assert_allclose(again.stiffness, network.stiffness, rtol=1e-9)
    np.testing.assert_allclose(again.force, network.force, atol=1e-9 * 50)


# Lattices -----------------------------------------------------------------------------------------


@draws
@given(seed=seeds, angle=st.sampled_from([0.0, np.pi / 4, np.pi / 6, np.arctan2(3, 4)]))
@pytest.mark.parametrize("name", [name for name in LATTICES if LATTICES[name]().dim == 2])
def test_a_turned_lattice_is_the_same_whatever_its_angle_rounds_to(name, seed, angle):
    rng = np.random.default_rng(seed)
    box, spacing = Box((0.37, 0.37)), 0.37 / 8

    def lattice(h, turn):
        found = fill_rotated(LATTICES[name](), box, float(h), float(turn))
        return along(found.points, found.springs, found.kind, found.factor, found.share), np.sort(
            found.point_volume
        )

    springs, volume = lattice(spacing, angle)
    other, again = lattice(rounded(rng, [spacing])[0], angle + EPS * rng.integers(-3, 4))
    np.testing.assert_allclose(other, springs, atol=2e-7)
    np.testing.assert_allclose(again, volume, rtol=0, atol=1e-9 * volume.max())


@draws
@given(seed=seeds)
def test_springs_by_shells_come_in_one_order(seed):
    rng = np.random.default_rng(seed)
    size, points = (1.0, 3**0.5), np.array([[0.1, 0.1], [0.6, 0.1 + 3**0.5 / 2]])
    arguments = ((1.0, 3**0.5), {"unit": (1.0, 1.0)})
    usual = pattern_by_shells("triangles", size, points, *arguments)
    other = pattern_by_shells("triangles", size, rounded(rng, points), *arguments)
    for name in ("springs", "image", "kind"):
        np.testing.assert_array_equal(getattr(other, name), getattr(usual, name))


# Layouts ------------------------------------------------------------------------------------------


@draws
@given(seed=seeds, n=st.integers(2, 60))
def test_the_ordering_is_the_librarys_where_that_has_no_choice(seed, n):
    rng = np.random.default_rng(seed)
    ends = rng.integers(0, n, (3 * n, 2))
    ends = ends[ends[:, 0] != ends[:, 1]]
    pairs = np.concatenate((ends, ends[:, ::-1], [[0, 1], [1, 0]])).T
    graph = coo_array((np.ones(pairs.shape[1]), pairs), shape=(n, n)).tocsr()
    found, degree = cuthill_mckee(graph), np.diff(graph.indptr)
    np.testing.assert_array_equal(np.sort(found), np.arange(n))
    pieces, piece = connected_components(graph)
    last = found[::-1]
    assert len(np.flatnonzero(np.diff(piece[last]))) == pieces - 1  # one piece after the other
    assert degree[last[0]] == degree.min()
    assert last[0] == np.flatnonzero(degree == degree.min())[0]
    if pieces == 1 and (degree == degree.min()).sum() == 1:
        np.testing.assert_array_equal(found, reverse_cuthill_mckee(graph, symmetric_mode=True))
