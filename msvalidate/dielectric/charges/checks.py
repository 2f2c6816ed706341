"""Checks of arguments and results of electrodes, faces and patches."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import LONGEST, Array, Index, ProblemError, SolverError
from msvalidate.problem.checks import finite, finite_coordinates, positive_number

MOST_DENSE = 5_000
"""Segments or patches beyond which no matrix of all pairs is made: 0.2 GB, of which models
take up to a dozen."""

ROUNDED = 8 * float(np.finfo(float).eps)
"""Error of an integral over pairs, over its larger terms: sums of some eight, rounded each."""
LEAST_KNOWN = 1e-3
"""Error of charges, over the charges, beyond which none are handed out: integrals of near segments
and factors of their matrices are rounded by 1e-16, and three digits are what a chart is read to."""


def refuse_dense(what: str, count: int) -> None:
    """Raise `ProblemError` before memory is taken for a matrix of too many segments or patches."""
    if count > MOST_DENSE:
        raise ProblemError(
            f"{what}: {count} of them, whose matrix takes {8e-9 * count**2:.2g} GB; take at most "
            f"{MOST_DENSE}, graded towards edges"
        )


def check_plane_points(name: str, points: ArrayLike, *, least: int = 0) -> Array:
    """Return points (n, 2) in m; raise `ProblemError` unless they are such, `least` or more."""
    return finite_coordinates(name, points, f"n>{least - 1}" if least else "n", 2)


def check_voltages(owner: str, count: int, voltages: ArrayLike) -> Array:
    """Return voltages (count,) in V; raise `ProblemError` unless there is one an `owner`."""
    given = finite("voltages", voltages, count, need=f"give ({count},), one {owner}")
    for value in given[given != 0]:
        _refuse_extreme("voltages", float(value), "V")
    return given


def check_positive(name: str, value: float, unit: str = "") -> float:
    """Return a number above 0; raise `ProblemError` unless it is one, and an ordinary one."""
    given = positive_number(name, value, unit)
    _refuse_extreme(name, given, unit)
    return given


def logarithm_error(extent: float) -> float:
    """Error of mean logarithms of distances (m) in electrodes of an extent (m), over their spread.

    A unit far from their size makes all logarithms large, and differences of them are what counts.
    """
    return ROUNDED * (1 + abs(float(np.log(extent))))


def check_error(error: float) -> float:
    """Return an error of charges, over their size; raise `SolverError` where it leaves no digits.

    Raises
    ------
    SolverError
        If the error is beyond `LEAST_KNOWN`.
    """
    if not error <= LEAST_KNOWN:
        raise SolverError(
            f"charges: known to {error:.2g} of their size only, rounding leaves no more of parts "
            "this close or this unlike; move them apart, or take fewer or less graded ones"
        )
    return float(error)


def _refuse_extreme(name: str, value: float, unit: str) -> None:
    """Raise `ProblemError` where squares and quotients of a number are none any more."""
    if not 1 / LONGEST <= abs(value) <= LONGEST:
        raise ProblemError(
            f"{name}: {value:g}{unit and ' ' + unit}; take units in which it is from "
            f"{1 / LONGEST:g} to {LONGEST:g}"
        )


def freeze(holder: object, **arrays: Array | Index) -> None:
    """Put checked arrays, read-only, into a frozen dataclass."""
    for name, array in arrays.items():
        array.setflags(write=False)
        object.__setattr__(holder, name, array)
