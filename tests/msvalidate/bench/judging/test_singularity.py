"""Exponents at corners, against closed forms and a weak form that shares nothing with Stroh's."""

from __future__ import annotations

import re

import numpy as np
import pytest

from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.problem import ProblemError, SolverError
from tests.table import table

CUBIC = np.array([[3.0, 2.0, 0.0], [2.0, 3.0, 0.0], [0.0, 0.0, 2.0]])
EXACT = 1e-10  # rounding of 1e-16, times condition numbers up to 1e3 of tensor and eigenproblem


def plane_stress(nu):
    return np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) / (1 - nu**2)


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


# Any tensor -----------------------------------------------------------------------------------


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
