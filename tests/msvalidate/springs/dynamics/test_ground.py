"""Ground springs: contact and friction in motion."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import Box, Obstacle
from msvalidate.problem.records import replace
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.integrate import (
    State,
    euler_cromer,
    motion,
    recommended_time_step,
)
from msvalidate.springs.dynamics.integrators import EULER_CROMER, LEAPFROG, VELOCITY_VERLET
from msvalidate.springs.lattice import square
from msvalidate.springs.network import spring_network
from msvalidate.springs.network.ground import Ground
from tests.table import refused

FLOOR = Obstacle("half_space", (0.0, 0.0), (0.0, 1.0))


def block(drop=1e-3, friction=0.0, obstacle=FLOOR, seed=None):
    """A free square block above a floor, and its ground springs; points in another order."""
    lattice = square(Box((0.37, 0.37)), 4)
    points, springs = np.array(lattice.points), np.array(lattice.springs)
    if seed is not None:
        order = np.random.default_rng(seed).permutation(len(points))
        points, springs = points[order], np.argsort(order)[springs]
    mass = np.full(len(points), 0.2)
    network = spring_network(
        points + np.array([0.0, drop]), springs, 1e4, mass=mass, force=np.outer(mass, (0.0, -9.81))
    )
    low = np.flatnonzero(points[:, 1] < 0.01)
    return network, Ground(network, low, obstacle, friction=friction)


@pytest.mark.parametrize("obstacle", [FLOOR, Obstacle("disc", (0.2, 0.0), (0.0, 1.0), 0.5)])
@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_compiled_and_plain_motions_agree_in_any_order_of_points(obstacle, friction):
    ends = []
    for path, seed in (("auto", None), ("plain", None), ("auto", 3)):
        network, ground = block(friction=friction, obstacle=obstacle, seed=seed)
        velocity = np.tile([0.3, -0.2], (len(network.points), 1))
        dt = recommended_time_step(network, EULER_CROMER, ground=ground)
        start = State(network.points, velocity)
        end = euler_cromer(network, start, dt, 400, ground=ground, path=path)
        at = np.lexsort(np.round(network.points, 6).T)
        ends.append(end.position[at])
        assert (ground.dissipated > 0) == bool(friction)
    np.testing.assert_allclose(ends[1], ends[0], rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(ends[2], ends[0], rtol=1e-9, atol=1e-12)


def test_energy_after_an_impact_is_that_before_to_second_order():
    errors = []
    for halved in (1, 2, 4):
        network, ground = block()
        dt = 0.2 * recommended_time_step(network, LEAPFROG, ground=ground) / halved
        start = State(network.points, np.tile([0.0, -0.5], (len(network.points), 1)))
        energy = []

        def look(_step, state, energy=energy, network=network, ground=ground):
            u = state.position - network.points
            kinetic = 0.5 * float(network.mass @ (state.velocity**2).sum(axis=1))
            springs = kernels.Motion(network).force_and_energy(u, np.empty_like(u))
            energy.append(springs + kinetic + ground.stored - float((network.force * u).sum()))

        motion(network, start, LEAPFROG, dt, 300 * halved, watch=look, ground=ground)
        errors.append(np.abs(np.array(energy) / energy[0] - 1).max())
    assert errors[0] > 3 * errors[1] > 9 * errors[2]
    assert errors[2] < 1e-2


def test_a_block_that_sticks_comes_back_and_one_that_slides_loses_what_friction_takes():
    network = spring_network(
        [[0.0, 0.0], [0.1, 0.0]], [[0, 1]], 1e4, force=[[0.0, -5.0], [0.0, -5.0]]
    )
    ground = Ground(network, np.array([0, 1]), FLOOR, friction=0.5, stiffness=1e4)
    deep = np.array([[0.0, -5e-4], [0.0, -5e-4]])
    ground.push(deep)
    small = deep + np.array([2e-4, 0.0])
    np.testing.assert_allclose(ground.push(small), [[-2.0, 5.0], [-2.0, 5.0]])
    np.testing.assert_allclose(ground.push(deep), [[0.0, 5.0], [0.0, 5.0]], atol=1e-12)
    assert ground.dissipated == 0
    far = ground.push(deep + np.array([1e-3, 0.0]))
    np.testing.assert_allclose(far, [[-2.5, 5.0], [-2.5, 5.0]])
    assert ground.dissipated == pytest.approx(2 * 2.5 * 7.5e-4)
    assert not ground.push(deep + np.array([0.0, 1e-3])).any()  # a floor does not pull
    assert ground.stored == 0


def test_ground_springs_are_part_of_the_stable_step():
    network, ground = block()
    stiff = Ground(network, ground.points, FLOOR, stiffness=4e6)
    dt = recommended_time_step(network, EULER_CROMER, ground=stiff)
    start = State(network.points, np.tile([0.0, -0.5], (len(network.points), 1)))
    euler_cromer(network, start, dt, 2000, ground=stiff)
    with pytest.warns(UserWarning, match="beyond the stability limit"):
        euler_cromer(network, start, 1.3 * dt, 1, ground=stiff)


def test_a_body_at_rest_inside_an_obstacle_is_pushed_out():
    network, _ = block(drop=-1e-4)
    network = replace(network, force=np.zeros_like(network.force))
    low = np.flatnonzero(network.points[:, 1] < 0.01)
    start = State(network.points, np.zeros_like(network.points))
    for path in ("auto", "plain"):
        ground = Ground(network, low, FLOOR)
        end = euler_cromer(network, start, 1e-4, 50, ground=ground, path=path)
        assert end.velocity[:, 1].mean() > 0


def test_bad_ground_springs_are_refused():
    network, ground = block()
    start = State(network.points, np.zeros_like(network.points))

    with refused("velocity_verlet: takes no ground springs"):
        motion(network, start, VELOCITY_VERLET, 1e-4, 1, ground=ground)
    with refused("ground springs: on path lattice or in threads; leave both out"):
        kernels.Motion(network, ground=ground, threads=2)
    for message, bad in (
        ("ground: points: points 99 to 99; there are 25, from 0", {"points": np.array([99])}),
        ("ground: friction: -1; give a number of 0 or more", {"friction": -1}),
        ("ground: stiffness 0 N/m; raise it above 0", {"stiffness": 0.0}),
    ):
        given = {"points": ground.points} | bad
        with refused(message):
            Ground(network, obstacle=FLOOR, **given)
    with refused("ground: an obstacle in 3D; give 2 axes"):
        Ground(network, ground.points, Obstacle("half_space", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0)))
