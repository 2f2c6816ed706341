"""Networks that stand for a problem: masses, constants, supports and loads on a lattice."""

from __future__ import annotations

import math

import numpy as np
import pytest

import reference_fem
from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    PointForce,
    Problem,
    Region,
    Support,
    Traction,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import (
    diagonal_square,
    fill,
    patterns,
    square,
    triangular,
    zigzag_block,
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


@table(("make", "message"), [
    (lambda: lattice_network(Problem(SHEET, MATERIAL, (CLAMP,)), square(Box((4.0, 2.0)), (4, 2))),
        "lattice fills a box 4 x 2 m, the problem's is a box 2 x 1 m; build it"),
    (lambda: loaded(PointForce((1.9, 0.5), (1.0, 0.0))), "no lattice point there; choose cells"),
    (lambda: loaded(constants=(1.0,)), "give 2, one a kind"),
    (lambda: loaded(constants=(1.0, NAN)), "spring constants: nan at index 1"),
    (lambda: loaded(constants=(1.0, -1.0)), "stiffness: -1 at index"),
    (lambda: loaded(weights="halved"), "boundary weights: 'halved'; choose shared, equal"),
    (lambda: loaded(mass="lumped"), "mass: 'lumped'; choose shared or equal"),
    (lambda: loaded(Traction(SHEET.side("right"), lambda p: p[:, 0])),
        "traction on (x = 2): the field returned shape"),
    (lambda: loaded(Traction(SHEET.side("right"), lambda p: p / np.where(p > 1.5, NAN, 1))),
        "traction on (x = 2): nan"),
])  # fmt: skip
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


@table("cells", [4, 6, 7])
@table("name", BUILD)
def test_a_fifth_that_the_points_do_not_divide_is_refused(name, cells):
    with refused("traction on (x = 0, 0.4 <= y <= 0.6): covers no whole number of cell edges"):
        pushed(BUILD[name](cells), Traction(Region((0.0, (0.4, 0.6))), (5.0, 0.0)))
