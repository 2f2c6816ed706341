"""Exponents of stress singularities at corners of a 2D elastic body.

At a corner the displacement is a sum of terms r^λ f(θ), r the distance to it. The smallest λ > 0 is
its exponent: below 1 the stress grows like r^(λ-1), and the displacement far from the corner has on
uniform meshes and lattices an error of order 2λ in the spacing, where smooth bodies may do better.

Voigt order xx, yy, xy with engineering shear strain; only ratios of the tensor's entries matter.
Exponents of isotropic wedges are in [Williams1952]; those of any tensor come from Stroh's formalism
[Ting1996]. With stress functions φ, zero along a free side, σ_i1 = -∂φ_i/∂y and σ_i2 = ∂φ_i/∂x, the
state (u, φ) = r^λ w(θ) obeys

    dw/dθ = λ N(θ) w    with    N = | -T⁻¹Rᵀ   T⁻¹   |,    R_ik = C_ijkl m_j n_l,
                                    | -E m mᵀ  -RT⁻¹ |     T_ik = C_ijkl n_j n_l,

m and n the directions of growing r and θ, E the modulus in uniaxial stress along m. The matrices N
of all directions commute, so the state crosses the wedge by exp(λM), M = ∫ N dθ. That holds for
isotropic tensors too, where Stroh's eigenvectors are too few.
"""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray
from scipy.linalg import eigvals, logm

from msvalidate.problem import Anisotropic, Array, ProblemError, SolverError
from msvalidate.problem.checks import finite, positive_number

DISPLACEMENT, STRESS = slice(0, 2), slice(2, 4)
"""The halves of a state (u, φ)."""
DEGREE = 32
"""Degree of the polynomials for w; the smallest exponents are exact to rounding."""
RESOLVED = 0.75 * DEGREE
"""Largest growth |λ| ρ(M) across the wedge that polynomials of that degree follow."""
NARROWEST = 1e-3
"""Smallest wedge angle (rad): the narrower, the nearer the state's crossing is to no change."""
CONDITION = 1e8
"""Largest condition number of a tensor; up to it the smallest exponents stay below `RESOLVED`."""


def clamped_free_exponent(tensor: Array, angle: float) -> float:
    """Exponent of the displacement where a clamped side along x meets a free one.

    Clamping the other side of the same wedge instead gives the same exponent (reciprocity).

    Source: [Williams1952] for isotropic wedges, [Ting1996] for any tensor.

    Parameters
    ----------
    tensor
        (3, 3) plane stiffness in any unit, symmetric and positive definite.
    angle
        Opening of the wedge in rad, in (0, 2π]: counter-clockwise from the clamped to the free
        side, through the material.

    Returns
    -------
    float
        The smallest real part > 0 of all exponents, real or complex. Its relative error is at
        most about 1e-15 times the condition number of the tensor.

    Raises
    ------
    ProblemError
        If the tensor or the angle is not as described.
    SolverError
        If the tensor is too close to singular, its condition number above 1e8, or the angle is
        below 1e-3.
    """
    return float(_exponents(_generator(tensor, angle)).real.min())


def _generator(tensor: Array, angle: float) -> Array:
    """M = ∫ N dθ, (4, 4), over the wedge that opens by `angle` from x."""
    C = _scaled_tensor(tensor)
    opening = positive_number("wedge angle", angle, "rad")
    if opening > 2 * np.pi:
        raise ProblemError(f"wedge angle: {angle} rad; give at most 2 pi, the angle of a crack")
    if opening < NARROWEST:
        raise SolverError(
            f"wedge angle: {opening:g} rad; below {NARROWEST:g} exponents are lost in rounding"
        )
    # cos h + sin h N(θ) has the logarithm ∫ N from θ to θ + h, the principal one if h < π.
    h = opening / 3
    parts = [np.cos(h) * np.eye(4) + np.sin(h) * _stroh_matrix(C, i * h) for i in range(3)]
    return np.asarray(sum(_logarithm(part) for part in parts))


def _logarithm(matrix: Array) -> Array:
    """The principal logarithm, real.

    SciPy estimates norms, by which it chooses its degree, from NumPy's global random numbers: from
    the same ones each time, last digits do not go by what ran before.
    """
    before = np.random.get_state()  # noqa: NPY002  the generator that SciPy takes them from
    np.random.seed(0)  # noqa: NPY002
    try:
        return np.asarray(logm(matrix).real)
    finally:
        np.random.set_state(before)  # noqa: NPY002


def _scaled_tensor(tensor: Array) -> Array:
    """The tensor (3, 3), checked, in a unit that gives displacements and stresses like sizes."""
    C = finite("stiffness tensor C", tensor)
    if C.shape != (3, 3):
        raise ProblemError(f"stiffness tensor C: shape {C.shape}; give a plane one, (3, 3)")
    # In a unit near its own, a power of two, products of eigenvalues are ordinary numbers.
    _, power = np.frexp(np.abs(Anisotropic(C).C).max())
    C = np.ldexp(C, -power)
    lowest, _, highest = np.linalg.eigvalsh(C)
    if highest > CONDITION * lowest:
        raise SolverError(
            f"stiffness tensor C: its eigenvalues go from {np.ldexp(lowest, power):g} to "
            f"{np.ldexp(highest, power):g}; the corner exponent needs a ratio of at most "
            f"{CONDITION:g}"
        )
    return np.asarray(C / np.sqrt(lowest * highest))


def _stroh_matrix(C: Array, theta: float) -> Array:
    """N(θ), (4, 4).

    Source: the fundamental elasticity matrix, [Ting1996]; [Stroh1962].
    """
    c, s = np.cos(theta), np.sin(theta)
    along, across = np.array([[c, 0, s], [0, s, c]]), np.array([[-s, 0, c], [0, c, -s]])
    R, T = along @ C @ across.T, across @ C @ across.T
    m, uniaxial = np.array([c, s]), np.array([c * c, s * s, c * s])
    # Not as R T⁻¹ Rᵀ - Q, where E would be lost in cancellation if C is nearly singular.
    E = 1 / (uniaxial @ np.linalg.solve(C, uniaxial))
    return np.block(
        [
            [-np.linalg.solve(T, R.T), np.linalg.inv(T)],
            [-E * np.outer(m, m), -np.linalg.solve(T, R.T).T],
        ]
    )


def _exponents(generator: Array) -> NDArray[np.complex128]:
    """All resolved λ with real part > 0 for which a state survives both sides' conditions.

    dw/ds = λ M w on 0 < s < 1 with u(0) = 0 and φ(1) = 0, by collocation at Gauss points: linear
    in λ, so all exponents, real and complex, are eigenvalues of one pencil.
    """
    points, _ = legendre.leggauss(DEGREE)
    value = legendre.legvander(points, DEGREE)
    # On -1 < x < 1, where the polynomials live, d/ds is 2 d/dx.
    slope = 2 * legendre.legvander(points, DEGREE - 1) @ legendre.legder(np.eye(DEGREE + 1))
    start, end = legendre.legvander(np.array([-1.0, 1.0]), DEGREE)
    one = np.eye(4)
    sides = np.vstack([np.kron(start, one[DISPLACEMENT]), np.kron(end, one[STRESS])])
    derivative = np.vstack([np.kron(slope, one), sides])
    growth = np.vstack([np.kron(value, generator), np.zeros_like(sides)])
    exponents = eigvals(derivative, growth)
    radius = np.abs(np.linalg.eigvals(generator)).max()
    return np.asarray(exponents[(exponents.real > 1e-3) & (np.abs(exponents) * radius < RESOLVED)])


def clamped_edge_exponent(tensor: Array) -> float:
    """Stress exponent at an edge of a cubic body with one clamped side.

    The sides lie along the axes of the material.

    In planes across the edge the strain is plane; shear along the edge has 1 there, as in any right
    angle between a clamped side and a free one.

    Source: `clamped_free_exponent` in the planes across the edge.

    Parameters
    ----------
    tensor
        (6, 6) stiffness of cubic symmetry in any unit.

    Raises
    ------
    ProblemError
        If it is no such tensor, or its plane part has no exponent.
    """
    C = finite("tensor", tensor)
    if C.shape != (6, 6):
        raise ProblemError(f"tensor: shape {C.shape}; give a solid's, (6, 6)")
    plane = np.array([[C[0, 0], C[0, 1], 0.0], [C[0, 1], C[1, 1], 0.0], [0.0, 0.0, C[5, 5]]])
    return clamped_free_exponent(plane, np.pi / 2)
