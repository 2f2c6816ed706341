"""Constants of a body's lattice: those that are given, checked, or those of its material.

What repeats in the lattice is found, and a route (`routes`) leads from there to the
material. Constants that are given, or were calibrated before, are checked against the body.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from msvalidate.constants.calibration import Calibration
from msvalidate.constants.routes import (
    ROUTES,
    calibrate_by_first_route,
    check_route,
    refuse_soft_cells,
)
from msvalidate.constants.spring_constants import edge_constants, target_of
from msvalidate.constants.stiffness import ALIKE, is_same_tensor, isotropic_tensor
from msvalidate.lattice import Constants, Lattice, Pattern, PatternLattice, patterns
from msvalidate.problem import Array, Isotropic, Material, Mesh, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_number,
    format_value,
    length_in_metres,
    require_type,
)

PATTERN_OF: Mapping[str, Callable[[], Pattern]] = {
    "square": patterns.square,
    "square at 45°": patterns.square,
    "triangular": patterns.triangular,
}
"""Lattices built without a pattern, and what repeats in them; a turn changes no isotropic solid."""

ORDINARY = 1e100
"""Moduli times thickness beyond which, or below one over which, squares have no digits left."""


def calibrate_by_route(
    material: Material, lattice: Pattern | Lattice, spacing: float | None, route: str | None
) -> Calibration:
    """What `bodies.calibrate.calibrate_material` returns, but for what it says of the body.

    Raises
    ------
    ProblemError
        As there.
    """
    if not isinstance(material, Isotropic):
        raise ProblemError(f"calibrate: {format_value(material)}; the material must be isotropic")
    pattern, unit = _repeating_cell(lattice, spacing)
    if not 1 / ORDINARY < material.E * material.thickness < ORDINARY:
        raise ProblemError(
            f"calibrate: a modulus of {material.E:g} Pa and a thickness of {material.thickness:g} "
            "m; choose units that give ordinary numbers"
        )
    if route is not None:
        check_route(route)
    lead = calibrate_by_first_route if route is None else ROUTES[route]
    found = lead(target_of(material, pattern), pattern, unit)
    if found.volume < 0 and isinstance(lattice, Pattern | PatternLattice):
        refuse_soft_cells(pattern, unit, found)
    return found


def default_constants(material: Material, lattice: Lattice) -> Constants:
    """Spring constants (N/m), one a kind, of the lattice that is the material by springs alone.

    Raises
    ------
    ProblemError
        If it cannot be, or the material is given as a tensor.
    """
    require_type("lattice", lattice, Lattice)
    if not isinstance(material, Isotropic):
        raise ProblemError("spring constants: the material is a tensor; give the constants")
    if isinstance(lattice.domain, Mesh) and not isinstance(lattice, PatternLattice):
        return edge_constants(material)
    return calibrate_by_route(material, lattice, None, "springs").constants


def spring_stiffnesses(
    material: Material,
    lattice: Lattice,
    given: Constants | Calibration | None = None,
    volume: float = 0.0,
) -> tuple[Array, float]:
    """Constants of springs (k,), one a kind, and κ of cells.

    Parameters
    ----------
    material, lattice
        By whose default constants nothing given is meant.
    given, volume
        Spring constants (N/m) with κ, or a calibration, which has its own.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, κ is given twice, or a calibration is for another
        lattice, spacing, thickness or isotropic material.
    """
    volume = finite_number("volume stiffness", volume)
    if isinstance(given, Calibration):
        if volume:
            raise ProblemError(
                f"volume stiffness: {format_value(volume)}; a calibration brings its own, leave it "
                f"out"
            )
        _refuse_other_material(given, lattice, material)
        constants, volume = given.constants, given.volume
    else:
        constants = default_constants(material, lattice) if given is None else given
    k = finite("spring constants", constants)
    if k.shape != (lattice.kinds,):
        raise ProblemError(
            f"spring constants: {format_value(constants)}; give {lattice.kinds}, one a kind"
        )
    return k, volume


def _refuse_other_material(given: Calibration, lattice: Lattice, material: Material) -> None:
    """A calibration of something else, whose constants would make another material of this."""
    pattern, unit = _repeating_cell(lattice, None)
    scales = pattern.dim == 3  # in the plane constants are the same at any spacing
    if (given.lattice, len(given.constants)) != (pattern.name, pattern.kinds):
        mismatch = f"a {given.lattice} lattice, not {pattern.name}"
    elif scales and abs(given.spacing - unit) > ALIKE * unit:
        mismatch = f"a spacing of {given.spacing:g} m, not {unit:g} m"
    elif abs(given.thickness - material.thickness) > ALIKE * material.thickness:
        mismatch = f"a thickness of {given.thickness:g} m, not {material.thickness:g} m"
    elif isinstance(material, Isotropic) and not _is_material(given, material, pattern):
        mismatch = (
            f"E = {given.E:g} Pa and nu = {given.nu:g} of another state or size than the problem's "
            f"{material.E:g} and {material.nu:g} in {material.state}"
        )
    else:
        return
    raise ProblemError(f"calibration: for {mismatch}; calibrate the problem's own body")


def _is_material(given: Calibration, material: Isotropic, pattern: Pattern) -> bool:
    """Whether the tensor of a calibration is that of the material along the lattice's axes."""
    target = target_of(material, pattern)
    if (pattern.dim - 1) * target.nu >= 1:
        return False
    return is_same_tensor(given.tensor, isotropic_tensor(pattern.dim, target.E, target.nu))


def _repeating_cell(lattice: Pattern | Lattice, spacing: float | None) -> tuple[Pattern, float]:
    """What repeats, and the length (m) of its unit."""
    require_type("lattice", lattice, Pattern | Lattice)
    if isinstance(lattice, Pattern):
        return lattice, length_in_metres("spacing", 1.0 if spacing is None else spacing)
    if spacing is not None:
        raise ProblemError(f"spacing: {format_value(spacing)}; a body has its own, leave it out")
    if isinstance(lattice, PatternLattice):
        return lattice.pattern, lattice.spacing
    if lattice.name in PATTERN_OF:
        return PATTERN_OF[lattice.name](), 1.0  # plane tensors do not depend on it
    raise ProblemError(
        f"spring constants: none known for {lattice.name}; give the constants, or calibrate the "
        "pattern that it was made from"
    )
