"""Triangles that fill a straight-edged outline, of about one size."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from scipy.spatial import Delaunay, KDTree

from msvalidate.problem import Array, Index, Polygon, ProblemError
from msvalidate.problem.checks import length_in_metres, refuse_too_many, require_type
from reference_fem.mesh.discretisation import Discretisation, make_discretisation

CLEAR = 0.6
"""Smallest distance of interior points from the outline, in spacings.

Closer points make flat triangles.
"""
TRIES = 6
"""Maximum number of refinements of the outline until triangles contain every edge."""


def outline_discretisation(
    outline: Polygon, spacing: float, through: Array | None = None
) -> Discretisation:
    """Linear triangles of about a spacing (m), with nodes at vertices and at places (p, 2) in m.

    Delaunay's triangles of points on the edges and of equilateral ones inside; edges of the outline
    are edges of triangles, for points on them are doubled until they are.

    Raises
    ------
    ProblemError
        If the triangles are too many, or no such triangles are found, as between edges that are
        very close to each other.
    """
    require_type("outline", outline, Polygon)
    h = length_in_metres("spacing", spacing)
    refuse_too_many(f"mesh of spacing {h:g} m", 2.4 * outline.volume / h**2)
    given = np.empty((0, 2)) if through is None else np.asarray(through, dtype=float)
    origin = outline.corners.mean(axis=0)
    for times in range(TRIES):
        rim = _rim(outline, h / 2**times, given) - origin
        inside = _inside(outline, h, given, rim + origin) - origin
        points = np.concatenate([rim, inside])
        cells = _triangles(points, origin, outline)
        if _covers(points, cells, outline):
            return make_discretisation(points + origin, cells, "P1")
    raise ProblemError(
        f"mesh of a {outline}: edges too close to each other for triangles of {h:g} m; give a mesh "
        "file"
    )


def _rim(outline: Polygon, h: float, given: Array) -> Array:
    """Points (n, 2) in m along the edges, in their order, through those given that lie there."""
    found = []
    for a, b in zip(outline.corners, np.roll(outline.corners, -1, axis=0), strict=True):
        along = b - a
        length = float(np.linalg.norm(along))
        t = (given - a) @ along / length**2
        off = np.linalg.norm(given - a - t[:, None] * along, axis=1)
        on = t[(off <= outline.tolerance) & (t > 0) & (t < 1)]
        stops = np.unique(np.concatenate([[0.0, 1.0], on]))
        stops = stops[np.concatenate([[True], np.diff(stops) * length > outline.tolerance])]
        for low, high in pairwise(stops):
            many = max(1, round((high - low) * length / h))
            part = low + (high - low) * np.arange(many) / many
            found.append(a + part[:, None] * along)
    return np.concatenate(found)


def _inside(outline: Polygon, h: float, given: Array, rim: Array) -> Array:
    """Equilateral points (n, 2) in m inside, clear of the rim, and those given."""
    (x0, x1), (y0, y1) = outline.span
    rows = np.arange(y0, y1, h * np.sqrt(3) / 2)
    x = np.arange(x0 - h / 2, x1 + h, h)
    grid = np.concatenate(
        [np.column_stack([x + h / 2 * (i % 2), np.full(len(x), y)]) for i, y in enumerate(rows)]
    )
    grid = grid[outline.contains(grid)]
    kept = given[outline.contains(given)]
    clear = KDTree(rim).query(grid)[0] > CLEAR * h if len(grid) else np.empty(0, dtype=bool)
    clear &= _distance_to_edges(outline, grid) > CLEAR * h / 2
    if len(kept):
        apart = KDTree(rim).query(kept)[0] > outline.tolerance
        kept = kept[apart]
    if len(kept):
        clear &= KDTree(kept).query(grid)[0] > CLEAR * h
    return np.concatenate([grid[clear], kept])


def _distance_to_edges(outline: Polygon, points: Array) -> Array:
    """Distance (n,) in m of points (n, 2) from the outline."""
    least = np.full(len(points), np.inf)
    for a, b in zip(outline.corners, np.roll(outline.corners, -1, axis=0), strict=True):
        along = b - a
        t = np.clip((points - a) @ along / (along @ along), 0, 1)
        least = np.minimum(least, np.linalg.norm(points - a - t[:, None] * along, axis=1))
    return least


def _triangles(points: Array, origin: Array, outline: Polygon) -> Index:
    """Triangles (c, 3), counter-clockwise, whose middles lie in the outline."""
    cells = Delaunay(points).simplices
    x = points[cells]
    a, b = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
    area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
    longest = np.linalg.norm(x - np.roll(x, 1, axis=1), axis=2).max(axis=1)
    thick = np.abs(area) > outline.tolerance * longest
    inside = thick & outline.contains(x.mean(axis=1) + origin)
    cells = np.where((area < 0)[:, None], cells[:, ::-1], cells)
    return np.asarray(cells[inside])


def _covers(points: Array, cells: Index, outline: Polygon) -> bool:
    """Return True if triangles fill the outline and use every point."""
    x = points[cells]
    a, b = x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]
    area = float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)
    used = len(np.unique(cells)) == len(points)
    return used and abs(area - outline.volume) <= 1e-10 * outline.volume
