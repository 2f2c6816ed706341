"""Irregular point sets in a periodic cell or a closed box, in 2D and 3D.

Three kinds, from the least to the most even:

- ``uniform``: every point anywhere, independent of the others.
- ``jittered``: the body is cut into as many parts of equal volume as there are points, nearly
  cubic, and each part has one point anywhere in it (stratified sampling [Cook1986]). The parts are
  layers, rows in them, and bricks in those: a grid of cubes where the number allows one, and
  otherwise layers and rows of which some hold a point more and are thicker for it.
- ``blue_noise``: no two points near each other. Of five times as many uniform points the most
  crowded is removed until the number is right (weighted sample elimination [Yuksel2015]), so any
  number can be had and no radius is asked for.

Same arguments and seed, same numbers.
"""

from __future__ import annotations

import heapq
import math
from itertools import combinations, product

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem import Array, Box, Index
from msvalidate.problem.checks import (
    length_in_metres,
    refuse_too_many,
    require_one_of,
    require_type,
    whole_number,
)

POINT_SETS = ("uniform", "jittered", "blue_noise")
LARGEST_SEED = 2**64 - 1
CANDIDATES = 5
"""Uniform points for each blue-noise point that is kept (Yuksel's number)."""
CROWDING, LIMIT, BLEND = 8, 0.65, 1.5
"""Yuksel's α, β and γ: the weight's exponent, and where nearer pairs weigh no more."""
RISE = 0.1
"""Reduction of distance for the weight of very close pairs, relative to the distance.

In [Yuksel2015] it is zero, and two points next to fixed ones may then almost coincide.
"""
UNIT = 2.0**-44
"""Quantum of the crowding weights, which makes their sums and differences exact.

It is exact for up to 512 of the largest weights. Two points that crowd only each other are then
equally crowded, without a decision by rounding.
"""


def periodic_points(kind: str, count: int, size: tuple[float, ...], seed: int) -> Array:
    """Random points (count, d) in m of a rectangular periodic cell.

    Their coordinates are 0 <= x < size.

    The kind is one of `POINT_SETS`; distances of blue noise are those to the nearest image.

    Source: jittered points [Cook1986], blue noise [Yuksel2015].

    Raises `ProblemError` if a value is out of its range or the points are too many.
    """
    require_one_of("point set", kind, POINT_SETS)
    edges = np.array(Box(size).size, dtype=float)
    n = whole_number("number of points", count, 1)
    refuse_too_many(f"{kind} point set", n * (CANDIDATES if kind == "blue_noise" else 1))
    rng = np.random.default_rng(whole_number("seed", seed, 0, LARGEST_SEED))
    if kind == "blue_noise":
        return _thin_out(rng.random((CANDIDATES * n, len(edges))) * edges, n, edges, period=edges)
    return _draw_points(kind, n, edges, rng)


def box_points(kind: str, box: Box, spacing: float, seed: int) -> Array:
    """Random points (n, d) in m of a closed box: corners, edges, sides, interior.

    `spacing` (m) is the mean distance of neighbours, the root of the volume that a point has. Each
    edge, side and the inside has a random set of its own, no nearer than half a spacing to what
    bounds it. An edge of length L has L/spacing - 1 points between its corners, and a side and the
    inside the product of that: one point per spacing^d if a point on a side counts half, on an edge
    a quarter and in a corner an eighth (in the plane, half and a quarter). Where the box is less
    than one and a half spacings thick, no points lie between those sides. Blue noise keeps its
    distance from the points on the boundary too.

    Source: jittered points [Cook1986], blue noise [Yuksel2015].

    Raises `ProblemError` if a value is out of its range or the points are too many.
    """
    require_one_of("point set", kind, POINT_SETS)
    require_type("box", box, Box)
    h = length_in_metres("point set: spacing", spacing)
    size = np.array(box.size, dtype=float)
    each = CANDIDATES if kind == "blue_noise" else 1
    refuse_too_many(f"{kind} point set", each * math.prod((size / h + 1).tolist()))
    rng = np.random.default_rng(whole_number("seed", seed, 0, LARGEST_SEED))
    points = np.array(list(product((0.0, 1.0), repeat=box.dim))) * size
    for free in range(1, box.dim + 1):
        placed = [points]
        for axes in combinations(range(box.dim), free):
            along = list(axes)
            across = [axis for axis in range(box.dim) if axis not in axes]
            count = round(math.prod(np.maximum(size[along] / h - 1, 0).tolist()))
            if not count:
                continue
            room = size[along] - h
            for ends in product((0.0, 1.0), repeat=len(across)):
                several = each * count
                new = np.empty((several, box.dim))
                new[:, across] = np.array(ends) * size[across]
                new[:, along] = h / 2 + _draw_points(kind, several, room, rng)
                placed.append(_thin_out(new, count, room, points) if each > 1 else new)
        points = np.concatenate(placed)
    return np.asarray(points)


def _draw_points(kind: str, count: int, size: Array, rng: np.random.Generator) -> Array:
    """Points (count, d) in [0, size): jittered, or uniform for both other kinds."""
    if kind != "jittered":
        return np.asarray(rng.random((count, len(size))) * size)
    low, edge = _equal_parts(count, size)
    return np.asarray(np.minimum(low + edge * rng.random(low.shape), np.nextafter(size, 0)))


def _equal_parts(count: int, size: Array) -> tuple[Array, Array]:
    """Lowest corners and edges, both (count, d), of parts of a box with equal volumes.

    The parts are nearly cubic.
    """
    dim = len(size)
    if dim == 1:
        low = np.arange(count)[:, None] / count * size
        return low, np.full((count, 1), size[0] / count)
    wanted = size[0] * (count / math.prod(size.tolist())) ** (1 / dim)
    layers = int(np.clip(np.rint(wanted), 1, count))
    starts = np.arange(layers + 1) * count // layers
    parts = [_equal_parts(int(number), size[1:]) for number in np.diff(starts)]
    low = np.repeat(starts[:-1] / count * size[0], np.diff(starts))
    edge = np.repeat(np.diff(starts) / count * size[0], np.diff(starts))
    return (
        np.column_stack([low, np.concatenate([part[0] for part in parts])]),
        np.column_stack([edge, np.concatenate([part[1] for part in parts])]),
    )


def _thin_out(
    candidates: Array,
    count: int,
    size: Array,
    fixed: Array | None = None,
    period: Array | None = None,
) -> Array:
    """Remove the most crowded candidate repeatedly until `count` remain.

    `size` are the edges of the room they fill. Points in `fixed` crowd them and are not removed.

    Source: weighted sample elimination, [Yuksel2015].
    """
    total = len(candidates)
    everywhere = candidates if fixed is None else np.concatenate([candidates, fixed])
    reach = _closest_packing(count, size)
    pairs = KDTree(everywhere, boxsize=period).query_pairs(reach, output_type="ndarray")
    pairs = pairs[pairs.min(axis=1) < total]
    apart = everywhere[pairs[:, 1]] - everywhere[pairs[:, 0]]
    if period is not None:
        apart -= period * np.rint(apart / period)
    distance = np.sqrt((apart**2).sum(axis=1)) / reach
    nearer = np.maximum(LIMIT * (1 - (count / total) ** BLEND) - distance, 0)
    crowding = np.maximum(1 - distance - (1 - RISE) * nearer, 0) ** CROWDING
    return candidates[_remaining_points(pairs, crowding, total, count)]


def _remaining_points(pairs: Index, crowding: Array, total: int, count: int) -> Index:
    """Numbers (count,) of the candidates, the first `total`, that are left."""
    crowding = np.rint(crowding / UNIT) * UNIT
    ends, others = pairs.ravel("F"), pairs[:, ::-1].ravel("F")
    order = np.argsort(ends, kind="stable")
    other, share = others[order], np.tile(crowding, 2)[order]
    most = max(total, int(ends.max(initial=-1)) + 1)
    weight: Array = np.bincount(ends, np.tile(crowding, 2), most).astype(float)
    start = np.searchsorted(ends[order], np.arange(total + 1)).tolist()
    # Weights only fall, so an entry of the heap that is out of date is too high, never too low.
    heap = [(-w, i) for i, w in enumerate(weight[:total].tolist())]
    heapq.heapify(heap)
    left = np.ones(total, dtype=bool)
    for _ in range(total - count):
        while -heap[0][0] > (now := float(weight[heap[0][1]])):
            heapq.heapreplace(heap, (-now, heap[0][1]))
        _, i = heapq.heappop(heap)
        left[i] = False
        beside = slice(start[i], start[i + 1])
        weight[other[beside]] -= share[beside]
    return np.flatnonzero(left)


def _closest_packing(count: int, size: Array) -> float:
    """Largest distance (m) that `count` points of a box can all keep, about.

    In a flat or narrow box it is that of a plane or a line of points.
    """
    densest = (1.0, math.sqrt(2 / math.sqrt(3)), 2 ** (1 / 6))
    longest = np.sort(size)[::-1]
    room = [math.prod(longest[:k].tolist()) / count for k in range(1, len(size) + 1)]
    return float(max(densest[k] * room[k] ** (1 / (k + 1)) for k in range(len(size))))
