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
from scipy.linalg import lu_factor, lu_solve

from msvalidate.dielectric.charges.checks import (
    ROUNDED,
    check_error,
    check_owners,
    check_permittivity,
    check_voltages,
    condition_number,
    freeze,
    one_norm,
    refuse_dense,
    refuse_gaps,
)
from msvalidate.dielectric.charges.contact import areas, refuse_overlap, refuse_tilted
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


class PatchMoments:
    """Patches with the factor of their equations, made once for any voltages.

    Parameters
    ----------
    patches
        One conductor or more.
    permittivity
        Of the medium all around (F/m).

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """

    def __init__(self, patches: Patches, *, permittivity: float = 1.0) -> None:
        require_type("patches", patches, Patches)
        refuse_dense("patches", len(patches.corners))
        self.patches = patches
        self.permittivity = check_permittivity(permittivity)
        mean = polygons.seen(patches.middle, patches.corners) / patches.area
        equations = np.asfortranarray(mean / (4 * np.pi * self.permittivity))
        norm = one_norm(equations)
        self._factor = lu_factor(equations, overwrite_a=True)
        self._condition = condition_number(self._factor[0], norm, symmetric=False)

    def charges(self, voltages: ArrayLike) -> PatchCharges:
        """Charges at potentials (k,) in V, one for each conductor, over that far away."""
        given = check_voltages("a conductor", self.patches.count, voltages)
        charge = lu_solve(self._factor, given[self.patches.conductor])
        error = check_error(ROUNDED * self._condition)
        return PatchCharges(self, given, charge, error)


@dataclass(frozen=True, eq=False)
class PatchCharges:
    """Charges at given voltages. Arrays are read-only.

    Parameters
    ----------
    moments
        What they solve.
    voltages
        (k,) of the conductors (V).
    charge
        (n,) of the patches (C).
    error
        How far the charges may be from the solution of their equations, as sums over all patches of
        the sizes of both, by the condition of the matrix.
    """

    moments: PatchMoments
    voltages: Array
    charge: Array
    error: float

    def __post_init__(self) -> None:
        self.charge.setflags(write=False)

    @property
    def density(self) -> Array:
        """(n,) charge per area (C/m²), of both faces together."""
        return self.charge / self.moments.patches.area

    @property
    def totals(self) -> Array:
        """(k,) of the conductors (C)."""
        patches = self.moments.patches
        total = np.bincount(patches.conductor, self.charge, patches.count)
        return np.asarray(total, dtype=float)

    @property
    def energy(self) -> float:
        """½ΣQV (J)."""
        return 0.5 * float(self.totals @ self.voltages)

    def potential(self, points: ArrayLike) -> Array:
        """Potential (k,) in V at points (k, 3) in m."""
        at = finite_coordinates("points", points, "k", 3)
        seen = polygons.seen(at, self.moments.patches.corners)
        total: Array = seen @ self.density / (4 * np.pi * self.moments.permittivity)
        return total


def patch_capacitance(patches: Patches, *, permittivity: float = 1.0) -> float:
    """Capacitance (F) of one conductor to far away, or between two of opposite potentials.

    Raises
    ------
    ProblemError
        If there are more than two conductors, or as `PatchMoments`.
    """
    moments = PatchMoments(patches, permittivity=permittivity)
    if patches.count > 2:
        raise ProblemError(f"patches: {patches.count} conductors; a capacitance is of one or two")
    voltages = (1.0,) if patches.count == 1 else (0.5, -0.5)
    return float(moments.charges(voltages).totals[0])


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
