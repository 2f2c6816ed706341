"""Detection of folded (inverted) cells in a deformed network.

A cell is looked at by the simplices at its corners: the triangle of a corner of a quadrilateral and
its two neighbours, the tetrahedron of a corner of a hexahedron and its three, and triangles and
tetrahedra as they are. The sign of each one's area or volume is compared with its own at the
reference points: for quadrilaterals and hexahedra that is the sign of the Jacobian at the corners.

A network without cells may show triangles of springs in the plane. Round a triangle each spring is
followed by the next one at its end, clockwise, so that no other spring leads into it from a corner;
where springs cross, as the diagonals of squares do, this closes on no triangle and nothing is said.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, Mask, format_point
from msvalidate.problem.records import ReadOnly, dataclass

FLATTEST = 0.25
"""Largest sine of a simplex's corners below which it is not checked for folding.

For three edges the sine is their determinant over their lengths. Flatter simplices fold at strains
of 1 - cos(arcsin 0.25) = 3 %, because their points almost lie on one line or plane.
"""
NARROWEST = 0.25
"""Smallest height of a spring triangle, relative to its longest spring, to be checked.

A triangle with a short side folds when that side alone turns.
"""
ENOUGH = 0.5
"""Fraction of the points that spring triangles must reach to be representative."""
SHOWN = 3
"""Cells that a message names."""

_CORNERS = {
    (2, 3): ((0, 1, 2),),
    (2, 4): ((0, 1, 3), (1, 2, 0), (2, 3, 1), (3, 0, 2)),
    (3, 4): ((0, 1, 2, 3),),
    (3, 8): (
        (0, 1, 3, 4),
        (1, 2, 0, 5),
        (2, 3, 1, 6),
        (3, 0, 2, 7),
        (4, 7, 5, 0),
        (5, 4, 6, 1),
        (6, 5, 7, 2),
        (7, 6, 4, 3),
    ),
}
"""(axes, corners) of a cell -> corner and neighbours of each simplex, in VTK order."""


@dataclass(frozen=True, eq=False)
class Simplices(ReadOnly):
    """Simplices that are checked for folding. Arrays are made read-only.

    Parameters
    ----------
    corners
        (s, d + 1) points of each simplex.
    cell
        (s,) the cell that it is a part of.
    positive
        (s,) whether its area or volume is above zero at the reference points.
    """

    corners: Index
    cell: Index
    positive: Mask


def is_shape_of_cells(dim: int, corners: int) -> bool:
    """Return True if cells with this number of corners can be checked for folds."""
    return (dim, corners) in _CORNERS


def simplices_of(points: Array, springs: Index, cells: Index | None) -> Simplices | None:
    """Simplices to look at, from a network's cells or the triangles of its springs.

    Parameters
    ----------
    points, springs
        (n, d) reference positions (m), and pairs (m, 2).
    cells
        (c, corners) in VTK order, where they are known. In the plane triangles of springs are
        taken instead where cells leave out points that these reach.
    """
    dim = points.shape[1]
    own = None if cells is None or not len(cells) else _simplices_of_cells(points, cells)
    if dim == 2 and (own is None or len(np.unique(own.corners)) < len(points)):
        found = _simplices_of_springs(points, springs)
        least = ENOUGH * len(points) if own is None else len(np.unique(own.corners))
        if found is not None and len(np.unique(found.corners)) >= least:
            return found
    return own


def folded_cells(simplices: Simplices, position: Array) -> Index:
    """Indices (f,) of the flat or inverted cells at `position` (n, d) in m."""
    over = (_determinant(position, simplices.corners) > 0) != simplices.positive
    return np.unique(simplices.cell[over]) if over.any() else simplices.cell[:0]


def count_folded(simplices: Simplices | None, position: Array) -> int | None:
    """Number of folded cells at `position` (n, d) in m; None without cells."""
    return None if simplices is None else len(folded_cells(simplices, position))


def describe_folded(simplices: Simplices, folded: Index, points: Array) -> str:
    """Describe the number of folded cells and the positions of the first ones."""
    places = []
    for cell in folded[:SHOWN]:
        corners = np.unique(simplices.corners[simplices.cell == cell])
        places.append(format_point(points[corners].mean(axis=0)))
    more = ", ..." if len(folded) > SHOWN else ""
    many = len(np.unique(simplices.cell))
    what = "cell is" if len(folded) == 1 else "cells are"
    return f"{len(folded)} {what} inside out, of {many}: at {', '.join(places)}{more}"


def _simplices_of_cells(points: Array, cells: Index) -> Simplices | None:
    """The simplices at all corners of cells."""
    parts = _CORNERS[points.shape[1], cells.shape[1]]
    corners = np.concatenate([cells[:, part] for part in parts])
    cell = np.tile(np.arange(len(cells)), len(parts))
    return _drop_flat(points, corners, cell, whole=len(parts) == 1)


def _drop_flat(points: Array, corners: Index, cell: Index, *, whole: bool) -> Simplices | None:
    """Remove simplices (s, d + 1) that are flat at the reference positions.

    A part of a larger cell is judged by its own corner, a whole cell by its widest one.
    """
    content = _determinant(points, corners)
    count = corners.shape[1]
    around = np.zeros(len(corners))
    for first in range(count if whole else 1):
        lengths = np.ones(len(corners))
        for other in range(count):
            if other != first:
                edge = points[corners[:, other]] - points[corners[:, first]]
                lengths = lengths * np.sqrt((edge**2).sum(axis=1))
        with np.errstate(divide="ignore", invalid="ignore"):  # corners in one place: not judged
            around = np.fmax(around, np.abs(content) / lengths)
    kept = (around >= FLATTEST) & np.isfinite(around)
    if not kept.any():
        return None
    return Simplices(corners[kept], cell[kept], content[kept] > 0)


def _determinant(x: Array, corners: Index) -> Array:
    """Determinant (s,) of the edges from the first corner: twice the area, or six volumes."""
    columns = np.ascontiguousarray(corners.T)
    e = [
        [axis[column] - axis[columns[0]] for axis in np.ascontiguousarray(x.T)]
        for column in columns[1:]
    ]
    if len(e) == 2:
        return np.asarray(e[0][0] * e[1][1] - e[0][1] * e[1][0])
    (a, b, c), (p, q, r), (u, v, w) = e
    return np.asarray(a * (q * w - r * v) + b * (r * u - p * w) + c * (p * v - q * u))


def _simplices_of_springs(points: Array, springs: Index) -> Simplices | None:
    """Triangles of springs in the plane that no other spring enters at a corner."""
    n = len(points)
    low, high = springs.min(axis=1), springs.max(axis=1)
    start, end = np.divmod(np.unique(low * n + high), n)
    m = len(start)
    source, target = np.concatenate([start, end]), np.concatenate([end, start])
    way = points[target] - points[source]
    order = np.lexsort((np.arctan2(way[:, 1], way[:, 0]), source))
    place = np.empty(2 * m, dtype=np.intp)
    place[order] = np.arange(2 * m)
    first = np.searchsorted(source[order], np.arange(n + 1))
    back = place[np.roll(np.arange(2 * m), m)]  # where the same spring stands at its other end
    before = np.where(back > first[target], back - 1, first[target + 1] - 1)
    following = order[before]
    second = following[np.arange(2 * m)]
    third = following[second]
    closed = following[third] == np.arange(2 * m)
    once = closed & (np.arange(2 * m) < second) & (np.arange(2 * m) < third)
    corners = np.column_stack([source[once], source[second[once]], source[third[once]]])
    if not len(corners):
        return None
    across = points[corners] - points[np.roll(corners, 1, axis=1)]
    longest = (across**2).sum(axis=2).max(axis=1)
    # The outside of a lone triangle goes round it clockwise.
    corners = corners[_determinant(points, corners) >= NARROWEST * longest]
    return (
        _drop_flat(points, corners, np.arange(len(corners)), whole=True) if len(corners) else None
    )
