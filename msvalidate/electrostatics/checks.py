"""What electrodes, faces and patches alike ask of the arrays that they are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, ProblemError, coordinates, finite, integers


def in_plane(name: str, points: ArrayLike, *, least: int = 0) -> Array:
    """Return points (n, 2) in m; raise `ProblemError` unless they are such, `least` or more."""
    given = coordinates(name, points)
    if given.ndim != 2 or given.shape[1] != 2 or len(given) < least:
        count = f", n above {least - 1}" if least else ""
        raise ProblemError(f"{name}: shape {given.shape}; give (n, 2){count}")
    return given


def owners(name: str, numbers: ArrayLike, count: int) -> Index:
    """Return numbers of electrodes or conductors; raise `ProblemError` unless one for each part."""
    given = integers(name, numbers)
    if given.shape != (count,):
        raise ProblemError(f"{name}: shape {given.shape}; give ({count},)")
    return given


def refuse_gaps(name: str, numbers: Index) -> None:
    """Raise `ProblemError` unless numbers of electrodes or conductors are 0, 1, ..., all there."""
    known = np.unique(numbers)
    if not np.array_equal(known, np.arange(len(known))):
        raise ProblemError(f"{name}: numbers are left out; count {name}s 0, 1, 2 and so on")


def voltages_of(owner: str, count: int, voltages: ArrayLike) -> Array:
    """Return voltages (count,) in V; raise `ProblemError` unless there is one an `owner`."""
    given = finite("voltages", voltages)
    if given.shape != (count,):
        raise ProblemError(f"voltages: shape {given.shape}; give ({count},), one {owner}")
    return given


def freeze(holder: object, **arrays: Array | Index) -> None:
    """Put checked arrays, read-only, into a frozen dataclass."""
    for name, array in arrays.items():
        array.setflags(write=False)
        object.__setattr__(holder, name, array)
