"""Which points that were given are which of the set's: by number, or by place."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from msvalidate_check.case_set import ElasticCase
from msvalidate_check.errors import CheckError

Array = np.ndarray
LARGEST, LEAST = 1e100, 1e-100
"""Sizes of numbers between which their squares are numbers too."""
SAME = 1e-6
"""Of the largest displacement, by which those of one place may differ."""
PLACED = 1e-5
"""Of the body's size: how near a place is to the node that it is, for places of five digits."""
UNITS = {"mm": 1e3, "cm": 1e2, "in": 1 / 0.0254, "um": 1e6, "km": 1e-3}
"""Units that places may be in, and how many of them a metre has."""
ALIKE = 0.1
"""Part by which the size of the places and the body's may differ."""
MOST_OUTSIDE = 0.1
"""Part of the places that may lie off the body: those of another body are refused."""
ROOMS = 4.0
"""Side of a cell of the grid by which points are matched, in rooms: a point's room is in few."""
FARTHEST, MIX = 2.0**62, np.uint64(0x9E3779B97F4A7C15)
"""Cells are numbered up to it; an odd number that mixes their numbers."""
FEWEST = 3
"""Named points that have to be among those given, or all that there are."""


def matched(
    case: ElasticCase, points: ArrayLike | None, move: Array
) -> tuple[Array, tuple[str, ...]]:
    """Number (n,) of the named point that each point is, -1 for none; sentences."""
    if points is None:
        if len(move) not in (len(case.points), len(case.named)):
            raise CheckError(
                f"displacement: {len(move)} points; {case} on {case.mesh} has {len(case.points)} "
                f"nodes, of which the set knows the first {len(case.named)}: give one or the other"
            )
        return _numbered(case, np.arange(len(move))), ()
    try:
        given = np.asarray(points)
    except ValueError as error:
        raise CheckError("points: rows of several lengths; give nodes, or places (n, d)") from error
    if np.ma.is_masked(points):
        raise CheckError("points: masked entries; leave these points out")
    if given.ndim == 1:
        if not np.issubdtype(given.dtype, np.integer):
            raise CheckError(
                "points: (n,) numbers that are not whole; give nodes, or places (n, d)"
            )
        _refuse_other_count(given, move)
        if len(given) and not 0 <= given.min() <= given.max() < len(case.points):
            raise CheckError(
                f"points: nodes {given.min()} to {given.max()}; {case} on {case.mesh} has 0 to "
                f"{len(case.points) - 1}"
            )
        number = _numbered(case, given)
        return number, _notes(case, number)
    places = vectors("points", given, case.points.shape[1])
    _refuse_other_count(places, move)
    number = _placed(case, places, move)
    return number, _notes(case, number)


def _numbered(case: ElasticCase, given: Array) -> Array:
    """The named point of each node; of several that are the same the first counts."""
    number = np.where(given < len(case.named), given, -1)
    _, first = np.unique(number, return_index=True)
    once = np.full(len(number), -1)
    once[first] = number[first]
    if (once >= 0).sum() < min(FEWEST, len(case.named)):
        raise CheckError(
            f"points: {(once >= 0).sum()} of the {len(case.named)} nodes that the set knows, the "
            "first of the mesh; give more"
        )
    return once


def _placed(case: ElasticCase, places: Array, move: Array) -> Array:
    """The named point at each place; of several places at a point the nearest counts."""
    named = case.points[case.named]
    size = float(np.ptp(named, axis=0).max())
    room = PLACED * size
    place, point = pairs_within(places, named, room)
    number = np.full(len(places), -1)
    nearest = nearest_of_pairs(places, named, place, point)
    at = np.flatnonzero(nearest >= 0)
    number[nearest[at]] = at
    again = np.abs(move[place] - move[nearest[point]]).max(axis=1, initial=0.0)
    apart = np.flatnonzero(again > SAME * float(np.abs(move).max()))
    if len(apart):
        first = point[apart[0]]
        where = ", ".join(f"{x:.4g}" for x in named[first])
        raise CheckError(
            f"points: ({where}) m stands {int((point == first).sum())} times, with displacements "
            f"that differ by {float(again[point == first].max()):.3g} m; give one"
        )
    outside = ((places < named.min(axis=0) - room) | (places > named.max(axis=0) + room)).any(
        axis=1
    )
    found = int((number >= 0).sum())
    if found < min(FEWEST, len(named)) or outside.mean() > MOST_OUTSIDE:
        raise CheckError(_nowhere(case, places, found))
    return number


def pairs_within(places: Array, points: Array, room: float) -> tuple[Array, Array]:
    """All pairs (k,), (k,) of a place (n, d) and a point (m, d) within `room` along each axis.

    By cells of a grid, so that it takes time by the pairs and not by n m. Ordered by the point,
    then by the place.
    """
    side = ROOMS * room
    keys = _cell_keys(places / side)
    order = np.argsort(keys, kind="stable")
    keys = keys[order]
    d = points.shape[1]
    corners = np.array(list(np.ndindex(*(2,) * d))) * 2 - 1
    around = np.stack([_cell_keys((points + room * corner) / side) for corner in corners], axis=1)
    around.sort(axis=1)
    fresh = np.ones(around.shape, dtype=bool)  # most points lie within one cell and its room
    fresh[:, 1:] = around[:, 1:] != around[:, :-1]
    point, _ = np.nonzero(fresh)
    first = np.searchsorted(keys, around[fresh], "left")
    count = np.searchsorted(keys, around[fresh], "right") - first
    point = np.repeat(point, count)
    start = np.repeat(first - np.concatenate([[0], np.cumsum(count)[:-1]]), count)
    place = order[start + np.arange(len(point))]
    near = (np.abs(places[place] - points[point]) <= room).all(axis=1)
    place, point = place[near], point[near]
    sorted_ = np.lexsort((place, point))
    return place[sorted_], point[sorted_]


def _cell_keys(scaled: Array) -> Array:
    """A number (n,) of the cell of side 1 of each place; seldom the same for two cells."""
    with np.errstate(over="ignore", invalid="ignore"):
        cells = np.floor(np.clip(scaled, -FARTHEST, FARTHEST)).astype(np.int64).view(np.uint64)
        keys = np.zeros(len(cells), dtype=np.uint64)
        for column in cells.T:
            keys = (keys ^ column) * MIX
            keys ^= keys >> np.uint64(29)
    return keys


def nearest_of_pairs(places: Array, points: Array, place: Array, point: Array) -> Array:
    """The nearest place (m,) of each point among pairs, the first of those alike; -1 for none."""
    away = np.abs(places[place] - points[point]).max(axis=1, initial=0.0)
    order = np.lexsort((place, away, point))
    own, first = np.unique(point[order], return_index=True)
    nearest = np.full(len(points), -1)
    nearest[own] = place[order][first]
    return nearest


def _notes(case: ElasticCase, number: Array) -> tuple[str, ...]:
    missing = len(case.named) - int((number >= 0).sum())
    if not missing:
        return ()
    return (f"{missing} of {len(case.named)} points that the set knows are not among those given",)


def _nowhere(case: ElasticCase, places: Array, found: int) -> str:
    """What to say where places are not the case's: another unit, other axes, another case."""
    low, high = case.points.min(axis=0), case.points.max(axis=0)
    spans = [
        " x ".join(f"{a:.4g} to {b:.4g}" for a, b in zip(*ends, strict=True))
        for ends in ((places.min(axis=0), places.max(axis=0)), (low, high))
    ]
    given, own = np.sort(np.ptp(places, axis=0)), np.sort(high - low)
    hint = "give places of this body at rest, or another case"
    for unit, many in UNITS.items():
        if (np.abs(given / (many * own) - 1) < ALIKE).all():
            hint = f"are they in {unit}? give m"
            break
    else:
        if (np.abs(given / own - 1) < ALIKE).all():
            shifted = np.abs(places.min(axis=0) - low).max() > ALIKE * own.max()
            turned = (np.abs(np.ptp(places, axis=0) / (high - low) - 1) >= ALIKE).any()
            if turned:
                hint = "are the axes in another order?"
            elif shifted:
                hint = "is the origin another one?"
    return (
        f"points: {found} of {len(case.named)} that the set knows are among the {len(places)} "
        f"given, which span {spans[0]} m; {case.name} spans {spans[1]} m: {hint}"
    )


def vectors(name: str, given: ArrayLike, d: int) -> Array:
    """An array (n, d) of finite numbers; a third component of 0 is left out in the plane."""
    if np.ma.is_masked(given):
        raise CheckError(f"{name}: masked entries; leave these points out, or fill them")
    try:
        plain = np.asarray(given)
        array = plain.astype(float) if plain.dtype.kind not in "bc" else None
    except (TypeError, ValueError, OverflowError) as error:
        raise CheckError(f"{name}: not numbers; give an array (n, {d})") from error
    if array is None:
        kind = "complex numbers" if plain.dtype.kind == "c" else "true and false"
        raise CheckError(f"{name}: {kind}; give real numbers")
    if array.ndim == 2 and array.shape[1] == 3 and d == 2 and not array[:, 2].any():
        array = array[:, :2]
    if array.ndim != 2 or array.shape[1] != d or not len(array):
        raise CheckError(f"{name}: shape {array.shape}; give an array (n, {d})")
    refuse_extreme(name, array)
    return array


def refuse_extreme(name: str, array: Array) -> None:
    """Refuse numbers that are not finite, or whose squares are not numbers."""
    size = float(np.abs(array).max(initial=0.0))
    if 0 < size < LEAST:
        raise CheckError(f"{name}: {size:g} at most; give numbers above {LEAST:g}, or 0 alone")
    bad = np.argwhere(~(np.abs(array) < LARGEST))
    if len(bad):
        row, column = (int(i) for i in bad[0])
        raise CheckError(
            f"{name}: {array[row, column]} along {'xyz'[column]} at point {row}, {len(bad)} in all;"
            f" give finite numbers below {LARGEST:g}"
        )


def _refuse_other_count(points: Array, move: Array) -> None:
    if len(points) != len(move):
        raise CheckError(
            f"displacement: {len(move)} of them for {len(points)} points; give one a point"
        )


def positive(name: str, value: float) -> float:
    """A number from 0; raise `CheckError` if it is none."""
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise CheckError(f"{name}: {value!r}; give a number") from error
    if not (math.isfinite(number) and number >= 0):
        raise CheckError(f"{name}: {number:g}; give a number from 0")
    return number
