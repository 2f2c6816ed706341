"""Exponents at corners, against closed forms and a weak form that shares nothing with Stroh's."""

from __future__ import annotations

import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.polynomial import legendre
from scipy.interpolate import BSpline
from scipy.optimize import brentq

from msvalidate.constants.directions import rotate_tensor
from msvalidate.judging.singularity import clamped_free_exponent
from msvalidate.problem import ProblemError, SolverError
from tests.table import table

TURN = 2 * np.pi
# No symmetry at all; a cubic one far from isotropy; fibres along x.
CROOKED = np.array([[3.0, 0.5, 0.4], [0.5, 2.0, -0.3], [0.4, -0.3, 1.0]])
CUBIC = np.array([[3.0, 2.0, 0.0], [2.0, 3.0, 0.0], [0.0, 0.0, 2.0]])
FIBRES = np.array([[8.0, 0.5, 0.0], [0.5, 1.0, 0.0], [0.0, 0.0, 0.5]])
ANISOTROPIC = pytest.mark.parametrize(
    "tensor", [CROOKED, CUBIC, FIBRES], ids=["crooked", "cubic", "fibres"]
)
EXACT = 1e-10  # rounding of 1e-16, times condition numbers up to 1e3 of tensor and eigenproblem
SPLINES = 1e-6  # error of the weak form's splines, worst for fibres in a wide wedge: 2e-7

angles = st.floats(0.05, TURN)
directions = st.floats(-np.pi, np.pi)
examples = settings(max_examples=20, deadline=None)


def plane_stress(nu):
    return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)


def exponent(tensor, angle, direction):
    """Of a wedge whose clamped side has a direction: that of the material turned back."""
    return clamped_free_exponent(rotate_tensor(tensor, -direction), angle)


def smallest_zero(f, angle):
    """Smallest real part > 0 of a zero of an entire f, by Newton's method from many places."""
    x, y = np.meshgrid(np.linspace(0.1, 4, 40), np.linspace(0, 3, 16))
    z = ((x + 1j * y) / angle).ravel()
    step = 1e-6 / angle
    with np.errstate(all="ignore"):  # some starts run away
        for _ in range(60):
            z = z - f(z) * 2 * step / (f(z + step) - f(z - step))
        zeros = z[(np.abs(f(z)) < 1e-12) & (z.real > 0.01)]
    return zeros.real.min()


def weak_form_exponent(tensor, angle, direction):
    """Smallest exponent by Galerkin's method in θ, for displacements alone: splines of degree 14.

    Strain of r^λ f(θ) is r^(λ-1) (λ A f + B f'), with A and B the symmetric products with the
    directions of r and θ. Tested with ρ(r) g(θ), ρ of compact support: for every g,

        ∫ (B g' - λ A g)ᵀ C (λ A f + B f') dθ = 0.
    """
    degree, pieces = 14, 50
    breaks = np.linspace(direction, direction + angle, pieces + 1)
    x, weight = legendre.leggauss(18)
    theta = (breaks[:-1, None] + angle / pieces * (1 + x) / 2).ravel()
    weight = np.tile(weight * angle / pieces / 2, pieces)
    knots = np.pad(breaks, degree, mode="edge")
    splines = BSpline(knots, np.eye(pieces + degree), degree)
    f, slope = splines(theta)[:, 1:], splines.derivative()(theta)[:, 1:]  # 0 where it is clamped
    c, s = np.cos(theta), np.sin(theta)
    zero = np.zeros_like(c)
    A = np.array([[c, zero], [zero, s], [s, c]])
    B = np.array([[-s, zero], [zero, c], [c, -s]])
    strain_r = np.einsum("abq,qj->qajb", A, f).reshape(len(theta), 3, -1)
    strain_t = np.einsum("abq,qj->qajb", B, slope).reshape(len(theta), 3, -1)

    def energy(first, second):
        return np.einsum("q,qai,ab,qbj->ij", weight, first, tensor, second, optimize=True)

    K0, K1, K2 = energy(strain_t, strain_t), energy(strain_t, strain_r), energy(strain_r, strain_r)
    one, nought = np.eye(len(K0)), np.zeros_like(K0)
    inverse = np.linalg.inv(K2)
    found = np.linalg.eigvals(np.block([[nought, one], [inverse @ K0, inverse @ (K1 - K1.T)]]))
    # Large eigenvalues are those of the splines.
    return found[(found.real > 1e-3) & (np.abs(found) < 10 / angle)].real.min()


# Closed forms ---------------------------------------------------------------------------------


@pytest.mark.parametrize("nu", [-0.5, 0.1, 1 / 3, 0.5, 0.9])
@pytest.mark.parametrize("degrees", [10, 45, 60, 90, 120, 150, 180, 270, 330, 359])
def test_clamped_free_wedges_are_williams(nu, degrees):
    """Real and complex: sin²(λα) = ((κ + 1)² - 4λ² sin²α)/(4κ), κ = (3 - nu)/(1 + nu)."""
    angle, kappa = np.deg2rad(degrees), (3 - nu) / (1 + nu)

    def williams(z):
        return np.sin(z * angle) ** 2 - ((kappa + 1) ** 2 - (2 * z * np.sin(angle)) ** 2) / (
            4 * kappa
        )

    found = clamped_free_exponent(plane_stress(nu), angle)
    assert found == pytest.approx(smallest_zero(williams, angle), rel=EXACT)


def test_known_values():
    # The 90° corner of a clamped block at nu = 1/3 gives order 1.489.
    assert 2 * clamped_free_exponent(plane_stress(1 / 3), np.pi / 2) == pytest.approx(1.4895, 1e-5)


@ANISOTROPIC
def test_a_crack_clamped_on_one_side_has_a_quarter_whatever_the_material(tensor):
    # 1/4 ± iε.
    assert clamped_free_exponent(tensor, TURN) == pytest.approx(0.25, rel=EXACT)


@pytest.mark.parametrize("tensor", [plane_stress(1 / 3), plane_stress(0.6), FIBRES])
def test_a_corner_is_regular_where_uniaxial_stress_does_not_stretch_the_clamped_side(tensor):
    """Stress along the free side, at α, strains the clamped one by cos²α - nu sin²α = 0."""

    def stretch(angle):
        c, s = np.cos(angle), np.sin(angle)
        return np.linalg.solve(tensor, [c * c, s * s, c * s])[0]

    angle = brentq(stretch, 0.5, np.pi / 2, xtol=1e-15)
    assert clamped_free_exponent(tensor, angle) == pytest.approx(1.0, rel=EXACT)


# Any tensor -----------------------------------------------------------------------------------


@ANISOTROPIC
@pytest.mark.parametrize("angle", [0.3, np.pi / 2, 2.5, 3.5, 1.5 * np.pi, 6.0])
def test_wedges_agree_with_a_weak_form(tensor, angle):
    direction = 0.7  # along no axis of symmetry
    expected = weak_form_exponent(tensor, angle, direction)
    assert exponent(tensor, angle, direction) == pytest.approx(expected, rel=SPLINES)


@examples
@given(angle=angles, direction=directions)
def test_either_side_may_be_the_clamped_one(angle, direction):
    """Reciprocity. Mirrored in x, the wedge has its sides in the other order."""
    mirrored = CROOKED * np.outer([1, 1, -1], [1, 1, -1])
    other = exponent(mirrored, angle, -direction - angle)
    assert other == pytest.approx(exponent(CROOKED, angle, direction), rel=EXACT)


@pytest.mark.parametrize("unit", [1e-9, 1e11])
def test_the_unit_of_stiffness_does_not_matter(unit):
    scaled = clamped_free_exponent(unit * CROOKED, 4.0)
    assert scaled == pytest.approx(clamped_free_exponent(CROOKED, 4.0), rel=EXACT)


def test_an_isotropic_tensor_is_the_limit_of_others():
    """Stroh's eigenvectors coalesce there; the exponent does not notice."""
    isotropic = clamped_free_exponent(plane_stress(0.3), 4.0)
    nearly = clamped_free_exponent(plane_stress(0.3) + np.diag([0.0, 0.0, 1e-7]), 4.0)
    assert nearly == pytest.approx(isotropic, rel=1e-6)
    assert nearly != isotropic


def test_nearly_singular_tensors_keep_their_digits():
    """As Williams, at the nu where a plane body does not change its area."""
    nu, angle = 1 - 1e-6, np.pi / 2
    kappa = (3 - nu) / (1 + nu)
    found = clamped_free_exponent(plane_stress(nu), angle)
    assert np.sin(found * angle) ** 2 == pytest.approx(
        ((kappa + 1) ** 2 - 4 * found**2) / (4 * kappa), rel=1e-9
    )


# Refusals -------------------------------------------------------------------------------------


@table(
    ("tensor", "angle", "message"),
    [
        (np.eye(6), 1.0, "stiffness tensor C: shape (6, 6); give a plane one, (3, 3)"),
        (np.diag([1.0, np.nan, 1.0]), 1.0, "stiffness tensor C: nan at index (1, 1)"),
        (np.diag([1.0, -1.0, 1.0]), 1.0, "stiffness tensor C: lowest eigenvalue -1"),
        (np.eye(3) + np.eye(3, k=1), 1.0, "stiffness tensor C: not symmetric"),
        (CUBIC, 0.0, "wedge angle: 0.0 rad; it must be above zero"),
        (CUBIC, 90.0, "wedge angle: 90.0 rad; give at most 2 pi, the angle of a crack"),
        (CUBIC, np.inf, "wedge angle: inf; every value must be finite"),
    ],
)
def test_what_is_no_wedge_is_refused(tensor, angle, message):
    with pytest.raises(ProblemError, match=re.escape(message)):
        clamped_free_exponent(tensor, angle)


def test_a_tensor_too_close_to_singular_is_refused():
    with pytest.raises(SolverError, match="eigenvalues go from 1e-09 to 1; the corner"):
        clamped_free_exponent(np.diag([1.0, 1.0, 1e-9]), 1.0)


def test_last_digits_do_not_go_by_what_ran_before():
    """SciPy's logarithm takes its degree by NumPy's global random numbers: here of two."""
    tensor = np.array([[26, 14, 0], [14, 26, 0], [0, 0, 14]]) / 3  # of cubic cells of equal springs
    found = set()
    for seed in range(100):
        np.random.seed(seed)  # noqa: NPY002
        found.add(clamped_free_exponent(tensor, np.pi / 2))
        drawn = np.random.random()  # noqa: NPY002
        np.random.seed(seed)  # noqa: NPY002
        assert drawn == np.random.random(), "nobody else's numbers are drawn"  # noqa: NPY002
    assert len(found) == 1
