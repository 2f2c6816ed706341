"""`statics.contact`: exact unilateral contact, by force and depth, in the plane and in space."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import nnls

from msvalidate.linear_algebra import choice
from msvalidate.problem import (
    Box,
    Contact,
    Isotropic,
    Obstacle,
    Problem,
    ProblemError,
    Region,
    SolverError,
    Support,
    Traction,
)
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import contact_network, lattice_network
from msvalidate.springs.lattice import fill, patterns, square
from msvalidate.springs.network import Configuration
from msvalidate.springs.statics.contact import solve_contact
from tests.table import refused

SIZE, THICK = 0.37, 0.2
BOX = Box((2 * SIZE, SIZE))
SHEET = Isotropic(2e5, 1 / 3, thickness=THICK)
DISC = Obstacle("disc", (0.4, SIZE), (0.0, -3.0), 0.3)


def pressed(obstacle=DISC, cells=12, loads=(), clamped="bottom", **how):
    """A clamped block under an obstacle: network, and what may touch."""
    contact = Contact(BOX.side("top"), obstacle, **(how or {"depth": 0.01}))
    clamp = Support(BOX.side(clamped), (0.0, 0.0))
    problem = Problem(BOX, SHEET, (clamp,), loads, contacts=(contact,))
    return contact_network(problem, square(BOX, (2 * cells, cells)))


def densely(network, touching):
    """Forces by the compliance of all candidates and least squares: another algorithm."""
    free, (one,) = ~network.fixed.ravel(), touching
    x, d = network.points[one.points], network.dim
    normal = one.obstacle.normal(x, one.depth)
    N = np.zeros((network.points.size, len(x)))
    for axis in range(d):
        N[d * one.points + axis, np.arange(len(x))] = normal[:, axis]
    K = Configuration(network).tangent().toarray()[np.ix_(free, free)]
    begun = np.linalg.solve(K, network.force.ravel()[free])
    C = N[free].T @ np.linalg.solve(K, N[free])
    gap = one.obstacle.gap(x, one.depth) + N[free].T @ begun
    L = np.linalg.cholesky((C + C.T) / 2)
    return nnls(L.T, -np.linalg.solve(L, gap))[0]


def test_an_obstacle_of_other_axes_names_that_of_the_body():
    with pytest.raises(ProblemError, match="give 3 numbers; for a body in 2D take a disc"):
        Obstacle("ball", (0.5, 1.0), (0.0, -1.0), 0.3)
    with pytest.raises(ProblemError, match="give 2 numbers; for a body in 3D take a paraboloid"):
        Obstacle("parabola", (0.5, 1.0, 0.0), (0.0, -1.0, 0.0), 0.3)


@pytest.mark.parametrize("loads", [(), (Traction(BOX.side("right"), (1e3, -2e3)),)])
@pytest.mark.parametrize("shape", ["disc", "parabola", "half_space"])
def test_forces_are_those_of_least_squares_and_of_the_depth_that_they_take(shape, loads):
    radius = None if shape == "half_space" else 0.3
    obstacle = Obstacle(shape, (0.4, SIZE), (0.1, -1.0) if radius is None else (0.0, -1.0), radius)
    network, touching = pressed(obstacle, loads=loads, depth=0.01)
    found = solve_contact(network, touching)
    (one,) = found.contacts
    wanted = densely(network, touching)
    np.testing.assert_allclose(one.force, wanted, atol=1e-9 * wanted.max())
    assert found.complementarity < 1e-10
    assert one.pressure @ one.share == pytest.approx(one.force.sum())
    if shape != "disc":  # whose normals turn as it is lowered
        again = solve_contact(*pressed(obstacle, loads=loads, force=one.total))
        assert again.contacts[0].depth == pytest.approx(0.01, rel=1e-9)
        np.testing.assert_allclose(again.contacts[0].force, one.force, atol=1e-8 * wanted.max())


@pytest.mark.parametrize("place", [0.1, 0.37, 0.4, 0.5])
@pytest.mark.parametrize("strain", [1e-12, 1e-9, 1e-5, 0.1])
def test_the_total_is_the_force(strain, place):
    force = strain * SHEET.E * SIZE * THICK
    found = solve_contact(*pressed(replace(DISC, at=(place, SIZE)), force=force))
    assert found.contacts[0].total == pytest.approx(force, rel=1e-9)
    assert found.complementarity <= 1e-7


def test_every_order_of_points_and_solver_give_the_same_forces(monkeypatch):
    network, (touching,) = pressed()
    found = solve_contact(network, touching)
    assert found.complementarity < 1e-10
    order = np.random.default_rng(0).permutation(len(network.points))
    place = np.argsort(order)
    other = replace(
        network, points=network.points[order], springs=place[network.springs],
        mass=network.mass[order], fixed=network.fixed[order], force=network.force[order],
        displacement=network.displacement[order], cells=None,
    )  # fmt: skip
    again = solve_contact(other, replace(touching, points=place[touching.points]))
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)  # of a factor: by multigrid
    same = solve_contact(network, touching).contacts[0].force
    np.testing.assert_allclose(same, found.contacts[0].force, atol=1e-8 * same.max())
    np.testing.assert_allclose(again.contacts[0].force, found.contacts[0].force, rtol=1e-8)


@pytest.mark.parametrize(("nu", "depth"), [(0.0, 1e-9), (0.3, 0.02)])
def test_a_flat_obstacle_on_rollers_presses_evenly(nu, depth):
    material = Isotropic(3e4, nu, thickness=THICK)
    flat = Obstacle("half_space", (0.0, SIZE), (0.0, -1.0))
    rollers = (Support(BOX.side("bottom"), (None, 0.0)), Support(Region((0.0, 0.0)), (0.0, None)))
    contact = (Contact(BOX.side("top"), flat, depth * SIZE),)
    problem, grid = Problem(BOX, material, rollers, contacts=contact), square(BOX, (16, 8))
    network, touching = contact_network(problem, grid, calibrate_material(material, grid))
    (one,) = solve_contact(network, touching).contacts
    np.testing.assert_allclose(one.pressure, 3e4 * depth, rtol=1e-12)


def test_a_ball_in_space_by_multigrid_closes_its_gaps(monkeypatch):
    box = Box((SIZE, SIZE, SIZE / 2))
    ball = Obstacle("ball", (SIZE / 2, SIZE / 2, SIZE / 2), (0.0, 0.0, -1.0), 0.5)
    clamp = Support(box.side("back"), (0.0, 0.0, 0.0))
    contact = (Contact(box.side("front"), ball, 0.01),)
    problem = Problem(box, Isotropic(1.0, 0.25, "solid"), (clamp,), contacts=contact)
    network, touching = contact_network(problem, fill(patterns.cubic18(), box, (8, 8, 4)))
    exact = solve_contact(network, touching)
    monkeypatch.setattr(choice, "MOST_PRODUCTS", 0)
    found = solve_contact(network, touching)
    assert found.equilibrium.solver.name == "multigrid"
    np.testing.assert_allclose(
        found.contacts[0].force, exact.contacts[0].force, atol=1e-8 * exact.contacts[0].force.max()
    )
    assert found.rounds > 1


@pytest.mark.parametrize("depth", [1e-7, 0.03, 0.09])
def test_at_large_depth_forces_are_along_the_obstacles_normals(depth):
    disc = replace(DISC, at=(0.37, SIZE))  # above a point
    network, touching = pressed(disc, depth=depth * SIZE)
    found = solve_contact(network, touching, "nonlinear")
    (one,) = found.contacts
    x = (network.points + found.equilibrium.displacement)[one.points]
    gap = disc.gap(x, one.depth)
    assert np.abs(gap[one.force > 0]).max() < 1e-9 * one.depth + 1e-15
    assert gap.min() > -1e-9 * one.depth - 1e-15
    load = found.load[one.points]
    turned = one.force[:, None] * disc.normal(x, one.depth)
    np.testing.assert_allclose(load, turned, atol=1e-9 * one.force.max())
    if depth < 1e-6:
        linear = solve_contact(network, touching).contacts[0].force
        np.testing.assert_allclose(one.force, linear, rtol=1e-3, atol=1e-3 * linear.max())


def test_what_is_too_deep_is_said_with_how_far_there_is_an_equilibrium():
    network, touching = pressed(
        Obstacle("disc", (0.4, SIZE), (0.0, -1.0), 0.2), cells=6, depth=0.19
    )
    with pytest.raises(SolverError, match=r"contact: no equilibrium beyond 0\.\d+ of the obstacle"):
        solve_contact(network, touching, "nonlinear")


def test_contacts_that_cannot_be_are_refused():
    with refused("no point of the region can be reached, the nearest is 0.01 m away"):
        solve_contact(*pressed(depth=-0.01))
    with refused("friction 0.5 at rest depends on the way there; take `motion`, or friction 0"):
        solve_contact(*pressed(depth=0.01, friction=0.5))
    parabola = Obstacle("parabola", (0.4, SIZE), (0.0, -1.0), 0.3)
    with refused("take a disc or ball, or geometry 'linear'"):
        solve_contact(*pressed(parabola, depth=0.01), "nonlinear")
    corner = replace(parabola, at=(0.001, SIZE))
    with refused("which is held, and presses nothing; move it"):
        solve_contact(*pressed(corner, clamped="left", force=1e-3))
    network, (one,) = pressed()
    with refused("two contacts claim point"):
        solve_contact(network, (one, one))
    with refused("contact: none; give one, or take equilibrium"):
        solve_contact(network, ())
    with refused("the supports leave the body free"):
        solve_contact(replace(network, fixed=np.zeros_like(network.fixed)), one)
    still = replace(network, fixed=np.ones_like(network.fixed))
    with refused("is held inside the obstacle; give a part of the surface that may move"):
        solve_contact(still, one)
    side = Contact(BOX.side("top"), DISC, 0.01)
    clamp = (Support(BOX.side("bottom"), (0.0, 0.0)),)
    with refused("has a contact; take contact_network, or leave it out"):
        lattice_network(Problem(BOX, SHEET, clamp, contacts=(side,)), square(BOX, (4, 2)))
    with refused("is in the body; lower it less, or place it outside"):
        Problem(BOX, SHEET, clamp, contacts=(Contact(BOX.side("top"), DISC, 0.35),))
    with refused("it is not on one side of the body all the way"):
        Problem(BOX, SHEET, clamp, contacts=(Contact(Region((None, 0.1)), DISC, 0.01),))
    for message, bad in (
        ("half_space: radius 1.0; leave it out", ("half_space", (0.0, 0.0), (0.0, 1.0), 1.0)),
        ("disc: radius None; give one in m", ("disc", (0.0, 0.0), (0.0, 1.0))),
        ("ball: at (0.0, 0.0): shape (2,); give 3 numbers", ("ball", (0.0, 0.0), (0.0, 1.0), 1.0)),
        ("towards has no length", ("half_space", (0.0, 0.0), (0.0, 0.0))),
    ):
        with refused(message):
            Obstacle(*bad)
    with refused("depth and force both; give one, the other follows"):
        Contact(BOX.side("top"), DISC, 0.1, 3.0)
    with refused("friction: -1; give a number of 0 or more"):
        Contact(BOX.side("top"), DISC, 0.1, friction=-1)
    with refused("no part of a side"):
        Contact(Region((0.0, 0.0)), DISC)
    with refused("an obstacle in 3D for a body in 2D"):
        Contact(BOX.side("top"), Obstacle("ball", (0.0, 0.0, 0.0), (0.0, 0.0, 1.0), 1.0))


def test_gaps_keep_their_digits_near_large_discs():
    disc = Obstacle("disc", (0.0, 0.0), (0.0, -1.0), 1e6)
    x = np.array([[1e-3, -1e-9], [0.0, 1e-12], [2.0, 0.0]])
    np.testing.assert_allclose(disc.gap(x), [1e-9 + 5e-13, -1e-12, 2e-6], rtol=1e-6)
