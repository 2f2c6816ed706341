"""What a calibration says of a body, against equilibria of it under uniform tension."""

from __future__ import annotations

import math

import numpy as np
import pytest

from msvalidate.problem import SIDES, Box, Isotropic, Problem, SolverError, Support, Traction
from msvalidate.springs.bodies.calibrate import calibrate, calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import fill, patterns, square, triangular, zigzag_block
from msvalidate.springs.statics.equilibrium import equilibrium

SHEET = Isotropic(E=2e6, nu=1 / 3, state="plane_stress", thickness=0.2)
TENSION = 3e3


def cut(name, cells, nu):
    """Material and body: cells across a box of 0.37 m."""
    if name == "triangular":
        box = Box((0.37, 0.37 * math.sqrt(3)))
        return SHEET, fill(patterns.triangular(), box, (cells, cells))
    return Isotropic(2e6, nu, "solid"), fill(getattr(patterns, name)(), Box((0.37,) * 3), cells)


def pulled(material, lattice, found, axis):
    """Displacement (n, d), and that of the material by Hooke's law, on rollers."""
    box, axes = lattice.domain, range(lattice.domain.dim)
    side = {place: box.side(name) for name, place in SIDES.items() if place[0] in axes}
    rollers = tuple(Support(side[a, 0], tuple(0.0 if b == a else None for b in axes)) for a in axes)
    load = Traction(side[axis, 1], tuple(TENSION * (a == axis) for a in axes))
    network = lattice_network(Problem(box, material, rollers, (load,)), lattice, found)
    strain = np.full(len(axes), -material.nu)
    strain[axis] = 1.0
    return equilibrium(network).displacement, lattice.points * strain * TENSION / material.E


def error_of(material, lattice, found):
    both = [pulled(material, lattice, found, axis) for axis in range(lattice.domain.dim)]
    return max(np.abs(u - exact).max() / np.abs(exact).max() for u, exact in both)


@pytest.mark.parametrize(
    ("name", "cells", "nu"),
    [
        ("triangular", 8, None),
        ("triangular", 16, None),
        ("bcc", 3, 0.25),
        ("bcc", 6, 0.4),
        ("fcc", 3, 0.25),
        ("fcc", 5, 0.4),
    ],
)
def test_stated_error_is_that_of_the_body(name, cells, nu):
    material, lattice = cut(name, cells, nu)
    found = calibrate_material(material, lattice)
    assert found.body.verdict == "first order"
    assert found.body.points == len(lattice.points)
    # Two factors of the same equations, which are of condition 1e4 or so.
    assert found.body.error == pytest.approx(error_of(material, lattice, found), rel=1e-9)
    assert found.body.error > 0.05
    assert f"{100 * found.body.error:.2g} %" in str(found)


@pytest.mark.parametrize(
    ("name", "cells"),
    [("triangular", 32), ("bcc", 8), pytest.param("fcc", 7, marks=pytest.mark.slow)],
)
def test_error_of_a_larger_body_is_told_from_a_smaller_one(name, cells):
    material, lattice = cut(name, cells, 0.25)
    found = calibrate_material(material, lattice)
    assert found.body.points < len(lattice.points)
    # The next order of the error is the spacing over the body once more: a tenth at ten cells.
    assert found.body.error == pytest.approx(error_of(material, lattice, found), rel=0.1)


@pytest.mark.parametrize("cells", [3, 9])
def test_an_unstable_body_is_said_to_be(cells):
    material, lattice = cut("fcc", cells, -0.1)
    found = calibrate_material(material, lattice)
    assert found.body.verdict == "unstable"
    assert math.isnan(found.body.error)
    assert "unstable" in str(found)
    if cells == 3:
        with pytest.raises(SolverError, match="unstable"):
            pulled(material, lattice, found, 0)


@pytest.mark.parametrize("seed", range(6))
def test_squares_are_exact(seed):
    rng = np.random.default_rng(seed)
    cells = tuple(int(n) for n in rng.integers(1, 40, 2))
    material = Isotropic(2e6, float(rng.uniform(-0.9, 0.4999)), "plane_stress", thickness=0.2)
    lattice = square(Box(tuple(0.01 * n for n in cells)), cells)
    found = calibrate_material(material, lattice)
    assert (found.body.verdict, found.body.error) == ("exact", 0.0)
    assert error_of(material, lattice, found) < 1e-9
    assert "exact" in str(found)


def test_cubes_are_exact():
    material = Isotropic(2e6, 0.3, "solid")
    lattice = fill(patterns.cubic18(), Box((0.37, 0.37, 0.74)), (3, 3, 6))
    assert calibrate_material(material, lattice).body.verdict == "exact"


def test_nothing_is_said_of_what_was_not_tried():
    endless = calibrate(2e6, 0.25, patterns.fcc(), "solid", spacing=0.1)
    assert endless.body is None
    assert "periodic lattice" in str(endless)
    triangles = triangular(zigzag_block(0.37, (2, 2)), 0.185)
    assert calibrate_material(SHEET, triangles).body.verdict == "not known"
    assert "not tried" in str(calibrate_material(SHEET, triangles))
