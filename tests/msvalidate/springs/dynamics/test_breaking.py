"""Springs that break in motion: compiled, plain, and where the energy goes."""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.problem import Box, Obstacle, ProblemError
from msvalidate.problem.records import replace
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrate import State, euler_cromer, motion
from msvalidate.springs.dynamics.integrators import VELOCITY_VERLET
from msvalidate.springs.dynamics.ledger import Ledger
from msvalidate.springs.lattice import fill, patterns
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.network.ground import Ground
from msvalidate.springs.network.laws.green import GREEN


def body(dim=2, rest=1.0, seed=0):
    """A lattice held on one side, its springs uneven, that flies from it at random."""
    pattern = patterns.square() if dim == 2 else patterns.cubic18()
    cells = (9, 8) if dim == 2 else (5, 4, 4)
    lattice = fill(pattern, Box(tuple(0.1 * n for n in cells)), cells)
    rng = np.random.default_rng(seed)
    held = np.repeat((lattice.points[:, 0] == 0)[:, None], dim, axis=1)
    network = spring_network(
        lattice.points, lattice.springs, rng.uniform(1, 2, len(lattice.springs)), fixed=held,
        mass=rng.uniform(1, 2, len(lattice.points)),
    )  # fmt: skip
    network = replace(network, rest_length=rest * network.rest_length)
    return network, State(network.points, rng.normal(0, 0.03, network.points.shape))


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("rest", [1.0, 0.99])
@pytest.mark.parametrize("path", ["auto", "plain"])
def test_compiled_breaks_what_plain_steps_break(dim, rest, path):
    network, start = body(dim, rest)
    pulled = replace(network, force=np.where(network.fixed, 0.0, 1e-3))
    plain, fast, parts = (Breakage(network, 0.1) for _ in range(3))
    known = euler_cromer(pulled, start, 0.05, 120, 0.1, path="plain", breakage=plain)
    now = other = start
    for _ in range(4):
        now = euler_cromer(pulled, now, 0.05, 30, 0.1, breakage=fast, path=path)
        other = euler_cromer(pulled, other, 0.05, 30, 0.1, breakage=parts, path="plain")
    assert other.position == pytest.approx(known.position, abs=1e-12)
    assert 10 < plain.broken.sum() < len(network.springs)
    assert np.array_equal(plain.broken, fast.broken)
    assert fast.released == pytest.approx(plain.released, rel=1e-12)
    assert now.position == pytest.approx(known.position, abs=1e-12)


def test_where_nothing_breaks_motion_is_the_same():
    network, start = body()
    never = Breakage(network, 1e3)
    a = euler_cromer(network, start, 0.05, 50, path="general")
    b = euler_cromer(network, start, 0.05, 50, breakage=never)
    assert b.position == pytest.approx(a.position, abs=1e-14)
    assert never.released == never.broken.sum() == 0


def test_a_look_at_forces_breaks_nothing():
    network, _ = body()
    broken = Breakage(network, 1e-3)
    moving = kernels.Motion(network, breakage=broken)
    u = np.random.default_rng(0).normal(0, 0.01, network.points.shape)
    out, plain = np.empty_like(u), np.empty_like(u)
    assert moving.path == "general"
    assert moving.force_and_energy(u, out) == kernels.Motion(network).force_and_energy(u, plain)
    assert np.array_equal(out, plain)
    assert not broken.broken.any()


def test_a_body_at_rest_beyond_its_critical_stretch_breaks_at_once():
    rod = spring_network(
        [[0, 0], [1, 0], [2, 0.0]], [[0, 1], [1, 2]], [1.0, 2.0], fixed=[[1, 1], [0, 1], [1, 1]],
        displacement=[[0, 0], [0, 0], [0.3, 0.0]],
    )  # fmt: skip
    start = State(rod.points + np.array([[0, 0], [0.2, 0], [0.3, 0]]), np.zeros((3, 2)))
    for path in ("auto", "plain"):
        broken = Breakage(rod, 0.15)
        euler_cromer(rod, start, 0.01, 1, path=path, breakage=broken)
        assert list(broken.broken) == [True, False]
        assert broken.released == pytest.approx(0.5 * 0.2**2, rel=1e-12)


@pytest.mark.parametrize("rate", [0.05, 1.0])
def test_the_ledger_closes_with_the_square_of_the_step(rate):
    network, start = body()
    network = replace(network, force=np.where(network.fixed, 0.0, [1e-3, 0.0]))
    books = []
    for k in range(4):
        dt, broken = 0.08 / 2**k, Breakage(network, 0.1)
        books.append(Ledger(network, broken, start, dt, rate))
        motion(
            network, start, VELOCITY_VERLET, dt, 75 * 2**k, rate, watch=books[-1], breakage=broken
        )
    closure = np.array([one.closure for one in books])
    assert closure[-2] / closure[-1] > 3
    order = np.polyfit(np.log(0.08 / 2.0 ** np.arange(4)), np.log(closure), 1)[0]
    assert 1.7 < order < 2.4
    assert closure[-1] < 1e-3
    book = books[-1].table()
    assert {"kinetic", "stored", "viscous", "released", "external"} < set(book)
    assert (np.diff(book["released"]) >= 0).all()
    assert broken.released == book["released"].iloc[-1] > 0


def test_ground_springs_and_breaks_together():
    network, start = body()
    floor = Obstacle("half_space", (0.0, 0.0), (0.0, 1.0))
    on = np.flatnonzero(network.points[:, 1] == 0)
    each = []
    for path in ("auto", "plain"):
        broken = Breakage(network, 0.1)
        ground = Ground(network, on, floor)
        end = euler_cromer(network, start, 0.05, 60, path=path, breakage=broken, ground=ground)
        each.append((end.position, broken.broken))
    assert np.array_equal(each[0][1], each[1][1])
    assert each[0][0] == pytest.approx(each[1][0], abs=1e-12)


def test_one_clear_line():
    network, _ = body()
    tight = replace(network, rest_length=0.9 * network.rest_length)
    for words, call in (
        ("critical stretch: 0", lambda: Breakage(network, 0.0)),
        ("critical stretch", lambda: Breakage(network, np.nan)),
        ("stretch of a spring at rest: 0.111", lambda: Breakage(tight, 0.1)),
        ("of the green law; take Hooke's", lambda: Breakage(replace(network, law=GREEN), 0.1)),
        ("breaking springs: on path lattice", lambda: kernels.Motion(
            network, path="lattice", breakage=Breakage(network, 0.1))),
        ("breaking springs: on path lattice or in threads", lambda: kernels.Motion(
            network, threads=2, breakage=Breakage(network, 0.1))),
    ):  # fmt: skip
        with pytest.raises(ProblemError, match=re.escape(words)):
            call()
