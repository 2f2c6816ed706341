"""A dielectric body in air with electrodes on parts of its surface, by free and bound charge.

In a body of even permittivity ε, all charge sits on its surface. Free and bound together, q on each
segment, act as in empty space of the air's permittivity ε/ε_r:

    on electrodes    Σⱼ Pᵢⱼ qⱼ + c = V               mean potential over the segment,
    on bare faces    qᵢ = 2·(ε_r-1)/(ε_r+1)·Σⱼ Φᵢⱼ qⱼ    no free charge,
    all together     Σ qⱼ = 0.

Φᵢⱼ is the part of the flux of qⱼ that leaves the body through segment i, in the mean of both sides:
outside the normal field is more by q/(2εₐl), inside it is less by as much, and the bare face asks
that ε_r times the one inside be the one outside. The last row is two statements at once: the bound
charge of a body adds up to nothing, and so does what a battery moved. With fluxes that are exact
means over segments, the free charge

    Qᵢ = εₐ·l·(E_out - ε_r·E_in)ᵢ = ½(1+ε_r)·qᵢ - (ε_r-1)·Σⱼ Φᵢⱼ qⱼ

adds up to nothing to rounding. For ε_r = 1 all this is Galerkin's `Moments`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    check_error,
    check_positive,
    check_voltages,
    logarithm_error,
    refuse_dense,
)
from msvalidate.dielectric.charges.faces import Faces
from msvalidate.dielectric.charges.moments import LineCharges, factorise, subtract_middle
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.dielectric.kernels import fluxes
from msvalidate.problem import Array
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, replace


class SlabInAir:
    """A body in air with the factor of its equations, made once for any voltages.

    Parameters
    ----------
    faces
        Its surface.
    ratio
        Permittivity of the body over that of the air around it, ε_r.
    permittivity
        Of the body (F/m).

    Attributes
    ----------
    around
        Permittivity of the air (F/m).
    flux
        Φ (n, n): part of the flux of one segment's charge that leaves through another.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """

    def __init__(self, faces: Faces, *, ratio: float = 1.0, permittivity: float = 1.0) -> None:
        require_type("faces", faces, Faces)
        refuse_dense("segments", len(faces.points))
        self.electrodes = faces
        self.ratio = check_positive("ratio", ratio)
        self.permittivity = check_positive("permittivity", permittivity, "F/m")
        self.around = self.permittivity / self.ratio
        self.flux: Array = fluxes.crossed(*self.electrodes.lines).imag / (2 * np.pi)
        self._inverse, self._condition = factorise(self._equations(), symmetric=False)

    @property
    def contrast(self) -> float:
        """(ε_r-1)/(ε_r+1)."""
        return (self.ratio - 1) / (self.ratio + 1)

    def charges(self, voltages: ArrayLike) -> ChargesInAir:
        """Charges at potentials (k,) in V, one for each electrode."""
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        level, middle = subtract_middle(given)
        wanted = np.where(self.electrodes.bare, 0.0, level[self.electrodes.electrode])
        solved = self.solve(self.around * wanted)
        constant = float(solved[-1]) / self.around + middle
        rounding = logarithm_error(self.electrodes.extent)
        found = ChargesInAir(
            self, given, solved[:-1], constant, check_error(rounding * self._condition)
        )
        return replace(found, error=found.error * _cancellation(found))

    def solve(self, right: Array, *, adjoint: bool = False) -> Array:
        """Solution (n + 1, ...) for n rows of the equations; `adjoint` transposes them."""
        neutral = np.zeros((1, *right.shape[1:]))
        return self._inverse(np.concatenate([right, neutral]), adjoint=adjoint)

    def _equations(self) -> Array:
        """Potentials times the air's permittivity, charges on bare faces, neutrality."""
        n, bare = len(self.electrodes.points), self.electrodes.bare
        whole = np.ones((n + 1, n + 1))
        whole[:n, :n] = integrals.means(*self.electrodes.lines) / (-2 * np.pi)
        whole[:n][bare] = 0.0
        whole[:n, :n][bare] = np.eye(n)[bare] - 2 * self.contrast * self.flux[bare]
        whole[n, n] = 0.0
        return whole


@dataclass(frozen=True, eq=False)
class ChargesInAir(LineCharges):
    """Charges of a body's segments, free and bound together; `error` is that of the free ones too.

    Potential and field are of all of them, inside the body and out.
    """

    moments: SlabInAir

    @property
    def free(self) -> Array:
        """(n,) free charge of the segments, per depth (C/m); none on bare faces."""
        moments = self.moments
        ratio, passed = moments.ratio, moments.flux @ self.charge
        return np.where(
            moments.electrodes.bare, 0.0, 0.5 * (1 + ratio) * self.charge - (ratio - 1) * passed
        )


def _cancellation(charges: ChargesInAir) -> float:
    """Factor by which the free charge loses relative accuracy, being a difference."""
    ratio = charges.moments.ratio
    taken, free = float(np.abs(charges.charge).sum()), float(np.abs(charges.free).sum())
    return max(1.0, (1 + ratio) * taken / free) if free else 1.0
