"""What electrodes, faces and patches alike ask of the arrays that they are given."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, ProblemError, coordinates, finite, integers, shown

MOST_DENSE = 30_000
"""Segments or patches beyond which no matrix is made of all pairs: it would take 7 GB or more."""


def refuse_dense(what: str, count: int) -> None:
    """Raise `ProblemError` before memory is taken for a matrix of too many segments or patches."""
    if count > MOST_DENSE:
        raise ProblemError(
            f"{what}: {count}, a matrix of {8e-9 * count**2:.3g} GB; take at most {MOST_DENSE}, or "
            "of electrodes in one medium the charges of `Multipole`"
        )


def in_plane(name: str, points: ArrayLike, *, least: int = 0) -> Array:
    """Return points (n, 2) in m; raise `ProblemError` unless they are such, `least` or more."""
    given = coordinates(name, points)
    if given.ndim != 2 or given.shape[1] != 2 or len(given) < least:
        count = f", n above {least - 1}" if least else ""
        raise ProblemError(f"{name}: shape {given.shape}; give (n, 2){count}")
    return given


def moved_points(name: str, points: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return points (n, 2) in m; raise `ProblemError` unless as many as there were."""
    given = in_plane(name, points)
    if given.shape != shape:
        raise ProblemError(f"{name}: shape {given.shape}; give {shape}, as there were")
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
        raise ProblemError(
            f"{name}: {shown(known)}; numbers are left out, count {name}s 0, 1, 2 and so on"
        )


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
