"""From a body's materials to the constants of its springs and cells, zone by zone.

Constants that are given, or were calibrated before, are checked against the body; by default they
are those of the material by springs alone, or with a volume energy if these do not suffice.

With zones each cell has the constants of its material. A spring has from each cell that shares it
the cell's part of that cell's constant: on an interface half of each material's. A body whose zones
end where cells do is then as exact as each material is alone: bars of two materials, one behind or
beside the other, are exact.

**A cell that a zone ends in** has of each material a fraction of its area or volume, found from
`SAMPLES` places along each axis. Its density is the mean by fraction. Its moduli are those of the
materials in series [Reuss1929]: 1/μ and 1/K are the means by fraction, and with them the
springs' constants and κ. It is a rule, and not exact: displacements are then of first order in the
spacing. A disc of radius a in a plate under tension changes displacements; these changes are off,
at a spacing of a/32, in the worst place and relative to the largest of them, by

    disc of                     10 times E    E/10
    in series                   0.9 %         2.6 %
    mean of the moduli          3.2 %         3.4 %
    material of the middle      3.1 %         6.5 %

The mean of the moduli [Voigt1889] makes the rim of a stiff part too wide, the middle makes an
interface of steps. Where that counts, let zones end where cells do.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from itertools import product
from typing import Any

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.spatial import KDTree

from msvalidate.problem import Array, CellSet, Problem, ProblemError, cut_cells, materials_at
from msvalidate.problem.checks import finite_number, format_value, require_type
from msvalidate.problem.shapes import STRAIGHT
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.routes import calibrate_by_route, constants_of, default_constants
from msvalidate.springs.constants.stiffness import shear_modulus
from msvalidate.springs.lattice import Constants, CutLattice, Lattice, Pattern
from msvalidate.springs.lattice.outline import is_outside, outline
from msvalidate.springs.lattice.parts import point_parts, spring_parts

SAMPLES: Mapping[int, int] = {2: 16, 3: 8}
"""Sample points per axis of a cell at a zone's end, for 1 % accuracy."""

OneOrEach = Constants | Calibration | tuple[Constants | Calibration, ...]
"""Constants of a body: one entry, or one for each of its materials."""


def calibrate_zones(
    problem: Problem,
    lattice: Pattern | Lattice,
    *,
    spacing: float | None = None,
    route: str | None = None,
) -> tuple[Calibration, ...]:
    """Find the constants of a lattice for each material of a problem.

    Parameters
    ----------
    problem
        Boundary value problem; its isotropic materials are those of the body and of each zone.
    lattice
        Unit cell, or a lattice that fills the body.
    spacing
        Length (m) of the unit of a pattern; a lattice in a body has its own spacing.
    route
        "springs", "volume energy" or "neo-Hookean", for all materials. Default: springs alone if
        they suffice for all, otherwise springs with a volume energy for all.

    Returns
    -------
    tuple of Calibration
        One calibration per material, in the order of `Problem.materials`.

    Raises
    ------
    ProblemError
        If a material is not isotropic, or the lattice cannot have its moduli by this route.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Region, Zone, calibrate_zones, square
    >>> box = Box((1.0, 1.0))
    >>> inclusion = Zone(Region(((0.5, 1.0), None)), Isotropic(E=1e6, nu=1 / 3))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(), zones=(inclusion,))
    >>> soft, stiff = calibrate_zones(problem, square(box, 10))
    >>> print(f"{stiff.constants[0] / soft.constants[0]:.6f}")
    10.000000
    """
    require_type("problem", problem, Problem)

    def by(route: str) -> tuple[Calibration, ...]:
        return tuple(
            calibrate_by_route(each, lattice, spacing, route) for each in problem.materials
        )

    if route is not None:
        return by(route)
    try:
        return by("springs")
    except ProblemError:
        return by("volume energy")


def constants_by_zone(
    problem: Problem, lattice: Lattice, constants: OneOrEach | None = None, volume: float = 0.0
) -> tuple[Array, Array, Array, Array]:
    """Constants of springs and cells, and the density at points, by zone.

    Spring constants are (m,) in N/m (Pa for 3D mesh edges), before the factors of the lattice; κ
    and pressure are (c,), in N/m in 2D and Pa in 3D; the density is (n,) in kg/m³.

    Parameters
    ----------
    problem, lattice
        The body: the lattice must fill the problem's domain.
    constants, volume
        Constants and κ, as for `lattice_network`.

    Raises
    ------
    ProblemError
        If the lattice fills another domain, or as `constants_of`; with zones, if there is not one
        entry for each material.
    """
    if lattice.domain != problem.domain:
        raise ProblemError(
            f"lattice fills a {lattice.domain}, the problem's is a {problem.domain}; "
            "build it from the problem's own"
        )
    k, kappa, pressure, shear = _constants_of_each(problem, lattice, constants, volume)
    density = np.array([material.density for material in problem.materials])
    at_points = np.full(len(lattice.points), density[0])
    if not problem.zones:
        of_cells = (np.full(len(lattice.cells), each[0]) for each in (kappa, pressure))
        return k[0, lattice.kind], *of_cells, at_points
    fraction = material_fractions(problem, lattice)
    if (density != density[0]).any():
        at_points = np.asarray(point_parts(lattice) @ (fraction @ density))
    # Of springs alone: λ = μ at rest, and λ = 0 of those whose cells bring all of it.
    own = 2 / lattice.points.shape[1] + (0.0 if pressure.any() else 1.0)
    springs = _gifts(lattice, fraction / shear, k).sum(axis=1)
    stiff = _volume_stiffness(fraction, shear, shear * own, kappa)
    # A cell's springs are as stiff as its materials' in a row: so is what they pull against.
    mean = 1 / (fraction @ (1 / pressure)) if pressure.any() else fraction @ pressure
    return springs, stiff, mean, at_points


def spring_shares(
    problem: Problem, lattice: Lattice, constants: OneOrEach | None = None
) -> csr_array:
    """Fraction (m, c) of each spring's stiffness from each cell; rows sum to 1.

    Which of the force of a spring on an interface is whose: `springs.statics.stress.cell_stress`
    takes them. A spring without stiffness has none.

    Parameters
    ----------
    problem, lattice, constants
        As for `lattice_network`.

    Raises
    ------
    ProblemError
        As there.
    """
    k, _, _, shear = _constants_of_each(problem, lattice, constants, 0.0)
    gifts = _gifts(lattice, material_fractions(problem, lattice) / shear, k)
    total = gifts.sum(axis=1)
    return csr_array(diags_array(1 / np.where(total, total, 1.0)) @ gifts)


def _constants_of_each(
    problem: Problem, lattice: Lattice, constants: OneOrEach | None, volume: float
) -> tuple[Array, Array, Array, Array]:
    """Spring constants (materials, kinds), κ, pressure and μ (materials,) of its materials."""
    volume, count = finite_number("volume stiffness", volume), len(problem.materials)
    if count > 1 and volume:
        raise ProblemError(
            f"volume stiffness: {format_value(volume)} for {count} materials; "
            "give calibrate_zones(problem, lattice), which has one for each"
        )
    constants = choose_constants(problem, lattice, constants, volume)
    each: tuple[Any, ...] = constants if isinstance(constants, tuple) else ()
    if count == 1 or constants is None:
        each = (constants,) * count
    elif len(each) != count or not all(isinstance(one, Calibration | tuple) for one in each):
        raise ProblemError(
            f"spring constants: {format_value(constants)} for {count} materials; give a tuple of "
            "one entry each, such as calibrate_zones(problem, lattice)"
        )
    found = [
        (*constants_of(material, lattice, one, volume), shear_modulus(material))
        for material, one in zip(problem.materials, each, strict=True)
    ]
    k, kappa, shear = zip(*found, strict=True)
    pressure = np.array([getattr(one, "pressure", 0.0) for one in each])
    if pressure.any() and not pressure.all():
        raise ProblemError("spring constants: some by route 'neo-Hookean'; take it for all zones")
    return np.array(k), np.array(kappa), pressure, np.array(shear)


def choose_constants(
    problem: Problem, lattice: Lattice, constants: OneOrEach | None, volume: float = 0.0
) -> OneOrEach:
    """Return the given constants, or those of the problem's materials.

    By default springs alone represent all materials, or springs with a volume energy if springs
    alone cannot. Raises `ProblemError` if neither can.
    """
    if constants is not None:
        return constants
    each: OneOrEach
    try:
        each = tuple(default_constants(material, lattice) for material in problem.materials)
    except ProblemError:
        each = ()
        if not volume:
            with suppress(ProblemError):
                each = calibrate_zones(problem, lattice, route="volume energy")
        if not each:
            raise
    return each if len(each) > 1 else each[0]


def _volume_stiffness(fraction: Array, shear: Array, bulk: Array, kappa: Array) -> Array:
    """κ (c,) of cells of some fractions (c, materials).

    Parameters
    ----------
    fraction
        Of each cell.
    shear, bulk, kappa
        (materials,) μ; the bulk modulus of its springs alone, λ + 2μ/d at λ = μ; and its κ.
    """
    found = np.asarray(fraction @ kappa)
    cut = (fraction < 1).all(axis=1)
    if kappa.any():
        ratio = bulk[0] / shear[0]
        part = fraction[cut]
        found[cut] = 1 / (part @ (1 / (bulk + kappa))) - ratio / (part @ (1 / shear))
    return found


def _gifts(lattice: Lattice, soft: Array, k: Array) -> csr_array:
    """Contribution (m, c) of each cell to each spring constant.

    Of each material's fraction over its shear modulus (c, materials), and its constants
    (materials, kinds).
    """
    of_cell = soft / soft.sum(axis=1, keepdims=True) @ k
    parts = spring_parts(lattice)
    kind = np.repeat(lattice.kind, np.diff(parts.indptr))
    data = parts.data * of_cell[parts.indices, kind]
    return csr_array((data, parts.indices, parts.indptr), shape=parts.shape)


def material_fractions(problem: Problem, lattice: Lattice) -> Array:
    """Fraction (c, materials) of each cell that is of each of a problem's materials.

    Raises
    ------
    ProblemError
        If a zone holds no part of a cell, or ends in cells that are cut to a solid that is no
        prism along z.
    """
    places, count = lattice.points[lattice.cells], len(problem.materials)
    shape = STRAIGHT[places.shape[:0:-1]]
    cut = cut_cells(problem, places, shape)
    named = any(isinstance(zone.region, CellSet) for zone in problem.zones)
    if isinstance(lattice, CutLattice) and named:  # whose middle may be in no cell of the mesh
        cut |= lattice.fraction < 1
    middle = np.einsum("qk,ckd->cd", shape.values(shape.middle[None]), places)
    found = np.eye(count)[materials_at(problem, middle)]
    n = SAMPLES[shape.dim]
    at = (np.array(list(product(range(n), repeat=shape.dim))) + 0.5) / n
    if shape.simplex:
        at = at[at.sum(axis=1) <= 1]
    x = np.einsum("qk,ckd->cqd", shape.values(at), places[cut])
    if cut.any():
        found[cut] = _sampled_fractions(problem, lattice, x)
    asked = np.concatenate([middle, x.reshape(-1, x.shape[2])])
    for number, zone in enumerate(problem.zones, 1):  # a later one may have all of an earlier
        if (
            not found[:, number].any()
            and not zone.region.select(asked, problem.domain.tolerance).any()
        ):
            raise ProblemError(f"zone {zone.region}: no cell has a part of it; take smaller cells")
    return found


def _sampled_fractions(problem: Problem, lattice: Lattice, places: Array) -> Array:
    """Fractions (c, materials) of the sample places of cells.

    Only the places (c, q, d) in m inside the body count. A cell without such a place takes the
    material of the nearest one. Raises `ProblemError` for a lattice that is cut to a solid that is
    no prism along z.
    """
    count, flat = len(problem.materials), places.reshape(-1, places.shape[2])
    each = np.eye(count)[materials_at(problem, flat)]
    if isinstance(lattice, CutLattice):
        area, room = outline(lattice.domain), lattice.domain.tolerance
        inside = ~is_outside(area, flat[:, :2], room)
        each[~inside] = 0.0
    each = each.reshape(*places.shape[:2], count).sum(axis=1)
    total = each.sum(axis=1, keepdims=True)
    (none,) = np.nonzero(total[:, 0] == 0)
    if len(none):  # slivers: as what is nearest
        owner = np.repeat(np.arange(len(places)), places.shape[1])[inside]
        nearest = KDTree(flat[inside]).query(places[none].mean(axis=1))[1]
        each[none], total[none] = each[owner[nearest]], total[owner[nearest]]
    return np.asarray(each / total)
