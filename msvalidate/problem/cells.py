"""Validity of mesh cells, and the facets on the surface of a mesh."""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem.arrays import Array, Index, Mask
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.motions import format_point
from msvalidate.problem.shapes import Shape, incident_pairs

FLAT = 1e-12
"""Smallest Jacobian of a valid cell, relative to the product of its sides."""
AT_ONCE = 2_000
"""Cells looked into at once: 216 places in each, of 27 nodes, take 40 MB."""
HALVINGS = 4
"""Number of bisections of a cell along each axis before it counts as folded."""


def refuse_unused_points(points: Array, cells: Index, tolerance: float) -> None:
    """Raise `ProblemError` for points of no cell, and points within `tolerance` (m) of another."""
    used = np.zeros(len(points), dtype=bool)
    used[cells] = True
    if not used.all():
        stray = int(np.flatnonzero(~used)[0])
        raise ProblemError(
            f"mesh points: {(~used).sum()} belong to no cell, the first is point {stray} at "
            f"{format_point(points[stray])}; remove them"
        )
    distance, nearest = KDTree(points).query(points, k=2)
    twins = np.flatnonzero(distance[:, 1] <= tolerance)
    if len(twins):
        a, (b, c) = int(twins[0]), nearest[twins[0]]
        raise ProblemError(
            f"mesh points: point {a} at {format_point(points[a])} coincides with point "
            f"{c if b == a else b}; merge them"
        )


def refuse_folded(points: Array, cells: Index, kind: Shape) -> None:
    """Raise `ProblemError` unless the Jacobian of each cell is positive everywhere.

    Its Jacobian is a polynomial, which lies above its least Bernstein coefficient. Where that is
    below zero, each half of the cell is looked into, and so on [JohnenRemacleGeuzaine2013].
    """
    whole = np.vstack([np.zeros(kind.dim), np.eye(kind.dim)])
    for start in range(0, len(cells), AT_ONCE):
        places = points[cells[start : start + AT_ONCE]]
        bad = np.flatnonzero(_find_folded(kind, places, whole, HALVINGS * kind.dim))
        if len(bad):
            order = "counter-clockwise" if kind.dim == 2 else "in VTK order"
            middle = format_point(places[bad[0]].mean(axis=0))
            raise ProblemError(
                f"mesh cells: cell {start + bad[0]} at {middle} is inverted, flat or folded; list "
                f"its corners {order}, and bend its sides less"
            )


def _find_folded(kind: Shape, places: Array, frame: Array, halvings: int) -> Mask:
    """Mask (c,) of cells that fold or cannot be shown not to.

    A cell of nodes (c, k, d) in m counts if its Jacobian within a part of the unit cell is no more
    than `FLAT` of the product of its sides, or if Bernstein coefficients leave that open after
    `halvings` halvings of the part. The part has its origin and the ends of its axes in the rows of
    the frame (d + 1, d).
    """
    at, to_coefficients = kind.bernstein
    slopes = kind.slopes(frame[0] + at @ (frame[1:] - frame[0]))
    columns = np.einsum("qke,ckd->cqde", slopes, places)
    size = np.linalg.norm(columns, axis=2).max(axis=1).prod(axis=1)
    jacobian = np.linalg.det(columns)
    bad = np.asarray((jacobian @ to_coefficients.T).min(axis=1) <= FLAT * size)
    doubtful = np.flatnonzero(bad & (jacobian.min(axis=1) > FLAT * size))
    if halvings and len(doubtful):
        halves = [
            _find_folded(kind, places[doubtful], half, halvings - 1)
            for half in _split_part(kind, frame)
        ]
        bad[doubtful] = halves[0] | halves[1]
    return bad


def _split_part(kind: Shape, frame: Array) -> tuple[Array, Array]:
    """Bisect a part of the unit cell along its first axis.

    Frames have shape (d + 1, d), as in `_find_folded`. The axis that was cut becomes the last one
    of both halves.
    """
    middle = frame[:2].mean(axis=0)
    if kind.simplex:
        first, second = (np.vstack([frame[i], frame[2:], middle]) for i in (0, 1))
        return first, second
    step = middle - frame[0]
    low = np.vstack([frame[0], frame[2:], middle])
    return low, low + step


def surface_facets(cells: Index, kind: Shape) -> Index:
    """Facets (f, k) that are no neighbour's; neighbours run round their common one oppositely.

    Raises `ProblemError` if cells overlap on a facet, or share its corners but not its mid-sides.
    """
    local = kind.facets
    nodes = cells[:, local].reshape(-1, local.shape[1])
    which, ahead = _canonical_rings(nodes[:, : len(kind.rings[0])])
    count = np.bincount(which)
    cell = np.arange(len(nodes)) // len(local)
    wrong = np.flatnonzero((np.bincount(which, ahead) > 1) | (np.bincount(which, ~ahead) > 1))
    if len(wrong):
        a, b = cell[which == wrong[0]][:2]
        raise ProblemError(f"mesh cells: cells {a} and {b} overlap; list each cell once")
    order = np.argsort(which, kind="stable")
    second = np.cumsum(count)[count == 2] - 1
    a, b = order[second - 1], order[second]
    torn = np.flatnonzero((np.sort(nodes[a]) != np.sort(nodes[b])).any(axis=1))
    if len(torn):
        one, other = cell[a[torn[0]]], cell[b[torn[0]]]
        raise ProblemError(
            f"mesh cells: cells {one} and {other} share corners but not the mid-sides between "
            "them; give both the same"
        )
    return np.asarray(nodes[count[which] == 1])


def refuse_hanging(
    points: Array, cells: Index, kind: Shape, surface: Index, tolerance: float
) -> None:
    """Raise `ProblemError` for a surface point that lies in a cell without being its node.

    Neighbours that do not share a whole side would part there, and cells that overlap would be two
    bodies in one place. Bodies that cross without a point of one in the other go unnoticed.
    """
    ends = np.unique(surface)
    for shape, number in _straight_and_bent(points, cells, kind, tolerance):
        nodes = cells[number][:, : len(shape.nodes)]
        cell, point = incident_pairs(shape, points[nodes], points[ends], tolerance)
        strange = np.flatnonzero((cells[number[cell]] != ends[point][:, None]).all(axis=1))
        if len(strange):
            at = int(ends[point[strange[0]]])
            raise ProblemError(
                f"mesh points: point {at} at {format_point(points[at])} lies in cell "
                f"{number[cell[strange[0]]]} or on a side of it, and is none of its points; cells "
                "must meet in whole sides, and not overlap"
            )


def _straight_and_bent(
    points: Array, cells: Index, kind: Shape, tolerance: float
) -> list[tuple[Shape, Index]]:
    """Numbers of the cells whose corners alone tell where they are, and of the others.

    Straight cells reach no further than their corners: far fewer points are near them.
    """
    straight = kind.straight
    amid = straight.values(kind.nodes) @ points[cells[:, : kind.corners]]
    bent = np.abs(points[cells] - amid).max(axis=(1, 2)) > tolerance
    each = ((straight, np.flatnonzero(~bent)), (kind, np.flatnonzero(bent)))
    return [(shape, number) for shape, number in each if len(number)]


def plane_sections(places: Array, axis: int, at: float) -> tuple[Array, Array]:
    """Compute the extent of the sections of straight cells with a plane.

    The cells have nodes (c, k, d); the low and high ends of the sections are (c, d), in m.

    The plane lies at a coordinate (m) along an axis, and each cell on both sides of it. A section
    is spanned by where the lines between corners meet the plane.
    """
    i, j = np.triu_indices(places.shape[1], 1)
    start, end = places[:, i], places[:, j]
    before, after = start[..., axis] - at, end[..., axis] - at
    meets = (before * after <= 0) & (before != after)
    share = before / np.where(meets, before - after, 1.0)
    met = start + share[..., None] * (end - start)
    low, high = (np.where(meets[..., None], met, far) for far in (np.inf, -np.inf))
    return low.min(axis=1), high.max(axis=1)


def _canonical_rings(corners: Index) -> tuple[Index, Mask]:
    """For rings of corners (r, c) the number of each ring, however listed, and its direction.

    A ring is turned so that its lowest corner is first, and then goes on to the lower neighbour.
    """
    start, n = corners.argmin(axis=1)[:, None], corners.shape[1]
    turned = np.take_along_axis(corners, (start + np.arange(n)) % n, axis=1)
    ahead = turned[:, 1] < turned[:, -1]
    if n == 2:
        ahead = start[:, 0] == 0
    back = ~ahead
    turned[back, 1:] = turned[back, :0:-1]
    _, which = np.unique(turned, axis=0, return_inverse=True)
    return np.asarray(which).ravel(), np.asarray(ahead)
