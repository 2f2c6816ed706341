"""The constants that make a body's lattice an isotropic material, or why there are none.

What a body made of the lattice will do under uniform tension is told with them, as a calibration is
of an endless lattice. A box on rollers is pulled along each axis, and its points are compared with
the material's uniform strain. Where no point is out of balance in that strain, it is exact, and no
equations are solved. Elsewhere springs that run across the cells' sides are cut (triangular in a
box, BCC, FCC), and the error is of first order: the part of the body that is next to its sides.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_array

from msvalidate.linear_algebra.factor import NoMemoryError, factorise
from msvalidate.problem import (
    SIDES,
    Array,
    Box,
    Isotropic,
    Problem,
    ProblemError,
    Support,
    Traction,
)
from msvalidate.problem.material import State
from msvalidate.problem.records import replace
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.calibration import Calibration, TensionCheck
from msvalidate.springs.constants.routes import calibrate_by_route
from msvalidate.springs.lattice import CutLattice, Lattice, Pattern, PatternLattice, fill
from msvalidate.springs.network import Network, tangent
from msvalidate.springs.network.inverse import elimination_order

MOST_TRIED = 800
"""Maximum number of points of a body for the tension test.

It takes a tenth of a second or two. A larger body is represented by a smaller one of the same
lattice.
"""
MOST_FACTORED = 30_000
"""Maximum number of points of a body without a pattern for a factor.

Larger ones get no result that needs a factor.
"""
BALANCED = 1e-9
"""Relative out-of-balance force that is rounding.

At a ratio near 1/2, stiffnesses are a thousand times the rest, and each sum is rounded by 1e-16 of
its terms.
"""
PULL = 1e-3
"""Traction over Young's modulus; answers to first order do not depend on it."""
NOT_KNOWN = TensionCheck("not known", math.nan, 0)


def calibrate(
    E: float,
    nu: float,
    lattice: Pattern | Lattice,
    plane: State = "plane_stress",
    *,
    thickness: float = 1.0,
    spacing: float | None = None,
    route: str | None = None,
) -> Calibration:
    """Find the constants with which a lattice has given isotropic moduli.

    A lattice of central springs that deforms affinely has nu = 1/3 in plane stress and 1/4 in plane
    strain and in 3D (Cauchy relation, [BornHuang1954]). Other ratios need a volume energy, or
    pressure in the cells.

    Parameters
    ----------
    E, nu
        Young's modulus (Pa) and Poisson's ratio of the three-dimensional material.
    lattice
        Unit cell (a function of `patterns` returns one), or a lattice that fills a body.
    plane
        "plane_stress" or "plane_strain" for a 2D lattice, "solid" for a 3D one.
    thickness
        Out-of-plane thickness (m) of a 2D body.
    spacing
        Length (m) of the unit of a pattern, default 1; a lattice in a body has its own spacing.
    route
        "springs", "volume energy" or "neo-Hookean". Default: springs alone if they suffice,
        otherwise springs with a volume energy.

    Returns
    -------
    Calibration
        Spring constants (N/m, thickness included; Pa for 3D mesh edges), one per kind of spring;
        stiffness κ of the volume energy (N/m in 2D, Pa in 3D); and the homogenised tensor. For a
        body, ``body`` states the error under uniform tension.

    Raises
    ------
    ProblemError
        If the lattice cannot have these moduli by this route; the message names the nearest that it
        can have.

    Examples
    --------
    >>> from msvalidate import calibrate, patterns
    >>> result = calibrate(1e5, 0.45, patterns.square(), "plane_strain", thickness=0.2)
    >>> result.route
    'volume energy'
    >>> print(f"{result.E:.6g} Pa, nu = {result.nu:.2f}")
    100000 Pa, nu = 0.45
    """
    material = Isotropic(E=E, nu=nu, state=plane, thickness=thickness)
    return calibrate_material(material, lattice, spacing=spacing, route=route)


def calibrate_material(
    material: Isotropic,
    lattice: Pattern | Lattice,
    *,
    spacing: float | None = None,
    route: str | None = None,
) -> Calibration:
    """Find the constants with which a lattice has a material's moduli.

    The route is a given one or the first possible.

    The endless lattice is that material. Of a body, `Calibration.body` says how far it is.

    Parameters
    ----------
    material, lattice
        What is to be, and of what.
    spacing
        Length (m) of a pattern's unit, by default 1; a body has its own.
    route
        One of `ROUTES`; None takes springs alone where they will do, or else a volume energy.

    Raises
    ------
    ProblemError
        With the reason and the nearest that there is, if there is no way.
    """
    found = calibrate_by_route(material, lattice, spacing, route)
    if isinstance(lattice, Pattern):
        return found
    return replace(found, body=_check_uniform_tension(material, lattice, found))


def _check_uniform_tension(
    material: Isotropic, lattice: Lattice, calibration: Calibration
) -> TensionCheck:
    """Response of a body of a calibrated lattice to uniform tension."""
    if isinstance(lattice, CutLattice) or not isinstance(lattice.domain, Box):
        return NOT_KNOWN
    small, scale = _smaller_lattice(lattice)
    stiff = min(calibration.volume, *calibration.constants) >= 0
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # what is infinite is not known
            body = _measure_tension(
                _on_rollers(material, small, calibration), small.points, stiff=stiff
            )
    except ProblemError:  # such as cells that do not fill the body, said when it is made
        return NOT_KNOWN
    return replace(body, error=scale * body.error)


def _measure_tension(
    pulls: list[tuple[Network, Array]], points: Array, *, stiff: bool
) -> TensionCheck:
    """Error of a body (n, d) in tension along each axis.

    `pulls` are pairs of a loaded network and the normal strains (d,) of the material under its
    load; all have one tangent. `points` (n, d) are in m. `stiff` states that no constant is
    negative, so that a balanced body needs no factor.
    """
    first, _ = pulls[0]
    K, free = tangent(first, points), np.flatnonzero(~first.fixed.ravel())
    wanted = [points * strain for _, strain in pulls]
    left = np.column_stack(
        [
            (network.force.ravel() - K @ u.ravel())[free]
            for (network, _), u in zip(pulls, wanted, strict=True)
        ]
    )
    most = max(float(np.abs(network.force).max()) for network, _ in pulls)
    balanced = bool(np.abs(left).max() <= BALANCED * most)
    if balanced and stiff:
        return TensionCheck("exact", 0.0, len(points))
    if len(points) > MOST_FACTORED:
        return NOT_KNOWN
    try:
        factor = factorise(csr_array(K[free][:, free]), elimination_order(first))
    except NoMemoryError:
        raise
    except RuntimeError:  # a pivot of zero
        return TensionCheck("unstable", math.nan, len(points))
    if factor.negative:
        return TensionCheck("unstable", math.nan, len(points))
    if balanced:
        return TensionCheck("exact", 0.0, len(points))
    off = np.abs(factor.solve(left)).max(axis=0)
    error = max(float(o / np.abs(u).max()) for o, u in zip(off, wanted, strict=True))
    return TensionCheck("first order", error, len(points)) if math.isfinite(error) else NOT_KNOWN


def _smaller_lattice(lattice: Lattice) -> tuple[Lattice, float]:
    """Smaller body of the same lattice with about `MOST_TRIED` points.

    The second value is its smallest number of cells along an axis, relative to that of the body.
    The body itself is returned if it is no larger, or its repeating cell is unknown.
    """
    box = lattice.domain
    if len(lattice.points) <= MOST_TRIED or not isinstance(box, Box):
        return lattice, 1.0
    if not isinstance(lattice, PatternLattice):
        return lattice, 1.0
    pattern = lattice.pattern
    edge = lattice.spacing * np.array(pattern.size)
    counts = np.rint(np.array(box.size) / edge)
    shrink = (MOST_TRIED / len(lattice.points)) ** (1 / box.dim)
    fewer = np.maximum(1, np.floor(counts * shrink)).astype(int)
    small = fill(pattern, Box(tuple(float(x) for x in fewer * edge)), tuple(fewer.tolist()))
    return small, float(fewer.min() / counts.min())


def _on_rollers(
    material: Isotropic, lattice: Lattice, calibration: Calibration
) -> list[tuple[Network, Array]]:
    """The body on rollers pulled along each axis, with the strain (d,) that the material has."""
    box = lattice.domain
    assert isinstance(box, Box)  # noqa: S101  `tried` has seen to it
    axes = range(box.dim)
    names = {place: name for name, place in SIDES.items()}
    rollers = tuple(
        Support(box.side(names[axis, 0]), tuple(0.0 if a == axis else None for a in axes))
        for axis in axes
    )
    pulls = []
    for axis in axes:
        traction = PULL * material.E * np.eye(box.dim)[axis]
        load = Traction(box.side(names[axis, 1]), tuple(traction.tolist()))
        network = lattice_network(Problem(box, material, rollers, (load,)), lattice, calibration)
        stress = np.zeros(len(calibration.tensor))
        stress[: box.dim] = traction * (material.thickness if box.dim == 2 else 1.0)
        strain: Array = np.linalg.solve(calibration.tensor, stress)[: box.dim].astype(float)
        pulls.append((network, strain))
    return pulls
