"""Spring constants that make a lattice isotropic by springs alone, or the nearest there are."""

from __future__ import annotations

import numpy as np
from scipy.optimize import least_squares, nnls

from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.springs.constants.homogenise import deforms_affinely, homogenise
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    CAUCHY,
    Moduli,
    axes_moduli,
    central_modulus,
    is_same_tensor,
    isotropic_moduli,
    isotropic_tensor,
    moduli,
    pattern_tensor,
)
from msvalidate.springs.lattice import Constants, Pattern

START = 1e-3
"""Smallest constant at the start of a search, relative to the largest.

At zero a spring would be missing.
"""


def isotropic_constants(material: Isotropic, pattern: Pattern, spacing: float) -> Constants:
    """Spring constants (N/m), one a kind, that make a pattern a material by springs alone.

    By the pattern's own rules where one leaves the material's ratio, or by search: linear where
    points follow a uniform strain, on the relaxed tensor elsewhere.

    Parameters
    ----------
    material, pattern
        What is to be, and what repeats.
    spacing
        Length (m) of the pattern's unit.

    Raises
    ------
    ProblemError
        With the reason and the nearest that there is, if there are none.
    """
    E, nu = axes_moduli(material, pattern.dim, f"{pattern.name} lattice")
    for rule in pattern.rules.values():
        solid = _isotropic_moduli(pattern, rule, spacing)
        if solid is not None and abs(nu - solid.nu) <= ALIKE:
            return tuple(k * E / solid.E for k in rule)
    if deforms_affinely(pattern):
        return _affine_constants(material, pattern, spacing)
    return _relaxed_constants(pattern, spacing, E, nu)


def _isotropic_moduli(pattern: Pattern, constants: Constants, spacing: float) -> Moduli | None:
    """Moduli of an isotropic solid; None of any other."""
    try:
        found = moduli(homogenise(pattern, constants, spacing).tensor)
    except ProblemError:
        return None
    return found if abs(found.zener - 1) <= ALIKE else None


def _affine_constants(material: Isotropic, pattern: Pattern, spacing: float) -> Constants:
    """Non-negative least squares: the tensor is linear in the constants, one column a kind."""
    d, what = pattern.dim, f"{pattern.name} lattice"
    target = isotropic_tensor(d, axes_moduli(material, d, what)[0], CAUCHY[d])
    kinds = np.eye(pattern.kinds)
    columns = [pattern_tensor(pattern, tuple(k), spacing).ravel() for k in kinds]
    constants, _ = nnls(np.column_stack(columns), target.ravel())
    tensor = (np.column_stack(columns) @ constants).reshape(target.shape)
    if not is_same_tensor(target, tensor):
        raise ProblemError(
            f"{what}: no spring constants make it isotropic, the nearest leave "
            f"{_describe_tensor(tensor)}; take another lattice, or give the constants"
        )
    central_modulus(material, d, what)
    return tuple(constants.tolist())


def _relaxed_constants(pattern: Pattern, spacing: float, E: float, nu: float) -> Constants:
    """Least squares on the tensor with the points at rest, from each of the pattern's rules."""
    if nu >= 1 / (pattern.dim - 1):
        raise ProblemError(
            f"{pattern.name} lattice: nu = {nu:.6g}; nothing is compressible, which takes an "
            "infinite constant: take a lower ratio"
        )
    target = isotropic_tensor(pattern.dim, E, nu)
    largest = float(np.abs(target).max())

    def misfit(constants: Array) -> Array:
        tensor = homogenise(pattern, tuple(constants), spacing).tensor
        return np.asarray((tensor - target).ravel() / largest)

    unit = largest * spacing ** (pattern.dim - 2)
    limits = {"ftol": None, "xtol": 1e-15, "gtol": 1e-15}
    tries = []
    for rule in pattern.rules.values():
        start = np.maximum(np.array(rule) / max(rule), START) * unit
        tries.append(least_squares(misfit, start, "3-point", (0, np.inf), x_scale=unit, **limits))
    # Of constants that are exact but for rounding, those of the first rule.
    exact = [fit for fit in tries if np.abs(fit.fun).max() <= ALIKE]
    best = exact[0] if exact else min(tries, key=lambda fit: float(fit.cost))
    solid = homogenise(pattern, tuple(best.x), spacing)
    if np.abs(best.fun).max() > ALIKE:
        nearest = np.where(best.x < 1e-12 * best.x.max(), 0.0, best.x)  # rounding
        raise ProblemError(
            f"{pattern.name} lattice: no spring constants make it isotropic at nu = {nu:.6g}; the "
            f"nearest found, {', '.join(f'{k:.3g}' for k in nearest)} N/m, leave "
            f"{_describe_tensor(solid.tensor)}: take a ratio nearer to those of its rules, or give "
            "the constants"
        )
    if solid.floppy:
        raise ProblemError(
            f"{pattern.name} lattice: nu = {nu:.6g}; the constants that it takes leave points "
            "loose: take another ratio, or give the constants"
        )
    return tuple(best.x.tolist())


def _describe_tensor(tensor: Array) -> str:
    """Describe a tensor in words."""
    try:
        mean = isotropic_moduli(tensor)
    except ProblemError:
        return "some strain without energy"
    return f"nu = {mean.nu:.6g} and a Zener ratio of {mean.zener:.6g}"
