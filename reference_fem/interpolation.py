"""Which cell holds a point, and where in it: for cells with straight edges, in d dimensions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem import Array, Index, ProblemError, place_name

OUTSIDE = 1e-9
"""A point this close to the body, relative to the body's size, lies on its edge."""
PAIRS_AT_ONCE = 1_000_000
NEWTON_STEPS = 12
"""The inverse of a multilinear map from a cell's centre converges quadratically; parallelograms
take one step."""


def locate(corners: Array, points: Array) -> tuple[Index, Array]:
    """Cell (p,) and local coordinates (p, d) of points (p, d).

    Parameters
    ----------
    corners
        (c, k, d) corners of convex triangles or quadrilaterals, in order, or of tetrahedra or
        hexahedra, in VTK order. Local coordinates run over the unit simplex or the unit cube,
        corner 0 at the origin.
    points
        (p, d) in m.

    Raises
    ------
    ProblemError
        If a point lies outside every cell.
    """
    reach = OUTSIDE * float(np.ptp(corners.reshape(-1, corners.shape[2]), axis=0).max())
    cells, local = np.zeros(len(points), dtype=np.intp), np.zeros(points.shape)
    least = np.full(len(points), np.inf)
    for cell, point in _pairs(corners, points, reach):
        where = _inverse(corners[cell], points[point])
        where, miss = _clipped(corners[cell], where, points[point])
        # Of the cells whose box holds a point, the one that misses it least; on an edge, the first.
        order = np.lexsort((cell, miss, point))
        found, start = np.unique(point[order], return_index=True)
        best = order[start]
        better = miss[best] < least[found]
        found, best = found[better], best[better]
        cells[found], local[found], least[found] = cell[best], where[best], miss[best]
    lost = least > reach
    if lost.any():
        raise ProblemError(
            f"points to sample: {place_name(points[lost][0])}; they must lie in the body"
        )
    return cells, local


def _pairs(corners: Array, points: Array, reach: float) -> Iterator[tuple[Index, Index]]:
    """Pairs (cell, point) of which the cell's box holds the point, in batches of rising cells."""
    if not len(points):
        return
    low, high = corners.min(axis=1) - reach, corners.max(axis=1) + reach
    tree = KDTree(points)
    # Each cell asks for the points of a cube about it: no table of all cells with all points.
    middle, half = (low + high) / 2, (high - low).max(axis=1) / 2 + reach
    asked = tree.query_ball_point(middle, half, np.inf, return_length=True)
    batch = np.cumsum(asked) // PAIRS_AT_ONCE
    for number in np.unique(batch[asked > 0]):
        cells = np.flatnonzero((batch == number) & (asked > 0))
        near = tree.query_ball_point(middle[cells], half[cells], np.inf)
        cell, point = np.repeat(cells, asked[cells]), np.concatenate(near).astype(np.intp)
        held = ((points[point] >= low[cell]) & (points[point] <= high[cell])).all(axis=1)
        yield cell[held], point[held]


def _inverse(corners: Array, points: Array) -> Array:
    """Local coordinates (q, d) of points (q, d), each in its own cell (q, k, d)."""
    q, k, d = corners.shape
    simplex = k == d + 1
    local = np.full((q, d), 1 / k if simplex else 0.5)
    for _ in range(1 if simplex else NEWTON_STEPS):
        place, columns = mapped(corners, local)
        gap = points - place
        # Cramer's rule: the gap in place of each column in turn.
        swapped = [[*columns[:axis], gap, *columns[axis + 1 :]] for axis in range(d)]
        step = np.column_stack([determinant(each) for each in swapped])
        # Far outside a cell the map may fold over; such a cell is not the point's, so stay near it.
        with np.errstate(divide="ignore", invalid="ignore"):
            change = step / determinant(columns)[:, None]
            local = np.clip(np.nan_to_num(local + change), -1.0, 2.0)
    return local


def _clipped(corners: Array, local: Array, points: Array) -> tuple[Array, Array]:
    """Nearest local coordinates inside the cell, and the distance (q,) in m left to the point."""
    inside = np.clip(local, 0.0, 1.0)
    if corners.shape[1] == corners.shape[2] + 1:
        inside /= np.maximum(inside.sum(axis=1, keepdims=True), 1.0)
    place, _ = mapped(corners, inside)
    return inside, np.linalg.norm(points - place, axis=1)


def mapped(corners: Array, local: Array) -> tuple[Array, list[Array]]:
    """Place (q, d) of local coordinates (q, d), and its derivative by each of them.

    Cells (q, k, d) are as in `locate`; one row of local coordinates serves them all.
    """
    x = corners.transpose(1, 0, 2)
    r, s, *t = local.T[:, :, None]
    if len(x) == local.shape[1] + 1:
        columns = [corner - x[0] for corner in x[1:]]
        return sum((u * side for u, side in zip((r, s, *t), columns, strict=True)), x[0]), columns
    if not t:
        return _bilinear(x, r, s)
    (low, sides), (high, others) = _bilinear(x[:4], r, s), _bilinear(x[4:], r, s)
    along, across = ((1 - t[0]) * a + t[0] * b for a, b in zip(sides, others, strict=True))
    return (1 - t[0]) * low + t[0] * high, [along, across, high - low]


def _bilinear(x: Array, r: Array, s: Array) -> tuple[Array, list[Array]]:
    """Place and derivatives on a quadrilateral with corners x (4, q, d)."""
    along = (1 - s) * (x[1] - x[0]) + s * (x[2] - x[3])
    across = (1 - r) * (x[3] - x[0]) + r * (x[2] - x[1])
    place = (1 - r) * (1 - s) * x[0] + r * (1 - s) * x[1] + r * s * x[2] + (1 - r) * s * x[3]
    return place, [along, across]


def determinant(columns: Sequence[Array]) -> Array:
    """Determinants (q,) of matrices of order 2 or 3, given by their columns (q, d)."""
    if len(columns) == 2:
        a, b = columns
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    a, b, c = columns
    return np.asarray((a * np.cross(b, c)).sum(axis=1))
