"""The general sweep: any network, numbering, path and number of threads against the plain form."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import ProblemError, SolverError
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrate import State, euler_cromer
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.kernels import general
from msvalidate.springs.kernels.general import Sweep, Threads
from msvalidate.springs.network import (
    Network,
    configuration_at,
    energy,
    internal_force,
    spring_network,
)
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.network.residual import force_scale
from tests.table import table

examples = settings(max_examples=25, deadline=None)
EVERY_WAY = [("general", 1), ("general", 2), ("general", 3), ("lattice", 1)]
"""Path and threads."""
SIDES = {2: (23, 19), 3: (8, 7, 6)}
"""Points along each axis, of some blocks."""
AROUND = [(0, 0), (1, 0), (1, 1), (0, 1)]
SHAPES = {
    (2, "none"): [],
    (2, "triangles"): [[0, 1, 3]],
    (2, "quadrilaterals"): [[0, 1, 2, 3]],
    (3, "none"): [],
    (3, "tetrahedra"): [[0, 1, 3, 4]],
    (3, "hexahedra"): [[0, 1, 2, 3, 4, 5, 6, 7]],
}
"""Axes and cells -> which corners of the box, in VTK order, each of them takes."""


def grid(
    dim, *, cells="none", shuffled=False, jitter=0.1, seed=0, sides=None, far=False
) -> Network:
    """A grid of points with springs to all neighbours, with all that a network can have."""
    rng, sides = np.random.default_rng(seed), sides or SIDES[dim]
    number = np.arange(np.prod(sides)).reshape(sides)
    places = np.stack(np.indices(sides), axis=-1).reshape(-1, dim).astype(float)
    points = places + rng.uniform(-jitter, jitter, places.shape)
    near = np.abs(places[:, None] - places[None]).max(axis=-1) == 1
    springs = np.argwhere(np.triu(near))
    if far:  # from the first point to the last
        springs = np.vstack([springs, [[0, len(points) - 1]]])
    around = AROUND if dim == 2 else [(*corner, z) for z in (0, 1) for corner in AROUND]
    boxes = np.column_stack(
        [
            number[tuple(slice(s, n - 1 + s) for s, n in zip(c, sides, strict=True))].ravel()
            for c in around
        ]
    )
    lists = boxes[:, SHAPES[dim, cells]].reshape(-1, max(map(len, SHAPES[dim, cells]), default=1))
    renamed = rng.permutation(len(points)) if shuffled else np.arange(len(points))
    there = np.empty_like(points)
    there[renamed] = points
    length = np.linalg.norm(points[springs[:, 1]] - points[springs[:, 0]], axis=1)
    volumes = Volumes(there, renamed[lists], rng.uniform(0, 2, len(lists))) if lists.size else None
    stiffness = rng.uniform(0.5, 2, len(springs)) if jitter else np.ones(len(springs))
    return spring_network(
        there,
        renamed[springs],
        stiffness,
        rest_length=length * (rng.uniform(0.95, 1.05, len(springs)) if jitter else 1.0),
        mass=rng.uniform(1, 2, len(points)),
        force=0.01 * rng.normal(size=points.shape),
        fixed=rng.random(points.shape) < 0.05,
        volumes=volumes,
    )


def start(network, seed=1):
    """Displacement, velocity, keep and push; what is held is at rest."""
    rng = np.random.default_rng(seed)
    u, v = 0.05 * rng.normal(size=(2, *network.points.shape))
    u[network.fixed] = v[network.fixed] = 0.0
    return u, v, rng.uniform(0.98, 1, len(u)), rng.uniform(0.01, 0.02, len(u))


def moved(motion, network, steps, **how):
    """Displacement and velocity after steps."""
    u, v, keep, push = start(network)
    motion.advance(u, v, keep, push, 0.02, steps, **how)
    return u, v


# Against the plain form -----------------------------------------------------------------------


@pytest.mark.parametrize("shuffled", [False, True])
@pytest.mark.parametrize(("dim", "cells"), SHAPES)
def test_forces_and_steps_are_those_of_the_plain_form(dim, cells, shuffled):
    network = grid(dim, cells=cells, shuffled=shuffled)
    assert bool(len(network.layout.order)) == shuffled, "numbers of neighbours are kept, or mended"
    u, v, *_ = start(network)
    position, force = network.points + u, np.full(u.shape, np.nan)
    stored = kernels.Motion(network).force_and_energy(u, force)
    # Only the order of summation differs, a hundred terms at most.
    scale = force_scale(configuration_at(network, position))
    np.testing.assert_allclose(force, internal_force(network, position), atol=1e-13 * scale)
    assert stored == pytest.approx(energy(network, position), rel=1e-13)
    damping = np.random.default_rng(2).uniform(0, 1, len(u))
    state = State(position, v)
    plain = euler_cromer(network, state, 0.02, 20, damping, path="plain")
    for threads in (1, 2):
        way = {"path": "general", "threads": threads}
        compiled = euler_cromer(network, state, 0.02, 20, damping, **way)
        # Positions of 20 m are rounded to 4e-15 m, forces to as much, in each of 20 steps.
        np.testing.assert_allclose(compiled.position, plain.position, rtol=0, atol=2e-13)
        np.testing.assert_allclose(compiled.velocity, plain.velocity, rtol=0, atol=2e-13)


@pytest.mark.parametrize("dim", [2, 3])
def test_trajectories_of_all_paths_agree_after_2000_steps(dim):
    """Plain, general, lattice and threads, within 1e-12 of the largest displacement."""
    network = grid(dim, jitter=0.0, sides=(9, 8) if dim == 2 else (5, 4, 4))
    network = replace(network, fixed=network.points[:, :1].repeat(dim, axis=1) < 0.5)
    u, v, *_ = start(network)
    state = State(network.points + 0.1 * u, 0.1 * v)
    plain = euler_cromer(network, state, 0.02, 2000, 0.2, path="plain")
    largest = np.abs(plain.position - network.points).max()
    for path, threads in EVERY_WAY:
        end = euler_cromer(network, state, 0.02, 2000, 0.2, path=path, threads=threads)
        assert np.abs(end.position - plain.position).max() <= 1e-12 * largest, (path, threads)


# To the bit -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("shuffled", "far"), [(False, False), (True, True)])
@pytest.mark.parametrize(("dim", "cells"), SHAPES)
def test_threads_and_waves_change_no_bit(dim, cells, shuffled, far):
    """Whatever the number of threads, also where a spring joins the first point to the last."""
    network = grid(dim, cells=cells, shuffled=shuffled, far=far)
    one = kernels.Motion(network, path="general")
    u, v = moved(one, network, 23)
    for threads in (2, 3, 100):
        shared = kernels.Motion(network, threads=threads)
        assert shared.path == "general"
        for found, expected in zip(moved(shared, network, 23), (u, v), strict=True):
            np.testing.assert_array_equal(found, expected)
    singly, fast, keep, push = start(network)
    for _ in range(23):
        one.advance(singly, fast, keep, push, 0.02, 1)
    np.testing.assert_array_equal(singly, u)
    np.testing.assert_array_equal(fast, v)


@pytest.mark.parametrize("steps", [1, 9, 10, 11, 57])
def test_a_long_network_takes_waves_of_steps(steps):
    """Where pieces are many and short, and threads meet but once in many steps."""
    network = grid(2, sides=(400, 5))
    sweep, shared = Sweep(network), Threads(network, 2)
    assert sweep._waves(57, False)[0] == general.MOST_WAVES
    assert shared.between > 1
    u, v, keep, push = start(network)
    singly, fast = u.copy(), v.copy()
    other, quick = u.copy(), v.copy()
    sweep.advance(u, v, keep, push, 0.02, steps)
    for _ in range(steps):
        sweep.advance(singly, fast, keep, push, 0.02, 1)
    shared.advance(other, quick, keep, push, 0.02, steps)
    for found in (singly, other):
        np.testing.assert_array_equal(found, u)
    for found in (fast, quick):
        np.testing.assert_array_equal(found, v)


@examples
@given(data=st.data(), threads=st.integers(1, 5))
def test_small_networks_of_any_kind_are_shared_too(networks, data, threads):
    """Of fewer points than a block, or than threads; some points may have no spring."""
    network, position = data.draw(networks(stressed=True))
    alone = spring_network(position, network.springs[:1], 1.0)
    for net in (network, alone):
        expected = moved(kernels.Motion(net, path="general"), net, 7)
        found = moved(kernels.Motion(net, path="general", threads=threads), net, 7)
        np.testing.assert_array_equal(found, expected)


def test_threads_report_the_same_steps_and_kinetic_energy():
    network = grid(2)
    ended = []
    for threads in (1, 3):
        u, v, keep, push = start(network)
        motion = kernels.Motion(network, path="general", threads=threads)
        assert motion.advance(u, v, keep, push, 0.02, 0, kinetic=5.0) == (0, 5.0, False)
        ended.append(motion.advance(u, v, keep, push, 0.02, 9))
        # A peak is found by one thread.
        peak = motion.advance(u, v, keep, push, 0.02, 500, to_peak=True)
        assert peak[2]
        assert peak[0] < 500
    assert ended[0][::2] == ended[1][::2] == (9, False)
    assert ended[0][1] == pytest.approx(ended[1][1], rel=1e-13)


# What a motion must not change ----------------------------------------------------------------


@pytest.mark.parametrize("far", [1.0, 2.0, 1e3])
@pytest.mark.parametrize(("path", "threads"), EVERY_WAY)
@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_moved_as_a_whole_feels_no_force(dim, path, threads, far):
    """Wherever it goes: tables are filled up with springs that must not meet a point there."""
    network = grid(dim, jitter=0.0, sides=(5, 4, 6)[:dim])
    network = replace(
        network, fixed=np.zeros_like(network.fixed), force=np.zeros_like(network.force)
    )
    size = np.ptp(network.points, axis=0).max()
    motion, out = kernels.Motion(network, path=path, threads=threads), np.empty_like(network.points)
    for corner in network.points:
        u = np.tile(-size * far - corner, (len(out), 1))
        v, ones = np.zeros_like(u), np.ones(len(u))
        went = u.copy()
        assert motion.force_and_energy(u, out) < 1e-24 * far**2  # (1e-13 m · far)² · 1 N/m
        motion.advance(u, v, ones, 0.02 * ones, 0.02, 3)
        # Vectors of 1 m, whose displacements of 10 m · far are rounded to 1e-15 · far.
        np.testing.assert_allclose(out, 0.0, atol=1e-13 * far)
        np.testing.assert_allclose(u, went, rtol=0, atol=1e-13 * far)


@pytest.mark.parametrize(("path", "threads"), EVERY_WAY)
def test_arrays_of_any_order_in_memory_are_moved_in_place(path, threads):
    network = grid(2, jitter=0.0)
    motion = kernels.Motion(network, path=path, threads=threads)
    expected = moved(motion, network, 5)
    u, v, keep, push = start(network)
    v[network.fixed] = 1.0  # which must not matter
    u, v = np.asfortranarray(u), np.repeat(v, 2, axis=1)[:, ::2]
    keep, push = np.repeat(keep, 3)[::3], push.copy()
    push.setflags(write=False)
    motion.advance(u, v, keep, push, np.array(0.02), np.int32(5))
    np.testing.assert_array_equal((u, v), expected)
    out = np.full(u.shape, np.nan, order="F")
    u.setflags(write=False)
    motion.force_and_energy(u, out)
    scale = force_scale(configuration_at(network, network.points + u))
    np.testing.assert_allclose(out, internal_force(network, network.points + u), atol=1e-13 * scale)


# Refused --------------------------------------------------------------------------------------


@table(("path", "threads"), EVERY_WAY)
def test_a_motion_that_blows_up_is_refused(path, threads):
    network = grid(2, jitter=0.0)
    u, v, *_ = start(network)
    state = State(network.points + u, v)
    with pytest.raises(SolverError, match=r"^euler_cromer: the motion grew.*stability_limit, 0.8"):
        euler_cromer(network, state, 3.0, 3000, warn=False, path=path, threads=threads)


@pytest.mark.parametrize("bad", [np.nan, np.inf, 1e200])
@pytest.mark.parametrize(("path", "threads"), EVERY_WAY)
def test_what_is_no_number_stays_none(path, threads, bad):
    network = grid(2, jitter=0.0)
    network = replace(network, fixed=np.zeros_like(network.fixed))
    motion = kernels.Motion(network, path=path, threads=threads)
    u, v, keep, push = start(network)
    u[len(u) // 2, 1] = bad
    _, kinetic, _ = motion.advance(u, v, keep, push, 0.02, 40)
    assert not np.isfinite(kinetic)
    assert not (np.abs(u) < 1e100).all()  # nor where it is NaN
    out = np.empty_like(u)
    assert not np.isfinite(motion.force_and_energy(u, out))


@table("jitter", [0.0, 0.1])
@table("name", ["algorithm1", "kinetic_damping"])
def test_a_relaxation_that_runs_away_is_refused(name, jitter):
    """By the stencil and by the sweep: loads that tear the body apart."""
    network = grid(2, jitter=jitter)
    held = np.zeros_like(network.fixed)
    held[:3] = True
    # A stiffness that the frequencies given deny makes each step too long by far.
    network = replace(network, fixed=held, stiffness=1e8 * network.stiffness)
    assert kernels.Motion(network).path == ("general" if jitter else "lattice")
    with pytest.raises(SolverError, match=r"^[^\n]*(grew|diverged|beyond)[^\n]*$"):
        relax(network, RELAXATIONS[name], frequencies=(0.1, 1.0))


@table(
    ("asked", "message"),
    [
        ({"path": "fast"}, "path: "),
        ({"threads": 0}, "threads: 0; give a whole number, 1 or more"),
        ({"threads": 1.5}, "threads: "),
        ({"waves": 0}, "waves: 0; give a whole number, 1 or more"),
        ({"path": "lattice"}, "path: lattice, for a network that is no uniform lattice; take"),
    ],
)
def test_a_motion_that_cannot_be_is_refused(asked, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        kernels.Motion(grid(2, sides=(3, 4)), **asked)


def test_a_lattice_is_for_one_thread():
    network = grid(2, jitter=0.0)
    with pytest.raises(ProblemError, match=r"^path: lattice, for more than one thread; take path"):
        kernels.Motion(network, path="lattice", threads=2)
    assert kernels.Motion(network, threads=2).path == "general"


@table(("path", "threads"), EVERY_WAY)
@table(
    ("changed", "message"),
    [
        ({"displacement": np.zeros((3, 2))}, "displacement: shape (3, 2); give (437, 2)"),
        ({"velocity": np.zeros((437, 3))}, "velocity: shape (437, 3); give (437, 2)"),
        ({"velocity": np.zeros((437, 2), np.float32)}, "velocity: float32; give an array of"),
        ({"displacement": [[0.0, 0.0]] * 437}, "displacement: list; give an array of float64"),
        ({"keep": np.ones(436)}, "keep: shape (436,); give (437,)"),
        ({"push": 0.1}, "push: shape (); give (437,)"),
        ({"steps": -1}, "steps: -1; give a whole number, 0 or more"),
        ({"steps": 1.5}, "steps: 1.5; give a whole number, 0 or more"),
    ],
)
def test_arrays_that_do_not_fit_are_refused(path, threads, changed, message):
    network = grid(2, jitter=0.0)
    names = ("displacement", "velocity", "keep", "push")
    usual = dict(zip(names, start(network), strict=True)) | {"dt": 0.1, "steps": 3}
    with pytest.raises(ProblemError, match=r"^" + re.escape(message)):
        kernels.Motion(network, path=path, threads=threads).advance(**(usual | changed))


def test_what_cannot_be_written_to_is_refused():
    network = grid(2)
    u, v, keep, push = start(network)
    v.setflags(write=False)
    with pytest.raises(ProblemError, match=r"^velocity: read-only; give a copy"):
        kernels.Motion(network).advance(u, v, keep, push, 0.1, 1)
    with pytest.raises(ProblemError, match=r"^out: read-only; give a copy"):
        kernels.Motion(network).force_and_energy(u, v)
    with pytest.raises(ProblemError, match=re.escape("out: shape (3, 2); give (437, 2)")):
        kernels.Motion(network).force_and_energy(u, np.zeros((3, 2)))


def test_a_network_beyond_the_tables_is_refused(monkeypatch):
    network = grid(2)
    monkeypatch.setattr(general, "INDICES", 4 * 438)
    Sweep(network)
    monkeypatch.setattr(general, "INDICES", 4 * 438 - 1)
    with pytest.raises(ProblemError, match=r"^network: 437 points; take at most 436 in 2 dim"):
        Sweep(network)
