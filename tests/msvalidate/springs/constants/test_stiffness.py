"""Spring constants to elastic constants and back."""

from __future__ import annotations

import re
from dataclasses import replace
from itertools import permutations, product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from msvalidate.problem import Anisotropic, Box, Isotropic, ProblemError
from msvalidate.springs.constants.directions import (
    directional_modulus,
    directional_ratio,
    rotate_tensor,
)
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.constants.isotropic import isotropic_constants
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.constants.stiffness import (
    cubic_part,
    shear_modulus,
    square_tensor,
)
from msvalidate.springs.lattice import (
    diagonal_square,
    patterns,
    square,
    trapezium,
    triangular,
    zigzag_block,
)
from tests.table import table

THIRD = Isotropic(E=2.5, nu=1 / 3, state="plane_stress", thickness=0.4)
# No symmetry at all, so that the sense of a rotation shows.
CROOKED = np.array([[3.0, 0.5, 0.4], [0.5, 2.0, -0.3], [0.4, -0.3, 1.0]])
EXACT = 1e-13  # a few products of numbers near 1, each rounded to 1e-16

angles = st.floats(-np.pi, np.pi)
examples = settings(max_examples=25, deadline=None)


def turned_strain(strain, angle):
    """Engineering Voigt strain turned counter-clockwise, by turning its matrix."""
    xx, yy, xy = strain
    R = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    e = R @ np.array([[xx, xy / 2], [xy / 2, yy]]) @ R.T
    return np.array([e[0, 0], e[1, 1], 2 * e[0, 1]])


# Constants ------------------------------------------------------------------------------------


def triangular_tensor(k):
    """C11 = 3√3k/4, C12 = C66 = √3k/4, whichever way the lattice lies."""
    return k * np.sqrt(3) / 4 * np.array([[3, 1, 0], [1, 3, 0], [0, 0, 1]])


@pytest.mark.parametrize("make", [patterns.square, patterns.triangular])
@table(("material", "message"), [
    (Isotropic(E=1.0, nu=0.3),
        "lattice: ratio 0.3 of its axes (plane_stress, nu = 0.3); central springs make it"),
    (Isotropic(E=1.0, nu=0.25),
        "at 0.333333 only (λ = μ): take nu = 1/3 in plane stress, 1/4 in plane strain"),
    (Isotropic(E=1.0, nu=1 / 3, state="plane_strain"), "ratio 0.5 of its axes (plane_strain"),
    (Isotropic(E=1.0, nu=0.5, state="plane_strain"), "ratio 1 of its axes (plane_strain"),
    (Isotropic(E=1.0, nu=0.25, state="solid"), "the material is a solid"),
    (Anisotropic(np.eye(3)), "the material must be isotropic"),
])  # fmt: skip
def test_a_material_that_the_lattice_cannot_be_is_refused_with_the_reason(make, material, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        isotropic_constants(material, make(), 1.0)


@pytest.mark.parametrize(
    ("name", "material", "message"),
    [
        ("square at 45°", Anisotropic(np.eye(3)), "the material is a tensor; give the constants"),
        ("kagome", THIRD, "none known for kagome; give the constants"),
    ],
)
def test_constants_that_are_not_known_must_be_given(name, material, message):
    lattice = replace(diagonal_square(Box((1.0, 1.0)), 2), name=name, unit_cell=None)
    with pytest.raises(ProblemError, match=f"spring constants: {message}"):
        default_constants(material, lattice)


# Homogenised tensors --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("rule", "expected"),
    [
        ("shared", square_tensor(0.7, 0.2)),
        ("equal", square_tensor(0.7, 0.2)),  # inside, nothing tells it from shared
        ("per_cell", square_tensor(1.4, 0.2)),  # shared edges carry two springs: k2/(2k1 + k2)
    ],
)
@pytest.mark.parametrize("cells", [1, (4, 2)])
def test_the_interior_of_a_lattice_has_one_tensor_at_any_size(rule, expected, cells):
    box = Box((2.0, 2.0) if cells == 1 else (2.0, 1.0))
    tensor = interior_tensor(square(box, cells), (0.7, 0.2), rule)
    np.testing.assert_allclose(tensor, expected, atol=EXACT)


@pytest.mark.parametrize(
    ("rule", "k"),
    [("shared", 0.8), ("equal", 0.8), ("per_cell", 1.6)],  # every inner spring borders two cells
)
@pytest.mark.parametrize("outline", [zigzag_block(1.0, (4, 5)), trapezium(0.2, (5, 3))], ids=str)
@pytest.mark.parametrize("spacing", [0.2, 0.1])
def test_the_interior_of_triangles_has_one_tensor_at_any_size(rule, k, outline, spacing):
    tensor = interior_tensor(triangular(outline, spacing), (0.8,), rule)
    np.testing.assert_allclose(tensor, triangular_tensor(k), atol=1e-14)


@pytest.mark.parametrize("n", [1, 2, 8])
def test_the_lattice_at_45_degrees_lacks_what_its_boundary_cut(n):
    # Of 2n² diagonals from middle to middle, 2n are cut: the share 1/(2n) of all diagonals.
    tensor = interior_tensor(diagonal_square(Box((3.0, 3.0)), n), (0.7, 0.2), "shared")
    expected = rotate_tensor(square_tensor(0.7, 0.2 * (1 - 1 / (2 * n))), np.pi / 4)
    np.testing.assert_allclose(tensor, expected, atol=EXACT)


@pytest.mark.parametrize("constants", [(0.7,), (0.7, 0.2, 0.1)])
def test_a_tensor_needs_one_constant_a_kind_of_spring(constants):
    with pytest.raises(ProblemError, match="spring constants"):
        interior_tensor(square(Box((1.0, 1.0)), 1), constants, "shared")


# Directions -----------------------------------------------------------------------------------


@examples
@given(angle=angles, strain=st.tuples(*[st.floats(-1, 1)] * 3))
def test_turning_body_and_strain_together_keeps_the_energy(angle, strain):
    strain = np.array(strain)
    turned = turned_strain(strain, angle)
    energy = turned @ rotate_tensor(CROOKED, angle) @ turned
    assert energy == pytest.approx(strain @ CROOKED @ strain, rel=EXACT, abs=EXACT)


@pytest.mark.parametrize(("k1", "k2"), [(1.0, 2.0), (1.0, 0.5), (3.0, 0.1)])
def test_ratio_along_the_axes_and_the_diagonals(k1, k2):
    C = square_tensor(k1, k2)
    for quarter in range(4):
        along_axis, along_diagonal = quarter * np.pi / 2, (quarter + 0.5) * np.pi / 2
        assert directional_ratio(C, along_axis) == pytest.approx(k2 / (k1 + k2), rel=EXACT)
        assert directional_ratio(C, along_diagonal) == pytest.approx(k1 / (k1 + 4 * k2), rel=EXACT)


@examples
@given(angle=angles)
def test_pulling_at_an_angle_is_turning_the_body_back(angle):
    compliance = np.linalg.inv(rotate_tensor(CROOKED, -angle))
    expected = -compliance[0, 1] / compliance[0, 0]
    # An inverse of a tensor of condition about 4.
    assert directional_ratio(CROOKED, angle) == pytest.approx(expected, abs=1e-12)


def test_an_angle_that_is_no_number_is_refused():
    with pytest.raises(ProblemError, match="angle: nan"):
        rotate_tensor(CROOKED, float("nan"))


def random_tensor(d):
    A = np.random.default_rng(d).normal(size=(d * (d + 1) // 2,) * 2)
    return A @ A.T + len(A) * np.eye(len(A))


@pytest.mark.parametrize("d", [2, 3])
def test_a_cubic_part_is_the_mean_over_turns_of_the_axes_into_each_other(d):
    C, pairs = random_tensor(d), {2: ((0, 0), (1, 1), (0, 1))}
    pairs[3] = ((0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1))
    named = {tuple(sorted(pair)): number for number, pair in enumerate(pairs[d])}
    mean, count = np.zeros_like(C), 0
    for axes in permutations(range(d)):
        for signs in product((1, -1), repeat=d):
            to = [named[tuple(sorted((axes[a], axes[b])))] for a, b in pairs[d]]
            sign = np.array([signs[a] * signs[b] for a, b in pairs[d]])
            mean += sign[:, None] * sign * C[np.ix_(to, to)]
            count += 1
    np.testing.assert_allclose(cubic_part(C), mean / count, atol=1e-13)


@pytest.mark.parametrize("d", [2, 3])
def test_a_modulus_is_that_of_the_body_turned_until_the_direction_is_x(d):
    C = random_tensor(d)
    ways = np.random.default_rng(7).normal(size=(len(C), d))
    ways /= np.linalg.norm(ways, axis=1)[:, None]
    one_by_one = [directional_modulus(C, way[None])[0] for way in ways]
    np.testing.assert_allclose(directional_modulus(C, ways), one_by_one, rtol=1e-13)
    along_x = 1 / np.linalg.inv(C)[0, 0]
    assert directional_modulus(C, np.eye(d)[:1])[0] == pytest.approx(along_x, rel=1e-12)
    if d == 2:
        angle = np.arctan2(ways[0, 1], ways[0, 0])
        turned = 1 / np.linalg.inv(rotate_tensor(C, -angle))[0, 0]
        assert one_by_one[0] == pytest.approx(turned, rel=1e-12)


@table("directions", [[[2.0, 0.0]], [1.0, 0.0], [[1.0, 0.0, 0.0]]])
def test_directions_that_are_no_unit_vectors_are_refused(directions):
    with pytest.raises(ProblemError, match=r"directions: shape .*; give unit vectors \(q, 2\)"):
        directional_modulus(CROOKED, directions)


def test_the_shear_modulus_of_a_sheet_has_its_thickness():
    assert shear_modulus(Isotropic(2e6, 0.25, thickness=0.2)) == pytest.approx(0.2 * 2e6 / 2.5)
