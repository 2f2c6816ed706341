"""Which solid the springs of a lattice with given constants are."""

from __future__ import annotations

import math
import textwrap
from itertools import product

import numpy as np

from msvalidate.case.advise.advice import WHOSE, block_frequency, step_limits, step_words
from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.checks import finite_number, length_in_metres, require_one_of
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.directions import directional_modulus
from msvalidate.springs.constants.homogenise import Homogenised, homogenise
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    AXES_OF,
    UNIT,
    is_same_tensor,
    isotropic_moduli,
    isotropic_part,
)
from msvalidate.springs.constants.waves import least_stable_volume
from msvalidate.springs.lattice import Constants
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate_check.text import WIDTH, align_table

STABLE = "stable"
ROUNDING = 1e-13
"""Of a tensor's largest entry, shown as 0."""


@dataclass(frozen=True, eq=False)
class Identified:
    """The solid that springs are.

    Parameters
    ----------
    what, tensor, error
        What was looked at; Voigt tensor, (3, 3) in N/m or (6, 6) in Pa, points at rest; and the
        largest error of an entry, as in `Homogenised`.
    stable
        `STABLE`, or why not.
    solid
        Whether every strain costs energy.
    omega, whose
        Highest frequency (rad/s), NaN where masses are not known, and of what.
    """

    what: str
    tensor: Array
    error: float
    stable: str
    solid: bool = True
    omega: float = math.nan
    whose: str = ""


def identify_lattice(
    lattice: str,
    constants: Constants,
    spacing: float,
    volume: float = 0.0,
    density: float | None = None,
) -> Identified:
    """The solid that a lattice is with constants (N/m), one a kind, at a spacing (m).

    Parameters
    ----------
    volume
        κ of a cell, N/m in the plane or Pa in space.
    density
        kg/m³, in the plane times the thickness; None leaves frequencies out.

    Raises
    ------
    ProblemError
        If a value is out of range, or κ is given of a lattice whose points move on by themselves.
    """
    require_one_of("lattice", lattice, all_patterns())
    pattern, h = all_patterns()[lattice](), length_in_metres("spacing", spacing)
    kappa, k = finite_number("kappa", volume), ", ".join(f"{each:g}" for each in constants)
    if len(constants) != pattern.kinds:
        names = ", ".join(f"k{number + 1}" for number in range(pattern.kinds))
        raise ProblemError(f"{lattice}: constants {k or 'missing'}; give {names}")
    what = f"{lattice}, spacing {h:g} m, k = {k} N/m"
    what += f", κ = {kappa:g} {UNIT[pattern.dim]}" if kappa else ""
    found = with_cells(what, homogenise(pattern, constants, h), kappa)
    if found.stable != STABLE:
        return found
    least = least_stable_volume(pattern, constants) / h ** (pattern.dim - 2)
    if kappa <= least * (1 - ALIKE):
        return replace(found, stable=f"unstable: short waves ask for κ above {least:.6g}")
    if density is None:
        return found
    heavy = Isotropic(1.0, 0.0, "solid" if pattern.dim == 3 else "plane_strain", density)
    try:
        omega = block_frequency(heavy, pattern, constants, kappa, h)
    except ProblemError as error:
        return replace(found, stable=f"endless stable, a body not: {error}")
    return replace(found, omega=omega, whose=WHOSE)


def with_cells(what: str, solid: Homogenised, kappa: float) -> Identified:
    """Springs at rest, with κ of cells (N/m in the plane, Pa in space) beside them.

    Raises
    ------
    ProblemError
        If there are cells, and points that move on in a uniform strain.
    """
    tensor, d = solid.tensor.copy(), AXES_OF[len(solid.tensor)]
    if kappa and np.abs(solid.affine - tensor).max() > ALIKE * np.abs(tensor).max():
        raise ProblemError(f"{what}: points move on in a uniform strain, cells change how; no κ")
    tensor[:d, :d] += kappa
    stable, whole = STABLE, True
    if solid.floppy:
        stable = f"not stable: {solid.floppy} motions of points stretch no spring"
    if np.linalg.eigvalsh(tensor)[0] <= ALIKE * np.abs(tensor).max():
        stable, whole = "no solid: some strain costs no energy", False
    return Identified(what, tensor, solid.error, stable, whole)


def identified_lines(found: Identified, thickness: float | None = None) -> list[str]:
    """Table of what the springs are: tensor, moduli and stable steps, with units.

    A thickness (m) makes moduli in N/m ones in Pa, of plane stress and of plane strain.
    """
    C, d = found.tensor, AXES_OF[len(found.tensor)]
    unit, order = UNIT[d], {2: "xx yy xy", 3: "xx yy zz yz xz xy"}[d].split()
    shown = np.where(np.abs(C) > ROUNDING * np.abs(C).max(), C, 0.0).tolist()
    digits = {2: 9, 3: 7}[d]
    values = [[f"{each:.{digits}g}" for each in row] for row in shown]
    head = textwrap.wrap(f"{found.what}: {found.stable}", WIDTH)
    head += [f"C in {unit} (to {found.error:.1g}):"]
    head += align_table(order, values, [True] * len(order))
    if not found.solid:
        return head
    return [*head, *align_table(("property", "value"), _moduli_rows(found, thickness))]


def _moduli_rows(found: Identified, thickness: float | None) -> list[tuple[str, str]]:
    """Moduli and stable steps of a solid, as names and texts."""
    C, d = found.tensor, AXES_OF[len(found.tensor)]
    unit, mean, rows = UNIT[d], isotropic_moduli(found.tensor), []
    solid = f"E = {mean.E:.9g} {unit}, nu = {mean.nu:.9g}"
    if is_same_tensor(C, isotropic_part(C)):
        rows.append(("isotropic", solid))
    else:
        way = np.array([n for n in product(range(8, -9, -1), repeat=d) if math.gcd(*n) == 1])
        way = way[np.argsort((way**2).sum(axis=1), kind="stable")]  # of those alike the simplest
        E = directional_modulus(C, way / np.linalg.norm(way, axis=1)[:, None])
        for name, end in (("lowest E", E.min()), ("highest E", E.max())):
            at = np.argmax(np.isclose(E, end, rtol=ALIKE, atol=0))
            rows.append((name, f"{E[at]:.6g} {unit} along {tuple(way[at].tolist())}"))
        rows.append(("Zener ratio along the axes", f"{mean.zener:.6g}"))
        rows.append(("nearest isotropic", solid))
    if d == 2 and thickness is not None:
        t, strain = length_in_metres("thickness", thickness), mean.nu / (1 + mean.nu)
        rows.append(("in plane stress", f"E = {mean.E / t:.6g} Pa, nu = {mean.nu:.6g}"))
        E_strain = mean.E / t * (1 - strain**2)
        rows.append(("in plane strain", f"E = {E_strain:.6g} Pa, nu = {strain:.6g}"))
    if math.isfinite(found.omega):
        rows.append(("highest frequency", f"{found.omega:.6g} rad/s of {found.whose}"))
        rows.append(("step", step_words(step_limits(found.omega))))
    return rows
