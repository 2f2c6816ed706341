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

from typing import Literal, Protocol

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
from msvalidate.dielectric.charges.neutral import Neutral, factorise, neutral_gmres, subtract_middle
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import dataclass

Weighting = Literal["galerkin", "collocation"]
WEIGHTINGS: tuple[Weighting, ...] = ("galerkin", "collocation")
LEAST_ITERATED = 1500
"""Segments below which a new factor costs less than iterations with an old one."""
RESIDUAL = 1e-12
"""Of the potentials, left by iterations."""
MOST_STEPS = 25
"""Iterations beyond which electrodes have moved too far for an old factor, and get their own."""

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


class Equations(Protocol):
    """Equations for charges: `Moments`, or `multipole.Multipole`."""

    electrodes: Electrodes
    permittivity: float
    weighting: Weighting

    def solve(self, potential: Array) -> Array:
        """Charges (m,) or (m, k) in C/m at potentials of segments (V), neutral together."""


@dataclass(frozen=True, eq=False)
class Charges:
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
        of the sizes of both, by the condition of the matrix or what one more correction changes.
        Totals and energy share it. What the segments' number leaves out is not in it.
    iterations
        Of GMRES, 0 if a factor of these equations was at hand.
    """

    moments: Equations
    voltages: Array
    charge: Array
    floating: float
    error: float
    iterations: int = 0

    def __post_init__(self) -> None:
        self.voltages.setflags(write=False)
        self.charge.setflags(write=False)

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
        self._state(electrodes, permittivity, weighting)
        self._nearby: Neutral | None = None
        self._own: Neutral | None = self._factorise()

    def _state(self, electrodes: Electrodes, permittivity: float, weighting: Weighting) -> None:
        self.electrodes = check_electrodes(electrodes)
        require_one_of("weighting", weighting, WEIGHTINGS)
        refuse_dense("segments", len(electrodes.segments))
        self.weighting: Weighting = weighting
        self.permittivity = check_permittivity(permittivity)
        self._matrix: Array | None = None

    def moved(self, points: ArrayLike) -> Moments:
        """The same electrodes with their points (n, 2) elsewhere (m).

        If they are many, their charges come from GMRES with the factor made for these: a few steps
        while the points are near their old places. A solve that would take many makes the factor
        of the new ones.
        """
        later = Moments.__new__(Moments)
        later._state(self.electrodes.moved(points), self.permittivity, self.weighting)
        few = len(self.electrodes.segments) < LEAST_ITERATED
        later._nearby = None if few else self._own or self._nearby
        later._own = later._factorise() if few else None
        return later

    def charges(self, voltages: ArrayLike) -> Charges:
        """Charges at potentials (k,) in V, one for each electrode."""
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        level, middle = subtract_middle(given)
        solved, steps, error = self._solve(level[self.electrodes.electrode])
        constant = float(solved[-1]) + middle
        return Charges(self, given, solved[:-1], constant, check_error(error), steps)

    def solve(self, potential: Array) -> Array:
        """Charges (m,) or (m, k) in C/m at potentials of segments (V), neutral together."""
        return self._solve(potential)[0][:-1]

    def _solve(self, potential: Array) -> tuple[Array, int, float]:
        """Charges (m,) or (m, k) and then the constant, the steps taken, and the charges' error."""
        if self._own is None and potential.ndim == 1:
            found = self._iterate(potential)
            if found is not None:
                return found
        if self._own is None:
            self._own, self._nearby = self._factorise(), None
        return self._own(potential), 0, self._rounding * self._own.condition

    def _factorise(self) -> Neutral:
        """The solution by a factor, for which the matrix is given up."""
        matrix = self._coefficients()
        self._matrix = None
        solve, condition = factorise(matrix, symmetric=self.weighting == "galerkin")
        return Neutral(solve, len(matrix), condition)

    def _iterate(self, potential: Array) -> tuple[Array, int, float] | None:
        """GMRES, or None if it takes too many steps."""
        self._matrix = matrix = self._coefficients()
        m, nearby = len(matrix), self._nearby
        assert nearby is not None  # noqa: S101  `moved` has seen to it

        def bordered(x: Array) -> Array:
            return np.append(matrix @ x[:m] + x[m], x[:m].sum())

        found = neutral_gmres(
            bordered,
            lambda x: nearby(x[:m], float(x[m])),
            potential,
            most=MOST_STEPS,
            residual=RESIDUAL,
        )
        if found is None:
            return None
        return found.solved, found.steps, found.error + self._rounding * nearby.condition

    @property
    def _rounding(self) -> float:
        return logarithm_error(self.electrodes.extent)

    def _coefficients(self) -> Array:
        if self._matrix is not None:
            return self._matrix
        return coefficients(self.electrodes, self.permittivity, self.weighting)


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
