"""Documented laws of simulators to first order, for requested E and nu.

A law is its first Piola-Kirchhoff stress P(F), as its source writes it, with Lamé's constants of
the asked E and nu put in as they stand. What solid that is at small strain is not typed in: it is
the derivative of P at F = I, by a complex step. So where constants of a law's energy are not those
of its small strain, the prediction shows it: of [SmithDeGoes2018] with its logarithm they come to
3/4 mu and lam - 5/8 mu, without it to mu and lam - mu.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import VOIGT, Array, ProblemError
from msvalidate.problem.checks import finite_number, positive_number, require_one_of
from msvalidate.problem.records import dataclass
from msvalidate.simulators.probe.reading import BAND, Elastic, elastic
from msvalidate.springs.constants import stiffness

Stress = Callable[[Array, float, float], Array]
"""F (..., 3, 3), real or complex, mu, lam (Pa) -> P (..., 3, 3) in Pa; analytic in F near I."""
STEP = 1e-30
"""Step of the complex derivative.

No difference is taken, so a small step loses no digits.
"""
POLAR_STEPS = 12
"""Number of Newton iterations for the rotation.

Convergence is quadratic: 30 % of strain takes five.
"""
ROUNDED = 1e-12
"""Relative error of a predicted stiffness: rounding of a few products."""
AT_REST = 1e-9
"""Stress at F = I over the stiffness, beyond which a law has no solid at rest there."""


@dataclass(frozen=True)
class Law:
    """A law as documented.

    Parameters
    ----------
    key, name, source
        Key: what `--law` takes too. Source: a key of docs/references.bib, or a program's file.
    stress
        P of F, mu, lam.
    """

    key: str
    name: str
    stress: Stress
    source: str


def lame(E: float, nu: float) -> tuple[float, float]:
    """Lamé's mu and lam (Pa) of E (Pa) and nu. Raises `ProblemError` where a solid has none."""
    nu = finite_number("law: nu", nu, above=-1.0, below=0.5)
    lam, mu = stiffness.lame(3, positive_number("law: E", E, "Pa"), nu)
    return mu, lam


def stress_of(law: str, E: float, nu: float) -> Callable[[Array], Array]:
    """P of F alone of a law of `LAWS` for E (Pa) and nu."""
    mu, lam = lame(E, nu)
    return lambda F: LAWS[law].stress(F, mu, lam)


def law_named(text: str) -> str:
    """Name of the law of a name or key; the text itself where there is none."""
    return next((name for name, law in LAWS.items() if text == law.key), text)


def nearest_law(E: float, nu: float, asked_E: float, asked_nu: float) -> str:
    """Name of the law that is nearest to E (Pa) and nu where it is asked for others; "" if none.

    Within `BAND`, of E relative and of nu absolute.
    """
    away = {"": BAND}
    for name in LAWS:
        law = predicted(name, asked_E, asked_nu)
        if law.E is None or law.nu is None:
            continue
        if max(abs(law.E / asked_E - 1), abs(law.nu - asked_nu)) > BAND / 10:  # else as asked
            away[name] = max(abs(E / law.E - 1), abs(nu - law.nu))
    return min(away, key=lambda name: away[name])


def predicted(law: str, E: float, nu: float) -> Elastic:
    """Elastic constants of a law of `LAWS` at small strain.

    The law is requested with E (Pa) and nu.

    Raises
    ------
    ProblemError
        For a law that is not there, E or nu out of range, or a law under stress at F = I.
    """
    require_one_of("law", law, LAWS)
    mu, lam = lame(E, nu)
    C = first_order(LAWS[law].stress, mu, lam)
    return elastic(C, ROUNDED * float(np.abs(C).max()))


def first_order(stress: Stress, mu: float, lam: float) -> Array:
    """Stiffness (6, 6) Pa at F = I, in order xx, yy, zz, yz, xz, xy with engineering strains.

    Raises
    ------
    ProblemError
        If P(I) is not 0.
    """
    rest = np.abs(stress(np.eye(3), mu, lam)).max()
    A = tangent(lambda F: stress(F, mu, lam), np.eye(3))
    A = (A + A.swapaxes(0, 1) + A.swapaxes(2, 3) + A.transpose(1, 0, 3, 2)) / 4
    first, second = np.transpose(VOIGT[3])
    C = A[first, second][:, first, second]
    if rest > AT_REST * np.abs(C).max():
        raise ProblemError(f"law: stress of {rest:.3g} Pa at F = I; it has no rest there")
    return np.asarray(C)


def tangent(stress: Callable[[Array], Array], F: Array) -> Array:
    """∂P/∂F (..., 3, 3, 3, 3) in Pa: Im P(F + i h G)/h, for h so small that h² is nothing."""
    found = np.empty((*F.shape, 3, 3))
    for k, m in np.ndindex(3, 3):
        change = np.zeros((3, 3), dtype=complex)
        change[k, m] = 1j * STEP
        found[..., k, m] = np.imag(stress(F + change)) / STEP
    return found


def _cofactor(F: Array) -> Array:
    """∂ det F/∂F, by cross products of columns: no inverse, and no conjugate."""
    a, b, c = np.moveaxis(F, -1, 0)
    return np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)


def _turned(F: Array) -> Array:
    return np.swapaxes(F, -1, -2)


def _times(number: Array, F: Array) -> Array:
    """A number for each F, times F."""
    return np.asarray(number)[..., None, None] * F


def _trace(F: Array) -> Array:
    return np.asarray(np.trace(F, axis1=-2, axis2=-1))


def _rotation(F: Array) -> Array:
    """R of F = R S by R ← (R + R⁻ᵀ)/2 [Higham2002], which is analytic in F: no conjugates."""
    R = F
    for _ in range(POLAR_STEPS):
        R = (R + _turned(np.asarray(np.linalg.inv(R)))) / 2
    return R


def _linear(F: Array, mu: float, lam: float) -> Array:
    e = (F + _turned(F)) / 2 - np.eye(3)
    return np.asarray(2 * mu * e + lam * _times(_trace(e), np.eye(3)))


def _corotated(F: Array, mu: float, lam: float) -> Array:
    R = _rotation(F)
    e = (_turned(R) @ F + _turned(F) @ R) / 2 - np.eye(3)
    return np.asarray(R @ (2 * mu * e + lam * _times(_trace(e), np.eye(3))))


def _fixed_corotated(F: Array, mu: float, lam: float) -> Array:
    volume = _times(lam * (np.linalg.det(F) - 1), _cofactor(F))
    return np.asarray(2 * mu * (F - _rotation(F)) + volume)


def _arap(F: Array, mu: float, lam: float) -> Array:  # noqa: ARG001  it has one constant
    return np.asarray(2 * mu * (F - _rotation(F)))


def _saint_venant(F: Array, mu: float, lam: float) -> Array:
    green = (_turned(F) @ F - np.eye(3)) / 2
    return np.asarray(F @ (2 * mu * green + lam * _times(_trace(green), np.eye(3))))


def _log_neo_hookean(F: Array, mu: float, lam: float) -> Array:
    inverse = _turned(np.asarray(np.linalg.inv(F)))
    return np.asarray(mu * (F - inverse) + lam * _times(np.log(np.linalg.det(F)), inverse))


def _smith(F: Array, mu: float, lam: float) -> Array:
    """W = mu/2 (I - 3 - ln(I + 1)) + lam/2 (J - 1 - 3/4 mu/lam)², I = tr FᵀF."""
    I1 = (F * F).sum(axis=(-2, -1))
    volume = lam * (np.linalg.det(F) - 1) - 0.75 * mu
    return mu * _times(1 - 1 / (I1 + 1), F) + _times(volume, _cofactor(F))


def _smith_corrected(F: Array, mu: float, lam: float) -> Array:
    """As `_smith` with 4/3 mu and lam + 5/6 mu, whose 3/4 and - 5/8 parts are mu and lam."""
    return _smith(F, 4 * mu / 3, lam + 5 * mu / 6)


def _simple(F: Array, mu: float, lam: float) -> Array:
    """W = mu/2 (I - 3) + lam/2 (J - 1 - mu/lam)²."""
    return mu * F + _times(lam * (np.linalg.det(F) - 1) - mu, _cofactor(F))


def _simple_corrected(F: Array, mu: float, lam: float) -> Array:
    return _simple(F, mu, lam + mu)


def _split(F: Array, mu: float, lam: float) -> Array:
    """W = mu/2 (J^(-2/3) I - 3) + K/2 (J - 1)², K the bulk modulus: shape and volume apart."""
    J = np.asarray(np.linalg.det(F))
    stretch = (F * F).sum(axis=(-2, -1))
    shape = F - _times(stretch / 3 / J, _cofactor(F))
    return _times(mu * J ** (-2 / 3), shape) + _times((lam + 2 * mu / 3) * (J - 1), _cofactor(F))


def _squares_and_volume(F: Array, mu: float, lam: float) -> Array:
    """W = mu/2 (I - 3)² + lam/2 (J - 1)²: the compliances 1/mu, 1/lam of two constraints."""
    stretch = (F * F).sum(axis=(-2, -1)) - 3
    return 2 * mu * _times(stretch, F) + _times(lam * (np.linalg.det(F) - 1), _cofactor(F))


NEWTON = "newton 1.8.0, newton/_src/solvers"
DRAKE = "drake, multibody/fem"
LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        Law("linear", "linear", _linear, "[TimoshenkoGoodier1970]"),
        Law("corotated", "corotated", _corotated,
            f"{DRAKE}/linear_corotated_model.cc, its rotation at F"),
        Law("fixed-corotated", "fixed corotated", _fixed_corotated, f"{DRAKE}/corotated_model.cc"),
        Law("arap", "as rigid as possible", _arap, "2 mu (F - R), without a volume term"),
        Law("stvk", "Saint Venant-Kirchhoff", _saint_venant, "[Crisfield1991]"),
        Law("neo-log", "neo-Hookean, log J", _log_neo_hookean, "[SimoPister1984]"),
        Law("smith-raw", "Smith's neo-Hookean, Lamé's constants as they stand", _smith,
            "[SmithDeGoes2018]; bullet3, src/BulletSoftBody/btDeformableNeoHookeanForce.h, "
            f"firstPiola; {NEWTON}/semi_implicit/kernels_particle.py:250, eval_tetrahedra"),
        Law("smith", "Smith's neo-Hookean, constants of small strain", _smith_corrected,
            "[SmithDeGoes2018]"),
        Law("neo-raw", "neo-Hookean without logarithm, Lamé's constants as they stand", _simple,
            f"{DRAKE}/neohookean_model.cc, CalcFirstPiolaStressImpl"),
        Law("neo", "neo-Hookean without logarithm, lam + mu", _simple_corrected,
            f"{NEWTON}/vbd/particle_vbd_kernels.py:184, "
            "evaluate_volumetric_neo_hookean_force_and_hessian"),
        Law("neo-split", "neo-Hookean of shape and volume apart", _split,
            "felupe, constitution/hyperelasticity/_neo_hooke_nearly_incompressible.py"),
        Law("constraints", "two constraints, I - 3 and J - 1", _squares_and_volume,
            f"{NEWTON}/xpbd/kernels.py:494, solve_tetrahedra, at convergence"),
    )
}  # fmt: skip
"""Name -> law."""
