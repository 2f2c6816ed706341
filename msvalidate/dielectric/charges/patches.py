"""Conductors in space, made of flat patches: bodies whose capacitance is known verify the method.

A patch is a polygon parallel to the plane z = 0 that carries an even charge, whose potential is
exact (`kernels.polygons`); it is asked for at one point of each patch. In space the potential is
zero far away, so charges need not add up to nothing.

Charge grows without bound towards edges, and more so towards corners, so patches must be finer
there: where the n-th line lies n⁴ from an edge, 36 x 36 patches have the capacitance of a square to
1e-4 and 24 rings that of a disc to 5e-5. Means over patches in place of values at points (Galerkin)
halve these errors, for twice the time and a closed form that loses its digits on such meshes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    ROUNDED,
    check_error,
    check_owners,
    check_permittivity,
    check_voltages,
    freeze,
    refuse_dense,
    refuse_gaps,
)
from msvalidate.dielectric.charges.contact import areas, refuse_overlap, refuse_tilted
from msvalidate.dielectric.charges.neutral import factorise
from msvalidate.dielectric.kernels import polygons
from msvalidate.problem import PLACEMENT, Array, Index, ProblemError
from msvalidate.problem.checks import finite_coordinates, require_type
from msvalidate.problem.records import dataclass


@dataclass(frozen=True, eq=False)
class Patches:
    """Conductors without thickness, each of patches at one potential. Arrays are read-only.

    Parameters
    ----------
    corners
        (n, c, 3) of polygons parallel to z = 0 (m), in order, either way round. A corner that is
        given several times in a row counts once.
    conductor
        (n,) which conductor each patch belongs to: 0, 1, ..., none left out.
    middle
        (n, 3) a point of each patch, where its potential is asked for (m).

    Raises
    ------
    ProblemError
        If a patch is not parallel to z = 0, has no area, crosses itself or is without its middle,
        if patches overlap, or if conductors touch.
    """

    corners: Array
    conductor: Index
    middle: Array

    def __post_init__(self) -> None:
        need = "give (n, c, 3), c above 2"
        corners = finite_coordinates("corners of patches", self.corners, "n>0", "c>2", 3, need=need)
        middle = finite_coordinates("middles of patches", self.middle, len(corners), 3)
        conductor = check_owners("conductor", self.conductor, len(corners))
        refuse_gaps("conductor", conductor)
        corners = np.where((areas(corners) < 0)[:, None, None], corners[:, ::-1], corners)
        near = PLACEMENT * float(np.ptp(corners.reshape(-1, 3), axis=0).max())
        refuse_tilted(corners, middle, near)
        refuse_overlap(corners, conductor, middle, near)
        freeze(self, corners=corners, conductor=conductor, middle=middle)

    @property
    def count(self) -> int:
        """Number of conductors."""
        return int(self.conductor.max()) + 1

    @property
    def area(self) -> Array:
        """(n,) in m²."""
        return areas(self.corners)


@dataclass(frozen=True, eq=False)
class PatchCharges:
    """Charges at given voltages.

    Parameters
    ----------
    charge
        (n,) of the patches (C).
    totals
        (k,) of the conductors (C).
    error
        How far the charges may be from the solution of their equations, as sums over all patches of
        the sizes of both, by the condition of the matrix.
    """

    charge: Array
    totals: Array
    error: float


def patch_charges(
    patches: Patches, voltages: ArrayLike, *, permittivity: float = 1.0
) -> PatchCharges:
    """Charges of conductors at potentials (k,) in V over that far away.

    Parameters
    ----------
    patches
        One conductor or more.
    voltages
        One for each conductor (V).
    permittivity
        Of the medium all around (F/m).

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If rounding leaves the charges no digits.
    """
    require_type("patches", patches, Patches)
    refuse_dense("patches", len(patches.corners))
    scale = 4 * np.pi * check_permittivity(permittivity)
    given = check_voltages("a conductor", patches.count, voltages)
    seen = polygons.seen(patches.middle, patches.corners) / patches.area
    inverse, condition = factorise(seen / scale, symmetric=False)
    charge = inverse(given[patches.conductor])
    totals = np.asarray(np.bincount(patches.conductor, charge, patches.count), dtype=float)
    return PatchCharges(charge, totals, check_error(ROUNDED * condition))


def patch_capacitance(patches: Patches, *, permittivity: float = 1.0) -> float:
    """Capacitance (F) of one conductor to far away, or between two of opposite potentials.

    Raises
    ------
    ProblemError
        If there are more than two conductors, or as `patch_charges`.
    """
    require_type("patches", patches, Patches)
    if patches.count > 2:
        raise ProblemError(f"patches: {patches.count} conductors; a capacitance is of one or two")
    voltages = (1.0,) if patches.count == 1 else (0.5, -0.5)
    return float(patch_charges(patches, voltages, permittivity=permittivity).totals[0])


def conductors(*bodies: Patches) -> Patches:
    """The patches of several bodies together; conductors are numbered in the order given."""
    for body in bodies:
        require_type("bodies", body, Patches)
    if not bodies:
        raise ProblemError("bodies: none; give the patches of each")
    most = max(body.corners.shape[1] for body in bodies)
    padded = [
        np.pad(body.corners, ((0, 0), (0, most - body.corners.shape[1]), (0, 0)), mode="edge")
        for body in bodies
    ]
    before = np.cumsum([0, *(body.count for body in bodies)])
    return Patches(
        np.concatenate(padded),
        np.concatenate([k + body.conductor for k, body in zip(before, bodies, strict=False)]),
        np.concatenate([body.middle for body in bodies]),
    )
