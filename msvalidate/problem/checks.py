"""Numbers as they enter: the checks on every value that is given.

One rule holds for every array, of networks and meshes alike: it is taken by its values, never by
its type, where these can be taken exactly, and is refused where something would be lost.

- Real numbers: any NumPy type, byte order and layout, nested lists, columns of pandas (nullable
  ones too, and tables of them), objects that are all real numbers. Float32 keeps its own digits.
- Whole numbers, such as indices: the same, where every value is whole: 2.0 is 2, as tables have it.
- Booleans: True and False, or numbers that are all 0 or 1.
- Refused: masked entries and missing ones, text, dates, booleans as numbers, complex numbers (even
  without imaginary part), quantities with a unit of their own, which nobody would look at.

Single counts (`whole_number`) are written by hand, and a float there is a slip: a length for a
number of
cells. They are whole by type.

A shape is told by its sizes (`shaped`), a range by its ends (`finite_number`), so that messages are
made
in one place.
"""

from __future__ import annotations

import difflib
import math
import reprlib
from collections.abc import Iterable
from contextlib import suppress
from itertools import product
from numbers import Real
from types import UnionType
from typing import Any, TypeVar, get_args

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem.arrays import LONGEST, MOST_POINTS, Array, Index, Mask
from msvalidate.problem.errors import ProblemError

MOST_COUNTED = 10**9
"""Largest whole number taken for cells, steps and the like, unless a function says otherwise."""
FARTHEST = 2.0**62
"""Size of whole numbers in arrays beyond which their type may not hold them."""

LARGEST_ANGLE = 1e6
"""Angle (rad) beyond which the last digits, which are all that turns leave of it, are rounding."""
LONGEST_SHOWN = 100
"""Letters of a given value that a message shows."""

_SHORT = reprlib.Repr()
_SHORT.maxstring = _SHORT.maxother = _SHORT.maxlong = LONGEST_SHOWN


def format_value(value: object) -> str:
    """A value formatted for a message: short, on one line, without invisible characters.

    Letters beyond ASCII are spelt out: a Cyrillic "а" in a name looks like a Latin one.
    """
    described = type(value).__str__ is not object.__str__ and not isinstance(value, str)
    described |= isinstance(value, int)  # reprlib of Python 3.14 tells where a long one is kept
    try:
        text = str(value) if described else _SHORT.repr(value)
    except ValueError:  # an integer of thousands of digits has no decimal form
        text = f"<{type(value).__name__}>"
    line = " ".join(text.encode("ascii", "backslashreplace").decode().split())
    return line if len(line) <= LONGEST_SHOWN else f"{line[: LONGEST_SHOWN - 3]}..."


Size = int | str | tuple[int, ...]
"""A number along one axis of an array; a letter for any, "n>1" for any above 1; one of several."""
Kept = TypeVar("Kept", bound=np.ndarray)


def shaped(name: str, array: Kept, *sizes: Size, need: str = "") -> Kept:
    """Return an array of a shape, one size an axis.

    `need` says what to give in other words than the sizes.

    Raises
    ------
    ProblemError
        If it has another shape.
    """
    fits = array.ndim == len(sizes) and all(
        _fits(length, size) for length, size in zip(array.shape, sizes, strict=True)
    )
    if not fits:
        raise ProblemError(f"{name}: shape {array.shape}; {need or f'give {_as_shape(sizes)}'}")
    return array


def _fits(length: int, size: Size) -> bool:
    """Whether an axis of this length is of a size."""
    if isinstance(size, str):
        return length > int(size.partition(">")[2] or -1)
    return length in size if isinstance(size, tuple) else length == size


def _as_shape(sizes: tuple[Size, ...]) -> str:
    """Sizes as messages have them: (n, 2) or (n, 3), n above 1."""
    choices = product(*(size if isinstance(size, tuple) else (size,) for size in sizes))
    least = [size.partition(">") for size in sizes if isinstance(size, str) and ">" in size]
    names = [[str(size).partition(">")[0] for size in choice] for choice in choices]
    shapes = [f"({', '.join(one)}{',' if len(one) == 1 else ''})" for one in names]
    return ", ".join(
        [" or ".join(shapes), *(f"{letter} above {most}" for letter, _, most in least)]
    )


def require_type(name: str, value: object, kind: type | UnionType) -> None:
    """Raise `ProblemError` unless `value` is of a kind, or of one of a union of kinds."""
    if not isinstance(value, kind):
        names = [k.__name__ for k in get_args(kind) or (kind,)]
        kinds = " or ".join(f"{'an' if k[0] in 'AEIOU' else 'a'} {k}" for k in names)
        raise ProblemError(f"{name}: {format_value(value)}; give {kinds}")


def numbers(name: str, values: Any) -> Array:
    """Return `values` as a float array of its own, in which not every number need be finite.

    Raises
    ------
    ProblemError
        If a value is masked, is missing or is not a real number.
    """
    given = _real_array(name, values)
    with np.errstate(over="ignore"):  # of a wider type: infinite, as any such number is
        return np.array(given, dtype=float, order="C")


def finite(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Array:
    """Return `values` as a read-only float array of its own, `shaped` where sizes are given.

    Raises
    ------
    ProblemError
        If a value is masked, is missing, is not a number or is infinite, or the shape is another.
    """
    array = numbers(name, values)
    if sizes:
        shaped(name, array, *sizes, need=need)
    _refuse(name, array, ~np.isfinite(array), "every value must be finite")
    array.setflags(write=False)
    return array


def integers(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Index:
    """Return `values` as an array of whole numbers of its own, `shaped` where sizes are given.

    Raises
    ------
    ProblemError
        If a value is not a whole number, or the shape is another.
    """
    given = _real_array(name, values)
    if sizes:
        shaped(name, given, *sizes, need=need)
    if given.dtype.kind == "f":
        _refuse(name, given, ~np.isfinite(given), "every value must be finite")
        if (given != np.round(given)).any():
            raise ProblemError(f"{name}: {format_value(values)}; give whole numbers")
    with np.errstate(over="ignore"):
        far = np.abs(given.astype(float)) > FARTHEST
    _refuse(name, given, far, f"the most is {FARTHEST:g}")
    return np.array(given, dtype=np.intp, order="C")


def boolean_mask(name: str, values: Any, shape: tuple[int, ...]) -> Mask:
    """Return `values` as a mask of a shape; raise `ProblemError` unless all are True or False."""
    given = _plain_array(name, values)
    if given.dtype.kind == "O" and all(isinstance(each, bool | np.bool_) for each in given.flat):
        given = given.astype(bool)
    told = given.dtype.kind in "iuf" and np.isin(given, (0, 1)).all()
    if given.shape != shape or not (told or given.dtype.kind == "b"):
        raise ProblemError(f"{name}: {given.dtype} {given.shape}; give booleans {shape}")
    return np.array(given, dtype=bool, order="C")


def indices(name: str, values: ArrayLike, count: int, *sizes: Size, need: str = "") -> Index:
    """Return numbers of some of `count` points, from 0, as `integers` does.

    Raises
    ------
    ProblemError
        If one is of no point, or the shape is another.
    """
    array = integers(name, values, *sizes, need=need)
    if array.size and (array.min() < 0 or array.max() >= count):
        raise ProblemError(
            f"{name}: points {array.min()} to {array.max()}; there are {count}, from 0"
        )
    return array


def finite_coordinates(name: str, values: ArrayLike, *sizes: Size, need: str = "") -> Array:
    """Return places or displacements (m) as `finite` does, none beyond `LONGEST`."""
    array = finite(name, values, *sizes, need=need)
    remedy = f"take a unit in which nothing is beyond {LONGEST:g} m"
    _refuse(name, array, np.abs(array) > LONGEST, remedy)
    return array


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
    """Return `value` as a float; raise `ProblemError` unless it is one finite number in a range."""
    given = _one_number(name, value)
    if not (above < given < below and least <= given <= most):
        said = {f"above {above:g}": above, f"of {least:g} or more": least}
        said |= {f"at most {most:g}": most, f"below {below:g}": below}
        ends = " and ".join(words for words, end in said.items() if math.isfinite(end))
        raise ProblemError(
            f"{name}: {format_value(value)}{unit and ' ' + unit}; give a number {ends}"
        )
    return float(given)


def _one_number(name: str, value: ArrayLike) -> Array:
    """Return a finite number as an array without axes; raise `ProblemError` for several."""
    given = finite(name, value)
    if given.ndim:
        kind = "a list" if isinstance(value, list | tuple) else f"an array {given.shape}"
        raise ProblemError(f"{name}: {format_value(value)} is {kind}; give one number")
    return given


def finite_angle(name: str, value: ArrayLike) -> float:
    """Return an angle (rad) as a float; raise `ProblemError` unless it is one with a meaning."""
    turn = finite(name, value)
    if turn.ndim or abs(turn) > LARGEST_ANGLE:
        raise ProblemError(
            f"{name}: {format_value(value)}; give one angle in rad, within {LARGEST_ANGLE:g}"
        )
    return float(turn)


def rotation_matrix(turn: ArrayLike, dim: int) -> Array:
    """Return the rotation matrix (dim, dim) of an angle (rad) in the plane, or one given as such.

    Raises
    ------
    ProblemError
        If it is neither.
    """
    if dim == 2 and np.shape(turn) == ():
        angle = finite_angle("angle", turn)
        c, s = np.cos(angle), np.sin(angle)
        return np.array([[c, -s], [s, c]])
    given = finite("rotation", turn)
    proper = given.shape == (dim, dim) and np.abs(given @ given.T - np.eye(dim)).max() <= 1e-12
    if not proper or np.linalg.det(given) < 0:
        need = "an angle (rad) or a rotation matrix (2, 2)" if dim == 2 else "a matrix (3, 3)"
        raise ProblemError(
            f"rotation: {format_value(turn)}; give {need}, orthonormal and not mirrored"
        )
    return given


def require_entry(name: str, value: object, kind: type, table: str, keys: Iterable[str]) -> None:
    """As `require_type`, of an entry of a table: who gives a key is told how to look it up."""
    if not isinstance(value, str):
        require_type(name, value, kind)
        return
    known = tuple(keys)
    near = difflib.get_close_matches(value.lower(), known, n=1)
    entry = f"{table}[{near[0]!r}]" if near else f"an entry of {table}: {', '.join(known)}"
    raise ProblemError(f"{name}: {format_value(value)} is a name; give {entry}")


def require_one_of(name: str, value: object, names: Iterable[str]) -> None:
    """Raise `ProblemError` unless `value` is one of some names."""
    known = tuple(names)
    if not isinstance(value, str) or value not in known:
        listed = " or ".join(known) if len(known) == 2 else ", ".join(known)
        raise ProblemError(f"{name}: {format_value(value)}; choose {listed}")


def whole_number(name: str, value: object, least: int, most: int = MOST_COUNTED) -> int:
    """Return `value` as an int; raise `ProblemError` unless it is whole and in this range."""
    if isinstance(value, bool) or not isinstance(value, int | np.integer) or value < least:
        raise ProblemError(f"{name}: {format_value(value)}; give a whole number, {least} or more")
    if value > most:
        raise ProblemError(f"{name}: {format_value(value)}; the most is {most}")
    return int(value)


def cell_counts(name: str, cells: object, axes: int = 2) -> tuple[int, ...]:
    """Return the number of cells along each axis, of which one whole number may serve all."""
    each = cells if isinstance(cells, tuple | list) else (cells,) * axes
    if len(each) != axes:
        several = {2: "two", 3: "three"}[axes]
        raise ProblemError(
            f"{name}: {format_value(cells)}; give one or {several} whole numbers, 1 or more"
        )
    return tuple(whole_number(name, count, 1) for count in each)


def refuse_too_many(name: str, count: float, most: int = MOST_POINTS, what: str = "points") -> None:
    """Raise `ProblemError` before memory is taken for more than `most` points, or of `what`."""
    if count > most:
        raise ProblemError(
            f"{name}: {count:.3g} {what}, and the most is {most:.3g}; take fewer"
            f"{', larger cells' if what == 'points' else ''}"
        )


def positive_number(name: str, value: float, unit: str = "") -> float:
    """Return `value` as a float; raise `ProblemError` unless it is finite and above zero."""
    given = _one_number(name, value)
    if given <= 0:
        raise ProblemError(
            f"{name}: {format_value(value)}{unit and ' ' + unit}; it must be above zero"
        )
    return float(given)


def length_in_metres(name: str, value: float) -> float:
    """Return a length (m) as a float; raise `ProblemError` unless `LONGEST` allows it."""
    length = positive_number(name, value, "m")
    if not 1 / LONGEST <= length <= LONGEST:
        raise ProblemError(
            f"{name}: {length:g} m; take a unit in which lengths are from {1 / LONGEST:g} to "
            f"{LONGEST:g}"
        )
    return length


def _plain_array(name: str, values: Any) -> np.ndarray:
    """What was given as a plain array, of whatever type, if nothing is lost on the way there."""
    if _has_masked_values(values):
        raise ProblemError(
            f"{name}: {format_value(values)}; entries are masked, and numbers behind a mask mean "
            f"nothing: "
            "leave these out or fill them in"
        )
    unit = getattr(values, "units", getattr(values, "unit", None))
    if unit is not None:
        raise ProblemError(
            f"{name}: {format_value(values)}; its unit {format_value(unit)} would be dropped: give "
            f"plain numbers "
            "in SI units"
        )
    try:
        return np.asarray(values)
    except ValueError as error:
        raise ProblemError(
            f"{name}: rows of different length, {format_value(values)}; give rows of one length"
        ) from error
    except (RuntimeError, TypeError) as error:  # of another library's tensors, on a GPU say
        raise ProblemError(
            f"{name}: {type(values).__name__} that is no array ({' '.join(str(error).split())}); "
            "give a NumPy array"
        ) from error


def _real_array(name: str, values: Any) -> np.ndarray:
    """What was given as a plain array of real numbers, of whatever type."""
    given = _plain_array(name, values)
    if given.dtype.kind == "O" and given.size and all(map(_is_real_number, given.flat)):
        with suppress(OverflowError):  # an integer beyond all floats stays what it is: refused
            given = given.astype(float)
    if given.dtype.kind not in "iuf":  # text would be converted, and then kept as text
        raise ProblemError(f"{name}: expected numbers, got {format_value(values)}")
    return given


def _is_real_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool)


def _has_masked_values(values: Any) -> bool:
    """Whether something is masked in an array or in lists of arrays."""
    if isinstance(values, list | tuple):
        return any(map(_has_masked_values, values))
    return isinstance(values, np.ma.MaskedArray) and bool(np.ma.getmaskarray(values).any())


def _refuse(name: str, array: Array, bad: Mask, remedy: str) -> None:
    """Raise `ProblemError` with the first bad value of an array, where it is, and the remedy."""
    if not bad.any():  # the usual case, asked often
        return
    where = tuple(int(i) for i in np.argwhere(bad)[0])
    place = f" at index {where[0] if len(where) == 1 else where}" if where else ""
    raise ProblemError(f"{name}: {array[where]}{place}; {remedy}")
