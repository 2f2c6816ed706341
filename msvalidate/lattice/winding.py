"""Which points of a grid a closed surface of flat triangles runs round."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, Mask

SHIFT = 1e-7 * np.array([0.7548776662466927, 0.5698402909980532])
"""Part of a cell, along x and y, by which upright lines miss the points that they stand for: no
edge of a triangle that follows the grid meets them."""
PAIRS = 500_000
"""Pairs of a triangle and a line that are looked into at once: some 100 MB."""


def is_enclosed(corners: Array, points: Index) -> Mask:
    """Mask (n,) of the points (n, 3), of whole numbers from 0, within triangles (t, 3, 3).

    On a line upwards from a point inside, the surface is left once more than it is entered. Points
    within a cell's 1e-7 of the surface may count as either.
    """
    lines, line = np.unique(points[:, :2], axis=0, return_inverse=True)
    line = line.ravel()
    height = float(max(corners[..., 2].max(), points[:, 2].max())) + 2.0
    met, z, sign = _crossings(corners, lines)
    at = met * height + z
    order = np.argsort(at, kind="stable")
    before = np.concatenate([[0.0], np.cumsum(sign[order])])
    first, last = (
        np.searchsorted(at[order], here)
        for here in (line * height + points[:, 2], (line + 1) * height)
    )
    return np.asarray(before[last] - before[first] > 0.5)


def _crossings(corners: Array, lines: Index) -> tuple[Index, Array, Array]:
    """Where triangles meet upright lines (l, 2): the line, z, and 1 where it leaves them, or -1."""
    flat = corners[..., :2] - SHIFT
    low, high = np.ceil(flat.min(axis=1)), np.floor(flat.max(axis=1))
    count = np.maximum(high - low + 1, 0).astype(np.intp)
    (some,) = np.nonzero(count.prod(axis=1))
    load = np.cumsum(count[some].prod(axis=1))
    width = int(max(lines[:, 1].max(), high[:, 1].max(initial=0))) + 2
    known = lines[:, 0] * width + lines[:, 1]
    found = []
    for group in np.split(some, np.searchsorted(load, np.arange(PAIRS, load[-1], PAIRS))):
        triangle, i, j = _lines_under(group, low[group].astype(np.intp), count[group])
        key = i * width + j
        line = np.minimum(np.searchsorted(known, key), len(known) - 1)
        wanted = known[line] == key
        place = np.stack([i, j], axis=1)[wanted]
        found.append(_meet(corners, flat, triangle[wanted], line[wanted], place))
    line, z, sign = (np.concatenate(each) for each in zip(*found, strict=True))
    return line, z, sign


def _lines_under(group: Index, low: Index, count: Index) -> tuple[Index, Index, Index]:
    """Pairs of a triangle and a line (i, j) in its box along x and y."""
    many = count.prod(axis=1)
    each = np.repeat(np.arange(len(group)), many)
    within = np.arange(len(each)) - np.repeat(np.cumsum(many) - many, many)
    i, j = np.divmod(within, count[each, 1])
    return group[each], low[each, 0] + i, low[each, 1] + j


def _meet(
    corners: Array, flat: Array, triangle: Index, line: Index, place: Index
) -> tuple[Index, Array, Array]:
    """Of pairs of a triangle and a line those that meet."""
    a, b, c = np.moveaxis(flat[triangle] - place[:, None], 1, 0)
    share = np.stack([_cross(b, c), _cross(c, a), _cross(a, b)], axis=1)
    turn = np.sign(share.sum(axis=1))
    meets = (share * turn[:, None] > 0).all(axis=1)
    share, turn = share[meets], turn[meets]
    z = (share * corners[triangle[meets], :, 2]).sum(axis=1) / share.sum(axis=1)
    return line[meets], z, turn


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
