"""Two routes from a pattern to an isotropic material, or why one does not lead there.

The first is taken where it leads to the material, or else the second:

- ``springs``: central springs alone. Where every point is a centre of symmetry they obey Cauchy's
  relation λ = μ, so there is one ratio: 1/3 in the plane, 1/4 in a solid.
- ``volume energy``: springs that carry λ = μ, and beside them an energy ½ κ V0 (V/V0 - 1)² a cell,
  which resists nothing but a change of its volume: κ = λ - μ brings any ratio (the idea is that of
  [Golec2020]). With E and nu of the d axes, in-plane ones for d=2,

      κ = E ((d + 1) nu - 1) / (2 (1 + nu) (1 - (d - 1) nu)).

What is said of E, nu and the anisotropy is read off the tensor that the constants make.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from msvalidate.constants.calibration import Calibration
from msvalidate.constants.homogenise import deforms_affinely, homogenise
from msvalidate.constants.spring_constants import Target, isotropic_constants, target_at_cauchy
from msvalidate.constants.stable_range import least_stable_volume
from msvalidate.constants.stiffness import ALIKE, UNIT, moduli
from msvalidate.lattice import Constants, Pattern
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_one_of


def calibrate_by_first_route(target: Target, pattern: Pattern, spacing: float) -> Calibration:
    """By springs alone where they will do, or else with a volume energy.

    Parameters
    ----------
    target, pattern
        What is to be, and of what.
    spacing
        Length (m) of the pattern's unit.

    Raises
    ------
    ProblemError
        If neither leads there.
    """
    try:
        return _springs_alone(target, pattern, spacing)
    except ProblemError:
        if not deforms_affinely(pattern):
            raise
        return _with_volume_energy(target, pattern, spacing)


def _springs_alone(target: Target, pattern: Pattern, spacing: float) -> Calibration:
    constants = isotropic_constants(target, pattern, spacing)
    tensor = homogenise(pattern, constants, spacing).tensor
    return _calibration(target, pattern, spacing, constants, 0.0, "springs", tensor)


def _with_volume_energy(target: Target, pattern: Pattern, spacing: float) -> Calibration:
    """Springs of the material's μ at Cauchy's ratio; κ = λ - μ."""
    E, nu, d = target.E, target.nu, pattern.dim
    _refuse_loose_points(pattern)
    room = 1 - (d - 1) * nu
    if room <= 0:
        raise ProblemError(
            f"{pattern.name} lattice: nu = {target.material.nu:g} in {target.material.state}; "
            "nothing is compressible, and κ would be infinite: take nu below 1/2, such as 0.499"
        )
    kappa = E * ((d + 1) * nu - 1) / (2 * (1 + nu) * room)
    springs = _cauchy_springs(E / (2 * (1 + nu)), pattern, spacing)
    normal = np.arange(len(springs.tensor)) < d
    tensor = springs.tensor + kappa * np.outer(normal, normal)
    return _calibration(target, pattern, spacing, springs.constants, kappa, "volume energy", tensor)


ROUTES: Mapping[str, Callable[[Target, Pattern, float], Calibration]] = {
    "springs": _springs_alone,
    "volume energy": _with_volume_energy,
}
"""The ways to give a lattice the moduli of a material."""


def check_route(route: str) -> None:
    """Raise `ProblemError` for a name that is no route."""
    if route == "shear springs":
        raise ProblemError("route: 'shear springs' is gone; take 'volume energy'")
    require_one_of("route", route, ROUTES)


def _calibration(
    target: Target,
    pattern: Pattern,
    spacing: float,
    constants: Constants,
    volume: float,
    route: str,
    tensor: Array,
) -> Calibration:
    """The material, of the state and thickness asked for, that a tensor is."""
    material, found = target.material, moduli(tensor)
    E, nu = found.E / material.thickness, found.nu
    if material.state == "plane_strain":
        nu = nu / (1 + nu)
        E *= 1 - nu**2
    return Calibration(
        constants=constants,
        volume=volume,
        E=E,
        nu=nu,
        zener=found.zener,
        route=route,
        tensor=tensor,
        lattice=pattern.name,
        spacing=spacing,
        thickness=material.thickness,
    )


def _cauchy_springs(mu: float, pattern: Pattern, spacing: float) -> Calibration:
    """Springs of a shear modulus (N/m or Pa) and the ratio that central springs have."""
    return _springs_alone(target_at_cauchy(mu, pattern), pattern, spacing)


def refuse_soft_cells(pattern: Pattern, spacing: float, found: Calibration) -> None:
    """Raise `ProblemError` where κ is too far below zero for points between the cells' corners."""
    d, mu = pattern.dim, found.tensor[-1, -1]
    least = least_stable_volume(pattern, found.constants) / spacing ** (d - 2)
    if found.volume > least * (1 - ALIKE):
        return
    ratio = least / mu + 1  # λ/μ
    raise ProblemError(
        f"{pattern.name} lattice: nu = {found.nu:.6g} takes κ = {found.volume:.6g} {UNIT[d]} in "
        f"its cells, unstable from {least:.6g} down, for its points are not all corners of cells: "
        f"take a ratio along its axes above {ratio / ((d - 1) * ratio + 2):.6g}"
    )


def _refuse_loose_points(pattern: Pattern) -> None:
    if not deforms_affinely(pattern):
        raise ProblemError(
            f"{pattern.name} lattice: its points move on in a uniform strain, and more so with "
            "what is added to its springs; take one whose points are centres of symmetry, or route "
            "'springs'"
        )
