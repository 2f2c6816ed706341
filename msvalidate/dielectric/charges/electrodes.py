"""Electrodes in the plane: chains of straight segments, each a line charge out of the plane."""

from __future__ import annotations

from itertools import pairwise
from typing import TypeVar

import numpy as np
import shapely
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import check_plane_points, freeze
from msvalidate.problem import PLACEMENT, Array, Index, ProblemError
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    format_value,
    indices,
    integers,
    length_in_metres,
    refuse_too_many,
    require_one_of,
    whole_number,
)
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.kernels.values import Complex

GRADINGS = ("uniform", "cosine")
Moved = TypeVar("Moved", bound="Segments")


class Segments:
    """Straight segments (m, 2), pairs of points (n, 2) in m, of electrodes or of a body's faces."""

    points: Array
    segments: Index
    electrode: Index

    @property
    def count(self) -> int:
        """Number of electrodes."""
        return int(self.electrode.max()) + 1

    @property
    def start(self) -> Array:
        """(m, 2) first ends (m)."""
        return self.points[self.segments[:, 0]]

    @property
    def along(self) -> Array:
        """(m, 2) from first to second end (m)."""
        return self.points[self.segments[:, 1]] - self.start

    @property
    def length(self) -> Array:
        """(m,) in m."""
        return np.asarray(np.hypot(*self.along.T))

    @property
    def extent(self) -> float:
        """The larger side (m) of the box around all points that segments join."""
        return float(np.ptp(self.points[self.segments.ravel()], axis=0).max())

    @property
    def middle(self) -> Array:
        """(m, 2) middles (m)."""
        return self.start + 0.5 * self.along

    @property
    def lines(self) -> tuple[Complex, Complex]:
        """Starts and vectors (m,), complex, as `kernels.charges` takes them."""
        return to_complex(self.start), to_complex(self.along)

    def moved(self: Moved, points: ArrayLike) -> Moved:
        """The same segments with their points (n, 2) elsewhere (m)."""
        name, shape = type(self).__name__.lower(), self.points.shape
        need = f"give {shape}, as there were"
        later = finite_coordinates(f"points of {name}", points, *shape, need=need)
        return replace(self, points=later)  # type: ignore[type-var]


def to_complex(points: Array) -> Complex:
    """Points or vectors (n, 2) as complex numbers (n,)."""
    return np.ascontiguousarray(points).view(np.complex128)[..., 0]


@dataclass(frozen=True, eq=False)
class Electrodes(Segments):
    """Conductors without thickness, each of segments at one potential. Arrays are read-only.

    Parameters
    ----------
    points
        (n, 2) ends of segments (m); neighbours share theirs.
    segments
        (m, 2) pairs of points.
    electrode
        (m,) which electrode each segment belongs to: 0, 1, ..., none left out.

    Raises
    ------
    ProblemError
        If a segment has no length, or if segments meet elsewhere than at a shared point of one
        electrode: electrodes that cross or touch are short-circuited.
    """

    points: Array
    segments: Index
    electrode: Index

    def __post_init__(self) -> None:
        points = check_plane_points("points of electrodes", self.points)
        segments = indices("segments", self.segments, len(points), "m>0", 2)
        electrode = integers("electrode", self.electrode, len(segments))
        known = np.unique(electrode)
        if not np.array_equal(known, np.arange(len(known))):
            raise ProblemError(
                f"electrode: {format_value(known)}; numbers are left out, count electrodes 0, 1, 2 "
                "and so on"
            )
        _refuse_contact(points, segments, electrode)
        freeze(self, points=points, segments=segments, electrode=electrode)


def _refuse_contact(points: Array, segments: Index, electrode: Index) -> None:
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
    """Return True if two segments with a common point overlap."""
    u, v = (points[pair[:, 1]] - points[pair[:, 0]] for pair in (one, other))
    swap = (one[:, 0] == other[:, 0]) | (one[:, 1] == other[:, 1])
    v = np.where(swap[:, None], v, -v)
    cross, dot = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0], (u * v).sum(axis=1)
    return np.asarray((dot > 0) & (np.abs(cross) <= PLACEMENT * dot))


def electrodes_of_chains(*lines: ArrayLike) -> Electrodes:
    """Electrodes, one from each chain of points (n, 2) in m."""
    given = [check_plane_points("points of electrodes", line, least=2) for line in lines]
    if not given:
        raise ProblemError("points of electrodes: none; give a chain of points for each electrode")
    firsts = np.cumsum([0, *map(len, given)])
    pairs = [np.arange(i, j - 1) for i, j in pairwise(firsts)]
    start = np.concatenate(pairs)
    return Electrodes(
        np.concatenate(given),
        np.column_stack([start, start + 1]),
        np.repeat(np.arange(len(pairs)), [len(pair) for pair in pairs]),
    )


def strip_points(
    width: float, height: float, segments: int, *, grading: str = "cosine", centre: float = 0.0
) -> Array:
    """Points (segments + 1, 2) in m of a flat electrode, from left to right.

    `cosine` puts them where equal angles of a half circle project: charge that grows like the
    inverse root of the distance from an edge is then spread evenly over the segments.
    """
    half, level = 0.5 * length_in_metres("width", width), finite_number("height", height)
    middle = finite_number("centre", centre)
    refuse_too_many("segments", whole_number("segments", segments, 1), what="segments")
    part = np.linspace(-1.0, 1.0, segments + 1)
    require_one_of("grading", grading, GRADINGS)
    if grading == "cosine":
        part = np.sin(0.5 * np.pi * part)
    return np.column_stack([middle + half * part, np.full(len(part), level)])


def facing_strips(
    width: float, gap: float, segments: int, *, grading: str = "cosine"
) -> Electrodes:
    """Two strips of one width (m), one above the other: electrode 0 at height gap (m), 1 at 0."""
    length_in_metres("gap", gap)
    return electrodes_of_chains(
        strip_points(width, gap, segments, grading=grading),
        strip_points(width, 0.0, segments, grading=grading),
    )
