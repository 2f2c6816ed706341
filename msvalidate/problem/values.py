"""Numbers as they enter: array types, the two errors, and the checks on every value given."""

from __future__ import annotations

import reprlib
from collections.abc import Callable, Iterable
from types import UnionType
from typing import Any, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]
"""Real numbers; (n, d) for points and vectors, d = 2 or 3."""
Mask = NDArray[np.bool_]
Index = NDArray[np.intp]
Field = Callable[[Array], Array]
"""A function of points (n, d) in m that returns values (n,) or (n, d)."""
Span = tuple[tuple[float, float], ...]
"""Low and high coordinate (m) of a body along each axis."""

AXES = "xyz"
PLACEMENT = 1e-9
"""Two places closer than this fraction of the body are the same place: far above rounding of
coordinates (1e-16), far below any spacing that fits in memory."""
LONGEST = 1e100
"""Lengths and coordinates (m) stay below it, and lengths above its inverse: areas and volumes, and
the squares that a distance takes, are then ordinary numbers too."""
MOST_POINTS = 20_000_000
"""Points of a lattice, or nodes of a mesh, beyond which none is made: its springs or cells, and the
lists that make them, would take tens of gigabytes."""
MOST_COUNTED = 10**9
"""Largest whole number taken for cells, steps and the like, unless a function says otherwise."""

LARGEST_ANGLE = 1e6
"""Angle (rad) beyond which the last digits, which are all that turns leave of it, are rounding."""
LONGEST_SHOWN = 100
"""Letters of a given value that a message shows."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = LONGEST_SHOWN


class ProblemError(ValueError):
    """The question is ill posed, or an argument is out of its range (exit code 2)."""


class SolverError(RuntimeError):
    """A well-posed question to which no trustworthy answer was found (exit code 3)."""


def shown(value: object) -> str:
    """A given value as a message shows it: short, on one line, with nothing that hides.

    Letters beyond ASCII are spelt out: a Cyrillic "а" in a name looks like a Latin one.
    """
    described = type(value).__str__ is not object.__str__ and not isinstance(value, str)
    try:
        text = str(value) if described else _SHORT.repr(value)
    except ValueError:  # an integer of thousands of digits has no decimal form
        text = f"<{type(value).__name__}>"
    line = " ".join(text.encode("ascii", "backslashreplace").decode().split())
    return line if len(line) <= LONGEST_SHOWN else f"{line[: LONGEST_SHOWN - 3]}..."


def instance(name: str, value: object, kind: type | UnionType) -> None:
    """Raise `ProblemError` unless `value` is of a kind, or of one of a union of kinds."""
    if not isinstance(value, kind):
        names = [k.__name__ for k in get_args(kind) or (kind,)]
        kinds = " or ".join(f"{'an' if k[0] in 'AEIOU' else 'a'} {k}" for k in names)
        raise ProblemError(f"{name}: {shown(value)}; give {kinds}")


def numbers(name: str, values: Any) -> Array:
    """Return `values` as a float array of its own, in which not every number need be finite.

    Raises
    ------
    ProblemError
        If a value is missing or is not a real number.
    """
    try:
        given = np.asarray(values)
    except ValueError as error:
        raise ProblemError(
            f"{name}: expected numbers, got rows of different length, {shown(values)}"
        ) from error
    if given.dtype.kind not in "iuf":  # text would be converted, and then kept as text
        raise ProblemError(f"{name}: expected numbers, got {shown(values)}")
    return np.array(given, dtype=float)


def finite(name: str, values: ArrayLike) -> Array:
    """Return `values` as a read-only float array of its own.

    Raises
    ------
    ProblemError
        If a value is missing, is not a number or is infinite.
    """
    array = numbers(name, values)
    _refuse(name, array, ~np.isfinite(array), "every value must be finite")
    array.setflags(write=False)
    return array


def integers(name: str, values: ArrayLike) -> Index:
    """Return `values` as an array of whole numbers of its own; raise `ProblemError` unless so."""
    array = finite(name, values)
    if (array != np.round(array)).any():
        raise ProblemError(f"{name}: {shown(values)}; give whole numbers")
    return np.array(array, dtype=np.intp)


def coordinates(name: str, values: ArrayLike) -> Array:
    """Return places or displacements (m) as `finite` does, none beyond `LONGEST`."""
    array = finite(name, values)
    remedy = f"take a unit in which nothing is beyond {LONGEST:g} m"
    _refuse(name, array, np.abs(array) > LONGEST, remedy)
    return array


def number(name: str, value: ArrayLike) -> float:
    """Return `value` as a float; raise `ProblemError` unless it is one finite number."""
    given = finite(name, value)
    if given.ndim:
        raise ProblemError(f"{name}: {shown(value)}; give one number")
    return float(given)


def direction(name: str, value: ArrayLike) -> float:
    """Return an angle (rad) as a float; raise `ProblemError` unless it is one with a meaning."""
    turn = finite(name, value)
    if turn.ndim or abs(turn) > LARGEST_ANGLE:
        raise ProblemError(
            f"{name}: {shown(value)}; give one angle in rad, within {LARGEST_ANGLE:g}"
        )
    return float(turn)


def rotation(turn: ArrayLike, dim: int) -> Array:
    """Return the rotation matrix (dim, dim) of an angle (rad) in the plane, or one given as such.

    Raises
    ------
    ProblemError
        If it is neither.
    """
    if dim == 2 and np.shape(turn) == ():
        angle = direction("angle", turn)
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s], [s, c]])
    given = finite("rotation", turn)
    proper = given.shape == (dim, dim) and np.abs(given @ given.T - np.eye(dim)).max() <= 1e-12
    if not proper or np.linalg.det(given) < 0:
        need = "an angle (rad) or a rotation matrix (2, 2)" if dim == 2 else "a matrix (3, 3)"
        raise ProblemError(f"rotation: {shown(turn)}; give {need}, orthonormal and not mirrored")
    return given


def chosen(name: str, value: object, names: Iterable[str]) -> None:
    """Raise `ProblemError` unless `value` is one of some names."""
    known = tuple(names)
    if not isinstance(value, str) or value not in known:
        listed = " or ".join(known) if len(known) == 2 else ", ".join(known)
        raise ProblemError(f"{name}: {shown(value)}; choose {listed}")


def whole(name: str, value: object, least: int, most: int = MOST_COUNTED) -> int:
    """Return `value` as an int; raise `ProblemError` unless it is whole and in this range."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ProblemError(f"{name}: {shown(value)}; give a whole number, {least} or more")
    if value > most:
        raise ProblemError(f"{name}: {shown(value)}; the most is {most}")
    return int(value)


def counts(name: str, cells: object, axes: int = 2) -> tuple[int, ...]:
    """Return the number of cells along each axis, of which one whole number may serve all."""
    each = cells if isinstance(cells, tuple | list) else (cells,) * axes
    if len(each) != axes:
        several = {2: "two", 3: "three"}[axes]
        raise ProblemError(
            f"{name}: {shown(cells)}; give one or {several} whole numbers, 1 or more"
        )
    return tuple(whole(name, count, 1) for count in each)


def refuse_too_many(name: str, count: float, most: int = MOST_POINTS, what: str = "points") -> None:
    """Raise `ProblemError` before memory is taken for more than `most` points, or of `what`."""
    if count > most:
        raise ProblemError(
            f"{name}: {count:.3g} {what}, and the most is {most:.3g}; take fewer"
            f"{', larger cells' if what == 'points' else ''}"
        )


def positive(name: str, value: float, unit: str = "") -> float:
    """Return `value` as a float; raise `ProblemError` unless it is finite and above zero."""
    given = finite(name, value)
    if given.ndim or given <= 0:
        raise ProblemError(f"{name}: {shown(value)}{unit and ' ' + unit}; it must be above zero")
    return float(given)


def metres(name: str, value: float) -> float:
    """Return a length (m) as a float; raise `ProblemError` unless `LONGEST` allows it."""
    length = positive(name, value, "m")
    if not 1 / LONGEST <= length <= LONGEST:
        raise ProblemError(
            f"{name}: {length:g} m; take a unit in which lengths are from {1 / LONGEST:g} to "
            f"{LONGEST:g}"
        )
    return length


def _refuse(name: str, array: Array, bad: Mask, remedy: str) -> None:
    """Raise `ProblemError` with the first bad value of an array, where it is, and the remedy."""
    if not bad.any():  # the usual case, asked often
        return
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    place = f" at index {where[0] if len(where) == 1 else where}" if where else ""
    raise ProblemError(f"{name}: {array[where]}{place}; {remedy}")
