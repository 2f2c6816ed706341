"""Delaunay triangulations of points in the plane and in space, and areas of their duals.

The triangulation is the lower hull of the points lifted onto a paraboloid. Where points are so
regular that it is not unique (the corners of a square), flat simplices without a circumcentre come
up; the paraboloid is then roughened by so little that only such choices depend on it.

The facet dual to an edge is a polygon of circumcentres, its area a sum over the faces around the
edge of signed triangles, all in arrays. The sum of area times edge length depends on how simplices
meet, and not on where their centres are: ill-conditioned ones do no harm to it.

For Voronoi cells of a body a periodic cell is repeated, a box is reflected across its sides. Only
images within a margin are made; a cell is complete if the empty sphere around each of its vertices,
through its points, stays within that.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import ConvexHull, KDTree, QhullError

from msvalidate.problem import Array, Box, Index, ProblemError, SolverError

ROUGHNESS = (0.0, 1e-11, 1e-9, 1e-7)
"""Perturbations of the paraboloid, relative to its height, tried in turn.

The next one is tried if a simplex is flat.
"""
FLAT = 1e-9
"""Volume of a flat simplex in parts of its longest edges' product."""
VERTICAL = 1e-9
"""Largest slope, as a cosine, of hull facets that are walls and not simplices."""
FACES = {
    2: np.array([[1, 2], [2, 0], [0, 1]]),
    3: np.array([[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]),
}
"""Face opposite each corner of a positive simplex, with an outward normal.

The normal is to the right of an edge (2D) or by the right-hand rule (3D).
"""

FIRST_MARGIN, STEP = 2.25, 1.3
"""First margin in spacings, and the largest relative size of the next one.

Regular sets need about 2. Cells at the end of too small a margin are long and ask for more than
they need.
"""
UNEVEN, UNEVEN_MARGIN = 0.5, {2: 3.0, 3: 2.75}
"""Variance over mean of points per box that marks an uneven set.

It is 1 for uniformly random points. The margin that is tried first for such sets follows, by number
of axes: their holes are larger, and another attempt costs more.
"""
BOXES = 8
"""Points in a box, about."""
MOST_IMAGES, IMAGES_OF_FEW, IMAGES_OF_EACH = 2_000_000, 15_000, 15
"""Maximum number of points with their images: in total, and per point.

A regular set in a compact body needs a fifth of it. Many more occur for points in a few rows, whose
triangulation takes minutes.
"""


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
        part = 0.5 * (np.cross(u, v) * edge).sum(axis=1)
    key, which = np.unique(np.minimum(a, b) * len(x) + np.maximum(a, b), return_inverse=True)
    return key // len(x), key % len(x), np.asarray(np.bincount(which, part, len(key)), dtype=float)


def relative_volume(x: Array, cells: Index) -> Array:
    """Volumes (c,) of simplices times d!, relative to products of edges.

    The edges, d of them, meet at the first corner.

    It is zero for a flat simplex.
    """
    corners = x[cells]
    edges = np.linalg.norm(corners[:, 1:] - corners[:, :1], axis=2)
    return np.asarray(np.abs(signed_volumes(corners)) / edges.prod(axis=1))


def stabilise_centres(centres: Array, flat: Array, beyond: Index, least: float) -> Array:
    """Replace the centres (c, d) of flat simplices by that of a neighbour.

    `flat` (c,) are relative volumes, of which those below `least` count as flat; `beyond`
    (c, d + 1) are the neighbours, or -1. The neighbour is the one of largest relative volume;
    without a neighbour a centre stays.

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
    """Merge centres (c, d) that lie within reach of each other.

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
        content = np.asarray((edges[:, 0] * np.cross(edges[:, 1], edges[:, 2])).sum(axis=1))
    flat = content == 0
    content[flat] = np.linalg.det(edges[flat])
    return content


def triangulate_with_images(
    x: Array, edges: Array, unit: float, *, mirrored: bool
) -> tuple[Array, Index, Index, Index, Index, Array]:
    """Points with as many images as cells need, their source and image number, and simplices.

    Of these, as `_cells`, the corners, those beyond their faces and the circumcentres. What is
    measured is in parts of 1/unit (m).

    Raises `ProblemError` if too many images are needed: the body is long or flat for its points;
    `SolverError` if points lie so close that their cells can't be told apart.
    """
    n, dim = x.shape
    box = Box(tuple((edges / unit).tolist()))
    # No point of the body is further than this from all images of one point.
    furthest = (2 if mirrored else 1) * float(np.linalg.norm(edges)) * (1 + 1e-9)
    spacing = (math.prod(edges.tolist()) / n) ** (1 / dim)
    margin = _first_margin(x, edges) * spacing
    margin = min(max(margin, 0.5 * float(edges.max()) / n), furthest)
    # In a long or flat body, points are as far apart as on its axis or in its plane: what they
    # will need is refused at once.
    longest = np.sort(edges)[::-1].tolist()
    apart = max((math.prod(longest[:k]) / n) ** (1 / k) for k in range(1, dim + 1))
    _refuse_too_many_images(n, box, min(FIRST_MARGIN * apart, furthest) / unit)
    again = True
    while True:
        _refuse_too_many_images(n, box, margin / unit)
        everywhere, source, image = _images(x, edges, margin, mirrored=mirrored)
        try:
            found = _cells(everywhere, source, n, regular=mirrored)
        except SolverError:
            # Two points and their reflections are on one circle: with other images around them
            # the simplex between them may not be flat.
            if not again or margin >= furthest:
                raise
            found, again = None, False
        if found is not None:
            cells, beyond, centres, radius = found
            away = np.maximum(-centres, centres - edges).max(axis=1)
            needed = float((away + radius).max())
            if needed <= margin:
                return everywhere, source, image, cells, beyond, centres
        if margin >= furthest:
            raise SolverError(f"cells of {n} points in {box}: not told apart, some are too close")
        # Cells only shrink as images are added, and their spheres' reach with them.
        step = STEP if found is None else min(STEP, 1.05 * needed / margin)
        margin = min(step * margin, furthest)


def _first_margin(x: Array, edges: Array) -> float:
    """Margin in spacings that points (n, d) will need, by how evenly boxes are filled."""
    dim = x.shape[1]
    across = np.maximum((edges / (math.prod(edges.tolist()) * BOXES / len(x)) ** (1 / dim)), 1)
    shape = tuple(across.astype(np.intp).tolist())
    place = np.minimum((x / edges * shape).astype(np.intp), np.array(shape) - 1)
    filled = np.bincount(np.ravel_multi_index(tuple(place.T), shape), minlength=math.prod(shape))
    return UNEVEN_MARGIN[dim] if filled.var() > UNEVEN * filled.mean() else FIRST_MARGIN


def _images(
    points: Array, size: Array, margin: float, *, mirrored: bool
) -> tuple[Array, Index, Index]:
    """Points and images within a margin, the points first; of each its source and image number.

    Image k of a mirrored axis is shifted by k·size if k is even, and else reflected: at -x for
    k = -1 and 2·size - x for k = 1.
    """
    source = np.arange(len(points))
    image = np.zeros(points.shape, dtype=np.intp)
    for axis, edge in enumerate(size.tolist()):
        start = points[:, axis]
        reach = math.ceil(margin / edge) + 1
        parts = []
        for k in sorted(range(-reach, reach + 1), key=abs):
            reflected = mirrored and k % 2 == 1
            place = (k + 1) * edge - start if reflected else start + k * edge
            near = (place >= -margin) & (place <= edge + margin)
            if reflected:  # points on a side are their own image
                near &= (start != 0) & (start != edge)
            elif k == 0:
                near[:] = True
            which = np.flatnonzero(near)
            moved, number = points[which], image[which]
            moved[:, axis], number[:, axis] = place[which], k
            parts.append((moved, source[which], number))
        points, source, image = (np.concatenate(part) for part in zip(*parts, strict=True))
    return points, source, image


def _cells(
    x: Array, source: Index, count: int, *, regular: bool
) -> tuple[Index, Index, Array, Array] | None:
    """Simplices at the first `count` points, those beyond their faces, circumcentres and radii.

    None if the cell of one of these points has no end.
    """
    try:
        cells, beyond = triangulation(x, count, source, regular=regular)
    except QhullError:  # so few images that they lie in a plane
        return None
    near = (cells < count).any(axis=1)
    cells, beyond = cells[near], beyond[near]
    ending = (beyond < 0) & (cells[:, FACES[x.shape[1]]] < count).any(axis=2)
    if ending.any() or not np.bincount(cells.ravel(), minlength=count)[:count].all():
        return None
    number = np.append(np.where(near, np.cumsum(near) - 1, -1), -1)
    start = x[cells[:, 0]]
    sides = x[cells[:, 1:]] - start[:, None]
    to_centre = np.linalg.solve(sides, 0.5 * (sides**2).sum(axis=2, keepdims=True))[:, :, 0]
    radius = np.linalg.norm(to_centre, axis=1)
    return cells, number[beyond], start + to_centre, np.asarray(radius)


def _refuse_too_many_images(count: int, box: Box, margin: float) -> None:
    wanted = count * math.prod(1 + 2 * margin / edge for edge in box.size)
    most = min(MOST_IMAGES, IMAGES_OF_FEW + IMAGES_OF_EACH * count)
    if wanted > most:
        remedy = "fewer points" if most == MOST_IMAGES else "more points, or more even ones"
        raise ProblemError(
            f"cells of {count} points in the {box}, {max(box.size) / min(box.size):.3g} times as "
            f"long as thick: they need {wanted:.3g} images, and the most is {most:.3g}; take "
            f"{remedy}, or a body less long and thin"
        )
