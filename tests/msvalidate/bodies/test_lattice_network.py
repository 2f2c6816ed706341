"""Networks that stand for a problem: masses, constants, supports and loads on a lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest

import reference_fem
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.lattice import diagonal_square, fill, patterns, square, triangular, zigzag_block
from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    PointForce,
    Problem,
    Region,
    Segment,
    Support,
    Traction,
)
from reference_fem.body import nodal_forces
from tests.table import refused, table

NAN = float("nan")


def moment(points, force):
    """Sum of x_a F_b - x_b F_a: moments about the origin in 2D and 3D alike."""
    first = points.T @ force
    return first - first.T


SHEET = Box((2.0, 1.0))
MATERIAL = Isotropic(E=3.0, nu=1 / 3, density=500.0, thickness=0.3)
CLAMP = Support(SHEET.side("left"), (0.0, 0.0))


def loaded(*loads, cells=(8, 4), **rules):
    return lattice_network(Problem(SHEET, MATERIAL, (CLAMP,), loads), square(SHEET, cells), **rules)


@pytest.mark.parametrize("mass", ["shared", "equal"])
def test_masses_sum_to_density_times_volume(mass):
    network = loaded(mass=mass)
    assert network.mass.sum() == pytest.approx(500.0 * 0.3 * 2.0, rel=1e-13)  # a sum of 45
    corner, middle = network.mass[0], network.mass[4 + 9]
    assert middle / corner == pytest.approx(4.0 if mass == "shared" else 1.0, rel=1e-13)


def test_weights_reach_the_springs():
    lattice = square(SHEET, (8, 4))
    problem = Problem(SHEET, MATERIAL, (CLAMP,))
    for rule, lowest, highest in (("shared", 0.5, 1), ("equal", 1, 1), ("per_cell", 1, 2)):
        network = lattice_network(problem, lattice, (7.0, 2.0), weights=rule)
        axial = network.stiffness[lattice.kind == 0] / 7.0
        assert (axial.min(), axial.max()) == (lowest, highest)
        assert (network.stiffness[lattice.kind == 1] == 2.0).all()


def test_a_body_force_sums_to_its_integral():
    # (2, x + 3y) over the sheet: 2 · area and ∫ (x + 3y) = 2 + 3; linear, so corners suffice.
    def weight(p):
        return np.stack([np.full(len(p), 2.0), p[:, 0] + 3 * p[:, 1]], axis=1)

    np.testing.assert_allclose(
        loaded(BodyForce(weight)).force.sum(axis=0), 0.3 * np.array([4.0, 5.0]), rtol=1e-13
    )
    np.testing.assert_allclose(
        loaded(BodyForce((0.0, -9.81))).force.sum(axis=0), [0.0, -9.81 * 0.3 * 2], rtol=1e-13
    )


PLATE = Isotropic(1e6, 1 / 3, "plane_stress", density=1100.0, thickness=0.2)
SOLID = Isotropic(1e6, 1 / 4, "solid", density=1100.0)


@pytest.mark.parametrize(
    ("size", "cells", "law", "element"),
    [
        ((0.37, 0.185), (4, 2), PLATE, "Q2"),
        ((1e4, 1.0), (10_000, 1), PLATE, "Q2"),
        ((0.37, 0.185, 0.185), (4, 2, 2), SOLID, "H1"),
    ],
)
def test_weight_is_density_times_volume_times_g_on_both_sides(size, cells, law, element):
    box, g = Box(size), (1.5, -9.81, 0.3)[: len(size)]
    held = Support(box.side("left"), (0.0,) * box.dim)
    problem = Problem(box, law, (held,), (BodyForce.gravity(law.density, g),))
    pattern = patterns.square() if box.dim == 2 else patterns.cubic18()
    springs = lattice_network(problem, fill(pattern, box, cells))
    elements = reference_fem.box_discretisation(box, cells, element)
    weight = 1100.0 * math.prod(size) * law.thickness * np.array(g)
    turning = moment(np.array([size]) / 2, weight[None])
    for points, force in (
        (springs.points, springs.force),
        (elements.points, nodal_forces(problem, elements)),
    ):
        np.testing.assert_allclose(force.sum(axis=0), weight, rtol=1e-12)
        room = 1e-12 * np.abs(turning).max()
        np.testing.assert_allclose(moment(points, force), turning, rtol=0, atol=room)
    # Mass and weight come from one density: the masses times g are the forces.
    np.testing.assert_allclose(springs.force, np.outer(springs.mass, g), rtol=1e-12)


def test_a_point_force_is_in_newtons_at_its_point():
    network = loaded(PointForce((2.0, 0.5), (1.0, -7.0)))
    assert network.force.tolist()[2 * 9 + 8] == [1.0, -7.0]
    assert np.count_nonzero(network.force) == 2


def test_supports_and_loads_meet_only_their_region():
    part = Support(Region((2.0, (0.5, 1.0))), (0.25, None))
    problem = Problem(SHEET, MATERIAL, (CLAMP, part))
    network = lattice_network(problem, square(SHEET, (4, 2)))
    x, y = network.points.T
    expected = np.stack([(x == 0) | ((x == 2) & (y >= 0.5)), x == 0], axis=1)
    np.testing.assert_array_equal(network.held, expected)
    np.testing.assert_array_equal(network.displacement[:, 0], 0.25 * (expected[:, 0] & (x == 2)))


@table(
    ("make", "message"),
    [
        (
            lambda: lattice_network(
                Problem(SHEET, MATERIAL, (CLAMP,)), square(Box((4.0, 2.0)), (4, 2))
            ),
            "lattice fills a box 4 x 2 m, the problem's is a box 2 x 1 m; build it",
        ),
        (
            lambda: loaded(PointForce((1.9, 0.5), (1.0, 0.0))),
            "no lattice point there; choose cells",
        ),
        (lambda: loaded(constants=(1.0,)), "give 2, one a kind"),
        (lambda: loaded(constants=(1.0, NAN)), "spring constants: nan at index 1"),
        (lambda: loaded(constants=(1.0, -1.0)), "stiffness: -1 at index"),
        (lambda: loaded(weights="halved"), "boundary weights: 'halved'; choose shared, equal"),
        (lambda: loaded(mass="lumped"), "mass: 'lumped'; choose shared or equal"),
        (
            lambda: loaded(Traction(SHEET.side("right"), lambda p: p[:, 0])),
            "traction on (x = 2): the field returned shape",
        ),
        (
            lambda: loaded(Traction(SHEET.side("right"), lambda p: p / np.where(p > 1.5, NAN, 1))),
            "traction on (x = 2): nan",
        ),
    ],
)
def test_a_problem_that_does_not_fit_the_lattice_is_refused(make, message):
    with refused(message):
        make()


# Patches of load ------------------------------------------------------------------------------

BUILD = {
    "square": lambda n: square(Box((2.0, 1.0)), (2 * n, n)),
    "square at 45 degrees": lambda n: diagonal_square(Box((2.0, 1.0)), (2 * n, n)),
    "triangular": lambda n: triangular(zigzag_block(1.0, (4 * (n // 2), n)), 1.0 / n),
}


def pushed(lattice, load):
    """Network of a body held on its right side under one load."""
    right = lattice.domain.span[0][1]
    held = Support(Region((right, None)), (0.0, 0.0))
    return lattice_network(Problem(lattice.domain, MATERIAL, (held,), (load,)), lattice)


@pytest.mark.parametrize(
    ("cells", "shares"), [(5, [1 / 2, 1 / 2]), (10, [1 / 4, 1 / 2, 1 / 4]), (15, [1, 2, 2, 1])]
)
@pytest.mark.parametrize("name", BUILD)
def test_the_middle_fifth_of_a_side_is_pushed_at_its_own_points_alone(name, cells, shares):
    for part in (Region((0.0, (0.4, 0.6))), Segment((0.0, 0.6), (0.0, 0.4))):
        network = pushed(BUILD[name](cells), Traction(part, (5.0, -2.0)))
        (points,) = np.nonzero(network.force.any(axis=1))
        points = points[np.argsort(network.points[points, 1])]
        assert len(points) == len(shares)
        np.testing.assert_allclose(network.points[points, 0], 0.0, atol=1e-15)
        expected = 0.3 * 0.2 * np.outer(shares, [5.0, -2.0]) / sum(shares)
        # Edges of the part are differences of coordinates, rounded to 1e-16 of 1 m.
        np.testing.assert_allclose(network.force[points], expected, rtol=1e-13)


@table("cells", [4, 6, 7])
@table("name", BUILD)
def test_a_fifth_that_the_points_do_not_divide_is_refused(name, cells):
    with refused("traction on (x = 0, 0.4 <= y <= 0.6): covers no whole number of cell edges"):
        pushed(BUILD[name](cells), Traction(Region((0.0, (0.4, 0.6))), (5.0, 0.0)))
