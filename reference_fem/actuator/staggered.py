"""Fixed points of an expensive map, by Anderson acceleration.

Of the differences of points and of their images the combination is taken that makes the next
movement least, without damping.

Source: [Anderson1965]; [WalkerNi2011], equation 2.1.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Generic, TypeVar

import numpy as np

from msvalidate.problem import Array, SolverError
from msvalidate.problem.checks import positive_number, whole_number
from msvalidate.problem.records import dataclass

SECANTS = 8
"""Differences that are kept: as many slow motions are taken out of the map."""
MOST_TURNS = 40
PATIENCE = 8
"""Turns in which the least movement so far must have come down: past a largest voltage it stays."""
SHORTENINGS = 4
"""Maximum number of bisections of a step towards the last valid point."""
ALIKE = 1e-8
"""Relative size below which a difference counts as linearly dependent on the others."""

T = TypeVar("T")


@dataclass(frozen=True)
class StaggeredResult(Generic[T]):
    """Result of a fixed-point iteration.

    Parameters
    ----------
    found
        What came with the last image.
    count
        Images that were asked for.
    left
        Largest movement from the last point to its image (m).
    """

    found: T
    count: int
    left: float


def fixed_point(
    answer: Callable[[Array], tuple[Array, T]], start: Array, near: float, most: int = MOST_TURNS
) -> StaggeredResult[T]:
    """The point (n, d) that a map takes to itself, to a movement of `near` (m).

    Parameters
    ----------
    answer
        The map: an image (n, d) and what comes with it, of a point (n, d). It may raise a
        `SolverError` where there is no image.
    start
        Point (n, d) to start from.
    near
        Largest movement (m) that is none.
    most
        Images to ask for at most.

    Raises
    ------
    ProblemError
        If `near` or `most` is out of range.
    SolverError
        If it does not settle, or there is no image on the way.
    """
    positive_number("movement that is none", near)
    whole_number("images", most, 1)
    points: list[Array] = []
    images: list[Array] = []
    point, least, since = start, np.inf, 0
    for count in range(1, most + 1):
        point, image, found = _apply_map(answer, point, points[-1] if points else None, start.shape)
        points.append(point.ravel())
        images.append(image.ravel())
        left = float(np.abs(image - point).max())
        if not np.isfinite(left):
            raise SolverError("field and body do not settle: a movement is not a finite number")
        if left <= near:
            return StaggeredResult(found, count, left)
        least, since = (left, 0) if left < least else (least, since + 1)
        if since == PATIENCE:
            break
        point = _anderson_step(points, images).reshape(start.shape)
    raise SolverError(
        f"field and body do not settle: a movement of {left:.2g} m is left after {count} turns"
    )


def _apply_map(
    answer: Callable[[Array], tuple[Array, T]],
    point: Array,
    back: Array | None,
    shape: tuple[int, ...],
) -> tuple[Array, Array, T]:
    """A point that has an image, no further than `point` from the last one that had; the image."""
    for _ in range(SHORTENINGS):
        try:
            return point, *answer(point)
        except SolverError:
            if back is None:
                raise
            point = 0.5 * (point + back.reshape(shape))
    return point, *answer(point)


def _anderson_step(points: list[Array], images: list[Array]) -> Array:
    """The next point (n·d,): an image, less what differences of the past can make up.

    Source: [Anderson1965]; [WalkerNi2011], equation 2.1.
    """
    if len(points) == 1:
        return images[-1]
    U = np.diff(np.array(points[-SECANTS - 1 :]), axis=0).T
    G = np.diff(np.array(images[-SECANTS - 1 :]), axis=0).T
    share = np.linalg.lstsq(G - U, images[-1] - points[-1], rcond=ALIKE)[0]
    return np.asarray(images[-1] - G @ share)
