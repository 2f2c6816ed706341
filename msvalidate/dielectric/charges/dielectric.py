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
    check_permittivity,
    check_ratio,
    check_voltages,
    logarithm_error,
    refuse_dense,
)
from msvalidate.dielectric.charges.faces import Faces
from msvalidate.dielectric.charges.moments import Complex, check_points, to_complex
from msvalidate.dielectric.charges.neutral import factorise, subtract_middle
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.dielectric.kernels import fluxes
from msvalidate.problem import Array
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import ReadOnly, dataclass, replace


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
        self.faces = faces
        self.ratio = check_ratio(ratio)
        self.permittivity = check_permittivity(permittivity)
        self.flux: Array = fluxes.crossed(*self.lines()).imag / (2 * np.pi)
        self._inverse, self._condition = factorise(self._equations(), symmetric=False)

    @property
    def air(self) -> float:
        """Permittivity of the air (F/m)."""
        return self.permittivity / self.ratio

    @property
    def contrast(self) -> float:
        """(ε_r-1)/(ε_r+1)."""
        return (self.ratio - 1) / (self.ratio + 1)

    def charges(self, voltages: ArrayLike) -> ChargesInAir:
        """Charges at potentials (k,) in V, one for each electrode."""
        given = check_voltages("an electrode", self.faces.count, voltages)
        level, middle = subtract_middle(given)
        solved = self.solve(self.air * np.where(self.faces.bare, 0.0, level[self.faces.electrode]))
        constant = float(solved[-1]) / self.air + middle
        rounding = logarithm_error(float(np.ptp(self.faces.points, axis=0).max()))
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
        n, bare = len(self.faces.points), self.faces.bare
        whole = np.ones((n + 1, n + 1))
        whole[:n, :n] = integrals.means(*self.lines()) / (-2 * np.pi)
        whole[:n][bare] = 0.0
        whole[:n, :n][bare] = np.eye(n)[bare] - 2 * self.contrast * self.flux[bare]
        whole[n, n] = 0.0
        return whole

    def lines(self) -> tuple[Complex, Complex]:
        """Starts and vectors (n,) of segments, complex, as `kernels.charges` takes them."""
        return to_complex(self.faces.points), to_complex(self.faces.along)


@dataclass(frozen=True, eq=False)
class ChargesInAir(ReadOnly):
    """Charges at given voltages. Arrays are read-only.

    Parameters
    ----------
    moments
        What they solve.
    voltages
        (k,) of the electrodes (V).
    charge
        (n,) free and bound of the segments, per depth (C/m).
    floating
        The constant (V) that the potentials of the charges lack.
    error
        How far the charges, and the free ones, may be from the solution of their equations, as sums
        over all segments of the sizes of both, by the condition of the matrix. Totals and energy
        share it. What the segments' number leaves out is not in it.
    """

    moments: SlabInAir
    voltages: Array
    charge: Array
    floating: float
    error: float

    @property
    def free(self) -> Array:
        """(n,) free charge of the segments, per depth (C/m); none on bare faces."""
        moments = self.moments
        ratio, passed = moments.ratio, moments.flux @ self.charge
        return np.where(
            moments.faces.bare, 0.0, 0.5 * (1 + ratio) * self.charge - (ratio - 1) * passed
        )

    @property
    def totals(self) -> Array:
        """(k,) free charge of the electrodes, per depth (C/m)."""
        faces = self.moments.faces
        covered = ~faces.bare
        total = np.bincount(faces.electrode[covered], self.free[covered], faces.count)
        return np.asarray(total, dtype=float)

    @property
    def energy(self) -> float:
        """½ΣQV per depth (J/m)."""
        return 0.5 * float(self.totals @ self.voltages)

    def potential(self, points: ArrayLike) -> Array:
        """Potential (k,) in V at points (k, 2) in m, inside the body and out."""
        seen = integrals.seen(check_points(points), *self.moments.lines())
        at: Array = self.floating - seen @ self.charge / (2 * np.pi * self.moments.air)
        return at

    def field(self, points: ArrayLike) -> Array:
        """Field (k, 2) in V/m at points (k, 2) in m; on the surface the mean of its two sides."""
        seen = integrals.fields(check_points(points), *self.moments.lines())
        turned = np.conj(seen @ self.charge) / (2 * np.pi * self.moments.air)
        return np.column_stack([turned.real, turned.imag])


def _cancellation(charges: ChargesInAir) -> float:
    """Factor by which the free charge loses relative accuracy, being a difference."""
    ratio = charges.moments.ratio
    taken, free = float(np.abs(charges.charge).sum()), float(np.abs(charges.free).sum())
    return max(1.0, (1 + ratio) * taken / free) if free else 1.0


def forces_in_air(charges: ChargesInAir) -> Array:
    """Force (n, 2) per depth (N/m) on each point of the surface, bare or covered.

    The energy's derivative in the points at fixed voltages, W = ½Σ V·Q. The equations are not
    symmetric, so it takes the adjoint y of the charges:

        dW = -½ y'(dP)q over electrodes + ½ [2·contrast·y - (ε_r-1)·V]'(dΦ)q,

    y on bare faces, V on electrodes. It holds the traction on faces, the pull at the edges of
    electrodes, and the moments of both on the ends of segments.

    At the edge of an electrode on a smooth face, r away, tractions go like ±1/r for ε_r other than
    1: inwards on the electrode, outwards beside it. Together they have a limit, each alone has
    none: sums over a finer and finer electrode without its neighbourhood do not converge.
    """
    require_type("charges", charges, ChargesInAir)
    moments = charges.moments
    on_covered, weight = adjoint_weights(charges)
    lines = *moments.lines(), moments.faces.segments
    n, charge = len(weight), charges.charge
    more, less = (integrals.pulled(*lines, on_covered + s * charge, n) for s in (1, -1))
    flux = fluxes.dragged(*lines, weight, charge, n)
    # A form of two vectors, from that of one.
    total = (more - less) / (16 * np.pi * moments.air) + flux / (2 * np.pi)
    return np.column_stack([total.real, -total.imag])


def adjoint_weights(charges: ChargesInAir) -> tuple[Array, Array]:
    """The weights (n,) of (dP)q, times the air's permittivity, and of (dΦ)q in `forces_in_air`."""
    moments = charges.moments
    faces, ratio = moments.faces, moments.ratio
    volt = np.where(faces.bare, 0.0, charges.voltages[faces.electrode])
    answer = moments.solve(
        0.5 * (1 + ratio) * volt - (ratio - 1) * (volt @ moments.flux), adjoint=True
    )[:-1]
    on_bare = np.where(faces.bare, answer, 0.0)
    return moments.air * (answer - on_bare), moments.contrast * on_bare - 0.5 * (ratio - 1) * volt
