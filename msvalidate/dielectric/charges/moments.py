"""The method of moments in the plane: charges of electrodes from their potentials.

A segment of charge q per depth (C/m), spread evenly, makes the potential -q/(2πε) times the mean
of ln r over it, in a medium of permittivity ε all around. The plane has no earth at infinity, so
potentials are known up to a constant c and the charges add up to nothing:

    [P  1] [q]   [V]
    [1' 0] [c] = [0].

Without the second row the answer would depend on the unit of length. Galerkin's weighting (means
over both segments) makes the charges those of least energy among all that are even on segments, so
forces are its derivatives (`forces`); collocation asks for the potential at the middles.

In the unit of length of the electrodes' own extent P is positive definite under Galerkin's
weighting, as that of any set of a logarithmic capacity below 1 is: Cholesky's factor serves it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import LinAlgError, cho_factor, cho_solve, lapack, lu_factor, lu_solve

from msvalidate.dielectric.charges.checks import (
    check_error,
    check_plane_points,
    check_positive,
    check_voltages,
    logarithm_error,
    refuse_dense,
)
from msvalidate.dielectric.charges.electrodes import Electrodes, to_complex
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import ReadOnly, dataclass
from msvalidate.springs.kernels.values import Complex

Weighting = Literal["galerkin", "collocation"]
WEIGHTINGS: tuple[Weighting, ...] = ("galerkin", "collocation")


@dataclass(frozen=True, eq=False)
class LineCharges(ReadOnly):
    """Charges of segments at given voltages. Arrays are read-only.

    Parameters
    ----------
    moments
        What they solve.
    voltages
        (k,) of the electrodes (V).
    charge
        (m,) of the segments, per depth (C/m).
    floating
        The constant c (V).
    error
        How far the charges may be from the solution of their equations, as sums over all segments
        of the sizes of both, by the condition of the matrix. Totals and energy share it. What the
        segments' number leaves out is not in it.
    """

    moments: Any
    voltages: Array
    charge: Array
    floating: float
    error: float

    @property
    def free(self) -> Array:
        """(m,) of the segments that a battery moved there, per depth (C/m)."""
        return self.charge

    @property
    def totals(self) -> Array:
        """(k,) of the electrodes, per depth (C/m)."""
        of = self.moments.electrodes
        return np.bincount(np.maximum(of.electrode, 0), self.free, of.count).astype(float)

    @property
    def energy(self) -> float:
        """½ΣQV per depth (J/m)."""
        return 0.5 * float(self.totals @ self.voltages)

    def potential(self, points: ArrayLike) -> Array:
        """Potential (n,) in V at points (n, 2) in m."""
        seen = integrals.seen(_check_points(points), *self.moments.electrodes.lines)
        charge = self.charge / (2 * np.pi * self.moments.around)
        return np.asarray(self.floating - seen @ charge)

    def field(self, points: ArrayLike) -> Array:
        """Field (n, 2) in V/m at points (n, 2) in m.

        On a segment the mean of its two sides. At the ends of segments, where densities jump, it is
        infinite, and NaN is returned.
        """
        seen = integrals.fields(_check_points(points), *self.moments.electrodes.lines)
        turned = np.conj(seen @ self.charge) / (2 * np.pi * self.moments.around)
        return np.column_stack([turned.real, turned.imag])


@dataclass(frozen=True, eq=False)
class Charges(LineCharges):
    """Charges of electrodes in one medium."""

    moments: Moments

    @property
    def density(self) -> Array:
        """(m,) charge per area (C/m²), of both faces together."""
        return self.charge / self.moments.electrodes.length


class Moments:
    """Electrodes with the factor of their equations, made once for any voltages.

    Source: the method of moments, [Harrington1968].

    Parameters
    ----------
    electrodes
        Two or more.
    permittivity
        Of the medium all around (F/m).
    weighting
        "galerkin" or "collocation".

    Raises
    ------
    ProblemError
        If there is but one electrode, segments are too many, or an argument is out of range.
    SolverError
        If segments are so close that rounding leaves their energies negative; from `charges`, if
        it leaves these no digits.
    """

    def __init__(
        self,
        electrodes: Electrodes,
        *,
        permittivity: float = 1.0,
        weighting: Weighting = "galerkin",
    ) -> None:
        self.electrodes = check_electrodes(electrodes)
        require_one_of("weighting", weighting, WEIGHTINGS)
        refuse_dense("segments", len(electrodes.segments))
        self.weighting: Weighting = weighting
        self.permittivity = self.around = check_positive("permittivity", permittivity, "F/m")
        matrix = coefficients(electrodes, self.permittivity, weighting)
        inverse, condition = factorise(matrix, symmetric=weighting == "galerkin")
        self._inverse, self._even = inverse, inverse(np.ones(len(matrix)))
        self._error = logarithm_error(electrodes.extent) * condition

    def charges(self, voltages: ArrayLike) -> Charges:
        """Charges at potentials (k,) in V, one for each electrode."""
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        level, middle = subtract_middle(given)
        charge, constant = self._solve(level[self.electrodes.electrode])
        return Charges(self, given, charge, float(constant) + middle, check_error(self._error))

    def solve(self, potential: Array) -> Array:
        """Charges (m,) or (m, k) in C/m at potentials of segments (V), neutral together."""
        return self._solve(potential)[0]

    def _solve(self, potential: Array) -> tuple[Array, Array]:
        """Charges P⁻¹(V - c), and the constant c with which they add up to nothing."""
        charge = self._inverse(potential)
        constant = charge.sum(axis=0) / self._even.sum()
        return charge - np.multiply.outer(self._even, constant), constant


def coefficients(electrodes: Electrodes, permittivity: float, weighting: Weighting) -> Array:
    """Maxwell's coefficients of potential P (m, m) in V·m/C: potentials of unit charges.

    They are zero at a distance of the electrodes' extent from a short segment: which distance it is
    makes no difference to charges that add up to nothing.

    Source: coefficients of potential [Maxwell1873]; weighting as in [Harrington1968].
    """
    start, along = electrodes.lines
    if weighting == "galerkin":
        mean: Array = integrals.means(start, along)
    else:
        mean = integrals.seen(to_complex(electrodes.middle), start, along)
    mean -= np.log(electrodes.extent)
    mean /= -2 * np.pi * permittivity
    return mean


Solve = Callable[..., Array]


def factorise(matrix: Array, *, symmetric: bool) -> tuple[Solve, float]:
    """The inverse of P (m, m), whose memory its factor takes, and P's condition in the 1-norm.

    The inverse of one that is not symmetric has an option `adjoint`, of its transpose. LAPACK
    estimates the condition from the factor, for a few solutions.

    Source: the estimate, [Higham2002], chapter 15.

    Raises
    ------
    SolverError
        If it has none, or is to be positive definite and is not.
    """
    # Transposed it is in the order of columns that LAPACK works in without a copy.
    norm = float(lapack.dlange("1", matrix.T))
    try:
        factor = (
            cho_factor(matrix.T, lower=True, overwrite_a=True, check_finite=False)
            if symmetric
            else lu_factor(matrix.T, overwrite_a=True, check_finite=False)
        )
    except LinAlgError as error:
        raise SolverError(
            "electrodes: to rounding, some of their segments lie on each other; move them apart, "
            "or take longer ones"
        ) from error
    if symmetric:
        inverse, _ = lapack.dpocon(factor[0], norm, uplo="L")
    else:
        inverse, _ = lapack.dgecon(factor[0], norm, norm="1")
    condition = 1 / float(inverse) if inverse > 0 else np.inf
    if symmetric:
        return lambda right: cho_solve(factor, right, check_finite=False), condition

    def solve(right: Array, *, adjoint: bool = False) -> Array:
        return np.asarray(lu_solve(factor, right, trans=int(not adjoint), check_finite=False))

    return solve, condition


def subtract_middle(voltages: Array) -> tuple[Array, float]:
    """Voltages less the middle of them, which makes no charge but would cost digits, and that."""
    middle = 0.5 * float(voltages.max()) + 0.5 * float(voltages.min())
    return voltages - middle, middle


def check_electrodes(electrodes: Electrodes) -> Electrodes:
    """Return electrodes; raise `ProblemError` unless they are two or more."""
    require_type("electrodes", electrodes, Electrodes)
    if electrodes.count < 2:
        raise ProblemError(
            "electrodes: one alone holds no charge in the plane, where all charges add up to "
            "nothing; add its counter-electrode"
        )
    return electrodes


def capacitance(electrodes: Electrodes, **how: object) -> float:
    """Capacitance per depth (F/m) of two electrodes; options as for `Moments`.

    Raises
    ------
    ProblemError
        If there are not two.
    """
    require_type("electrodes", electrodes, Electrodes)
    if electrodes.count != 2:
        raise ProblemError(f"electrodes: {electrodes.count}; a capacitance is of two")
    return float(Moments(electrodes, **how).charges((1.0, 0.0)).totals[0])  # type: ignore[arg-type]


def _check_points(points: ArrayLike) -> Complex:
    """Given points (n, 2) in m as complex numbers (n,); raise `ProblemError` unless they are."""
    return to_complex(check_plane_points("points", points))
