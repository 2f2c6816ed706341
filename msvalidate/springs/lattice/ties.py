"""Numbers that are alike but for rounding: places equally far, lines on one level.

Rounding goes by the processor and by the order of sums, and so would every choice between such
numbers. Choices are made by levels instead, and on one level by place or by number.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index

TIE = 1e-6
"""Relative difference below which two distances are equal.

Rounding of coordinates is 1e-16 of the body's size, which may be 1e7 distances or more. Distances
that differ by intention differ by more.
"""

SLANT = np.array([[0.0, 0.8, 0.3], [0.0, 0.5, 0.7], [0.0, 0.0, 1.0]])
"""Strain without symmetry: no rectangle or box at a chosen angle keeps its shape."""


def break_ties(points: Array) -> Array:
    """Strain points (n, d) by `TIE`, to separate cocircular or cospherical points.

    How the squares and cubes between points of a lattice are cut into triangles and tetrahedra is
    then told by their places: as given, any cut is Delaunay's, and rounding chooses one.
    """
    d = points.shape[1]
    return np.asarray(points + TIE * points @ SLANT[:d, :d])


def level_numbers(values: Array, room: float, axis: int = 0) -> Index:
    """Number of the level of each value, from 0 up along an axis.

    A value stands on the level of the next lower one that is within `room` (in their unit) of it:
    no grid of roundings, whose borders would again divide what is alike.
    """
    order = np.argsort(values, axis=axis, kind="stable")
    rising = np.take_along_axis(values, order, axis=axis)
    first = np.take(rising, [0], axis=axis)
    number = np.cumsum(np.diff(rising, axis=axis, prepend=first) > room, axis=axis)
    found = np.empty_like(number)
    np.put_along_axis(found, order, number, axis=axis)
    return np.asarray(found)
