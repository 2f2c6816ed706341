"""Constants of central springs that make a lattice an isotropic material.

Where every point is a centre of symmetry the tensor is linear in the constants and obeys Cauchy's
relation λ = μ: one ratio, 1/3 in the plane and 1/4 in a solid. Elsewhere the points at rest leave
other ratios: honeycomb (k1 + 3 k2)/(k1 + 9 k2), between 1/3 and 1.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
from scipy.optimize import least_squares, nnls

from msvalidate.constants.homogenise import deforms_affinely, homogenise
from msvalidate.constants.stiffness import (
    ALIKE,
    CAUCHY,
    Moduli,
    in_plane_moduli,
    is_same_tensor,
    isotropic_moduli,
    isotropic_tensor,
    moduli,
    pattern_tensor,
    square_constants,
    triangular_constants,
)
from msvalidate.lattice import Constants, Pattern
from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.material import State
from msvalidate.problem.records import dataclass

CLOSED: Mapping[str, Callable[[Isotropic], Constants]] = {
    "square": square_constants,
    "triangular": triangular_constants,
}
"""Patterns whose constants have a closed form."""
START = 1e-3
"""Least constant to start a search from, relative to the largest: at zero springs are gone."""


@dataclass(frozen=True)
class Target:
    """An isotropic material as a lattice's own axes see it: what constants are sought for.

    Parameters
    ----------
    E, nu
        Of the lattice's axes: in-plane ones, E in N/m with the thickness, or the solid's, in Pa.
    material
        What is asked for, to name it and to give its closed form.
    """

    E: float
    nu: float
    material: Isotropic


def target_of(material: Isotropic, pattern: Pattern) -> Target:
    """A material as a pattern's axes see it.

    Raises
    ------
    ProblemError
        If the material is of another dimension.
    """
    if pattern.dim == 2:
        return Target(*in_plane_moduli(material), material)
    if material.state != "solid":
        raise ProblemError(f"{pattern.name} lattice: material in {material.state}; give a solid")
    return Target(material.E, material.nu, material)


def target_at_cauchy(mu: float, pattern: Pattern) -> Target:
    """The material of a shear modulus (N/m or Pa) with the ratio that central springs have."""
    nu = CAUCHY[pattern.dim]
    state: State = "plane_stress" if pattern.dim == 2 else "solid"
    return target_of(Isotropic(2 * mu * (1 + nu), nu, state), pattern)


def edge_constants(material: Isotropic) -> tuple[float]:
    """The constant of a spring per edge of a mesh: E·t (N/m) in the plane, E (Pa) in space.

    Raises
    ------
    ProblemError
        If the ratio is not the one of central springs, 1/3 in the plane or 1/4 in space.
    """
    d = material.dim
    E, nu = in_plane_moduli(material) if d == 2 else (material.E, material.nu)
    if abs(nu - CAUCHY[d]) > ALIKE:
        raise ProblemError(
            f"springs along a mesh's edges: ratio {nu:.6g} ({material.state}, nu = "
            f"{material.nu:g}); their mean over directions has {CAUCHY[d]:.6g} only: take that, or "
            "give the constant"
        )
    return (E,)


def isotropic_constants(target: Target, pattern: Pattern, spacing: float) -> Constants:
    """Spring constants (N/m), one a kind, that make a pattern a material by springs alone.

    By closed form where there is one, by the pattern's own rules where one leaves the material's
    ratio, or by search: linear where points follow a uniform strain, on the relaxed tensor
    elsewhere.

    Parameters
    ----------
    target, pattern
        What is to be, and what repeats.
    spacing
        Length (m) of the pattern's unit.

    Raises
    ------
    ProblemError
        With the reason and the nearest that there is, if there are none.
    """
    E, nu = target.E, target.nu
    if pattern.name in CLOSED:
        return CLOSED[pattern.name](target.material)
    for rule in pattern.rules.values():
        solid = _isotropic_moduli(pattern, rule, spacing)
        if solid is not None and abs(nu - solid.nu) <= ALIKE:
            return tuple(k * E / solid.E for k in rule)
    if deforms_affinely(pattern):
        return _affine_constants(pattern, spacing, E, nu)
    return _relaxed_constants(pattern, spacing, E, nu)


def _isotropic_moduli(pattern: Pattern, constants: Constants, spacing: float) -> Moduli | None:
    """Moduli of an isotropic solid; None of any other."""
    try:
        found = moduli(homogenise(pattern, constants, spacing).tensor)
    except ProblemError:
        return None
    return found if abs(found.zener - 1) <= ALIKE else None


def _affine_constants(pattern: Pattern, spacing: float, E: float, nu: float) -> Constants:
    """Non-negative least squares: the tensor is linear in the constants, one column a kind."""
    d, cauchy = pattern.dim, CAUCHY[pattern.dim]
    target = isotropic_tensor(d, E, cauchy)
    kinds = np.eye(pattern.kinds)
    columns = [pattern_tensor(pattern, tuple(k), spacing).ravel() for k in kinds]
    constants, _ = nnls(np.column_stack(columns), target.ravel())
    tensor = (np.column_stack(columns) @ constants).reshape(target.shape)
    if not is_same_tensor(target, tensor):
        raise ProblemError(
            f"{pattern.name} lattice: no spring constants make it isotropic, the nearest leave "
            f"{_describe_tensor(tensor)}; take another lattice, or give the constants"
        )
    if abs(nu - cauchy) > ALIKE:
        raise ProblemError(
            f"{pattern.name} lattice: nu = {nu:.6g}; central springs make it isotropic at "
            f"{cauchy:.6g} only (λ = μ): take that ratio or a volume energy, or give "
            "the constants"
        )
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
    exact = [found for found in tries if np.abs(found.fun).max() <= ALIKE]
    best = exact[0] if exact else min(tries, key=lambda found: float(found.cost))
    solid = homogenise(pattern, tuple(best.x), spacing)
    if np.abs(best.fun).max() > ALIKE:
        raise ProblemError(
            f"{pattern.name} lattice: no spring constants make it isotropic at nu = {nu:.6g}; the "
            f"nearest found, {', '.join(f'{k:.3g}' for k in best.x)} N/m, leave "
            f"{_describe_tensor(solid.tensor)}: take a ratio nearer to those of its rules, or give "
            f"the "
            "constants"
        )
    if solid.floppy:
        raise ProblemError(
            f"{pattern.name} lattice: nu = {nu:.6g}; the constants that it takes leave points "
            "loose: take another ratio, or give the constants"
        )
    return tuple(best.x.tolist())


def _describe_tensor(tensor: Array) -> str:
    """What a tensor is, in words."""
    try:
        mean = isotropic_moduli(tensor)
    except ProblemError:
        return "some strain without energy"
    return f"nu = {mean.nu:.6g} and a Zener ratio of {mean.zener:.6g}"
