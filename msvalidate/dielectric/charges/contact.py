"""Where electrodes and faces may lie: none on or across another, none without size."""

from __future__ import annotations

import numpy as np
import shapely

from msvalidate.problem import PLACEMENT, Array, Index, ProblemError
from msvalidate.problem.checks import format_value

BARE = -1
"""In the place of an electrode's number: none."""


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
            "where the face is bare"
        )
    after = np.roll(electrode, -1)
    touching = np.flatnonzero((electrode != after) & (electrode != BARE) & (after != BARE))
    if len(touching):
        i = touching[0]
        raise ProblemError(
            f"electrodes {electrode[i]} and {after[i]} touch between segments {i} and "
            f"{(i + 1) % len(electrode)}; leave a bare face between them"
        )
