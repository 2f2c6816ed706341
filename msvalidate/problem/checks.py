"""Numbers as they enter: the checks on every value that is given.

Arrays are what NumPy makes of them, of real numbers: masked arrays, text, booleans as numbers,
complex numbers and quantities with a unit of their own are refused. Single counts are whole by
type: a float there is a slip, a length for a number of cells. Messages on shapes (`shaped`) and
ranges (`finite_number`) are made in one place.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Mapping
from itertools import product
from types import UnionType
from typing import Any, TypeVar, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem.arrays import LONGEST, MOST_POINTS, PLACEMENT, Array, Index, Mask
from msvalidate.problem.errors import ProblemError

MOST_COUNTED = 10**9
"""Largest whole number taken for cells, steps and the like, unless a function says otherwise."""
LARGEST_ANGLE = 1e6
"""Largest accepted angle (rad); rounding would dominate the rotation of larger ones."""
LONGEST_SHOWN = 100
"""Letters of a given value that a message shows."""
LONGEST_NAME = 100
"""Letters in a name that stands in messages and titles."""

Size = int | str | tuple[int, ...]
"""Required length of an array axis.

A number stands for itself, a letter for any length, "n>1" for any above 1, a tuple for one of
several.
"""
ArrayType = TypeVar("ArrayType", bound=np.ndarray)
Record = TypeVar("Record")


def format_value(value: object) -> str:
    """A value formatted for a message: short, on one line."""
    try:
        short = isinstance(value, str) or hasattr(value, "_repr_html_")  # whose text is a table
        line = " ".join((repr(value) if short else str(value)).split())
    except ValueError:  # an integer of thousands of digits has no decimal form
        line = f"<{type(value).__name__}>"
    return line if len(line) <= LONGEST_SHOWN else f"{line[: LONGEST_SHOWN - 3]}..."


def shaped(name: str, array: ArrayType, *sizes: Size, need: str = "") -> ArrayType:
    """Return an array; raise `ProblemError` unless its shape is of these sizes, one an axis.

    `need` says what to give in other words than the sizes.
    """
    if array.ndim != len(sizes) or not all(map(_fits, array.shape, sizes)):
        raise ProblemError(f"{name}: shape {array.shape}; {need or f'give {_as_shape(sizes)}'}")
    return array


def _fits(length: int, size: Size) -> bool:
    """Return True if an axis of this length has the required size."""
    if isinstance(size, str):
        return length > int(size.partition(">")[2] or -1)
    return length in size if isinstance(size, tuple) else length == size


def _as_shape(sizes: tuple[Size, ...]) -> str:
    """Sizes as messages have them: (n, 2) or (n, 3), n above 1."""
    choices = product(*(size if isinstance(size, tuple) else (size,) for size in sizes))
    names = [[str(size).partition(">")[0] for size in choice] for choice in choices]
    shapes = [f"({', '.join(one)}{',' if len(one) == 1 else ''})" for one in names]
    least = [str(size).replace(">", " above ") for size in sizes if ">" in str(size)]
    return ", ".join([" or ".join(shapes), *least])


def require_type(name: str, value: object, kind: type | UnionType) -> None:
    """Raise `ProblemError` unless `value` is an instance of a type or of a union."""
    if not isinstance(value, kind):
        names = [k.__name__ for k in get_args(kind) or (kind,)]
        kinds = " or ".join(f"{'an' if k[0] in 'AEIOU' else 'a'} {k}" for k in names)
        raise ProblemError(f"{name}: {format_value(value)}; give {kinds}")


def _plain_array(name: str, values: Any) -> np.ndarray:
    """Convert to a plain NumPy array; raise `ProblemError` for masks, units and ragged rows."""
    rows = values if isinstance(values, list | tuple) else (values,)
    if any(isinstance(row, np.ma.MaskedArray) for row in rows):
        raise ProblemError(f"{name}: a masked array; leave out what is masked, or fill it in")
    unit = getattr(values, "units", getattr(values, "unit", None))
    if unit is not None:
        said = f"its unit {format_value(unit)} would be dropped"
        raise ProblemError(f"{name}: {said}; give numbers in SI units")
    try:
        return np.asarray(values)
    except (ValueError, TypeError, RuntimeError) as error:
        what = "rows of different length" if isinstance(error, ValueError) else "no array"
        raise ProblemError(
            f"{name}: {what}, {format_value(values)}; give rows of one length"
        ) from error


def _real_array(name: str, values: Any) -> np.ndarray:
    """Convert to a plain NumPy array of integers or floats.

    The array may share the memory of `values`. Raises `ProblemError` as `_plain_array`, and for
    Booleans, complex numbers and text.
    """
    given = _plain_array(name, values)
    if given.dtype.kind not in "iuf":
        raise ProblemError(f"{name}: expected numbers, got {format_value(values)}")
    return given


def numbers(name: str, values: Any) -> Array:
    """Return a copy of `values` as floats; infinities and NaN are allowed.

    Raises `ProblemError` for Booleans, complex numbers, text, masked arrays and units.
    """
    return np.array(_real_array(name, values), dtype=float, order="C")


def finite(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Array:
    """Return a read-only copy of `values` as finite floats.

    Raises `ProblemError` as `numbers`, for infinities and NaN, and for a shape other than `sizes`.
    """
    array = numbers(name, values)
    if sizes:
        shaped(name, array, *sizes, need=need)
    _refuse(name, array, ~np.isfinite(array), "every value must be finite")
    array.setflags(write=False)
    return array


def integers(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Index:
    """Return a copy of `values` as integers.

    Raises `ProblemError` for values that are not whole numbers, and for a shape other than `sizes`.
    """
    given = _real_array(name, values)
    if sizes:
        shaped(name, given, *sizes, need=need)
    with np.errstate(invalid="ignore"):  # of what is none: it comes out as another number
        whole = np.array(given, dtype=np.intp, order="C")
    if (whole != given).any():
        raise ProblemError(f"{name}: {format_value(values)}; give whole numbers")
    return whole


def boolean_mask(name: str, values: Any, shape: tuple[int, ...]) -> Mask:
    """Return a copy of `values` as a Boolean array.

    The values may be True and False, or 1 and 0. Raises `ProblemError` for other values, and if
    their shape is not `shape`.
    """
    given = _plain_array(name, values)
    told = given.dtype.kind in "iuf" and np.isin(given, (0, 1)).all()
    if given.shape != shape or not (told or given.dtype.kind == "b"):
        raise ProblemError(f"{name}: {given.dtype} {given.shape}; give booleans {shape}")
    return np.array(given, dtype=bool, order="C")


def indices(
    name: str, values: ArrayLike, count: int, *sizes: Size, need: str = "", what: str = "points"
) -> Index:
    """Return `values` as indices from 0, each below `count`.

    Raises `ProblemError` as `integers`, and for an index out of range; `what` is the name of the
    things that are counted.
    """
    array = integers(name, values, *sizes, need=need)
    if array.size and (array.min() < 0 or array.max() >= count):
        ends = f"{what} {array.min()} to {array.max()}"
        raise ProblemError(f"{name}: {ends}; there are {count}, from 0")
    return array


def finite_coordinates(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Array:
    """Return places or displacements (m) as `finite` does, none beyond `LONGEST`.

    Raises `ProblemError` as `finite`, and for a value beyond `LONGEST`.
    """
    array = finite(name, values, *sizes, need=need)
    remedy = f"take a unit in which nothing is beyond {LONGEST:g} m"
    _refuse(name, array, np.abs(array) > LONGEST, remedy)
    return array


def _refuse(name: str, array: Array, bad: Mask, remedy: str) -> None:
    """Raise `ProblemError` with the first bad value of an array, where it is, and the remedy."""
    if not bad.any():  # the usual case, asked often
        return
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    place = f" at index {where[0] if len(where) == 1 else where}" if where else ""
    raise ProblemError(f"{name}: {array[where]}{place}; {remedy}")


def finite_number(
    name: str,
    value: ArrayLike,
    *,
    above: float = -math.inf,
    least: float = -math.inf,
    most: float = math.inf,
    below: float = math.inf,
    unit: str = "",
) -> float:
    """Return `value` as a float; raise `ProblemError` unless it is finite and in range."""
    given = _one_number(name, value)
    if not (above < given < below and least <= given <= most):
        said = {f"above {above:g}": above, f"of {least:g} or more": least}
        said |= {f"at most {most:g}": most, f"below {below:g}": below}
        ends = " and ".join(words for words, end in said.items() if math.isfinite(end))
        shown = f"{format_value(value)}{unit and ' ' + unit}"
        raise ProblemError(f"{name}: {shown}; give a number {ends}")
    return given


def _one_number(name: str, value: ArrayLike) -> float:
    """Return a finite number; raise `ProblemError` for several."""
    given = finite(name, value)
    if given.ndim:
        kind = "a list" if isinstance(value, list | tuple) else f"an array {given.shape}"
        raise ProblemError(f"{name}: {format_value(value)} is {kind}; give one number")
    return float(given)


def positive_number(name: str, value: float, unit: str = "") -> float:
    """Return `value` as a float; raise `ProblemError` unless it is finite and above zero."""
    given = _one_number(name, value)
    if given <= 0:
        shown = f"{format_value(value)}{unit and ' ' + unit}"
        raise ProblemError(f"{name}: {shown}; it must be above zero")
    return given


def length_in_metres(name: str, value: float) -> float:
    """Return a length (m) as a float; raise `ProblemError` unless `LONGEST` allows it."""
    length, least = positive_number(name, value, "m"), 1 / LONGEST
    if not least <= length <= LONGEST:
        remedy = f"take a unit in which lengths are from {least:g} to {LONGEST:g}"
        raise ProblemError(f"{name}: {length:g} m; {remedy}")
    return length


def refuse_far_off(name: str, points: Array) -> None:
    """Raise `ProblemError` for a body without size, or far from the origin.

    The points are (n, d) in m. The longest side must pass `length_in_metres`. The distance from the
    origin may be about 1e6 such sides, where rounding of coordinates is a quarter of `PLACEMENT`.
    """
    size, away = float(np.ptp(points, axis=0).max()), float(np.abs(points).max())
    length_in_metres(f"{name}: its longest side", size)
    if 4 * np.finfo(float).eps * away > PLACEMENT * size:
        raise ProblemError(
            f"{name}: {size:g} m long and {away:g} m from the origin, where coordinates no longer "
            "tell its places apart; move it to the origin"
        )


def finite_angle(name: str, value: ArrayLike) -> float:
    """Return an angle (rad) as a float; raise `ProblemError` beyond `LARGEST_ANGLE`."""
    return finite_number(name, value, least=-LARGEST_ANGLE, most=LARGEST_ANGLE, unit="rad")


def check_name(label: str, name: object) -> None:
    """Raise `ProblemError` for a name that is too long or not printable on one line."""
    if not isinstance(name, str) or not name.isprintable() or not 0 < len(name) <= LONGEST_NAME:
        need = f"give 1 to {LONGEST_NAME} printable letters on one line as its name"
        raise ProblemError(f"{label}: {format_value(name)}; {need}")


def require_one_of(name: str, value: object, names: Iterable[str]) -> None:
    """Raise `ProblemError` unless `value` is one of some names."""
    known = tuple(names)
    if not isinstance(value, str) or value not in known:
        listed = " or ".join(known) if len(known) == 2 else ", ".join(known)
        raise ProblemError(f"{name}: {format_value(value)}; choose {listed}")


def choose_entry(
    name: str, value: object, kind: type[Record], table: Mapping[str, Record]
) -> Record:
    """Return a record of a table, given as itself or by its key.

    Raises `ProblemError` for another type, and for an unknown key with the nearest one.
    """
    if not isinstance(value, str):
        require_type(name, value, kind)
        return cast("Record", value)
    if value not in table:
        near = difflib.get_close_matches(value.lower(), table, n=1)
        remedy = f"did you mean {near[0]!r}?" if near else f"choose {', '.join(table)}"
        raise ProblemError(f"{name}: {format_value(value)}; {remedy}")
    return table[value]


def whole_number(name: str, value: object, least: int, most: int = MOST_COUNTED) -> int:
    """Return a whole number as an int, checked for type and range.

    Raises `ProblemError` if `value` is not a Python or NumPy integer from `least` to `most`.
    Booleans and floats are refused, even a float such as 3.0.
    """
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ProblemError(f"{name}: {format_value(value)}; give a whole number, {least} or more")
    if value > most:
        raise ProblemError(f"{name}: {format_value(value)}; the most is {most}")
    return int(value)


def cell_counts(name: str, cells: object, axes: int = 2) -> tuple[int, ...]:
    """Return the number of cells along each axis, each at least 1.

    One integer applies to all axes; a tuple or list has one for each. Raises `ProblemError` for
    anything else.
    """
    each = cells if isinstance(cells, tuple | list) else (cells,) * axes
    if len(each) != axes:
        need = f"give one or {'two' if axes == 2 else 'three'} whole numbers, 1 or more"
        raise ProblemError(f"{name}: {format_value(cells)}; {need}")
    return tuple(whole_number(name, count, 1) for count in each)


def refuse_too_many(name: str, count: float, most: int = MOST_POINTS, what: str = "points") -> None:
    """Raise `ProblemError` before memory is taken for more than `most` points, or of `what`."""
    if count > most:
        remedy = f"take fewer{', larger cells' if what == 'points' else ''}"
        raise ProblemError(f"{name}: {count:.3g} {what}, and the most is {most:.3g}; {remedy}")
