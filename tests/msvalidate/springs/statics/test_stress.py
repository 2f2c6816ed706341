"""Stresses of networks: exact for uniform strain, in sum the virial of the forces from outside."""

from __future__ import annotations

import numpy as np
import pytest

from msvalidate.problem import (
    BodyForce,
    Box,
    Isotropic,
    Mesh,
    Problem,
    Region,
    Support,
)
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import pattern_tensor
from msvalidate.springs.lattice import fill, mesh_lattice, patterns, trapezium, triangular
from msvalidate.springs.lattice.corners import corner_volumes
from msvalidate.springs.statics.equilibrium import Equilibrium, equilibrium
from msvalidate.springs.statics.stress import (
    cell_stress,
    cell_volume,
    fitted_stress,
    point_stress,
    spring_cell_pairs,
    spring_virial,
)
from tests.table import refused

PLANE, SPACE = (0.7, -0.4, 0.3), (0.7, -0.4, 0.2, 0.3, -0.1, 0.5)
"""Voigt strains, engineering shear."""
THICKNESS = 0.3


def lattices():
    """Lattice, tensor (N/m in the plane, Pa in space) by name; constants as `NETWORK` has them."""
    square, cubic = patterns.square(), patterns.cubic18()
    equilateral = triangular(trapezium(0.2, (5, 3)), 0.2)
    triangles = patterns.triangular()
    third = 3.0 * THICKNESS * np.array([[9 / 8, 3 / 8, 0], [3 / 8, 9 / 8, 0], [0, 0, 3 / 8]])
    mesh = Mesh(equilateral.points, equilateral.cells, "triangle")
    return {
        "square": (
            fill(square, Box((1.0, 0.5)), (4, 2)),
            (2.0, 0.7),
            pattern_tensor(square, (2.0, 0.7)),
        ),
        "triangular": (equilateral, (2.0,), pattern_tensor(triangles, (2.0,))),
        "mesh": (mesh_lattice(mesh), (3.0 * THICKNESS,), third),
        "cubic 18": (
            fill(cubic, Box((0.5, 0.5, 1.0)), (1, 1, 2)),
            (2.0, 0.7),
            pattern_tensor(cubic, (2.0, 0.7), 0.5),
        ),
    }


LATTICES = lattices()


def material(dim):
    if dim == 2:
        return Isotropic(E=3.0, nu=1 / 3, thickness=THICKNESS)
    return Isotropic(E=3.0, nu=1 / 4, state="solid")


def clamped(lattice, constants, volume=0.0, loads=()):
    """Network of a lattice held at the low end of x."""
    d = lattice.points.shape[1]
    low = Support(Region((float(lattice.points[:, 0].min()),) + (None,) * (d - 1)), (0.0,) * d)
    if isinstance(lattice.domain, Box):
        problem = Problem(lattice.domain, material(d), (low,), loads)
    else:
        points = [Support(Region(tuple(p)), (0.0, 0.0)) for p in lattice.points[:2].tolist()]
        problem = Problem(lattice.domain, material(d), tuple(points), loads)
    return lattice_network(problem, lattice, constants, volume=volume)


def moved(network, displacement):
    """The network in a state that it need not be at rest in."""
    return Equilibrium(displacement, network.points + displacement, displacement * 0, 0.0, 0)


def gradient(strain):
    """A displacement gradient of that strain, with some turn in it."""
    d = 2 if len(strain) == 3 else 3
    e = np.diag(strain[:d]).astype(float)
    for (i, j), g in zip([(0, 1)] if d == 2 else [(1, 2), (0, 2), (0, 1)], strain[d:], strict=True):
        e[i, j], e[j, i] = g / 2 + 0.2, g / 2 - 0.2
    return e


@pytest.mark.parametrize("geometry", ["linear", "nonlinear"])
@pytest.mark.parametrize("kappa", [0.0, 1.3])
@pytest.mark.parametrize("name", LATTICES)
def test_stress_times_volume_sums_to_the_virial_of_the_forces_from_outside(name, kappa, geometry):
    lattice, constants, _ = LATTICES[name]
    d = lattice.points.shape[1]
    weight = BodyForce((0.01, -0.05, 0.02)[:d])
    network = clamped(lattice, constants, kappa, (weight,))
    found = equilibrium(network, geometry)
    place = found.position if geometry == "nonlinear" else network.points
    outside = (network.force + found.reaction).T @ place
    t = THICKNESS if d == 2 else 1.0
    stress = cell_stress(network, lattice, found, geometry=geometry, thickness=t)
    volume = t * corner_volumes(place, lattice.cells).sum(axis=1)
    total = volume @ stress
    first, second = ([0, 1, 0], [0, 1, 1]) if d == 2 else ([0, 1, 2, 1, 0, 0], [0, 1, 2, 2, 2, 1])
    # What is out of balance at free points has a virial too; the rest is rounding.
    scale = found.residual * np.abs(place).sum() + 1e-13 * np.abs(outside).max()
    np.testing.assert_allclose(outside, outside.T, rtol=0, atol=scale)
    np.testing.assert_allclose(total, outside[first, second], rtol=0, atol=scale)


@pytest.mark.parametrize("name", ["square", "cubic 18"])
def test_stress_turns_with_the_body(name):
    lattice, constants, _ = LATTICES[name]
    d = lattice.points.shape[1]
    network = clamped(lattice, constants, 1.3)
    strained = lattice.points @ (np.eye(d) + 0.1 * gradient(PLANE if d == 2 else SPACE)).T
    Q = np.eye(d)
    Q[:2, :2] = [[0, -1], [1, 0]]  # a quarter turn about z
    states = [moved(network, x - lattice.points) for x in (strained, strained @ Q.T)]
    one, two = (cell_stress(network, lattice, state, geometry="nonlinear") for state in states)
    swapped = [1, 0, 2] if d == 2 else [1, 0, 2, 4, 3, 5]
    sign = [1, 1, -1] if d == 2 else [1, 1, 1, 1, -1, -1]
    np.testing.assert_allclose(two, one[:, swapped] * sign, rtol=0, atol=1e-13)


def test_springs_from_cell_to_cell_have_no_stress_by_cells():
    lattice = fill(patterns.fcc(), Box((2.0, 2.0, 2.0)), 2)
    network = clamped(lattice, (1.0, 0.0))
    with refused("corners of no one cell; ask fitted_stress"):
        cell_stress(network, lattice, moved(network, 0 * lattice.points))


def lame(x):
    """Displacement and stress round a pressed hole at (-1, -1), E = 1, ratio 1/3; r = 1 to 4."""
    d = x + 1
    r2 = (d**2).sum(axis=1)
    n = d / np.sqrt(r2)[:, None]
    # sigma = -+ 1/r², u = (4/3)/r along n.
    xx, xy = (n[:, 1] ** 2 - n[:, 0] ** 2) / r2, -2 * n[:, 0] * n[:, 1] / r2
    return 4 / 3 * d / r2[:, None], np.stack([xx, -xx, xy], axis=1)


def test_orders_on_a_closed_form():
    box = Box((2.0, 2.0))
    sides = tuple(
        Support(box.side(side), (lambda x: lame(x)[0][:, 0], lambda x: lame(x)[0][:, 1]))
        for side in ("left", "right", "top", "bottom")
    )
    tensor = np.array([[9 / 8, 3 / 8, 0], [3 / 8, 9 / 8, 0], [0, 0, 3 / 8]])
    places = np.array([[0.0, 0.0], [0.0, 1.0], [0.93, 0.71], [2.0, 2.0]])
    error = {"cells": [], "points": [], "rim": [], "fitted": []}
    for n in (8, 16, 32):
        lattice = fill(patterns.square(), box, n)
        network = lattice_network(Problem(box, Isotropic(E=1.0, nu=1 / 3), sides), lattice)
        found = equilibrium(network)
        stress = cell_stress(network, lattice, found)
        middle = lattice.points[lattice.cells].mean(axis=1)
        error["cells"].append(np.abs(stress - lame(middle)[1]).max())
        off = np.abs(point_stress(lattice, stress) - lame(lattice.points)[1]).max(axis=1)
        on_rim = ((lattice.points < 1e-9) | (lattice.points > 2 - 1e-9)).any(axis=1)
        error["points"].append(off[(np.abs(lattice.points - 1) <= 0.5).all(axis=1)].max())
        error["rim"].append(off[on_rim].max())
        fitted = fitted_stress(lattice.points, found.displacement, places, tensor, count=60)
        error["fitted"].append(np.abs(fitted - lame(places)[1]).max())
    order = {name: np.log2(e[1] / e[2]) for name, e in error.items()}
    assert order["cells"] == pytest.approx(2, abs=0.3)
    assert order["points"] == pytest.approx(2, abs=0.3)
    assert order["rim"] == pytest.approx(1, abs=0.3)  # the mean of cells on one side of a point
    assert order["fitted"] > 1.7
    assert error["fitted"][2] < error["rim"][2] / 10


def test_a_fit_is_exact_for_polynomials_of_its_degree():
    rng = np.random.default_rng(2)
    for d, tensor in ((2, np.diag([1.0, 2.0, 3.0])), (3, np.diag(np.arange(1.0, 7.0)))):
        x = rng.uniform(0, 1, (400, d))
        a, b, c = x.T[0], x.T[1], x.T[-1]
        u = np.stack([a**3 - b, a * b, c**2 * a][:d], axis=1)
        at = np.array([[0.4, 0.6, 0.5][:d], [1.1, 0.2, 0.9][:d]])
        p, q, r = at.T[0], at.T[1], at.T[-1]
        strain = [3 * p**2, p] if d == 2 else [3 * p**2, p, 2 * r * p]
        zero = 0 * p
        strain += [q - 1] if d == 2 else [zero, r**2, q - 1]
        wanted = np.stack(strain, axis=1) * np.diag(tensor)
        found = fitted_stress(x, u, at, tensor, degree=3)
        np.testing.assert_allclose(found, wanted, rtol=0, atol=1e-11)


def test_what_does_not_belong_together_is_refused():
    lattice, constants, tensor = LATTICES["square"]
    network = clamped(lattice, constants)
    other = clamped(*LATTICES["triangular"][:2])
    found = moved(network, 0 * network.points)
    with refused("the network's springs are not the lattice's; give its own"):
        cell_stress(other, lattice, found)
    with refused("stress: displacements (15, 2), points"):
        cell_stress(other, LATTICES["triangular"][0], found)
    with refused("geometry: 'affine'"):
        spring_virial(network, found, "affine")
    with refused("stress of the cells: shape (3, 3); the lattice has 8 cells"):
        point_stress(lattice, np.eye(3))
    with refused("16 of 15 points a fit"):
        fitted_stress(
            lattice.points, 0 * lattice.points, np.zeros((1, 2)), tensor, degree=2, count=16
        )
    solid = fill(patterns.fcc(), Box((1.0, 1.0, 1.0)), 2)
    with refused("of the FCC lattice is no cell's corner; ask fitted_stress"):
        point_stress(solid, np.ones((8, 6)))
    for points, places in ((lattice.points, np.zeros((0, 2))), (np.ones((30, 4)), np.ones((1, 4)))):
        with refused("give (n, d) twice and (p, d)"):
            fitted_stress(points, points, places, tensor, degree=1)
    in_one_place = np.zeros((30, 2))
    with refused("lie on a curve of that degree"):
        fitted_stress(in_one_place, in_one_place, np.zeros((1, 2)), tensor, degree=1)
    for ask in (cell_volume, spring_cell_pairs):
        with refused("lattice: None; give a Lattice"):
            ask(None)
    on_line = np.stack([np.linspace(0, 1, 30), np.zeros(30)], axis=1)
    with refused("lie on a curve of that degree; take more points or a lower degree"):
        fitted_stress(on_line, 0 * on_line, np.zeros((1, 2)), tensor, degree=1)
    np.testing.assert_allclose(cell_volume(lattice), 1 / 16, rtol=1e-14)
