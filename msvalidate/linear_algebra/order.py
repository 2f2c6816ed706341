"""Order of points for a sparse factor, by nested dissection, and what the factor takes.

A body is cut in two across its longest axis, these pieces in two, and so on; a cut is made of the
points that springs from one half to the other end in, and comes after both halves [George1973].
Entries of the factor then grow as n log n in the plane and n^(4/3) in space, its work as n^(3/2)
and n²; no order does better [HoffmanMartinRose1973]. Lattices and random points are cut alike, by
places and springs alone.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, Mask
from msvalidate.problem.records import dataclass

SMALL = 4
"""Points of a piece that is cut no further."""
MIDDLE = 0.2
"""Relative distance from the middle within which a piece is cut."""
WIDE = 0.5
"""Smallest gap of a cut between layers, relative to the widest gap."""
ALIKE = 1e-6
"""Relative difference of extents that is rounding."""
LEFT, RIGHT, CUT = 0, 1, 2
LEVELS = 30
"""Cuts in a path, two bits each."""


@dataclass(frozen=True, eq=False)
class Dissection:
    """An order of elimination, and what a factor in it takes.

    Parameters
    ----------
    order
        (n,) points, the first to be eliminated first; (0,) where the count was broken off.
    entries, products
        Of the triangular factor of a matrix with one number a point: its entries, and the products
        that make it. Blocks of d x d have d² and d³ times as many.
    """

    order: Index
    entries: float
    products: float


def nested_dissection(points: Array, pairs: Index, most: float = np.inf) -> Dissection:
    """Order of points (n, d) that are joined in pairs (p, 2) of their numbers.

    Source: [George1973].

    Parameters
    ----------
    points
        Places (n, d), in any unit.
    pairs
        Which are joined; a pair may occur more than once, or join a point to itself.
    most
        Products beyond which the factor is of no use: then the rest is not cut.
    """
    place = _scale_by_spacing(points, pairs)
    n = len(place)
    path, depth = np.zeros(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    inner = np.array(pairs.T, dtype=np.intp, order="C")
    outer = inner[:, :0]
    order, entries, products = np.arange(n), 0.0, 0.0
    for level in range(LEVELS):
        start = np.flatnonzero(np.diff(path[order], prepend=-1))
        size = np.diff(start, append=len(order))
        piece = np.empty(n, dtype=np.int64)
        piece[order] = np.repeat(np.arange(len(start)), size)
        final = size <= SMALL if level < LEVELS - 1 else np.ones(len(size), dtype=bool)
        order, side = _bisect(place, order, start, size)
        taken = np.zeros(n, dtype=np.int64)
        taken[order] = side
        _make_separator(taken, piece, inner, len(start))
        taken[order[np.repeat(final, size)]] = CUT  # the whole of it
        width = np.bincount(piece[order], taken[order] == CUT, len(start))
        beyond = _adjacent_separators(piece, outer, len(start))
        entries += float((width * (width + 1) / 2 + width * beyond).sum())
        products += float((width**3 / 3 + width**2 * beyond + width * beyond**2).sum())
        if products > most:
            return Dissection(order[:0], entries, products)
        path[order] = 4 * path[order] + taken[order]
        depth[order] += 1
        order = order[taken[order] != CUT]
        if not len(order):
            break
        inner, outer = _remaining_pairs(taken, inner, outer)
    path <<= 2 * (LEVELS - depth)
    return Dissection(np.argsort(path, kind="stable"), entries, products)


def pairs_in(cells: Index) -> Index:
    """Pairs (p, 2) of points in the same cell (c, k), once per cell."""
    first, second = np.triu_indices(cells.shape[1], 1)
    return np.stack([cells[:, first].ravel(), cells[:, second].ravel()], axis=1)


def free_unknowns(order: Index, fixed: Mask, *, by_component: bool = False) -> Index:
    """Positions (f,) of the free components in the order (n,) of their points.

    `fixed` (n, d) are those that are not; they are counted by point, or else by component.
    """
    counted = fixed.T if by_component else fixed
    number = (np.cumsum(~counted.ravel()) - 1).reshape(counted.shape)
    number = number.T if by_component else number
    return np.asarray(number[order][~fixed[order]])


def _scale_by_spacing(points: Array, pairs: Index) -> Array:
    """Places over the mean reach of what joins them along each axis."""
    reach = np.abs(points[pairs[:, 0]] - points[pairs[:, 1]]).mean(axis=0)
    return np.asarray((points - points.min(axis=0)) / np.where(reach > 0, reach, 1.0))


def _bisect(place: Array, order: Index, start: Index, size: Index) -> tuple[Index, Index]:
    """Points by their places along the longest axis of each piece, and the half of each."""
    low = np.minimum.reduceat(place[order], start)
    extent = np.maximum.reduceat(place[order], start) - low
    axis = (extent >= extent.max(axis=1, keepdims=True) * (1 - ALIKE)).argmax(axis=1)
    each = np.arange(len(start))
    which = np.repeat(each, size)
    scale = 0.5 / np.maximum(extent[each, axis], np.finfo(float).tiny)
    along = (place[order, axis[which]] - low[each, axis][which]) * scale[which]
    turn = np.argsort(which + along, kind="stable")
    order, along = order[turn], along[turn]
    first = _second_half_start(np.diff(along, prepend=0.0), start, size, which)
    return order, np.where(np.arange(len(order)) < first[which], LEFT, RIGHT)


def _second_half_start(gap: Array, start: Index, size: Index, which: Index) -> Index:
    """Start (p,) of the second half of each piece, at a wide central gap."""
    from_middle = np.abs(np.arange(len(gap)) - (start + size / 2)[which])
    near = from_middle <= MIDDLE * size[which]
    widest = np.maximum.reduceat(np.where(near, gap, 0.0), start)
    allowed = near & (gap >= WIDE * widest[which])
    distance = np.where(allowed, from_middle, np.inf)
    nearest = np.minimum.reduceat(distance, start)
    first = start + size  # of a single point
    (at,) = np.nonzero(distance == nearest[which])
    first[which[at[::-1]]] = at[::-1]
    return first


def _make_separator(side: Index, piece: Index, inner: Index, pieces: int) -> None:
    """Make the ends of what joins two halves a cut, on the side where they are fewer."""
    of_first, of_second = side[inner]
    on_cut = np.zeros(len(side), dtype=bool)
    on_cut[inner[:, of_first != of_second]] = True
    (at,) = np.nonzero(on_cut)
    count = np.bincount(2 * piece[at] + side[at], minlength=2 * pieces).reshape(-1, 2)
    fewer = (count[:, 1] < count[:, 0]).astype(np.int64)
    side[at[side[at] == fewer[piece[at]]]] = CUT


def _adjacent_separators(piece: Index, outer: Index, pieces: int) -> Array:
    """Points of earlier cuts (p,) that each piece is joined to."""
    n = len(piece)
    key = np.sort(piece[outer[0]] * n + outer[1])  # np.unique goes by hashes: far slower
    return np.bincount(key[np.diff(key, prepend=-1) > 0] // n, minlength=pieces).astype(float)


def _remaining_pairs(taken: Index, inner: Index, outer: Index) -> tuple[Index, Index]:
    """Pairs among the remaining points and the cuts after a new cut."""
    first, second = (taken == CUT)[inner]
    still = np.compress(taken[outer[0]] != CUT, outer, axis=1)
    ahead = np.compress(~first & second, inner, axis=1)
    behind = np.compress(first & ~second, inner, axis=1)[::-1]
    return np.compress(~(first | second), inner, axis=1), np.hstack([still, ahead, behind])
