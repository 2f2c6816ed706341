"""The compiled loop against its plain NumPy form."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.springs import kernels
from msvalidate.springs.kernels.cells import push
from msvalidate.springs.network import (
    configuration_at,
    energy,
    internal_force,
    spring_network,
    tangent,
)
from msvalidate.springs.network.laws.volumes import Volumes, dilatation, force, force_magnitudes
from msvalidate.springs.network.laws.volumes import energy as volume_energy
from msvalidate.springs.network.residual import force_scale

examples = settings(max_examples=25, deadline=None)


AROUND = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], dtype=float)
CELLS = {
    (2, 3): AROUND[[0, 1, 3]],
    (2, 4): AROUND,
    (3, 4): np.concatenate([np.zeros((1, 3)), np.eye(3)]),
    (3, 8): np.column_stack([np.tile(AROUND, (2, 1)), np.repeat([0.0, 1.0], 4)]),
}
"""(axes, corners) -> a cell at rest, corners in VTK order."""


@examples
@given(data=st.data())
def test_force_and_energy_are_those_of_the_plain_form(networks, data):
    network, position = data.draw(networks(stressed=True))
    force = np.full(position.shape, np.nan)  # what was there before must not matter
    stored = kernels.Motion(network).force_and_energy(position - network.points, force)
    # Only the order of summation differs, a hundred terms at most.
    scale = force_scale(configuration_at(network, position))
    np.testing.assert_allclose(force, internal_force(network, position), atol=1e-13 * scale)
    assert stored == pytest.approx(energy(network, position), rel=1e-13)


@examples
@given(data=st.data())
def test_curvature_is_that_of_the_tangent(networks, data):
    network, position = data.draw(networks(stressed=True))
    way = np.random.default_rng(len(position)).normal(size=position.shape)
    found = kernels.curvature(network, position - network.points, way)
    K = tangent(network, position)
    assert found == pytest.approx(way.ravel() @ K @ way.ravel(), rel=0, abs=1e-12 * abs(K).sum())


@examples
@given(data=st.data())
def test_a_peak_of_the_kinetic_energy_ends_the_steps(networks, data):
    network, position = data.draw(networks(stressed=True))
    start, mass = position - network.points, network.mass
    keep, push = np.ones(len(mass)), np.full(len(mass), 1e-2)
    u, v, motion = start.copy(), np.zeros_like(start), kernels.Motion(network)
    done, energy_there, fell = motion.advance(u, v, keep, push, 1e-2, 5000, to_peak=True)
    singly, fast, history = start.copy(), np.zeros_like(start), [0.0]
    for _ in range(done):
        motion.advance(singly, fast, keep, push, 1e-2, 1)
        history.append(0.5 * mass @ (fast**2).sum(axis=1))
    assert energy_there == pytest.approx(history[-1], rel=1e-12)
    assert (np.diff(history)[:-1] >= 0).all()
    assert fell == (history[-1] < history[-2])
    assert fell or done == 5000
    np.testing.assert_array_equal(u, singly)


def several_cells(kind, count, seed):
    """Cells of one kind, each with points of its own, and a large displacement of them."""
    rng = np.random.default_rng(seed)
    dim, corners = kind
    points = (CELLS[kind] + rng.uniform(-0.1, 0.1, (count, corners, dim))).reshape(-1, dim)
    cells = np.arange(count * corners).reshape(count, corners)
    volumes = Volumes(points, cells, rng.uniform(-5, 5, count))
    # A displacement that shears, turns and here and there turns a cell inside out.
    return volumes, points @ rng.uniform(-1, 1, (dim, dim)) + rng.uniform(-0.5, 0.5, points.shape)


def pushed(volumes, u, begin, end):
    # Where in the arrays a corner's components begin.
    out, cells = np.zeros(u.shape), (volumes.dim * volumes.cells).astype(np.uint32)
    stored = push(
        tuple(range(volumes.dim)),
        tuple(range(cells.shape[1])),
        volumes.points,
        u,
        cells,
        volumes.stiffness,
        volumes.rest_volume,
        begin,
        end,
        out,
    )
    return out, stored


@pytest.mark.parametrize("kind", CELLS, ids=str)
@examples
@given(count=st.integers(1, 11), seed=st.integers(0, 2**32 - 1))
def test_cells_push_as_in_the_plain_form(kind, count, seed):
    """Sheared, turned inside out, with κ of both signs, in groups whole and not."""
    volumes, u = several_cells(kind, count, seed)
    found, stored = pushed(volumes, u, 0, count)
    wanted = force(volumes, u)
    # A hundred operations, each within an eps of the largest force that meets at a point, but for
    # what cancels within V - V0: a few times as much.
    scale = force_magnitudes(volumes, u).max() + np.abs(volumes.stiffness).max()
    np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-13 * scale)
    terms = np.abs(volumes.stiffness) * volumes.rest_volume * dilatation(volumes, u) ** 2
    plain = volume_energy(volumes, u)
    assert stored == pytest.approx(plain, rel=0, abs=1e-13 * (terms.sum() + scale))
    # Neither a force nor a moment of a cell on itself.
    x = volumes.points + u
    np.testing.assert_allclose(found.sum(axis=0), 0, atol=1e-13 * scale * count)
    moment = x.T @ found
    np.testing.assert_allclose(moment, moment.T, atol=1e-13 * scale * count * np.abs(x).max())


@pytest.mark.parametrize("kind", CELLS, ids=str)
def test_cells_add_to_what_is_there_whatever_their_groups(kind):
    """A cell's force does not depend on the cells beside it: to the bit, in any run of cells."""
    volumes, u = several_cells(kind, 11, 3)
    at_once, stored = pushed(volumes, u, 0, 11)
    for cut in range(12):
        first, one = pushed(volumes, u, 0, cut)
        second, other = pushed(volumes, u, cut, 11)
        np.testing.assert_array_equal(first + second, at_once)
        assert one + other == pytest.approx(stored, rel=0, abs=1e-13 * 11 * 5 * 8)


@pytest.mark.parametrize("kind", CELLS, ids=str)
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_a_number_that_is_none_comes_out_as_none(kind, bad):
    """Of the cell that has it, and of no other."""
    volumes, u = several_cells(kind, 7, 5)
    whole, _ = pushed(volumes, u, 0, 7)
    for cell in (0, 6):
        spoilt = u.copy()
        spoilt[volumes.cells[cell, -1], 0] = bad
        found, stored = pushed(volumes, spoilt, 0, 7)
        assert not np.isfinite(stored)
        assert not np.isfinite(found[volumes.cells[cell]]).all()
        others = np.delete(volumes.cells, cell, axis=0)
        np.testing.assert_array_equal(found[others], whole[others])


@pytest.mark.parametrize("cells", [False, True])
def test_a_body_far_away_moves_like_one_near(cells):
    """To the bit: displacements carry no rounding of the place, which stiff modes would gather."""
    near = np.array([[0.0, 0.0], [1.0, 0.0], [0.5, 0.75]])
    moved = []
    for place in (0.0, 1024.0):
        network = spring_network(
            near + place,
            [[0, 1], [1, 2], [2, 0]],
            1e4,
            volumes=Volumes(near + place, [[0, 1, 2]], [1e4]) if cells else None,
            force=[[0.1, -3.0]] * 3,
        )
        u, v = np.zeros((3, 2)), np.zeros((3, 2))
        kernels.Motion(network).advance(u, v, np.full(3, 0.9995), np.full(3, 1e-3), 1e-3, 1000)
        moved.append(u)
    np.testing.assert_array_equal(*moved)
