"""`statics.breaking`: which springs break, when, and what is released, against dense algebra."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.spatial import Delaunay

from msvalidate.linear_algebra import choice
from msvalidate.problem import Box, ProblemError
from msvalidate.problem.records import replace
from msvalidate.springs.lattice import boundary_weights, fill, patterns
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.laws.green import GREEN
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.statics import breaking
from msvalidate.springs.statics.breaking import propagate_crack


def random_body(dim=2, size=0.37, loaded=False, seed=0):
    """Springs on the edges of random triangles or tetrahedra, clamped below, pulled above."""
    rng = np.random.default_rng(seed)
    n = 5 if dim == 2 else 4
    grid = np.stack(np.meshgrid(*[np.arange(n + 1.0)] * dim, indexing="ij"), axis=-1)
    x = grid.reshape(-1, dim)
    inside = ((x > 0) & (x < n)).all(axis=1)
    x = x + inside[:, None] * rng.uniform(-0.3, 0.3, x.shape)
    cells = Delaunay(x + rng.uniform(-1e-3, 1e-3, x.shape)).simplices
    pairs = np.unique(
        np.sort([[a, b] for c in cells for k, a in enumerate(c) for b in c[k + 1 :]]), axis=0
    )
    x = x * size / n
    low, high = x[:, -1] <= 1e-9, x[:, -1] >= size - 1e-9
    held = np.repeat((low if loaded else low | high)[:, None], dim, axis=1)
    moved, force = np.zeros(x.shape), np.zeros(x.shape)
    if loaded:
        force[high, -1] = rng.uniform(1, 2, int(high.sum()))
    else:
        moved[high] = size * np.eye(dim)[-1] + 0.2 * size * np.eye(dim)[0]
    k = rng.uniform(0.5, 2, len(pairs))
    return spring_network(x, pairs, k, fixed=held, displacement=moved, force=force)


def densely(network, stretch, events):
    """The same by pseudo-inverses: loads, springs, stored energy and work of each event."""
    b = network.vector / network.distance[:, None]
    m, (n, d) = len(b), network.points.shape
    B = np.zeros((m, n, d))
    B[np.arange(m), network.springs[:, 1]] += b
    B[np.arange(m), network.springs[:, 0]] -= b
    B, free = B.reshape(m, -1), ~network.fixed.ravel()
    k, load, found = network.stiffness.copy(), 0.0, []

    def whole():
        K = B.T @ (k[:, None] * B)
        u = network.displacement.ravel().copy()
        right = network.force.ravel() - K @ u
        u[free] = np.linalg.pinv(K[np.ix_(free, free)], rcond=1e-10) @ right[free]
        return u, B @ u

    def potential(load):
        u, e = whole()
        return load**2 * (k @ e**2 / 2 - network.force.ravel() @ u)

    for _ in range(events):
        e = whole()[1]
        part = np.where(k > 0, e / network.distance / stretch, 0)
        springs = np.flatnonzero(part >= part.max() * (1 - 1e-9))
        load = max(load, 1 / part.max())
        before, own = potential(load), load**2 * k[springs] @ e[springs] ** 2 / 2
        k[springs] = 0
        found.append((load, set(springs), own, before - potential(load)))
    return found


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("loaded", [False, True])
def test_events_are_those_of_dense_algebra(dim, loaded, monkeypatch):
    monkeypatch.setattr(breaking, "BREAKS_A_FACTOR", 4)
    network = random_body(dim, loaded=loaded, seed=dim - 2)
    known = densely(network, 0.01, 12)
    found = propagate_crack(network, 0.01, 1e3, most_breaks=12)
    many = min(len(known), len(found.breaks))
    assert many >= (3 if loaded else 12)
    for one, (load, springs, own, released) in zip(found.breaks, known, strict=False):
        assert set(one.springs) == springs
        assert [one.load, one.stored_energy] == pytest.approx([load, own], rel=1e-9)
        assert one.released == pytest.approx(released, rel=1e-6)  # a difference there
    assert found.closure < 1e-10


def test_a_strain_of_1e_9_breaks_as_one_of_a_hundredth_does():
    network = random_body()
    large, small = (
        propagate_crack(network, 0.01, most_breaks=8),
        propagate_crack(network, 1e-9, most_breaks=8),
    )
    assert np.array_equal(large.broken, small.broken)
    assert small.load / large.load == pytest.approx(1e-7, rel=1e-12)
    assert small.released / large.released == pytest.approx(1e-14, rel=1e-9)
    assert small.closure < 1e-10


def strip(crack=5, nx=12, ny=7):
    """Square-8 between clamps, and the springs across its middle up to a place."""
    lattice = fill(patterns.square(), Box((float(nx), float(ny))), (nx, ny))
    x, ends = lattice.points, lattice.points[lattice.springs]
    k = np.array([2.0, 1.0])[lattice.kind] * boundary_weights(lattice, "shared")
    held = np.repeat(np.isin(x[:, 1], [0, ny])[:, None], 2, axis=1)
    moved = np.where(held, (x - [0, ny / 2]) * [0, 1], 0.0)
    network = spring_network(x, lattice.springs, k, fixed=held, displacement=moved)
    over = np.prod(ends[:, :, 1] - ny / 2, axis=1) < 0
    return network, np.flatnonzero(over & (ends[:, :, 0].max(axis=1) <= crack))


@pytest.mark.parametrize("solver", ["direct", "multigrid"])
def test_neither_numbering_nor_solver_nor_side_matter(solver, monkeypatch):
    network, crack = strip()
    rng = np.random.default_rng(1)
    p, s = rng.permutation(len(network.points)), rng.permutation(len(network.springs))
    other = spring_network(
        network.points[p] * [-1, 1], np.argsort(p)[network.springs][s], network.stiffness[s],
        fixed=network.fixed[p], displacement=network.displacement[p],
    )  # fmt: skip
    found = propagate_crack(network, 0.01, crack=crack)
    if solver == "multigrid":
        monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    same = propagate_crack(other, 0.01, crack=np.argsort(s)[crack])
    assert same.equilibrium.solver.name == solver
    assert [set(one.springs) for one in found.breaks] == [
        set(s[one.springs]) for one in same.breaks
    ]
    assert len(found.breaks) == 22
    assert found.released == pytest.approx(same.released, rel=1e-9)
    assert set(found.loose) == set(p[same.loose])
    assert same.closure < 1e-10


def test_own_energy_is_a_part_of_what_a_spring_releases():
    """A rod of two springs between walls: k e²/2 / (1 - k/(k + k'))."""
    rod = spring_network(
        [[0, 0], [1, 0], [2, 0.0]], [[0, 1], [1, 2]], [1.0, 2.0], fixed=[[1, 1], [0, 1], [1, 1]],
        displacement=[[0, 0], [0, 0], [1, 0.0]],
    )  # fmt: skip
    found = propagate_crack(rod, 0.1, 10.0)
    assert found.breaks[0].load == pytest.approx(0.15, rel=1e-14)
    assert found.stored_energy == pytest.approx(0.005, rel=1e-14)
    assert found.released == pytest.approx(0.005 / (1 - 1 / 3), rel=1e-14)
    assert found.ended == "parted"
    assert found.equilibrium.reaction == pytest.approx(0, abs=1e-15)


def test_a_load_that_would_fall_ends_it():
    rope = spring_network(
        [[0, 0], [1, 0.0]], [[0, 1]], 1.0, fixed=[[1, 1], [0, 1]], force=[[0, 0], [1, 0.0]]
    )
    found = propagate_crack(rope, 0.1, 10.0)
    assert (found.ended, found.breaks, found.load) == ("falls", (), pytest.approx(0.1))
    assert found.stored == pytest.approx(found.work) == pytest.approx(0.005)


def test_what_a_crack_leaves_without_a_hold_is_loose():
    network, _ = strip()
    alone = int(np.flatnonzero((network.points == [6, 3]).all(axis=1))[0])
    crack = np.flatnonzero((network.springs == alone).any(axis=1))
    found = propagate_crack(network, 0.01, crack=crack, most_breaks=1)
    assert list(found.loose) == [alone]
    assert found.closure < 1e-10
    fewer, kept = crack[1:], crack[:1]  # one spring does not hold it along every axis
    hinged = propagate_crack(network, 0.01, crack=fewer, most_breaks=1)
    assert list(hinged.loose) == [alone]
    assert hinged.breaks[0].load == pytest.approx(found.breaks[0].load, rel=1e-12)
    assert hinged.network.stiffness[kept] > 0


def test_a_soft_spring_holds_and_a_force_on_what_is_loose_falls():
    """A spring in parallel with one of a thousand millionth; a millionth of the load, cut off."""
    x = [[0, 0], [1, 0], [2, 0], [1, 1.0]]
    held = [[1, 1], [0, 0], [1, 1], [1, 1]]
    for soft in (1e-3, 1e-6, 1e-9):
        beside = spring_network(
            x, [[0, 1], [1, 2], [1, 3]], [1.0, soft, 1.0], fixed=held,
            force=[[0, 0], [1e-3, 0], [0, 0], [0, 0.0]],
        )  # fmt: skip
        found = propagate_crack(beside, [1e-4, np.inf, np.inf])
        assert found.ended == "raised"
        assert found.released == pytest.approx(0.5e-8 * (1 + 1 / soft), rel=1e-6)
    network, _ = strip()
    alone = int(np.flatnonzero((network.points == [6, 3]).all(axis=1))[0])
    crack = np.flatnonzero((network.springs == alone).any(axis=1))
    force = np.zeros(network.points.shape)
    force[alone, 1] = 1e-6
    with pytest.raises(ProblemError, match="nothing holds what it leaves of a loaded part"):
        propagate_crack(replace(network, force=force), 0.01, crack=crack)


def test_a_loose_piece_stays_where_it_was():
    rope = spring_network(
        [[0, 0], [1, 0], [2, 0], [3, 0.0]], [[0, 1], [1, 2], [2, 3]], [1.0, 1.0, 2.0],
        fixed=[[1, 1], [0, 1], [0, 1], [1, 1]], displacement=[[0, 0], [0, 0], [0, 0], [1, 0.0]],
    )  # fmt: skip
    found = propagate_crack(rope, [0.1, 0.1, np.inf], 10.0)
    assert [list(one.springs) for one in found.breaks] == [[0, 1]]
    assert list(found.loose) == [1]
    assert found.equilibrium.displacement[1, 0] == pytest.approx(0.1, rel=1e-12)
    # All else is held: nothing to invert.
    whole = replace(rope, fixed=np.ones((4, 2)))
    assert list(propagate_crack(whole, 0.1, 10.0).broken) == [2]


def test_units_and_a_body_far_from_the_origin():
    network, crack = strip()
    mm = replace(
        network, points=1e3 * network.points + 1e4, rest_length=1e3 * network.rest_length,
        displacement=1e3 * network.displacement, stiffness=1e-3 * network.stiffness,
    )  # fmt: skip
    a, b = (propagate_crack(each, 0.01, crack=crack) for each in (network, mm))
    assert np.array_equal(a.broken, b.broken)
    assert b.released / a.released == pytest.approx(1e3, rel=1e-9)


def test_one_clear_line():
    network, _ = strip()
    tight = spring_network(network.points, network.springs, network.stiffness, rest_length=0.9,
                           fixed=network.fixed, displacement=network.displacement)  # fmt: skip
    cells = Volumes(np.array([[0, 0], [1, 0], [0, 1.0]]), np.array([[0, 1, 2]]), np.ones(1))
    three = spring_network(
        cells.points, [[0, 1], [1, 2], [0, 2]], 1.0, volumes=cells, fixed=np.ones((3, 2))
    )
    none = replace(network, displacement=0 * network.points)
    for words, given, how in (
        ("critical stretch: 0 at index 0 is none; give an", network, {"critical_stretch": 0}),
        ("critical stretch: -1 at index 0", network, {"critical_stretch": -1.0}),
        ("critical stretch: nan at index 0", network, {"critical_stretch": np.nan}),
        ("critical stretch: shape (2,); give one number or", network, {"critical_stretch": [1, 2]}),
        ("stretch of a spring at rest: 0.111111 at index 0", tight, {"critical_stretch": 0.1}),
        ("springs that are stretched or pressed at rest", tight, {"critical_stretch": 1.0}),
        ("linear law and cells; take Hooke's", three, {"critical_stretch": 1.0}),
        ("of the green law", replace(network, law=GREEN), {"critical_stretch": 1.0}),
        ("nothing is raised", none, {}),
        ("raised: 0", network, {"raised": 0.0}),
        ("crack: springs 1000000 to 1000000; there are", network, {"crack": [10**6]}),
        ("crack: ", network, {"crack": [1.5]}),
        ("crack: ", network, {"crack": np.ones(len(network.springs), dtype=bool)}),
        ("leave the body free", replace(none, fixed=np.zeros_like(network.fixed)), {}),
    ):  # fmt: skip
        with pytest.raises(ProblemError, match=re.escape(words)):
            propagate_crack(given, **{"critical_stretch": 0.01, **how})
    half = network.points[:, 1] < 4
    cut = np.flatnonzero(half[network.springs[:, 0]] != half[network.springs[:, 1]])
    force = np.where(half[:, None], 0.0, [0.0, 1.0])
    free = replace(none, fixed=network.fixed & half[:, None], force=force)
    with pytest.raises(ProblemError, match="nothing holds what it leaves of a loaded part"):
        propagate_crack(free, 0.01, crack=cut)
