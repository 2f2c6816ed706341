"""Ties: what is alike but for rounding is alike, however points are numbered and rounded.

Each body is made again with its points, cells or springs in another order and with coordinates off
by a few roundings, which is all that one processor's results differ from another's by.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from msvalidate.bodies.cut_network import cut_network
from msvalidate.bodies.fit import fitted_constants
from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.routes import isotropic_constants
from msvalidate.constants.waves import highest_frequency
from msvalidate.kernels.grid import recognised
from msvalidate.lattice import cut_lattice, fill, fill_rotated, patterns
from msvalidate.lattice.pattern import pattern_by_shells, repeat_cell
from msvalidate.lattice.point_sets import POINT_SETS, box_points, periodic_points
from msvalidate.lattice.tessellation import (
    bounded_tessellation,
    delaunay_simplices,
    periodic_tessellation,
)
from msvalidate.lattice.ties import level_numbers
from msvalidate.lattice.voronoi import voronoi_box
from msvalidate.network import spring_network
from msvalidate.network.layout import cuthill_mckee
from msvalidate.problem import Box, Isotropic, Polygon, Problem, Segment, Support, Traction
from msvalidate.statics.equilibrium import equilibrium
from msvalidate.statics.stress import fitted_stress

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


@draws
@given(seed=seeds, place=st.sampled_from([(0, 0), (0.5, 0), (0.5, 0.5), (6, 3)]))
@pytest.mark.parametrize("count", [24, 60])
def test_a_fitted_stress_hangs_on_no_tie(count, seed, place):
    rng = np.random.default_rng(seed)
    h = 0.37 / 16
    grid = np.stack(np.meshgrid(np.arange(-9, 10.0), np.arange(-9, 10.0)), -1).reshape(-1, 2)
    tensor = np.array([[3.0, 1.0, 0.0], [1.0, 3.0, 0.0], [0.0, 0.0, 1.0]])

    def stress(points):
        x, y = points.T / h  # no polynomial: which points are taken tells
        move = np.stack([np.sin(0.7 * x) * np.cos(y), np.exp(0.2 * x) * np.sin(0.9 * y)], axis=1)
        return fitted_stress(points, move, h * np.array([place]), tensor, degree=2, count=count)

    usual = stress(h * grid)
    other = stress(rounded(rng, h * grid)[rng.permutation(len(grid))])
    np.testing.assert_allclose(other, usual, rtol=0, atol=1e-9 * np.abs(usual).max())


def test_a_fit_takes_all_points_as_far_as_the_last_one():
    """Of 24 asked round a point of a lattice, 25: four of them are √8 cells away."""
    grid = np.stack(np.meshgrid(np.arange(-9, 10.0), np.arange(-9, 10.0)), -1).reshape(-1, 2)
    far = (grid**2).sum(axis=1)
    assert (far <= 8).sum() == 25

    def seen(point):
        move = np.zeros((len(grid), 2))
        move[point] = (1.0, 0.5)
        found = fitted_stress(grid, move, np.zeros((1, 2)), np.eye(3), degree=2, count=24)
        return np.abs(found).max() > 1e-9

    assert [seen(point) for point in np.flatnonzero(far == 8)] == [True] * 4
    assert not any(seen(point) for point in np.flatnonzero(far == 9))


def test_fitted_constants_are_those_of_renumbered_networks():
    order = np.random.default_rng(3).permutation(28)
    lattice = fill(patterns.square(), Box((0.74, 0.37)), (6, 3))
    n = len(lattice.points)
    held = np.repeat(lattice.points[:, :1] == 0, 2, axis=1)
    force = np.where(lattice.points[:, :1] == 0.74, [0.3, 0.1], 0.0)

    def network(order, stiffness):
        springs, given = np.argsort(order)[lattice.springs], {"held": held, "force": force}
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
    np.testing.assert_array_equal(again.held, network.held)
    np.testing.assert_array_equal(again.springs, network.springs)
    np.testing.assert_allclose(again.stiffness, network.stiffness, rtol=1e-9)
    np.testing.assert_allclose(again.force, network.force, atol=1e-9 * 50)


@draws
@given(seed=seeds, part=st.sampled_from([0.0, 0.01, 0.25]))
def test_a_cell_with_just_a_sliver_inside_is_left_out_whatever_its_area_rounds_to(seed, part):
    rng = np.random.default_rng(seed)
    h = 0.37 / 5

    def cells(wide):
        box = Box((float(wide), 0.37))
        return len(cut_lattice(patterns.square(), box, h, sliver=part).cells)

    for wide in rounded(rng, [h * (5 + part)]):
        assert cells(wide) == cells(h * (5 + part)) == 25


def notched(rng=None, h=0.37 / 4):
    """A cut lattice of an L: the places in the cell beside its inner corner are in no cell."""
    corners = h * np.array([[0, 0], [4, 0], [4, 2], [2, 2], [2, 4], [0, 4.0]])
    lattice = cut_lattice(
        patterns.square(), Polygon(tuple(tuple(corner) for corner in corners.tolist())), h
    )
    if rng is None:
        return lattice
    order, cells = rng.permutation(len(lattice.points)), rng.permutation(len(lattice.cells))
    number = np.argsort(order)
    return replace(
        lattice,
        points=rounded(rng, lattice.points)[order],
        cells=number[lattice.cells[cells]],
        springs=np.sort(number[lattice.springs], axis=1),
        fraction=lattice.fraction[cells],
        corner_volume=lattice.corner_volume[cells],
    )


@draws
@given(seed=seeds)
def test_a_place_is_in_the_same_cell_however_cells_are_numbered(seed):
    """On sides, in corners and beside the body, where cells are as near as each other."""
    rng = np.random.default_rng(seed)
    h = 0.37 / 4
    steps = np.arange(-2, 19) / 4
    places = h * np.stack(np.meshgrid(steps, steps), -1).reshape(-1, 2)

    def moved(lattice):
        x, y = lattice.points.T / h  # not linear: which cell goes on beyond the body tells
        value = np.sin(1.3 * x) + x * y**2
        points, weights = lattice.weights_at(places)
        return (weights * value[points]).sum(axis=1)

    usual = moved(notched())
    np.testing.assert_allclose(moved(notched(rng)), usual, atol=1e-9 * np.abs(usual).max())


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
@pytest.mark.parametrize("dim", [2, 3])
def test_simplices_of_a_grid_are_the_same_however_it_is_numbered(dim, seed):
    """Squares and cubes may be cut in several ways, all of them Delaunay's."""
    rng = np.random.default_rng(seed)
    n = 5 if dim == 2 else 3
    grid = np.stack(np.meshgrid(*[np.linspace(0, 0.37, n)] * dim), -1).reshape(-1, dim)
    box = Box((0.37,) * dim)

    def corners(points):
        cells, facets = delaunay_simplices(points, box)
        found = [
            np.round(points / 0.37 * (n - 1))[each] @ n ** np.arange(dim)
            for each in (cells, facets)
        ]
        return [np.unique(np.sort(each, axis=1), axis=0) for each in found]

    usual = corners(grid)
    other = corners(np.clip(rounded(rng, grid), 0, 0.37)[rng.permutation(len(grid))])
    for one, two in zip(usual, other, strict=True):
        np.testing.assert_array_equal(two, one)


@draws
@given(seed=seeds)
@pytest.mark.parametrize("bounded", [False, True])
def test_cells_of_a_grid_are_the_same_however_it_is_numbered(bounded, seed):
    rng = np.random.default_rng(seed)
    grid = (np.stack(np.meshgrid(np.arange(4), np.arange(4)), -1).reshape(-1, 2) + 0.5) * 0.37 / 4

    def springs(points):
        if bounded:
            found = bounded_tessellation(points, Box((0.37, 0.37)))
            return along(found.points, found.springs, found.area)
        found = periodic_tessellation(points, (0.37, 0.37))
        return along(found.points, found.springs, np.abs(found.image).sum(axis=1), found.area)

    other = springs(rounded(rng, grid)[rng.permutation(len(grid))])
    np.testing.assert_allclose(other, springs(grid), atol=2e-7)


@pytest.mark.parametrize("kind", POINT_SETS)
def test_random_points_are_the_same_in_a_body_of_another_size(kind):
    """Distances round otherwise there, and of points that crowd each other alone one must go."""
    for seed in range(60):
        small = periodic_points(kind, 3, (0.37, 0.37), seed)
        np.testing.assert_allclose(small / 0.37, periodic_points(kind, 3, (1.0, 1.0), seed))
        filled = box_points(kind, Box((0.74, 0.37)), 0.37 / 6, seed)
        np.testing.assert_allclose(filled / 0.37, box_points(kind, Box((2.0, 1.0)), 1 / 6, seed))


def test_a_random_lattice_is_the_same_in_a_body_of_another_size():
    for seed in range(5):
        here, there = (voronoi_box(Box((2 * L, L)), L / 6, seed=seed) for L in (1.0, 0.37))
        np.testing.assert_array_equal(there.springs, here.springs)
        np.testing.assert_allclose(there.factor, here.factor, rtol=1e-8)
        np.testing.assert_allclose(there.point_volume, 0.37**2 * here.point_volume, rtol=1e-8)


@settings(max_examples=3, deadline=None)
@given(seed=seeds)
@pytest.mark.parametrize("name", LATTICES)
def test_a_solid_is_the_same_however_its_cell_is_numbered_and_rounded(name, seed):
    """Its tensor and its highest frequency, which several waves may share."""
    rng = np.random.default_rng(seed)
    pattern = LATTICES[name]()
    constants = next(iter(pattern.rules.values()))
    n, m = len(pattern.points), len(pattern.springs)
    order, turn = rng.permutation(n), rng.permutation(m)
    x = rounded(rng, pattern.points)
    other = replace(
        pattern,
        points=np.where(pattern.points == 0, 0.0, np.abs(x))[order],
        springs=np.argsort(order)[pattern.springs][turn],
        image=pattern.image[turn],
        kind=pattern.kind[turn],
        factor=pattern.factor[turn],
        volume=pattern.volume[order],
    )
    usual = homogenise(pattern, constants).tensor
    found = homogenise(other, constants).tensor
    np.testing.assert_allclose(found, usual, atol=1e-12 * np.abs(usual).max())
    if pattern.dim == 2:  # in space it takes seconds
        usual = highest_frequency(pattern, constants)
        assert highest_frequency(other, constants) == pytest.approx(usual, rel=1e-9)


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


def test_constants_that_several_rules_lead_to_are_those_of_the_first():
    """Where as many constants as there like make the solid, rounding must not choose among them."""
    pattern = patterns.honeycomb()
    material = Isotropic(E=3.0, nu=0.5)
    usual = isotropic_constants(material, pattern, 1.0)
    rules = dict(reversed([*pattern.rules.items(), ("again", next(iter(pattern.rules.values())))]))
    found = isotropic_constants(material, replace(pattern, rules=rules), 1.0)
    np.testing.assert_allclose(found, usual, rtol=1e-7)


@draws
@given(seed=seeds)
def test_facets_of_a_crowded_face_are_the_same_however_its_points_are_numbered(seed):
    """A face of 2 x 2 squares may be cut in many ways."""
    rng = np.random.default_rng(seed)
    pattern = repeat_cell(patterns.cubic18(), 2)
    order = rng.permutation(len(pattern.points))
    other = replace(
        pattern, points=pattern.points[order], springs=np.argsort(order)[pattern.springs]
    )
    box = Box((0.37, 0.37, 0.37))

    def places(lattice):
        corner = np.round(lattice.points[lattice.facets] / 0.37 * 8) @ [1, 9, 81]
        return np.unique(np.sort(corner, axis=1), axis=0)

    np.testing.assert_array_equal(places(fill(other, box, 2)), places(fill(pattern, box, 2)))


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


@draws
@given(seed=seeds)
def test_a_cube_has_the_same_rows_however_its_points_are_numbered(seed):
    rng = np.random.default_rng(seed)
    lattice = fill(patterns.cubic18(), Box((0.37, 0.37, 0.37)), 3)
    k = 2e3 * lattice.share

    def rows(points, order):
        number = np.argsort(order)
        grid = recognised(spring_network(points[order], number[lattice.springs], k))
        assert grid is not None
        return grid.shape, grid.ahead, grid.law[..., 0], np.round(grid.vector / 0.37, 9)

    n = len(lattice.points)
    usual = rows(lattice.points, rng.permutation(n))
    other = rows(lattice.points, rng.permutation(n))
    for one, two in zip(usual, other, strict=True):
        np.testing.assert_allclose(two, one)


def test_levels_of_what_is_alike():
    values = np.array([[0.3, 0.1 + 1e-12, 0.1, 0.3 - 1e-12, 0.2]])
    np.testing.assert_array_equal(level_numbers(values, 1e-9, axis=1), [[2, 0, 0, 2, 1]])
    np.testing.assert_array_equal(level_numbers(values.T, 1e-9)[:, 0], [2, 0, 0, 2, 1])
    # A border of rounding to a digit between them would part them.
    np.testing.assert_array_equal(level_numbers(np.array([0.5 + EPS, 0.5 - EPS]), 1e-9), [0, 0])
