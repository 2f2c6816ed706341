"""Routes from an isotropic material to the constants of a lattice.

A route that fails gives the reason.

The first is taken where it leads to the material, or else the second:

- ``springs``: central springs alone. Where every point is a centre of symmetry the tensor is linear
  in the constants and obeys Cauchy's relation λ = μ, so there is one ratio: 1/3 in the plane, 1/4
  in a solid. Elsewhere the points at rest leave other ratios: honeycomb (k1 + 3 k2)/(k1 + 9 k2),
  between 1/3 and 1.
- ``volume energy``: springs that carry λ = μ, and beside them an energy ½ κ V0 (V/V0 - 1)² a cell,
  which resists nothing but a change of its volume: κ = λ - μ brings any ratio (the idea is that of
  [Golec2020]). With E and nu of the d axes, in-plane ones for d=2,

      κ = E ((d + 1) nu - 1) / (2 (1 + nu) (1 - (d - 1) nu)).

- ``neo-Hookean``, where it is asked for: springs of no rest length beside cells under pressure,
  U(J) = -μ ln J + (λ/2) ln²J, any ratio. Springs all alike, of directions of second-order
  isotropy, store Σ ½k|F r|² = (μ/2) F:F if Σ k r⊗r is μ a volume; the rest of the neo-Hookean law
  is U. It is that law in homogeneous strain, and in these bodies elements of it, node for node:
  squares, where k = μ/3, are bilinear ones with one mean J a cell, and edges of triangles and
  tetrahedra by the rule "cotangent" are linear ones (study `large_strain`, question twins). In
  plane stress it is the two-dimensional law of the same small-strain moduli, which at a stretch of
  1.1 differs from a sheet that thins by 0.24 %.

What is said of E, nu and the anisotropy is read off the tensor that the constants make.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from msvalidate.problem import Array, Isotropic, Material, Mesh, ProblemError
from msvalidate.problem.checks import (
    finite,
    format_value,
    length_in_metres,
    require_one_of,
    require_type,
)
from msvalidate.problem.material import State
from msvalidate.problem.records import replace
from msvalidate.springs.constants.calibration import Calibration
from msvalidate.springs.constants.homogenise import deforms_affinely, homogenise
from msvalidate.springs.constants.isotropic import isotropic_constants
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    CAUCHY,
    UNIT,
    axes_moduli,
    central_modulus,
    is_of_material,
    isotropic_tensor,
    lame,
    moduli,
    pattern_tensor,
)
from msvalidate.springs.constants.waves import least_stable_volume
from msvalidate.springs.lattice import Constants, Lattice, Pattern, PatternLattice
from msvalidate.springs.lattice.edges import REST_SHARE, EdgeLattice

ORDINARY = 1e100
"""Moduli times thickness beyond which, or below one over which, squares have no digits left."""


def calibrate_by_route(
    material: Material, lattice: Pattern | Lattice, spacing: float | None, route: str | None
) -> Calibration:
    """Calibrate a lattice as `springs.bodies.calibrate.calibrate_material`, without its body.

    Raises
    ------
    ProblemError
        As there.
    """
    if not isinstance(material, Isotropic):
        raise ProblemError(f"calibrate: {format_value(material)}; the material must be isotropic")
    if not 1 / ORDINARY < material.E * material.thickness < ORDINARY:
        raise ProblemError(
            f"calibrate: a modulus of {material.E:g} Pa and a thickness of {material.thickness:g} "
            "m; choose units that give ordinary numbers"
        )
    if route is not None:
        check_route(route)
    if isinstance(lattice, EdgeLattice) and route is not None and spacing is None:
        return _along_edges(material, lattice, route)
    pattern, unit = _repeating_cell(lattice, spacing)
    lead = _by_first_route if route is None else ROUTES[route]
    found = lead(material, pattern, unit)
    if found.volume < 0 and isinstance(lattice, Pattern | PatternLattice):
        _refuse_soft_cells(pattern, unit, found)
    return found


def constants_of(
    material: Material, lattice: Lattice, chosen: Constants | Calibration | None, volume: float
) -> tuple[Array, float]:
    """Check the constants (kinds,) and κ of a material, or compute the default.

    Parameters
    ----------
    material, lattice
        Of a body, or of a zone of it.
    chosen, volume
        Spring constants (N/m; Pa for 3D mesh edges) with κ, or a calibration, which has its own.

    Raises
    ------
    ProblemError
        If the constants are not one a kind, κ is given twice, a calibration is for another lattice,
        spacing, thickness or material, or there are no constants by springs alone.
    """
    if chosen is None:
        return np.array(default_constants(material, lattice)), volume
    if isinstance(chosen, Calibration):
        if volume:
            raise ProblemError(
                f"volume stiffness: {format_value(volume)}; a calibration brings its own, leave "
                "it out"
            )
        _refuse_other_material(chosen, lattice, material)
        volume = chosen.volume
    constants = chosen.constants if isinstance(chosen, Calibration) else chosen
    k = finite("spring constants", constants)
    if k.shape != (lattice.kinds,):
        raise ProblemError(
            f"spring constants: {format_value(constants)}; give {lattice.kinds}, one a kind"
        )
    return k, volume


def default_constants(material: Material, lattice: Lattice) -> Constants:
    """Spring constants, one per kind, that make a material by springs alone.

    The constants are in N/m with the thickness, except in Pa for the edges of a 3D mesh. A lattice
    of mesh edges has one constant, the Young's modulus of the axes.

    Raises
    ------
    ProblemError
        If springs alone cannot make the material, or the material is given as a tensor.
    """
    require_type("lattice", lattice, Lattice)
    if not isinstance(material, Isotropic):
        raise ProblemError("spring constants: the material is a tensor; give the constants")
    if not isinstance(lattice.domain, Mesh) or isinstance(lattice, PatternLattice):
        return calibrate_by_route(material, lattice, None, "springs").constants
    what = "springs along a mesh's edges"
    return (central_modulus(material, material.dim, what, "neo-Hookean"),)


def _refuse_other_material(known: Calibration, lattice: Lattice, material: Material) -> None:
    """Raise `ProblemError` for a calibration that does not fit the body.

    Its lattice, number of constants and thickness must be the body's, in 3D also its spacing, and
    its tensor must be the material's.
    """
    if isinstance(lattice, EdgeLattice):
        name, kinds, scales, unit = lattice.name, 1, False, 0.0
    else:
        pattern, unit = _repeating_cell(lattice, None)
        name, kinds = pattern.name, pattern.kinds
        scales = pattern.dim == 3  # in the plane constants are the same at any spacing
    if (known.lattice, len(known.constants)) != (name, kinds):
        mismatch = f"a {known.lattice} lattice, not {name}"
    elif scales and abs(known.spacing - unit) > ALIKE * unit:
        mismatch = f"a spacing of {known.spacing:g} m, not {unit:g} m"
    elif abs(known.thickness - material.thickness) > ALIKE * material.thickness:
        mismatch = f"a thickness of {known.thickness:g} m, not {material.thickness:g} m"
    elif is_of_material(known.tensor, material):
        return
    elif isinstance(material, Isotropic):
        mismatch = (
            f"E = {known.E:g} Pa and nu = {known.nu:g} of another state or size than the problem's "
            f"{material.E:g} and {material.nu:g} in {material.state}"
        )
    else:
        raise ProblemError(
            f"calibration: for E = {known.E:g} Pa and nu = {known.nu:g}, not the problem's tensor; "
            "give spring constants of this tensor, such as (k1, k2), one a kind"
        )
    raise ProblemError(f"calibration: for {mismatch}; calibrate the problem's own body")


def _repeating_cell(lattice: Pattern | Lattice, spacing: float | None) -> tuple[Pattern, float]:
    """Unit cell of a lattice, and the length (m) of its unit."""
    require_type("lattice", lattice, Pattern | Lattice)
    if isinstance(lattice, Pattern):
        return lattice, length_in_metres("spacing", 1.0 if spacing is None else spacing)
    if spacing is not None:
        raise ProblemError(f"spacing: {format_value(spacing)}; a body has its own, leave it out")
    if isinstance(lattice, PatternLattice):
        return lattice.pattern, lattice.spacing
    if lattice.unit_cell is not None:
        return lattice.unit_cell, 1.0  # plane tensors do not depend on it
    raise ProblemError(
        f"spring constants: none known for {lattice.name}; give the constants, or calibrate the "
        "pattern that it was made from"
    )


def _by_first_route(material: Isotropic, pattern: Pattern, spacing: float) -> Calibration:
    """By springs alone where they will do, or else with a volume energy."""
    try:
        return _springs_alone(material, pattern, spacing)
    except ProblemError:
        if not deforms_affinely(pattern):
            raise
        return _with_volume_energy(material, pattern, spacing)


def _springs_alone(material: Isotropic, pattern: Pattern, spacing: float) -> Calibration:
    constants = isotropic_constants(material, pattern, spacing)
    tensor = homogenise(pattern, constants, spacing).tensor
    return calibration_of(material, pattern, spacing, constants, 0.0, "springs", tensor)


def _with_volume_energy(material: Isotropic, pattern: Pattern, spacing: float) -> Calibration:
    """Springs of the material's μ at Cauchy's ratio; κ = λ - μ."""
    d = pattern.dim
    _refuse_moving_points(pattern)
    E, nu, room = _compressible_moduli(material, d, pattern.name)
    kappa = E * ((d + 1) * nu - 1) / (2 * (1 + nu) * room)
    state: State = "plane_stress" if d == 2 else "solid"
    _, mu = lame(d, E, nu)
    cauchy = Isotropic(2 * mu * (1 + CAUCHY[d]), CAUCHY[d], state)
    springs = _springs_alone(cauchy, pattern, spacing)
    normal = np.arange(len(springs.tensor)) < d
    tensor = springs.tensor + kappa * np.outer(normal, normal)
    return calibration_of(
        material, pattern, spacing, springs.constants, kappa, "volume energy", tensor
    )


def _of_no_rest_length(material: Isotropic, pattern: Pattern, spacing: float) -> Calibration:
    """Springs of no rest length against the pressure of cells; see the module's text."""
    d = pattern.dim
    _refuse_moving_points(pattern)
    E, nu, _ = _compressible_moduli(material, d, pattern.name)
    lam, mu = lame(d, E, nu)
    # Σ k r⊗r over the volume is the mean of the tensor's last two indices.
    alike = (1.0,) * pattern.kinds
    moment = pattern_tensor(pattern, alike, spacing)[:, :d].sum(axis=1)
    even = np.arange(len(moment)) < d
    if np.abs(moment - moment[0] * even).max() > ALIKE * moment[0]:
        raise ProblemError(
            f"{pattern.name} lattice: springs all alike are stiffer along one axis than along "
            "another; take a lattice with the symmetry of squares, cubes or triangles"
        )
    constants = tuple(mu / moment[0] * k for k in alike)
    tensor = isotropic_tensor(d, E, nu)
    found = calibration_of(material, pattern, spacing, constants, lam, "neo-Hookean", tensor)
    return replace(found, pressure=mu)


def _along_edges(material: Isotropic, lattice: EdgeLattice, route: str) -> Calibration:
    """The same along a mesh's edges."""
    if route != "neo-Hookean" or lattice.rule != "cotangent":
        raise ProblemError(
            f"route: {route!r} for edges of a mesh by the rule {lattice.rule!r}; take "
            "'neo-Hookean' and edges by 'cotangent' of either sign, or give the "
            "constant"
        )
    d = lattice.points.shape[1]
    E, nu, _ = _compressible_moduli(material, d, lattice.name)
    lam, mu = lame(d, E, nu)
    return Calibration(
        constants=(mu / REST_SHARE[d],),
        volume=lam,
        E=material.E,
        nu=material.nu,
        zener=1.0,
        route=route,
        tensor=isotropic_tensor(d, E, nu),
        lattice=lattice.name,
        spacing=float(np.linalg.norm(lattice.vectors, axis=1).mean()),
        thickness=material.thickness,
        pressure=mu,
        pushing=(int((lattice.factor < 0).sum()), len(lattice.springs)),
    )


def _refuse_moving_points(pattern: Pattern) -> None:
    if not deforms_affinely(pattern):
        raise ProblemError(
            f"{pattern.name} lattice: its points move on in a uniform strain, and more so with "
            "what is added to its springs; take one whose points are centres of symmetry, or route "
            "'springs'"
        )


def _compressible_moduli(material: Isotropic, d: int, name: str) -> tuple[float, float, float]:
    """E and nu of the d axes, and 1 - (d - 1) nu, which is above 0."""
    E, nu = axes_moduli(material, d, f"{name} lattice")
    room = 1 - (d - 1) * nu
    if room <= 0:
        raise ProblemError(
            f"{name} lattice: nu = {material.nu:g} in {material.state}; "
            "nothing is compressible, and κ would be infinite: take nu below 1/2, such as 0.499"
        )
    return E, nu, room


ROUTES: Mapping[str, Callable[[Isotropic, Pattern, float], Calibration]] = {
    "springs": _springs_alone,
    "volume energy": _with_volume_energy,
    "neo-Hookean": _of_no_rest_length,
}
"""The ways to give a lattice the moduli of a material."""


def check_route(route: str) -> None:
    """Raise `ProblemError` for a name that is no route."""
    if route == "shear springs":
        raise ProblemError("route: 'shear springs' is gone; take 'volume energy'")
    require_one_of("route", route, ROUTES)


def calibration_of(
    material: Isotropic,
    pattern: Pattern,
    spacing: float,
    constants: Constants,
    volume: float,
    route: str,
    tensor: Array,
) -> Calibration:
    """The material, of the state and thickness asked for, that a tensor is."""
    found = moduli(tensor)
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


def _refuse_soft_cells(pattern: Pattern, spacing: float, result: Calibration) -> None:
    """Raise `ProblemError` where κ is too far below zero for points between the cells' corners."""
    d, mu = pattern.dim, result.tensor[-1, -1]
    least = least_stable_volume(pattern, result.constants) / spacing ** (d - 2)
    if result.volume > least * (1 - ALIKE):
        return
    ratio = least / mu + 1  # λ/μ
    raise ProblemError(
        f"{pattern.name} lattice: nu = {result.nu:.6g} takes κ = {result.volume:.6g} {UNIT[d]} in "
        f"its cells, unstable from {least:.6g} down, for its points are not all corners of cells: "
        f"take a ratio along its axes above {ratio / ((d - 1) * ratio + 2):.6g}"
    )
