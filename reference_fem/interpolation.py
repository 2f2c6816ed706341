"""Which cell holds a point, and where in it: for straight-sided triangles and quadrilaterals."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, ProblemError, place_name

OUTSIDE = 1e-9
"""A point this close to the body, relative to the body's size, lies on its edge."""
PAIRS_AT_ONCE = 10_000_000
NEWTON_STEPS = 12
"""The inverse of a bilinear map from a cell's centre converges quadratically; parallelograms take
one step."""


def locate(corners: Array, points: Array) -> tuple[Index, Array]:
    """Cell (p,) and local coordinates (p, 2) of points (p, 2).

    Parameters
    ----------
    corners
        (c, 3 or 4, 2) corners of convex cells, in order. Local coordinates run over the
        unit triangle or the unit square, corner 0 at the origin.
    points
        (p, 2) in m.

    Raises
    ------
    ProblemError
        If a point lies outside every cell.
    """
    reach = OUTSIDE * float(np.ptp(corners.reshape(-1, 2), axis=0).max())
    low, high = corners.min(axis=1) - reach, corners.max(axis=1) + reach
    cells, local = np.empty(len(points), dtype=np.intp), np.empty((len(points), 2))
    chunk = max(1, PAIRS_AT_ONCE // len(corners))
    for first in range(0, len(points), chunk):
        part = slice(first, first + chunk)
        cells[part], local[part] = _located(corners, low, high, points[part], reach)
    return cells, local


def _located(
    corners: Array, low: Array, high: Array, points: Array, reach: float
) -> tuple[Index, Array]:
    x = points[:, None, :]
    point, cell = np.nonzero(((x >= low) & (x <= high)).all(axis=2))
    local = _inverse(corners[cell], points[point])
    local, miss = _clipped(corners[cell], local, points[point])
    # Of the cells whose box holds a point, the one that misses it least; on an edge, the first.
    order = np.lexsort((cell, miss, point))
    found, start = np.unique(point[order], return_index=True)
    best = order[start]
    lost = np.ones(len(points), dtype=bool)
    lost[found[miss[best] <= reach]] = False
    if lost.any():
        raise ProblemError(
            f"points to sample: {place_name(points[lost][0])}; they must lie in the body"
        )
    return cell[best], local[best]


def _inverse(corners: Array, points: Array) -> Array:
    """Local coordinates (q, 2) of points (q, 2), each in its own cell (q, 3 or 4, 2)."""
    local = np.full(points.shape, 0.5 if corners.shape[1] == 4 else 1 / 3)
    for _ in range(NEWTON_STEPS if corners.shape[1] == 4 else 1):
        place, along, across = _mapped(corners, local)
        gap = points - place
        determinant = along[:, 0] * across[:, 1] - along[:, 1] * across[:, 0]
        step = np.column_stack(
            [
                gap[:, 0] * across[:, 1] - gap[:, 1] * across[:, 0],
                along[:, 0] * gap[:, 1] - along[:, 1] * gap[:, 0],
            ]
        )
        # Far outside a cell the map may fold over; such a cell is not the point's, so stay near it.
        with np.errstate(divide="ignore", invalid="ignore"):
            local = np.clip(np.nan_to_num(local + step / determinant[:, None]), -1.0, 2.0)
    return local


def _clipped(corners: Array, local: Array, points: Array) -> tuple[Array, Array]:
    """Nearest local coordinates inside the cell, and the distance (q,) in m left to the point."""
    inside = np.clip(local, 0.0, 1.0)
    if corners.shape[1] == 3:
        inside /= np.maximum(inside.sum(axis=1, keepdims=True), 1.0)
    place, _, _ = _mapped(corners, inside)
    return inside, np.linalg.norm(points - place, axis=1)


def _mapped(corners: Array, local: Array) -> tuple[Array, Array, Array]:
    """Place (q, 2) of local coordinates, and its derivatives by them."""
    r, s = local[:, :1], local[:, 1:]
    x = corners.transpose(1, 0, 2)
    if len(x) == 3:
        along, across = x[1] - x[0], x[2] - x[0]
        return x[0] + r * along + s * across, along, across
    along = (1 - s) * (x[1] - x[0]) + s * (x[2] - x[3])
    across = (1 - r) * (x[3] - x[0]) + r * (x[2] - x[1])
    place = (1 - r) * (1 - s) * x[0] + r * (1 - s) * x[1] + r * s * x[2] + (1 - r) * s * x[3]
    return place, along, across
