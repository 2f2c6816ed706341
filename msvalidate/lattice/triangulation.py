"""Delaunay triangulations of points in the plane and in space, and areas of their duals.

The triangulation is the lower hull of the points lifted onto a paraboloid. Where points are so
regular that it is not unique (the corners of a square), flat simplices without a circumcentre come
up; the paraboloid is then roughened by so little that only such choices depend on it.

The facet dual to an edge is a polygon of circumcentres, its area a sum over the faces around the
edge of signed triangles, all in arrays. The sum of area times edge length depends on how simplices
meet, and not on where their centres are: ill-conditioned ones do no harm to it.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, KDTree, QhullError

from msvalidate.problem import Array, Index, SolverError

ROUGHNESS = (0.0, 1e-11, 1e-9, 1e-7)
"""Of the paraboloid, in parts of its height, tried in turn until no simplex is flat."""
FLAT = 1e-9
"""Volume of a flat simplex in parts of its longest edges' product."""
VERTICAL = 1e-9
"""Largest slope, as a cosine, of hull facets that are walls and not simplices."""
FACES = {
    2: np.array([[1, 2], [2, 0], [0, 1]]),
    3: np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
}
"""Face opposite each corner of a positive simplex, its normal (right of it; by the right hand)
outwards."""


def triangulation(
    x: Array, count: int, source: Index, *, regular: bool = False
) -> tuple[Index, Index]:
    """Positive simplices (c, d+1) and the one beyond each face (c, d+1), -1 outside.

    Those at the first `count` points are not flat. Where choices are made, they are alike for all
    images of a point, of which `source` has the number, unless only images meet. Points known to
    be `regular`, as two and their reflections are, are not tried without roughness.

    Source: [Delaunay1934].
    """
    dim = x.shape[1]
    centred = x - 0.5 * (x.min(axis=0) + x.max(axis=0))
    height = (centred**2).sum(axis=1)
    height /= math.sqrt(height.max()) or 1.0
    rng = np.random.default_rng(0)
    rough = (rng.random(len(x))[source] + 0.03 * rng.random(len(x))) * height.max()
    for roughness in ROUGHNESS[regular:]:
        try:
            hull = ConvexHull(np.column_stack([centred, height + roughness * rough]))
        except QhullError:  # all points on one circle or sphere
            if roughness == ROUGHNESS[-1]:
                raise
            continue
        lower = hull.equations[:, dim] < -VERTICAL
        number = np.where(lower, np.cumsum(lower) - 1, -1)
        cells, beyond = hull.simplices[lower].astype(np.intp), number[hull.neighbors[lower]]
        content, here = signed_volumes(centred[cells]), (cells < count).any(axis=1)
        if not (relative_volume(centred, cells[here]) <= FLAT).any():
            break
    else:
        if not content[here].all():
            raise SolverError(f"{count} points: some are so close that their simplices are flat")
    turned = content < 0
    cells[turned, :2], beyond[turned, :2] = cells[turned, 1::-1], beyond[turned, 1::-1]
    return cells, beyond


def dual_areas(
    x: Array, cells: Index, beyond: Index, centres: Array, count: int
) -> tuple[Index, Index, Array]:
    """Facets across edges at the first `count` points: lower and higher index, and area."""
    dim = x.shape[1]
    here, corner = np.nonzero(beyond > np.arange(len(cells))[:, None])
    there = beyond[here, corner]
    face = cells[here[:, None], FACES[dim][corner]]
    ends = face[:, None] if dim == 2 else face[:, [[0, 1], [1, 2], [2, 0]]]
    a, b = ends.reshape(-1, 2).T
    here, there = (np.repeat(cell, ends.shape[1]) for cell in (here, there))
    at_points = (a < count) | (b < count)
    a, b, here, there = a[at_points], b[at_points], here[at_points], there[at_points]
    edge, middle = x[b] - x[a], 0.5 * (x[a] + x[b])
    edge /= np.linalg.norm(edge, axis=1)[:, None]
    u, v = centres[here] - middle, centres[there] - middle
    if dim == 2:
        part = (v - u)[:, 0] * edge[:, 1] - (v - u)[:, 1] * edge[:, 0]
    else:
        (ux, uy, uz), (vx, vy, vz), (x_, y_, z_) = u.T, v.T, edge.T
        part = 0.5 * (
            (uy * vz - uz * vy) * x_ + (uz * vx - ux * vz) * y_ + (ux * vy - uy * vx) * z_
        )
    key, which = np.unique(np.minimum(a, b) * len(x) + np.maximum(a, b), return_inverse=True)
    return key // len(x), key % len(x), np.asarray(np.bincount(which, part, len(key)), dtype=float)


def relative_volume(x: Array, cells: Index) -> Array:
    """Volume (c,) of simplices in parts of the product of the edges at a corner: zero if flat."""
    corners = x[cells]
    edges = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2)
    return np.asarray(np.abs(signed_volumes(corners)) / edges.prod(axis=1))


def stabilise_centres(centres: Array, flat: Array, beyond: Index, least: float) -> Array:
    """Centres (c, d), those of simplices flatter than `least` being of the least flat one beside.

    Rounding puts the centre of a flat simplex anywhere; those of its neighbours are near it.
    """
    which = np.flatnonzero(flat < least)
    beside = beyond[which]
    best = np.where(beside < 0, -1.0, flat[beside]).argmax(axis=1)
    source = beside[np.arange(len(which)), best]
    steady = centres.copy()
    steady[which[source >= 0]] = centres[source[source >= 0]]
    return steady


def merge_centres(centres: Array, size: Array, reach: float, *, mirrored: bool) -> Array:
    """Centres (c, d) moved by little, so that those within reach of each other are one.

    So are the images of one: a body of edges `size` is repeated, or mirrored in its sides.
    """
    period = 2 * size if mirrored else size
    place = centres - np.floor(centres / period) * period
    way = np.ones_like(place)
    if mirrored:
        way[place > size] = -1.0
        place = np.minimum(place, period - place)
    else:
        place[place >= period] = 0.0
    tree = KDTree(place, boxsize=None if mirrored else period)
    i, j = tree.query_pairs(reach, output_type="ndarray").T
    count = len(centres)
    groups = coo_array((np.ones(len(i), dtype=bool), (i, j)), shape=(count, count))
    number, group = connected_components(groups, directed=False)
    start = place[np.unique(group, return_index=True)[1]]
    away = place - start[group]
    if not mirrored:
        away -= period * np.rint(away / period)
    many = np.bincount(group, minlength=number)
    mean = np.column_stack([np.bincount(group, a, number) / many for a in away.T])
    if mirrored:  # next to a side, a centre and its mirror image are one
        for side in (0.0, size):
            mean = np.where(np.abs(start + mean - side) <= reach, side - start, mean)
    return np.asarray(centres + way * (mean[group] - away))


def signed_volumes(corners: Array) -> Array:
    """Signed volumes times d! of simplices (c, d+1, d).

    Written out, for elimination takes longer; flat ones by elimination, whose rounding leaves most
    of these a sign, so that they can be turned.
    """
    edges = corners[:, 1:] - corners[:, :1]
    if edges.shape[1] == 2:
        (a, b), (c, d) = edges.transpose(1, 2, 0)
        content = np.asarray(a * d - b * c)
    else:
        a, b, c = edges.transpose(1, 2, 0)
        content = np.asarray(
            a[0] * (b[1] * c[2] - b[2] * c[1])
            + a[1] * (b[2] * c[0] - b[0] * c[2])
            + a[2] * (b[0] * c[1] - b[1] * c[0])
        )
    flat = content == 0
    content[flat] = np.linalg.det(edges[flat])
    return content
