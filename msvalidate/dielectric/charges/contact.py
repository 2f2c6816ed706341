"""Where electrodes, faces and patches may lie: none on or across another, none without size."""

from __future__ import annotations

import numpy as np
import shapely

from msvalidate.problem import PLACEMENT, Array, Index, ProblemError
from msvalidate.problem.checks import format_value

BARE = -1
"""In the place of an electrode's number: none."""
OVERLAP = 1e-6
"""Part of a patch that another may seem to cover: rounding of thin ones takes some 1e-10."""


def refuse_contact(points: Array, segments: Index, electrode: Index) -> None:
    """Raise `ProblemError` where segments meet but at shared points of one electrode."""
    ends = points[segments]
    length = np.hypot(*(ends[:, 1] - ends[:, 0]).T)
    near = PLACEMENT * float(np.ptp(points[segments.ravel()], axis=0).max())
    short = np.flatnonzero(length <= near)
    if len(short):
        i = short[0]
        raise ProblemError(
            f"segment {i}: length {length[i]:g} m; leave it out, or move its points apart"
        )
    lines = shapely.linestrings(ends)
    first, second = shapely.STRtree(lines).query(lines, predicate="dwithin", distance=near)
    first, second = first[first < second], second[first < second]
    other = electrode[first] != electrode[second]
    if other.any():
        i, j = first[other][0], second[other][0]
        x, y = points[segments[i]].mean(axis=0)
        raise ProblemError(
            f"electrodes {electrode[i]} and {electrode[j]} cross or touch at segments {i} and {j} "
            f"near ({x:g}, {y:g}) m; leave a gap"
        )
    shared = (segments[first][:, :, None] == segments[second][:, None, :]).any(axis=(1, 2))
    crossed = ~shared | _lie_on_each_other(points, segments[first], segments[second])
    if crossed.any():
        i, j = first[crossed][0], second[crossed][0]
        x, y = points[segments[i]].mean(axis=0)
        raise ProblemError(
            f"electrode {electrode[i]} crosses or touches itself at segments {i} and {j} near "
            f"({x:g}, {y:g}) m; let neighbours share a point, and others keep apart"
        )


def _lie_on_each_other(points: Array, one: Index, other: Index) -> Array:
    """Whether two segments with a shared point lie on each other."""
    u, v = (points[pair[:, 1]] - points[pair[:, 0]] for pair in (one, other))
    swap = (one[:, 0] == other[:, 0]) | (one[:, 1] == other[:, 1])
    v = np.where(swap[:, None], v, -v)
    cross, dot = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1)
    return np.asarray((dot > 0) & (np.abs(cross) <= PLACEMENT * dot))


def refuse_outline(points: Array) -> None:
    """Raise `ProblemError` unless points (n, 2) run round a body once, counter-clockwise."""
    near = PLACEMENT * float(np.ptp(points, axis=0).max())
    length = np.hypot(*(np.roll(points, -1, axis=0) - points).T)
    if (length <= near).any():
        i = int(np.argmin(length))
        raise ProblemError(
            f"segment {i} of the faces: length {length[i]:g} m; leave its point out, the last is "
            "not the first again"
        )
    ring = shapely.LinearRing(points)
    if not ring.is_simple:
        why = shapely.is_valid_reason(shapely.Polygon(points))
        raise ProblemError(f"faces: the outline crosses or touches itself ({why}); part its sides")
    if not ring.is_ccw:
        raise ProblemError("faces: the outline runs clockwise; give its points the other way round")


def refuse_electrodes(electrode: Index) -> None:
    """Raise `ProblemError` unless there are two electrodes or more (n,), none beside another."""
    known = np.unique(electrode)
    if not np.array_equal(known[known != BARE], np.arange(max(2, known[-1] + 1))):
        raise ProblemError(
            f"electrode: {format_value(known)}; give at least 0 and 1, and leave out none; -1 "
            f"where the "
            "face is bare"
        )
    after = np.roll(electrode, -1)
    touching = np.flatnonzero((electrode != after) & (electrode != BARE) & (after != BARE))
    if len(touching):
        i = touching[0]
        raise ProblemError(
            f"electrodes {electrode[i]} and {after[i]} touch between segments {i} and "
            f"{(i + 1) % len(electrode)}; leave a bare face between them"
        )


def areas(corners: Array) -> Array:
    """(n,) in m², positive where corners are in counter-clockwise order."""
    first = corners[..., :2] - corners[:, :1, :2]
    second = np.roll(first, -1, axis=1)
    cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return np.asarray(0.5 * cross.sum(axis=1))


def refuse_tilted(corners: Array, middle: Array, near: float) -> None:
    """Raise `ProblemError` unless patches are level but for a length (m)."""
    z = np.column_stack([corners[..., 2], middle[:, 2]])
    tilt = np.ptp(z, axis=1)
    if (tilt > near).any():
        i = int(np.argmax(tilt))
        raise ProblemError(
            f"patch {i}: its corners and middle differ by {tilt[i]:g} m in z; give a polygon "
            "parallel to z = 0"
        )


def refuse_overlap(corners: Array, conductor: Index, middle: Array, near: float) -> None:
    """Raise `ProblemError` where patches of one plane share more than edges of one conductor."""
    flat = shapely.polygons(corners[..., :2])
    bad = np.flatnonzero((areas(corners) <= near**2) | ~shapely.is_valid(flat))
    if len(bad):
        raise ProblemError(
            f"patch {bad[0]}: it has no area or crosses itself; give its corners in order"
        )
    outside = np.flatnonzero(~shapely.intersects_xy(flat, middle[:, 0], middle[:, 1]))
    if len(outside):
        raise ProblemError(f"patch {outside[0]}: its middle is beside it; give a point inside")
    first, second = shapely.STRtree(flat).query(flat, predicate="dwithin", distance=near)
    level = np.abs(corners[first, 0, 2] - corners[second, 0, 2]) <= near
    first, second = first[(first < second) & level], second[(first < second) & level]
    other = conductor[first] != conductor[second]
    if other.any():
        i, j = first[other][0], second[other][0]
        raise ProblemError(
            f"conductors {conductor[i]} and {conductor[j]} overlap or touch at patches {i} and "
            f"{j}; leave a gap"
        )
    shared = shapely.area(shapely.intersection(flat[first], flat[second]))
    smaller = np.minimum(shapely.area(flat[first]), shapely.area(flat[second]))
    over = np.flatnonzero(shared > OVERLAP * smaller)
    if len(over):
        i, j = first[over[0]], second[over[0]]
        raise ProblemError(f"patches {i} and {j}: they overlap; let them share edges only")
