"""Charges of more segments than a dense matrix serves: far ones by a fast multipole method.

A segment far from another acts on it as point charges on its Gauss points do, whose sums the
library pyfmmlib (FMMLIB2D of Gimbutas and Greengard) finds at a cost in proportion to their number.
Pairs that are near have the exact integrals of `kernels.charges` instead, a sparse matrix. The
equations are those of `moments` under Galerkin's weighting, solved by GMRES.

Its preconditioner is that of `two_levels`.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from msvalidate.dielectric.charges.checks import check_error, check_permittivity, check_voltages
from msvalidate.dielectric.charges.electrodes import Electrodes
from msvalidate.dielectric.charges.moments import (
    Charges,
    Complex,
    Weighting,
    check_electrodes,
    segment_lines,
)
from msvalidate.dielectric.charges.neutral import Iterated, neutral_gmres, subtract_middle
from msvalidate.dielectric.charges.two_levels import TwoLevels
from msvalidate.dielectric.kernels import charges as integrals
from msvalidate.problem import Array, Index, ProblemError, SolverError

NEAR = 8.0
"""Distance of the middles over the mean length up to which pairs have exact integrals."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = 0.5 * (_NODES + 1), 0.5 * _WEIGHTS
"""Gauss points on 0 ... 1: at the distance NEAR they leave out 1e-10 of a mean of ln r."""
PRECISION = 4
"""What the library calls 1e-12."""
RESIDUAL = 1e-10
"""Of the potentials, left by GMRES. Charges err by about ten times that, energies by far less."""
SUMMED = 1e-8
"""Error of charges by sums over Gauss points, which leave out 1e-10 of a mean of ln r: a hundred
times that, as it is for electrodes at a distance of a hundredth of their width."""
MOST_STEPS = 100


class Multipole:
    """Electrodes of very many segments; used as `Moments` is.

    Time and memory are in proportion to their number: a millisecond or two and 10 kB a segment, so
    that `Moments` is quicker up to some 10,000. `forces` of the charges look at all pairs, without
    a matrix; `tangent` needs one.

    Source: [GreengardRokhlin1987], by the library [pyfmmlib].

    Parameters
    ----------
    electrodes
        Two or more.
    permittivity
        Of the medium all around (F/m).

    Raises
    ------
    ProblemError
        If the optional library is not installed, there is but one electrode, or an argument is out
        of range.
    """

    def __init__(self, electrodes: Electrodes, *, permittivity: float = 1.0) -> None:
        self._library = _library()
        self.electrodes = check_electrodes(electrodes)
        self.permittivity = check_permittivity(permittivity)
        self.weighting: Weighting = "galerkin"
        start, along = segment_lines(electrodes)
        self._points = (start[:, None] + along[:, None] * NODES).ravel()
        self._near = _corrections(start, along)
        self._unit = float(np.log(electrodes.extent))
        self._nearly = TwoLevels(start, along, electrodes.electrode, self._unit)

    def charges(self, voltages: ArrayLike) -> Charges:
        """Charges at potentials (k,) in V, one for each electrode.

        Raises
        ------
        SolverError
            If GMRES does not converge.
        """
        given = check_voltages("an electrode", self.electrodes.count, voltages)
        level, middle = subtract_middle(given)
        found = self._solved(level[self.electrodes.electrode])
        error = check_error(found.error + SUMMED) if level.any() else 0.0
        constant = float(found.solved[-1]) + middle
        return Charges(self, given, found.solved[:-1], constant, error, found.steps)

    def solve(self, potential: Array) -> Array:
        """Charges (m,) or (m, k) in C/m at potentials of segments (V), neutral together."""
        if potential.ndim == 1:
            return self._solved(potential).solved[:-1]
        return np.column_stack([self.solve(column) for column in potential.T])

    def _solved(self, potential: Array) -> Iterated:
        found = neutral_gmres(
            self._bordered, self._nearly, potential, most=MOST_STEPS, residual=RESIDUAL
        )
        if found is None:
            raise SolverError(
                f"multipole: {MOST_STEPS} steps of GMRES leave more than {RESIDUAL:g} of the "
                "potentials; grade segments so that neighbours are more alike"
            )
        found.solved[:-1] *= 2 * np.pi * self.permittivity
        return found

    def _bordered(self, x: Array) -> Array:
        """Potentials and sum (m + 1,) of charges over 2πε, and a constant (m + 1,)."""
        charge, total = x[:-1], x[:-1].sum()
        summed = self._sums(np.outer(charge, WEIGHTS).ravel())
        mean = summed.reshape(-1, len(WEIGHTS)) @ WEIGHTS + self._near @ charge
        return np.append(self._unit * total - mean + x[-1], total)

    def _sums(self, charge: Array) -> Array:
        """Σ q·ln r over all Gauss points but the one they are seen from."""
        places = np.column_stack([self._points.real, self._points.imag])
        kernel = self._library.LaplaceKernel()
        with warnings.catch_warnings():
            warnings.filterwarnings("error", message="FMM routine")
            try:
                found = self._library.fmm_part("p", PRECISION, kernel, places, mop_charge=charge)
            except UserWarning as told:
                raise SolverError(f"multipole: pyfmmlib failed, {told}; take `Moments`") from told
        return np.asarray(found.real)


def _library() -> Any:
    try:
        import pyfmmlib  # noqa: PLC0415  optional
    except ImportError as error:
        raise ProblemError(
            "multipole: pyfmmlib is not installed; pip install 'msvalidate[multipole]', or take "
            "`Moments`, which serves to 5,000 segments or so"
        ) from error
    return pyfmmlib


def _corrections(start: Complex, along: Complex) -> csr_array:
    """Exact means of ln r between near segments, less those of their Gauss points (m, m)."""
    first, second = _near_pairs(start + 0.5 * along, np.abs(along))
    mean = integrals.listed(first, second, start, along)
    own = first == second
    for s, at_s in enumerate(NODES):
        for t, at_t in enumerate(NODES):
            r = start[first] + at_s * along[first] - start[second] - at_t * along[second]
            if s == t:
                r[own] = 1.0  # a charge does not see itself
            mean -= WEIGHTS[s] * WEIGHTS[t] * np.log(np.abs(r))
    lower = csr_array((mean, (first, second)), shape=(len(start),) * 2)
    other = csr_array((mean[~own], (second[~own], first[~own])), shape=lower.shape)
    return csr_array(lower + other)


def _near_pairs(middle: Complex, length: Array) -> tuple[Index, Index]:
    """All pairs that are near, once each, a segment with itself too: the longer one first."""
    places = np.column_stack([middle.real, middle.imag])
    around = cKDTree(places).query_ball_point(places, NEAR * length)
    second = np.fromiter((j for each in around for j in each), dtype=np.intp)
    first = np.repeat(np.arange(len(length)), [len(each) for each in around])
    longer = length[first] > length[second]
    longer |= (length[first] == length[second]) & (first >= second)
    apart = np.abs(middle[first] - middle[second])
    near = longer & (apart <= 0.5 * NEAR * (length[first] + length[second]))
    return first[near], second[near]
