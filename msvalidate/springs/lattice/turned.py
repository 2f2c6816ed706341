"""Regular lattice in a box, with its rows at any angle to the sides."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from msvalidate.problem import Array, Box, Index, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_angle,
    format_value,
    length_in_metres,
    refuse_too_many,
    require_type,
)
from msvalidate.springs.lattice.corners import corner_volumes
from msvalidate.springs.lattice.filled import (
    Lattice,
    missing_springs,
    number_springs,
    side_share,
    weakly_supported,
)
from msvalidate.springs.lattice.pattern import Pattern
from msvalidate.springs.lattice.tessellation import delaunay_simplices
from msvalidate.springs.lattice.ties import TIE, level_numbers

WEAK = 0.4
"""Smallest eigenvalue of Σ n nᵀ for which a point needs no braces.

The sum is over the directions n of the point's springs of the first kind, since others may have no
stiffness. Two springs at 60 degrees have 1/2; the springs of a moved point may almost lie in a
plane.
"""
REACH = 0.4
"""Distance from a side within which points move onto it, in nearest-neighbour distances.

It is below 1/2, so that neighbours on opposite sides do not coincide.
"""


def fill_rotated(pattern: Pattern, box: Box, spacing: float, turn: float | Array) -> Lattice:
    """Fill a box with a lattice at any angle to its sides.

    Points near a side are moved onto it, the nearest point moves into each corner, and points
    farther out are removed with their springs. Points with too few springs get additional ones of
    the first kind. Supports and loads then coincide with the sides at any angle, but a uniform
    strain has an error of first order in the spacing at the boundary.

    Parameters
    ----------
    pattern
        Unit cell of the lattice.
    box
        Box of the same dimension d.
    spacing
        Length (m) of the unit of the pattern.
    turn
        Counter-clockwise angle (rad) in 2D, or a rotation matrix of shape (d, d).

    Returns
    -------
    Lattice
        Points (n, d) in m and springs (m, 2); cells are Delaunay triangles or tetrahedra.

    Raises
    ------
    ProblemError
        If a value is out of its range, there are too many points, or the box has too few.

    Examples
    --------
    >>> from msvalidate import Box, fill_rotated, patterns
    >>> lattice = fill_rotated(patterns.triangular(), Box((0.37, 0.2)), spacing=0.05, turn=0.3)
    >>> print(f"{lattice.point_volume.sum():.6f} m²")
    0.074000 m²
    """
    require_type("pattern", pattern, Pattern)
    if not isinstance(box, Box) or box.dim != pattern.dim:
        raise ProblemError(
            f"{pattern.name} lattice: a {format_value(box)}; give a box of {pattern.dim} lengths"
        )
    a, Q = length_in_metres("spacing", spacing), rotation_matrix(turn, box.dim)
    number, points = _rotated_sites(pattern, box, a, Q)
    pairs, which = number_springs(pattern, number)
    # Where places were merged, two springs may have become one, or none.
    springs, first = np.unique(pairs, axis=0, return_index=True)
    proper = springs[:, 0] < springs[:, 1]
    springs, which = springs[proper], which[first[proper]]
    cells, facets = delaunay_simplices(points, box)
    braces = missing_springs(
        springs, cells, weakly_supported(points, springs[pattern.kind[which] == 0], WEAK)
    )
    springs = np.concatenate([springs, braces])
    kind = np.concatenate([pattern.kind[which], np.zeros(len(braces), dtype=np.intp)])
    each = corner_volumes(points, cells).ravel()
    return Lattice(
        name=f"{pattern.name}, turned",
        domain=box,
        points=points,
        springs=springs,
        kind=kind,
        cells=cells,
        facets=facets,
        share=side_share(points, springs, box),
        point_volume=np.bincount(cells.ravel(), each, len(points)).astype(float),
        factor=np.concatenate([pattern.factor[which], np.ones(len(braces))]),
        regular=False,
    )


def _rotated_sites(pattern: Pattern, box: Box, a: float, Q: Array) -> tuple[Index, Array]:
    """Numbers (.., cells y, cells x, points a cell) of the places, -1 left out, and positions."""
    edges = np.array(box.size)
    reach = REACH * (1 + TIE) * a * float(np.linalg.norm(pattern.vectors, axis=1).min())
    ends = np.array(list(product((0.0, 1.0), repeat=box.dim))) * edges
    cells = ends @ Q / (a * np.array(pattern.size))
    low, high = np.floor(cells.min(axis=0)) - 1, np.ceil(cells.max(axis=0)) + 2
    refuse_too_many(
        f"{pattern.name} lattice, turned", len(pattern.points) * math.prod((high - low).tolist())
    )
    axes = [np.arange(*span) for span in zip(low[::-1], high[::-1], strict=True)]
    cell = np.stack(np.meshgrid(*axes, indexing="ij")[::-1], axis=-1)[..., None, :]
    place = a * (cell * np.array(pattern.size) + pattern.points) @ Q.T
    kept = ((place >= -reach) & (place <= edges + reach)).all(axis=-1)
    points = place[kept]
    points[points <= reach] = 0.0
    beyond = points >= edges - reach
    points[beyond] = np.broadcast_to(edges, points.shape)[beyond]
    number = np.full(kept.shape, -1)
    number[kept], points = _merge_points(points, ends, reach)
    return number, points


def _merge_points(points: Array, ends: Array, reach: float) -> tuple[Index, Array]:
    """Numbers of points of which those that met are one, and the points, one in every corner."""
    nearest = _first_of_nearest(points, ends, TIE * reach)
    if len(set(nearest.tolist())) < len(ends):
        raise ProblemError(
            "lattice, turned: two corners of the box share their nearest point; take a smaller "
            "spacing"
        )
    points[nearest] = ends
    same = np.arange(len(points))
    pairs = KDTree(points).query_pairs(reach * (1 + TIE), output_type="ndarray")
    corner = np.isin(np.arange(len(points)), nearest)
    for i, j in pairs[np.lexsort(pairs.T[::-1])]:
        into, gone = (j, i) if corner[j] else (i, j)
        if same[into] == into and same[gone] == gone:
            same[gone] = into
    kept, number = np.unique(same, return_inverse=True)
    return number, points[kept]


def _first_of_nearest(points: Array, places: Array, room: float) -> Index:
    """The point (q,) nearest to each place (q, d), of those as near the first along x, y and z.

    Distances and coordinates within `room` (m) of each other are one.
    """
    tree = KDTree(points)
    apart, _ = tree.query(places)
    found = []
    for near in tree.query_ball_point(places, apart + room, return_sorted=True):
        order = np.lexsort(level_numbers(points[near], room).T[::-1])
        found.append(near[order[0]])
    return np.array(found)


def rotation_matrix(turn: ArrayLike, dim: int) -> Array:
    """Return the rotation matrix (dim, dim) of an angle (rad), or a given matrix.

    Raises `ProblemError` if it is neither.
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
