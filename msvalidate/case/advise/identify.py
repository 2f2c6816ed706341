"""Effective solid of a lattice with given spring constants."""

from __future__ import annotations

import math
import textwrap
from itertools import product

import numpy as np

from msvalidate.case.advise.advice import WHOSE, block_frequency, step_limits, step_words
from msvalidate.problem import Array, Isotropic, ProblemError
from msvalidate.problem.checks import finite_number, length_in_metres, require_one_of
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.bounds import TensorBounds
from msvalidate.springs.constants.directions import contraction_ratios, directional_modulus
from msvalidate.springs.constants.homogenise import Homogenised, homogenise
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    AXES_OF,
    UNIT,
    cubic_part,
    is_same_tensor,
    isotropic_moduli,
    isotropic_part,
)
from msvalidate.springs.constants.waves import least_stable_volume
from msvalidate.springs.lattice import Constants
from msvalidate.springs.lattice.patterns import all_patterns, cubic_tensor
from msvalidate.springs.network import Network
from msvalidate_check.text import WIDTH, align_table

STABLE = "stable"
ROUNDING = 1e-12
"""Entries of a tensor relative to the largest that are shown as 0."""


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
    bounds
        Of an irregular piece, for one size of windows after another: the tensor is then the mean
        of the first bounds, and the error half their distance.
    network
        Of a finite piece in files: with the supports and forces of its table, if there are any.
    """

    what: str
    tensor: Array
    error: float
    stable: str
    solid: bool = True
    omega: float = math.nan
    whose: str = ""
    bounds: tuple[TensorBounds, ...] = ()
    network: Network | None = None


def mass_density(
    dim: int, density: float | None, thickness: float | None
) -> tuple[float | None, str]:
    """Mass of a unit of volume (kg/m³, in 2D kg/m²), None if it is not known, and a note on it.

    A solid, and a plane body of known thickness (m), have the density (kg/m³) of `Isotropic` by
    default.

    Raises
    ------
    ProblemError
        If the dimension and the values do not go together.
    """
    if dim == 3 and thickness is not None:
        raise ProblemError("--thickness: a solid has none; leave it out")
    if dim == 1 and density is not None:
        raise ProblemError("--density: a chain has no volume; give a column mass in points.csv")
    if dim == 2 and density is not None and thickness is None:
        raise ProblemError("--density: a plane lattice's mass takes its --thickness too; give both")
    if dim < 3 and thickness is None:
        return None, ""
    value = Isotropic.density if density is None else density
    return value * (thickness or 1.0), f"{value:g} kg/m³{' (default)' * (density is None)}"


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


def identify_cubic(C11: float, C12: float, C44: float) -> Identified:
    """The cubic solid of three constants (Pa), along its axes.

    Raises
    ------
    ProblemError
        If some strain costs no energy.
    """
    what = f"cubic solid, C11, C12, C44 = {C11:g}, {C12:g}, {C44:g} Pa"
    if not (C44 > 0 and C11 > C12 and C11 + 2 * C12 > 0):
        raise ProblemError(f"--cubic: {what}; give C44 > 0 and C12 between -C11/2 and C11")
    return Identified(what, cubic_tensor(3, C11, C12, C44), 0.0, STABLE)


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


def with_bounds(what: str, rows: tuple[TensorBounds, ...]) -> Identified:
    """The solid that is known by bounds, for one size of windows after another."""
    best = rows[0]
    mean, half = (best.upper + best.lower) / 2, np.diag(best.upper - best.lower) / 2
    whole = bool(np.linalg.eigvalsh(best.lower)[0] > ALIKE * np.abs(mean).max())
    stable = STABLE if whole else "the lower bound is no solid: some strain costs no energy"
    return Identified(what, mean, float((half / np.diag(mean)).max()), stable, bounds=rows)


def identified_lines(found: Identified, thickness: float | None = None) -> list[str]:
    """Table of what the springs are: tensor, moduli and stable steps, with units.

    A thickness (m) makes moduli in N/m ones in Pa, of plane stress and of plane strain.
    """
    C, d = found.tensor, AXES_OF[len(found.tensor)]
    if d == 1:
        rows = [("EA", f"{C[0, 0]:.9g} N"), *_step_rows(found)]
        return [*textwrap.wrap(found.what, WIDTH), *align_table(("property", "value"), rows)]
    unit, order = UNIT[d], {2: "xx yy xy", 3: "xx yy zz yz xz xy"}[d].split()
    shown = np.where(np.abs(C) > ROUNDING * np.abs(C).max(), C, 0.0).tolist()
    digits = 4 if found.bounds else {2: 9, 3: 7}[d]
    values = [[f"{each:.{digits}g}" for each in row] for row in shown]
    head = textwrap.wrap(f"{found.what}: {found.stable}", WIDTH)
    head += [f"C in {unit} (to {found.error:.1g}):"]
    head += align_table(order, values, [True] * len(order))
    if not found.solid:
        return head
    return [*head, *align_table(("property", "value"), moduli_rows(found, thickness))]


def moduli_rows(found: Identified, thickness: float | None = None) -> list[tuple[str, str]]:
    """Moduli and stable steps of a solid, as names and texts."""
    C, d = found.tensor, AXES_OF[len(found.tensor)]
    unit, rows = UNIT[d], []
    for each in found.bounds:
        ends = [f"{low:.4g} to {high:.4g}" for low, high in each.moduli.T.tolist()]
        text = f"E = {ends[0]} {unit}, nu = {ends[1]}, Zener ratio {ends[2]}"
        rows.append((f"bounds, {each.windows} × {each.points:.0f} points", text))
    mean, digits = isotropic_moduli(C), 4 if found.bounds else 9
    nu = mean.nu if abs(mean.nu) > ROUNDING else 0.0
    solid = f"E = {mean.E:.{digits}g} {unit}, nu = {nu:.{digits}g}"
    if is_same_tensor(C, isotropic_part(C)):
        rows.append(("isotropic", solid))
    else:
        rows += _directional_rows(C)
        cubic = is_same_tensor(C, cubic_part(C))
        name = "Zener ratio along the axes" if cubic else "Zener ratio of the mean over the axes"
        rows.append((name, f"{mean.zener:.6g}"))
        rows.append(("nearest isotropic", solid))
    rows += [("auxetic", "widens when it is pulled")] * (nu < 0)
    if d == 2 and thickness is not None:
        t, strain = length_in_metres("thickness", thickness), mean.nu / (1 + mean.nu)
        rows.append(("in plane stress", f"E = {mean.E / t:.6g} Pa, nu = {mean.nu:.6g}"))
        E_strain = mean.E / t * (1 - strain**2)
        rows.append(("in plane strain", f"E = {E_strain:.6g} Pa, nu = {strain:.6g}"))
    return rows + _step_rows(found)


def _directional_rows(C: Array) -> list[tuple[str, str]]:
    """Lowest and highest modulus, and along axes and diagonals the modulus and Poisson's ratios."""
    d = AXES_OF[len(C)]
    lines = np.array([n for n in product(range(8, -9, -1), repeat=d) if math.gcd(*n) == 1])
    lines = lines[np.argsort((lines**2).sum(axis=1), kind="stable")]  # of equal ones the simplest
    unit = lines / np.linalg.norm(lines, axis=1)[:, None]
    E, rows = directional_modulus(C, unit), []
    for name, end in (("lowest E", E.min()), ("highest E", E.max())):
        at = np.argmax(np.isclose(E, end, rtol=ALIKE, atol=0))
        rows.append((name, f"{E[at]:.6g} {UNIT[d]} along {tuple(lines[at].tolist())}"))
    for line in np.tril(np.ones((d, d), dtype=int)):
        at = (lines == line).all(axis=1).argmax()
        across = np.flatnonzero(lines @ line == 0)
        ratio = np.round(contraction_ratios(C, unit[at], unit[across]), 10) + 0.0
        ends = dict.fromkeys((int(ratio.argmin()), int(ratio.argmax())))
        words = [f"{ratio[i]:.6g} along {tuple(lines[across[i]].tolist())}" for i in ends]
        text = f"E = {E[at]:.6g} {UNIT[d]}, nu = {' to '.join(words)}"
        rows.append((f"along {tuple(line.tolist())}", text))
    return rows


def _step_rows(solid: Identified) -> list[tuple[str, str]]:
    """Highest frequency and stable steps, if masses are known."""
    if not math.isfinite(solid.omega):
        return []
    return [
        ("highest frequency", f"{solid.omega:.6g} rad/s of {solid.whose}"),
        ("step", step_words(step_limits(solid.omega))),
    ]
