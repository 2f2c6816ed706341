"""Location of points in straight or curved cells, in 2D and 3D."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem import Array, Index, ProblemError, format_point
from reference_fem.mesh.maps import Cells, determinant

OUTSIDE = 1e-9
"""A point this close to the body, relative to the body's size, lies on its edge."""
PAIRS_AT_ONCE = 1_000_000
"""Number of pairs of cells and points per batch, for cells of eight nodes."""


def locate(cells: Cells, points: Array) -> tuple[Index, Array]:
    """Cell (p,) and local coordinates (p, d) of points (p, d) in m.

    Of the cells that hold a point, the one that misses it least; on an edge, the first.

    Raises
    ------
    ProblemError
        If a point lies outside every cell.
    """
    point, cell, local = incident(cells, points)
    _, first = np.unique(point, return_index=True)
    return cell[first], local[first]


def incident(cells: Cells, points: Array) -> tuple[Index, Index, Array]:
    """Pairs of a point and a cell that holds it, with local coordinates: (q,), (q,) and (q, d).

    By rising point; of the cells of one point, the one that misses it least comes first, and of
    those alike the first of them.

    Raises
    ------
    ProblemError
        If a point lies outside every cell.
    """
    d = points.shape[1]
    reach = OUTSIDE * float(np.ptp(cells.nodes.reshape(-1, d), axis=0).max())
    found: list[tuple[Index, Index, Array, Array]] = [
        (np.zeros(0, dtype=np.intp), np.zeros(0, dtype=np.intp), np.zeros((0, d)), np.zeros(0))
    ]
    for cell, point in _candidate_pairs(cells.hull, points, reach):
        nodes = cells.nodes[cell]
        where, miss = _clip_to_cell(
            cells, nodes, _inverse(cells, nodes, points[point]), points[point]
        )
        held = miss <= reach
        found.append((point[held], cell[held], where[held], miss[held]))
    point, cell, local, miss = (np.concatenate(each) for each in zip(*found, strict=True))
    lost = np.bincount(point, minlength=len(points)) == 0
    if lost.any():
        raise ProblemError(
            f"points to sample: {format_point(points[lost][0])}; they must lie in the body"
        )
    order = np.lexsort((cell, miss, point))
    return point[order], cell[order], local[order]


def _candidate_pairs(hull: Array, points: Array, reach: float) -> Iterator[tuple[Index, Index]]:
    """Pairs (cell, point) of which the cell's box holds the point, in batches of rising cells."""
    if not len(points):
        return
    low, high = hull.min(axis=1) - reach, hull.max(axis=1) + reach
    tree = KDTree(points)
    # Each cell asks for the points of a cube about it: no table of all cells with all points.
    middle, half = (low + high) / 2, (high - low).max(axis=1) / 2 + reach
    asked = tree.query_ball_point(middle, half, np.inf, return_length=True)
    batch = np.cumsum(asked) * max(8, hull.shape[1]) // (8 * PAIRS_AT_ONCE)
    for number in np.unique(batch[asked > 0]):
        cells = np.flatnonzero((batch == number) & (asked > 0))
        near = tree.query_ball_point(middle[cells], half[cells], np.inf)
        cell, point = np.repeat(cells, asked[cells]), np.concatenate(near).astype(np.intp)
        held = ((points[point] >= low[cell]) & (points[point] <= high[cell])).all(axis=1)
        yield cell[held], point[held]


def _inverse(cells: Cells, nodes: Array, points: Array) -> Array:
    """Local coordinates (q, d) of points (q, d), each in its own cell (q, k, d)."""
    q, d = points.shape
    if cells.start.ndim == 1:
        local = np.tile(cells.start, (q, 1))
    else:  # the nearest node's
        local = cells.start[((nodes - points[:, None]) ** 2).sum(axis=2).argmin(axis=1)]
    for _ in range(cells.steps):
        place, columns = cells.map(nodes, local)
        gap = points - place
        # Cramer's rule: the gap in place of each column in turn.
        swapped = [[*columns[:axis], gap, *columns[axis + 1 :]] for axis in range(d)]
        step = np.column_stack([determinant(each) for each in swapped])
        # Far outside a cell the map may fold over; such a cell is not the point's, so stay near it.
        with np.errstate(divide="ignore", invalid="ignore"):
            change = step / determinant(columns)[:, None]
            local = np.clip(np.nan_to_num(local + change), -1.0, 2.0)
    return local


def _clip_to_cell(cells: Cells, nodes: Array, local: Array, points: Array) -> tuple[Array, Array]:
    """Nearest local coordinates inside the cell, and the distance (q,) in m left to the point."""
    inside = np.clip(local, 0.0, 1.0)
    if cells.simplex:
        inside /= np.maximum(inside.sum(axis=1, keepdims=True), 1.0)
    place, _ = cells.map(nodes, inside)
    return inside, np.linalg.norm(points - place, axis=1)
