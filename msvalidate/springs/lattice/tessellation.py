"""Voronoi cells and Delaunay simplices of points in a periodic cell or a box.

Two points are joined by a spring where their Voronoi cells share a facet. With a the facet's area,
l the spring's length and V the volume of a cell, the pyramids that stand on its facets make up a
cell, so the sum of a·l over all springs is d times the volume of all cells (the divergence theorem
for the position from the cell's point). It holds for the springs that are kept, or the points are
refused.

Both kinds of body come down to points without end: a periodic cell is repeated, a box is reflected
across its sides, which clips cells exactly to it. The facets come from a Delaunay triangulation
(`msvalidate.springs.lattice.triangulation`), whose circumcentres are the vertices of cells.
"""

from __future__ import annotations

import math
from itertools import product

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem import Array, Box, Index, Mask, ProblemError, SolverError, format_point
from msvalidate.problem.checks import finite_coordinates, format_value, require_type
from msvalidate.problem.records import ReadOnly, dataclass
from msvalidate.springs.lattice.ties import break_ties
from msvalidate.springs.lattice.triangulation import (
    FACES,
    dual_areas,
    merge_centres,
    relative_volume,
    signed_volumes,
    stabilise_centres,
    triangulate_with_images,
    triangulation,
)

NEGLIGIBLE = 1e-14
"""Facet size, relative to spacing^(d-1), below which points are not joined.

A square grid thus has no diagonals. A point has at most a dozen such facets, less than 1e-13 of its
cell.
"""
ALIKE = (1e-11, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6)
"""Distances, in spacings, within which vertices of cells merge, tried in turn.

The first suffices above rounding and does not affect generic points. The others are for regular
points with a noise below 1e-8 spacings, for which rounding may choose wrong simplices: their
vertices are some tens of times the noise apart and merge. Facets are then perpendicular to springs
to within some tens of times the noise, and the sum of a·l is exact.
"""
LOST = 2e-13
"""Tolerance of the sum of a·l/d over facets, relative to the body.

It covers rounding and negligible facets.
"""


@dataclass(frozen=True, eq=False)
class Tessellation(ReadOnly):
    """Voronoi cells that fill a periodic cell or a box, and springs across facets.

    The cell or box has edges `size` (m).

    Points (n, d) in m are wrapped into [0, size) where periodic. Springs (m, 2) are pairs of points
    whose cells share a facet of `area` (m,), in m in the plane and m² in space, the lower index
    first. A periodic cell may join two points more than once, and a point to its own image: the
    second point is at points[j] + image·size, `image` (m, d) of whole numbers, zeros in a box.
    `volume` (n,) is the size of each point's cell, in m² or m³.
    """

    size: tuple[float, ...]
    points: Array
    springs: Index
    image: Index
    area: Array
    volume: Array

    @property
    def vectors(self) -> Array:
        """Vector (m, d) in m along each spring."""
        start, end = self.points[self.springs.T]
        return np.asarray(end - start + self.image * np.array(self.size))


@dataclass(frozen=True, eq=False)
class BoundedTessellation(Tessellation):
    """Voronoi cells clipped to a box.

    `side_area` (n, 2d) is the area of each cell on each side of the box, in the order of `SIDES`:
    low and high end of x, of y, of z.
    """

    side_area: Array

    @property
    def side_distance(self) -> Array:
        """Distance (n, 2d) in m of each point from each side, as `side_area`."""
        both = np.stack([self.points, np.array(self.size) - self.points], axis=2)
        return both.reshape(len(self.points), -1)


def periodic_tessellation(points: Array, size: tuple[float, ...]) -> Tessellation:
    """Voronoi cells and springs of a rectangular periodic cell, each spring once.

    Points (n, d) in m outside the cell, whose edges have lengths `size` (m), are wrapped into it.

    Raises `ProblemError` if the points are not as described, two are one place, or too many images
    are needed; `SolverError` if points lie so close that their cells can't be told apart.
    """
    box = Box(size)
    x = _check_points(points, box.dim)
    edges = np.array(box.size, dtype=float)
    x = x - np.floor(x / edges) * edges
    x[(x >= edges) | (x < 0)] = 0.0
    _refuse_coincident(x, box, edges)
    low, high, shift, area, length = _facets(x, edges, mirrored=False)
    volume = _pyramid_volumes(low, high, area * length, len(x)) / box.dim
    return Tessellation(box.size, x, np.column_stack([low, high]), shift, area, volume)


def bounded_tessellation(points: Array, box: Box) -> BoundedTessellation:
    """Voronoi cells clipped to a box, and the springs across their facets.

    Points (n, d) in m may lie inside or on the boundary; those within the box's tolerance of a side
    are put on it. The facet between two points on one side is halved by it, and between two on one
    edge of a box in space quartered, as their cells are.

    Raises `ProblemError` or `SolverError` as `periodic_tessellation`; `ProblemError` if a point is
    outside the box.
    """
    x, edges = _snap_to_box(points, box)
    low, high, shift, area, length = _facets(x, edges, mirrored=True)
    on_low, on_high = x == 0, x == edges
    between = high >= 0
    i, j, across = low[between], high[between], area[between]
    across *= 0.5 ** ((on_low[i] & on_low[j]) | (on_high[i] & on_high[j])).sum(axis=1)
    sides = np.zeros((len(x), 2 * box.dim))
    owner, image = low[~between], shift[~between]
    axis, way = np.abs(image).argmax(axis=1), image.sum(axis=1)
    on = on_low | on_high
    halved = 0.5 ** (on[owner].sum(axis=1) - on[owner, axis])
    np.add.at(sides, (owner, 2 * axis + (way > 0)), area[~between] * halved)
    # A point on a side has no image across it: what closes its cell is the area there.
    pull = across[:, None] * (x[j] - x[i]) / length[between, None]
    for k in range(box.dim):
        out = np.bincount(i, pull[:, k], len(x)) - np.bincount(j, pull[:, k], len(x))
        at_low, at_high = on_low[:, k], on_high[:, k]
        sides[at_low, 2 * k] = (out + sides[:, 2 * k + 1])[at_low]
        sides[at_high, 2 * k + 1] = (sides[:, 2 * k] - out)[at_high]
    volume = _pyramid_volumes(i, j, across * length[between], len(x))
    volume += (sides * np.stack([x, edges - x], axis=2).reshape(len(x), -1)).sum(axis=1)
    volume /= box.dim
    if not abs(volume.sum() - box.volume) <= 1e-9 * box.volume:
        raise SolverError(
            f"cells of {len(x)} points make up {format_value(float(volume.sum()))} of {box}: some "
            "points are too close"
        )
    sides[np.abs(sides) <= ALIKE[0] * _spacing(x, box) ** (box.dim - 1)] = 0.0
    springs, none = np.column_stack([i, j]), np.zeros_like(shift[between])
    return BoundedTessellation(box.size, x, springs, none, across, volume, sides)


def delaunay_simplices(points: Array, box: Box) -> tuple[Index, Index]:
    """Delaunay simplices (c, d+1) that fill a box, and its boundary facets (f, d).

    All corners of the box are among the points (n, d) in m. Simplices are positively oriented;
    facets run counter-clockwise seen from outside, in the plane with the box on the left.

    Source: [Delaunay1934].

    Raises `ProblemError` if a corner is missing, a point is outside the box or two are one place;
    `SolverError` if points lie so close that their simplices can't be told apart.
    """
    x, edges = _snap_to_box(points, box)
    for ends in product((0.0, 1.0), repeat=box.dim):
        corner = np.array(ends) * edges
        if not (x == corner).all(axis=1).any():
            raise ProblemError(
                f"points: none in the corner {format_point(corner)} of the {box}; add it"
            )
    x = x * _unit(x, box)
    cells, beyond = triangulation(break_ties(x), len(x), np.arange(len(x)))
    facets = cells[:, FACES[box.dim]][beyond < 0]
    on_side = (x[facets] == 0) | (x[facets] == x.max(axis=0))
    volume = signed_volumes(x[cells]).sum() / math.factorial(box.dim)
    whole_volume = math.prod(x.max(axis=0).tolist())
    used = np.unique(cells)
    if (
        abs(volume - whole_volume) > 1e-9 * whole_volume
        or len(used) < len(x)
        or not on_side.all(axis=1).any(axis=1).all()
    ):
        raise SolverError(f"simplices of {len(x)} points do not fill the {box}: some are too close")
    return cells, facets


def _facets(
    points: Array, size: Array, *, mirrored: bool
) -> tuple[Index, Index, Index, Array, Array]:
    """Whole facets of the cells: point, neighbour (-1: its own mirror image), image, area, length.

    Each facet between two points is listed once, the lower index first; lengths are of springs.
    Simplices chosen wrongly have facets of negative area. The sum of area times length does not
    depend on where the centres are, so where these are made one such facets vanish without loss.
    """
    n, dim = points.shape
    unit = _unit(points, Box(tuple(size.tolist())))
    x, edges = points * unit, size * unit
    everywhere, source, image, cells, beyond, centres = triangulate_with_images(
        x, edges, unit, mirrored=mirrored
    )
    flat, whole_volume = relative_volume(everywhere, cells), math.prod(edges.tolist())
    for reach in ALIKE:
        alike = stabilise_centres(centres, flat, beyond, reach)
        alike = merge_centres(alike, edges, reach, mirrored=mirrored)
        low, second, area = dual_areas(everywhere, cells, beyond, alike, n)
        kept = (area > NEGLIGIBLE) & _pick_one_image(low, second, source, image, mirrored=mirrored)
        low, second, area = low[kept], second[kept], area[kept]
        length = np.linalg.norm(everywhere[second] - everywhere[low], axis=1)
        content = area * length
        if mirrored:
            content *= _fraction_inside(everywhere[low], everywhere[second], edges, second < n)
        if abs(content.sum() - dim * whole_volume) <= LOST * dim * whole_volume:
            high = np.where(mirrored & (second >= n), -1, source[second])
            return low, high, image[second], area / unit ** (dim - 1), length / unit
    raise SolverError(
        f"cells of {n} points: facets make up "
        f"{format_value(float(content.sum() / dim / whole_volume))} "
        "of the body; some points are too close or too nearly even: move them apart or make them so"
    )


def _pick_one_image(
    low: Index, second: Index, source: Index, image: Index, *, mirrored: bool
) -> Mask:
    """Mask of the facets that represent all their periodic images.

    The lower end of such a facet's spring is a point of the body.
    """
    high, shift, inside = source[second], image[second], second <= source.max()
    if mirrored:
        # Across a side, a point inside is image 1 or -1; one on the opposite side is 2 or -2.
        return np.asarray(inside | ((high == low) & ((shift != 0).sum(axis=1) == 1)))
    ahead = np.take_along_axis(shift, (shift != 0).argmax(axis=1)[:, None], axis=1)[:, 0] > 0
    return np.asarray(inside | (low < high) | ((low == high) & ahead))


def _fraction_inside(start: Array, end: Array, edges: Array, inside: Mask) -> Array:
    """Fraction (f,) of facet times length inside a box.

    The springs lie inside the box or join mirror images.

    A side halves the facet between points on it, and the way of a point to its mirror image. That
    of a point on a side to an image beyond it is outside.
    """
    common = (start == end) & ((start == 0) | (start == edges))
    outwards = ((start == 0) & (end < 0)) | ((start == edges) & (end > edges))
    part = 0.5 ** (common.sum(axis=1) + ~inside)
    return np.where(outwards.any(axis=1), 0.0, part)


def _pyramid_volumes(i: Index, j: Index, content: Array, count: int) -> Array:
    """Half of each facet's area times length, summed at both of its points."""
    halves = np.bincount(i, content, count) + np.bincount(j, content, count)
    return np.asarray(0.5 * halves, dtype=float)


def _spacing(points: Array, box: Box) -> float:
    return float((box.volume / len(points)) ** (1 / box.dim))


def _unit(points: Array, box: Box) -> float:
    """A power of two, exact to multiply by, that makes the spacing about 1."""
    return float(2.0 ** -round(math.log2(_spacing(points, box))))


def _check_points(points: Array, dim: int) -> Array:
    need = f"give (n, {dim}), n at least 1"
    return np.array(finite_coordinates("points", points, "n>0", dim, need=need))


def _snap_to_box(points: Array, box: Box) -> tuple[Array, Array]:
    """The points, those near a side on it, and the box's edges."""
    require_type("box", box, Box)
    x, edges = _check_points(points, box.dim), np.array(box.size, dtype=float)
    outside = np.flatnonzero(((x < -box.tolerance) | (x > edges + box.tolerance)).any(axis=1))
    if len(outside):
        which = int(outside[0])
        raise ProblemError(f"points: {which}, at {format_point(x[which])}, is outside the {box}")
    x[np.abs(x) <= box.tolerance] = 0.0
    x = np.where(np.abs(x - edges) <= box.tolerance, edges, x)
    _refuse_coincident(x, box, None)
    return x, edges


def _refuse_coincident(points: Array, box: Box, period: Array | None) -> None:
    twins = KDTree(points, boxsize=period).query_pairs(box.tolerance)
    if twins:
        i, j = min(twins)
        raise ProblemError(
            f"points: {i} and {j} are one place, {format_point(points[i])}; leave one out"
        )
