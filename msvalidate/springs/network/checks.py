"""Checks of what a network is made of, each with the entry at fault."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, Mask, ProblemError
from msvalidate.problem.checks import finite, integers
from msvalidate.springs.network.folds import is_shape_of_cells


def check_springs(springs: ArrayLike, n: int) -> Index:
    """Springs (m, 2) as pairs of different ones of n points.

    Raises `ProblemError` if there is none, or a pair has a missing point or one point twice.
    """
    pairs = integers("springs", springs, "m>0", 2, need="give whole numbers (m, 2)")
    _refuse_beyond("springs", pairs, n)
    own = np.flatnonzero(pairs[:, 0] == pairs[:, 1])
    if len(own):
        raise ProblemError(f"springs: {pairs[own[0]]} at index {own[0]} joins a point to itself")
    return pairs


def check_cells(numbers: ArrayLike, n: int, d: int) -> Index:
    """Cells (c, corners) as numbers of n points in d axes, read-only.

    Raises `ProblemError` if cells have another number of corners, or name a missing point.
    """
    cells = integers("cells", numbers)
    if cells.ndim != 2 or not is_shape_of_cells(d, cells.shape[1]):
        raise ProblemError(
            f"cells: {cells.shape} of points ({n}, {d}); give triangles or quadrilaterals in the "
            "plane, tetrahedra or hexahedra in space"
        )
    _refuse_beyond("cells", cells, n)
    cells.setflags(write=False)
    return cells


def _refuse_beyond(name: str, rows: Index, n: int) -> None:
    """Raise `ProblemError` with the first row (k, any) that names none of n points."""
    bad = np.flatnonzero(((rows < 0) | (rows >= n)).any(axis=1))
    if len(bad):
        raise ProblemError(f"{name}: {rows[bad[0]]} at index {bad[0]}; there are {n} points")


def broadcast_values(name: str, value: ArrayLike, count: int) -> Array:
    """Values (count,), of which one number may stand for all."""
    array = finite(name, value)
    return array if array.ndim else np.full(count, float(array))


def refuse_first_bad(name: str, values: Array, bad: Mask, remedy: str) -> None:
    """Raise `ProblemError` with the first value that is bad (same shape), and the remedy."""
    at = np.flatnonzero(bad)
    if len(at):
        raise ProblemError(f"{name}: {values[at[0]]:g} at index {at[0]} {remedy}")
