"""Uniform lattices: which are recognised, and the stencil against the general loop."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import Box, Isotropic, Problem, Support
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.kernels import Motion, grid, stencil
from msvalidate.springs.kernels.general import Sweep
from msvalidate.springs.lattice import WEIGHTS, fill, patterns
from msvalidate.springs.network import Network, spring_network

examples = settings(max_examples=40, deadline=None)
STEPS = 20


def lattice(shape, rng, *, ways=None, shuffled=False, stress=0.0) -> Network:
    """A lattice of these places, with random constants, row and column factors, masses, loads."""
    d = len(shape)
    number = np.arange(np.prod(shape)).reshape(shape)
    index = np.indices(shape).reshape(d, -1).T
    points = index * rng.uniform(0.5, 2, d) + rng.uniform(-3, 3, d)
    every = [way for way in product((-1, 0, 1), repeat=d) if way > (0,) * d]
    pairs, stiffness = [], []
    for way in every if ways is None else ways:
        low = tuple(slice(max(0, -s), n - max(0, s)) for s, n in zip(way, shape, strict=True))
        high = tuple(slice(max(0, s), n - max(0, -s)) for s, n in zip(way, shape, strict=True))
        room = number[low].shape
        k = np.full(room, rng.uniform(1, 3))
        for axis, count in enumerate(room):
            factor = np.ones(count)
            factor[[0, -1]] = rng.choice([0.5, 1.0, 0.0])
            k = k * factor.reshape([-1 if axis == a else 1 for a in range(d)])
        pairs.append(np.column_stack([number[low].ravel(), number[high].ravel()]))
        stiffness.append(k.ravel())
    pairs, stiffness, n = np.concatenate(pairs), np.concatenate(stiffness), len(points)
    length = np.linalg.norm(points[pairs[:, 1]] - points[pairs[:, 0]], axis=1) * (1 + stress)
    turned = rng.random(len(pairs)) < 0.5
    pairs[turned] = pairs[turned, ::-1]
    renamed = rng.permutation(n) if shuffled else np.arange(n)
    at = np.empty_like(points)
    at[renamed] = points
    order = rng.permutation(len(pairs)) if shuffled else np.arange(len(pairs))
    return spring_network(
        at,
        renamed[pairs][order],
        stiffness[order],
        rest_length=length[order],
        mass=rng.uniform(1, 2, n),
        force=rng.normal(size=(n, d)) * 0.1,
        fixed=rng.random((n, d)) < 0.1,
    )


@st.composite
def lattices(draw) -> Network:
    d = draw(st.sampled_from([2, 3]))
    most = 12 if d == 2 else 6
    shape = tuple(draw(st.lists(st.integers(1, most), min_size=d, max_size=d)))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    room = [
        way
        for way in product((-1, 0, 1), repeat=d)
        if way > (0,) * d and all(n > abs(s) for n, s in zip(shape, way, strict=True))
    ]
    if not room:
        return lattice((2,) * d, rng)
    # One spring along each axis at least: what has none does not say how far apart its places are.
    along = {way for way in room if sum(map(abs, way)) == 1}
    ways = sorted(along | draw(st.sets(st.sampled_from(room))))
    stress = draw(st.sampled_from([0.0, 0.02]))
    return lattice(shape, rng, ways=ways, shuffled=draw(st.booleans()), stress=stress)


def motion(network, seed=0):
    """Displacement, velocity, keep and push of a motion."""
    rng = np.random.default_rng(seed)
    shape = network.points.shape
    u, v = 0.02 * rng.normal(size=shape), 0.1 * rng.normal(size=shape)
    u[network.fixed] = v[network.fixed] = 0.0
    push = rng.uniform(0.01, 0.02, shape[0])
    return u, v, rng.uniform(0.9, 1, shape[0]), push


def by_springs(network, u, v, keep, push, steps=STEPS, kinetic=0.0, to_peak=False, dt=0.02):
    """The oracle: the general sweep."""
    return Sweep(network).advance(u, v, keep, push, dt, steps, kinetic, to_peak)


@examples
@given(network=lattices())
def test_the_stencil_moves_a_lattice_as_its_springs_do(network):
    found = grid.recognised(network)
    assert found is not None
    u, v, keep, push = motion(network)
    other, fast = u.copy(), v.copy()
    done, kinetic, fell = stencil.advance(found, u, v, keep, push, 0.02, STEPS, 0.0, False)
    expected = by_springs(network, other, fast, keep, push)
    # Forces are rounded to some eps of k·L, 1e-15 N, and 20 steps add up 20 of these.
    np.testing.assert_allclose(u, other, rtol=0, atol=1e-13)
    np.testing.assert_allclose(v, fast, rtol=0, atol=1e-13)
    assert (done, fell) == (STEPS, False)
    assert kinetic == pytest.approx(expected[1], rel=1e-12)


@examples
@given(network=lattices())
def test_steps_add_up_to_the_bit(network):
    found = grid.recognised(network)
    u, v, keep, push = motion(network)
    once, fast = u.copy(), v.copy()
    for steps in (0, 3, 4):
        stencil.advance(found, u, v, keep, push, 0.02, steps, 0.0, False)
    stencil.advance(found, once, fast, keep, push, 0.02, 7, 0.0, False)
    np.testing.assert_array_equal(u, once)
    np.testing.assert_array_equal(v, fast)


@examples
@given(network=lattices())
def test_a_peak_of_the_kinetic_energy_ends_the_steps(network):
    found = grid.recognised(network)
    u, v, _, push = motion(network)
    u[:], v[:], keep = 0.0, 0.0, np.ones(len(u))
    other, fast = u.copy(), v.copy()
    done, kinetic, fell = stencil.advance(found, u, v, keep, push, 0.02, 500, 0.0, True)
    expected = by_springs(network, other, fast, keep, push, 500, 0.0, True)
    assert (done, fell) == (expected[0], expected[2])
    assert kinetic == pytest.approx(expected[1], rel=1e-9)


@examples
@given(network=lattices())
def test_balance_is_the_force_that_a_step_goes_by(network):
    """As lists of springs have it, to rounding, and 0 where points are held."""
    u, *_ = motion(network)
    before = u.copy()
    known, found = (Motion(network, path=path).balance(u) for path in ("general", "lattice"))
    np.testing.assert_allclose(found, known, rtol=0, atol=1e-13)
    assert not found[network.fixed].any()
    np.testing.assert_array_equal(u, before)


def test_points_pushed_into_one_place_are_noticed():
    network = lattice((3, 4), np.random.default_rng(2), ways=[(0, 1), (1, 0)])
    whole, ones = np.indices((3, 4)).reshape(2, -1).T, np.ones(len(network.springs))
    network = replace(network, points=whole, stiffness=ones, rest_length=ones)
    u, v, keep, push = motion(network)
    u[:] = 0.0
    u[1] = 0.0, -1.0
    stencil.advance(grid.recognised(network), u, v, keep, 0 * push + 1, 0.02, 1, 0.0, False)
    assert np.isnan(u).any()


def spoilt(network, name):
    rng = np.random.default_rng(4)
    k, rest, points = (x.copy() for x in (network.stiffness, network.rest_length, network.points))
    some = len(k) // 2
    if name == "stiffer":
        k[some] *= 1 + 1e-12
    elif name == "longer":
        rest[some] += 1e-9
    elif name == "moved":
        points[len(points) // 2] += 1e-9 * rng.normal(size=network.dim)
    elif name == "missing":
        keep = np.arange(len(k)) != some
        return replace(
            network, springs=network.springs[keep], stiffness=k[keep], rest_length=rest[keep]
        )
    elif name == "doubled":
        twice = np.append(np.arange(len(k)), some)
        return replace(
            network, springs=network.springs[twice], stiffness=k[twice], rest_length=rest[twice]
        )
    elif name == "far":
        springs_there = network.springs.copy()
        springs_there[some] = 0, len(points) - 1
        return replace(network, springs=springs_there)
    return replace(network, points=points, stiffness=k, rest_length=rest)


@pytest.mark.parametrize("shape", [(6, 7), (4, 5, 6)])
@pytest.mark.parametrize("name", ["stiffer", "longer", "moved", "missing", "doubled", "far"])
def test_what_is_almost_a_lattice_is_none(shape, name):
    network = lattice(shape, np.random.default_rng(3))
    network = replace(network, stiffness=np.ones(len(network.springs)))
    assert grid.recognised(network) is not None
    assert grid.recognised(spoilt(network, name)) is None


def test_a_point_too_many_is_no_lattice():
    network = lattice((3, 4), np.random.default_rng(3))
    more = spring_network(
        np.vstack([network.points, network.points[:1] + 0.1]), network.springs, network.stiffness
    )
    assert grid.recognised(more) is None


@pytest.mark.parametrize("weights", WEIGHTS)
@pytest.mark.parametrize(
    ("pattern", "cells"),
    [
        (patterns.square, (7, 5)),
        (patterns.square4, (7, 5)),
        (patterns.cubic18, (3, 4, 5)),
        (patterns.cubic26, (3, 4, 5)),
    ],
)
def test_filled_boxes_are_lattices_in_the_order_of_their_points(pattern, cells, weights):
    network = filled(pattern, cells, weights)
    found = grid.recognised(network)
    assert found is not None
    assert found.shape == tuple(n + 1 for n in reversed(cells))
    assert not found.order.size
    u, v, keep, push = motion(network)
    other, fast = u.copy(), v.copy()
    stencil.advance(found, u, v, keep, push, 0.01, STEPS, 0.0, False)
    by_springs(network, other, fast, keep, push, dt=0.01)
    np.testing.assert_allclose(u, other, rtol=0, atol=1e-13)


@pytest.mark.parametrize("pattern", [patterns.bcc, patterns.fcc])
def test_boxes_of_other_lattices_are_none(pattern):
    assert grid.recognised(filled(pattern, (3, 4, 5), "shared")) is None


def filled(pattern, cells, weights):
    box = Box(tuple(0.3 * n for n in cells))
    made = fill(pattern(), box, cells)
    material = Isotropic(E=3.0, nu=0.25, state="plane_stress" if len(cells) == 2 else "solid")
    problem = Problem(box, material, (Support(box.side("left"), (0.0,) * len(cells)),))
    return lattice_network(problem, made, (1.0,) * made.kinds, weights=weights)
