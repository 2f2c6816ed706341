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

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import (
    check_error,
    check_permittivity,
    check_plane_points,
    check_voltages,
    logarithm_error,
    refuse_dense,
)
from msvalidate.dielectric.charges.electrodes import Electrodes
from msvalidate.dielectric.charges.neutral import Neutral, factorise, subtract_middle
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import ReadOnly, dataclass

Weighting = Literal["galerkin", "collocation"]
WEIGHTINGS: tuple[Weighting, ...] = ("galerkin", "collocation")

Complex = np.ndarray[tuple[int, ...], np.dtype[np.complex128]]


def to_complex(points: Array) -> Complex:
    """Points or vectors (n, 2) as complex numbers (n,), as `kernels.charges` takes them."""
    return np.ascontiguousarray(points).view(np.complex128)[..., 0]


def check_points(points: ArrayLike) -> Complex:
    """Given points (n, 2) in m as complex numbers (n,); raise `ProblemError` unless they are."""
    return to_complex(check_plane_points("points", points))


def segment_lines(electrodes: Electrodes) -> tuple[Complex, Complex]:
    """Starts and vectors (m,) of segments as complex numbers."""
    return to_complex(electrodes.start), to_complex(electrodes.along)


@dataclass(frozen=True, eq=False)
class Charges(ReadOnly):
    """Charges at given voltages. Arrays are read-only.

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

    moments: Moments
    voltages: Array
    charge: Array
    floating: float
    error: float

    @property
    def density(self) -> Array:
        """(m,) charge per area (C/m²), of both faces together."""
        return self.charge / self.moments.electrodes.length

    @property
    def totals(self) -> Array:
        """(k,) of the electrodes, per depth (C/m)."""
        electrodes = self.moments.electrodes
        return np.bincount(electrodes.electrode, self.charge, electrodes.count).astype(float)

    @property
    def energy(self) -> float:
        """½ΣQV per depth (J/m)."""
        return 0.5 * float(self.totals @ self.voltages)

    def potential(self, points: ArrayLike) -> Array:
        """Potential (n,) in V at points (n, 2) in m."""
        seen = integrals.seen(check_points(points), *segment_lines(self.moments.electrodes))
        charge = self.charge / (2 * np.pi * self.moments.permittivity)
        return np.asarray(self.floating - seen @ charge)

    def field(self, points: ArrayLike) -> Array:
        """Field (n, 2) in V/m at points (n, 2) in m.

        On an electrode the mean of its two faces. At the ends of segments, where densities jump, it
        is infinite, and NaN is returned.
        """
        seen = integrals.fields(check_points(points), *segment_lines(self.moments.electrodes))
        turned = np.conj(seen @ self.charge) / (2 * np.pi * self.moments.permittivity)
        return np.column_stack([turned.real, turned.imag])


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
        self.permittivity = check_permittivity(permittivity)
        matrix = coefficients(electrodes, self.permittivity, weighting)
        inverse, condition = factorise(matrix, symmetric=weighting == "galerkin")
        self._neutral = Neutral(inverse, len(matrix))
        self._error = logarithm_error(electrodes.extent) * condition

    def charges(self, voltages: ArrayLike) -> Charges:
        """Charges at potentials (k,) in V, one for each electrode."""
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        level, middle = subtract_middle(given)
        solved = self._neutral(level[self.electrodes.electrode])
        constant = float(solved[-1]) + middle
        return Charges(self, given, solved[:-1], constant, check_error(self._error))

    def solve(self, potential: Array) -> Array:
        """Charges (m,) or (m, k) in C/m at potentials of segments (V), neutral together."""
        return self._neutral(potential)[:-1]


def coefficients(electrodes: Electrodes, permittivity: float, weighting: Weighting) -> Array:
    """Maxwell's coefficients of potential P (m, m) in V·m/C: potentials of unit charges.

    They are zero at a distance of the electrodes' extent from a short segment: which distance it is
    makes no difference to charges that add up to nothing.

    Source: coefficients of potential [Maxwell1873]; weighting as in [Harrington1968].
    """
    start, along = segment_lines(electrodes)
    if weighting == "galerkin":
        mean: Array = integrals.means(start, along)
    else:
        mean = integrals.seen(to_complex(electrodes.middle), start, along)
    mean -= np.log(electrodes.extent)
    mean /= -2 * np.pi * permittivity
    return mean


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
