"""Lattices at any angle in a box: made to fit at the sides, themselves inside."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from msvalidate.problem import Anisotropic, Box, Problem, Region, Support, Traction
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.directions import (
    directional_modulus,
    directional_ratio,
    rotate_tensor,
)
from msvalidate.springs.constants.stiffness import pattern_tensor
from msvalidate.springs.lattice import fill_rotated, patterns
from msvalidate.springs.statics.equilibrium import equilibrium
from tests.table import refused, table

LATTICES = patterns.all_patterns()
PLANE, SPACE = Box((1.0, 0.75)), Box((1.0, 0.75, 0.5))
TILT = Rotation.from_rotvec([0.3, 0.5, 0.7]).as_matrix()


def made(name, spacing=None, angle=0.4):
    pattern = LATTICES[name]()
    if pattern.dim == 2:
        return fill_rotated(pattern, PLANE, spacing or 1 / 16, angle)
    return fill_rotated(pattern, SPACE, spacing or 1 / 8, TILT)


@pytest.mark.parametrize("name", LATTICES)
def test_inside_every_point_has_the_springs_of_the_turned_pattern(name):
    pattern = LATTICES[name]()
    spacing = 1 / 16 if pattern.dim == 2 else 1 / 12
    lattice = made(name, spacing)
    c, s = np.cos(0.4), np.sin(0.4)
    Q = np.array([[c, -s], [s, c]]) if pattern.dim == 2 else TILT
    expected = spacing * pattern.vectors @ Q.T
    both = np.concatenate([expected, -expected])
    longest = np.linalg.norm(expected, axis=1).max()
    away = np.minimum(lattice.points, np.array(lattice.domain.size) - lattice.points).min(axis=1)
    # Beyond the reach of what was moved onto a side, and of the braces of that.
    inside = np.flatnonzero(away > np.maximum(1.45 * longest, 2 * spacing))
    assert len(inside) > 0
    per_point = 2 * len(expected) / len(pattern.points)
    for point in inside:
        ours = (lattice.springs == point).any(axis=1)
        assert ours.sum() == per_point
        gap = np.linalg.norm(lattice.vectors[ours][:, None] - both, axis=2).min(axis=1)
        assert gap.max() < 1e-12
    np.testing.assert_allclose(lattice.share[(lattice.springs == inside[0]).any(axis=1)], 1.0)


def stretched(lattice, tensor, constants):
    """Modulus and ratio of the box pulled along x between uniform tractions."""
    box, d = lattice.domain, lattice.domain.dim
    along = (1.0,) + (0.0,) * (d - 1)
    supports = [
        Support(Region((0.0,) * d), (0.0,) * d),
        Support(Region((box.size[0], *(0.0,) * (d - 1))), (None,) + (0.0,) * (d - 1)),
    ]
    if d == 3:
        supports.append(Support(Region((0.0, box.size[1], 0.0)), (None, None, 0.0)))
    loads = (
        Traction(box.side("left"), tuple(-x for x in along)),
        Traction(box.side("right"), along),
    )
    problem = Problem(box, Anisotropic(tensor), tuple(supports), loads)
    move = equilibrium(lattice_network(problem, lattice, constants), "linear").displacement
    x = np.column_stack([lattice.points, np.ones(len(move))])
    gradient = np.linalg.lstsq(x, move, rcond=None)[0][:d]
    return 1 / gradient[0, 0], -gradient[1, 1] / gradient[0, 0]


@pytest.mark.parametrize(("name", "angle"), [("square", 0.4), ("square", 1.2), ("triangular", 0.2)])
def test_a_turned_block_comes_to_the_turned_solid_at_first_order(name, angle):
    pattern = LATTICES[name]()
    constants = (1.0, 2.0)[: pattern.kinds]  # the square one is far from isotropic
    tensor = rotate_tensor(pattern.tensor(constants), angle)
    E = directional_modulus(tensor, np.array([[1.0, 0.0]]))[0]
    nu = directional_ratio(tensor, 0.0)
    errors = []
    for cells in (12, 24, 48, 96):
        lattice = fill_rotated(pattern, PLANE, 1 / cells, angle)
        found = stretched(lattice, tensor, constants)
        errors.append((abs(found[0] / E - 1), abs(found[1] - nu)))
    error = np.array(errors)
    # An edge about half a spacing thick that carries less than its part, or more.
    assert (error * np.array([[12], [24], [48], [96]]) < 0.7).all()
    order = np.log2(error[0, 0] / error[-1, 0]) / 3
    assert 0.6 < order < 1.6


def test_a_turned_solid_comes_near_the_turned_tensor():
    pattern = LATTICES["cubic26"]()
    constants = (1.0, 1.0, 1.0)
    errors = []
    for cells in (6, 12):
        tensor = rotate_tensor(pattern_tensor(pattern, constants, 1 / cells), TILT)
        compliance = np.linalg.inv(tensor)
        E, nu = stretched(fill_rotated(pattern, SPACE, 1 / cells, TILT), tensor, constants)
        errors.append([E * compliance[0, 0] - 1, nu + compliance[1, 0] / compliance[0, 0]])
    assert (np.abs(errors[1]) < 0.08).all()
    assert abs(errors[1][0]) < abs(errors[0][0])


def test_points_left_with_too_few_springs_get_more():
    # Without braces, points on the edges of this box are held in two directions only.
    pattern, constants = patterns.fcc(), (1.0, 0.0)
    turn = Rotation.from_rotvec(0.3 * np.array([1, 2, 3]) / np.sqrt(14)).as_matrix()
    tensor = rotate_tensor(pattern_tensor(pattern, constants, 1 / 4), turn)
    lattice = fill_rotated(pattern, Box((1.0, 1.0, 1.0)), 1 / 4, turn)
    E, nu = stretched(lattice, tensor, constants)
    assert np.linalg.inv(tensor)[0, 0] * E == pytest.approx(1, abs=0.15)
    assert 0.15 < nu < 0.4


@table(("call", "message"), [
    (lambda: fill_rotated(None, PLANE, 0.1, 0.0), "pattern: None; give a Pattern"),
    (lambda: fill_rotated(patterns.fcc(), PLANE, 0.1, 0.0), "FCC lattice: a box 1 x 0.75 m; give"),
    (lambda: fill_rotated(patterns.square(), PLANE, -0.1, 0.0), "spacing: -0.1 m"),
    (lambda: fill_rotated(patterns.square(), PLANE, 0.1, np.nan), "angle: nan"),
    (lambda: fill_rotated(patterns.square(), PLANE, 0.1, "north"), "angle: "),
    (lambda: fill_rotated(patterns.square(), PLANE, 0.1, np.diag([1.0, -1.0])), "rotation: "),
    (lambda: fill_rotated(patterns.fcc(), SPACE, 0.1, 0.3), "rotation: 0.3; give a matrix (3, 3)"),
    (lambda: fill_rotated(patterns.fcc(), SPACE, 0.1, 2 * np.eye(3)), "rotation: "),
    (lambda: fill_rotated(patterns.square(), PLANE, 1e-6, 0.3), "points, and the most is"),
    (lambda: fill_rotated(patterns.square(), PLANE, 3.0, 0.3), "take a smaller spacing"),
])  # fmt: skip
def test_bad_input_is_refused(call, message):
    with refused(message):
        call()
