"""Numbers as they enter: array types, the two errors, and the checks on every value given."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
"""Real numbers; (n, d) for points and vectors, d = 2 or 3."""
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
Field = Callable[[Array], Array]
"""A function of points (n, d) in m that returns values (n,) or (n, d)."""

AXES = "xyz"


class ProblemError(ValueError):
    """The question is ill posed, or an argument is out of its range (exit code 2)."""


class SolverError(RuntimeError):
    """A well-posed question to which no trustworthy answer was found (exit code 3)."""


def finite(name: str, values: ArrayLike) -> Array:
    """Return `values` as a read-only float array of its own.

    Raises
    ------
    ProblemError
        If a value is missing, is not a number or is infinite.
    """
    try:
        given = np.asarray(values)
    except ValueError as error:
        raise ProblemError(
            f"{name}: expected numbers, got rows of different length, {values!r}"
        ) from error
    if given.dtype.kind not in "biuf":  # text would be converted, and then kept as text
        raise ProblemError(f"{name}: expected numbers, got {values!r}")
    array = np.array(given, dtype=float)
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        where = tuple(int(i) for i in bad[0])
        place = f" at index {where[0] if len(where) == 1 else where}" if where else ""
        raise ProblemError(f"{name}: {array[where]}{place}; every value must be finite")
    array.setflags(write=False)
    return array


def whole(name: str, value: object, least: int) -> int:
    """Return `value` as an int; raise `ProblemError` unless it is a whole number >= `least`."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ProblemError(f"{name}: {value!r}; give a whole number, {least} or more")
    return int(value)


def positive(name: str, value: float, unit: str = "") -> float:
    """Return `value` as a float; raise `ProblemError` unless it is finite and above zero."""
    number = finite(name, value)
    if number.ndim or number <= 0:
        raise ProblemError(f"{name}: {value!r}{unit and ' ' + unit}; it must be above zero")
    return float(number)
