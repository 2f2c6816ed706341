"""The surface of a dielectric body in the plane, parts of which are electrodes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import shapely
from numpy.typing import ArrayLike

from msvalidate.dielectric.charges.checks import check_plane_points, freeze
from msvalidate.dielectric.charges.electrodes import GRADINGS, Segments, strip_points
from msvalidate.problem import PLACEMENT, Array, Index, Mask, ProblemError
from msvalidate.problem.checks import (
    finite_coordinates,
    finite_number,
    format_value,
    indices,
    integers,
    length_in_metres,
    require_one_of,
    whole_number,
)
from msvalidate.problem.records import dataclass, field

BARE = -1
"""In the place of an electrode's number: none."""


@dataclass(frozen=True, eq=False)
class Faces(Segments):
    """The closed outline of a body, of straight segments. Arrays are read-only.

    Parameters
    ----------
    points
        (n, 2) in counter-clockwise order (m); segment i runs from point i to the next, the last to
        the first.
    electrode
        (n,) of each segment: 0, 1, ..., none left out, or -1 where the face is bare.

    Raises
    ------
    ProblemError
        If the outline crosses or touches itself, runs clockwise or has segments of no length, if
        there are fewer than two electrodes, or if two of them touch.
    """

    points: Array
    segments: Index = field(init=False, repr=False)
    electrode: Index

    def __post_init__(self) -> None:
        points = check_plane_points("points of faces", self.points, least=3)
        electrode = integers("electrode", self.electrode, len(points))
        _refuse_outline(points)
        _refuse_electrodes(electrode)
        first = np.arange(len(points))
        segments = np.column_stack([first, np.roll(first, -1)])
        freeze(self, points=points, segments=segments, electrode=electrode)

    @property
    def bare(self) -> Mask:
        """(m,) whether a segment is bare."""
        return np.asarray(self.electrode == BARE)


def _refuse_outline(points: Array) -> None:
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


def _refuse_electrodes(electrode: Index) -> None:
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


def faces_of(points: ArrayLike, outline: ArrayLike, electrodes: tuple[ArrayLike, ...]) -> Faces:
    """Faces of a body whose points (n, 2) in m have numbers, as those of a network have.

    Parameters
    ----------
    points
        (n, 2), those inside the body too.
    outline
        (m,) numbers of the points around it, counter-clockwise; the last is not the first again.
    electrodes
        Chains of numbers, either way round, along the outline.

    Raises
    ------
    ProblemError
        If a chain leaves the outline, or as `Faces`.
    """
    given = finite_coordinates("points", points, "n", 2)
    around = indices("outline", outline, len(given), "m>0")
    segment = {
        frozenset(pair): i
        for i, pair in enumerate(zip(around.tolist(), np.roll(around, -1).tolist(), strict=True))
    }
    electrode = np.full(len(around), BARE)
    if not isinstance(electrodes, tuple | list):
        raise ProblemError(
            f"electrodes: {format_value(electrodes)}; give a tuple of chains of numbers"
        )
    for k, chain in enumerate(electrodes):
        numbers = integers(f"electrode {k}", chain, "m")
        for pair in pairwise(numbers.tolist()):
            place = segment.get(frozenset(pair))
            if place is None:
                raise ProblemError(
                    f"electrode {k}: from point {pair[0]} to {pair[1]} it is not on the surface; "
                    "let its chain follow the outline"
                )
            if electrode[place] != BARE:
                raise ProblemError(
                    f"electrodes {electrode[place]} and {k}: both cover the surface from point "
                    f"{pair[0]} to {pair[1]}; leave a gap"
                )
            electrode[place] = k
    return Faces(given[around], electrode)


def slab_faces(
    length: float,
    height: float,
    segments: int,
    *,
    covered: float = 1.0,
    grading: str = "cosine",
) -> Faces:
    """A slab about x = 0 on y = 0: electrode 1 is its whole bottom, 0 the middle of its top.

    Parameters
    ----------
    length, height
        In m.
    segments
        Of the bottom. Other parts have as many as make segments alike where they meet.
    covered
        Part of the top's length that its electrode covers.
    grading
        Of every straight part, as for `strip_points`.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """
    require_one_of("grading", grading, GRADINGS)
    whole_number("segments", segments, 1)
    part = finite_number("covered", covered, above=0, most=1)
    half, top = 0.5 * length_in_metres("length", length), length_in_metres("height", height)
    edge = half * part
    stops = [(-half, 0.0), (half, 0.0), (half, top), (edge, top), (-edge, top), (-half, top)]
    kinds = [1, BARE, BARE, 0, BARE, BARE]
    if half - edge <= PLACEMENT * half:
        del stops[3:5], kinds[2], kinds[-2]
    points, electrode = [], []
    for kind, start, end in zip(kinds, stops, [*stops[1:], stops[0]], strict=True):
        step = np.subtract(end, start)
        reach = float(np.hypot(*step)) / length
        # The first cosine segment goes like the length over the square of the number.
        count = max(2, round(segments * (np.sqrt(reach) if grading == "cosine" else reach)))
        share = 0.5 + strip_points(1.0, 0.0, count, grading=grading)[:-1, :1]
        points.append(start + share * step)
        electrode += [kind] * count
    return Faces(np.concatenate(points), np.array(electrode))
