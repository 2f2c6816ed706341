"""Detection of uniform lattices, which `stencil` steps without lists of springs.

A network is one if its points fill a grid of places along the axes, each place once, in any
numbering, and all springs that lead the same way from place to neighbouring place are alike but for
factors of their row and their column, as shares of sides are. Masses, supports and loads may be
anything. In doubt it is none, and the general path serves it.
"""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from msvalidate.springs.kernels.lanes import WIDTH
from msvalidate.springs.kernels.rows import in_rows
from msvalidate.springs.network import Network

ROUNDING = 4 * float(np.finfo(float).eps)
"""Rounding of places relative to the largest coordinate.

A few roundings lie between an ideal place and its coordinates.
"""


@dataclass(frozen=True, eq=False)
class Grid:
    """A uniform lattice, ready for `stencil`. Rows are the last axis of `shape`.

    Parameters
    ----------
    shape
        Places along each axis, in the order that suits rows, not x, y, z.
    order
        (n,) point at each place, row by row; empty where the points are numbered so.
    ahead
        (g,) rows from a row to those that its springs lead to, rising from 0, its own.
    law
        (rows, 3g, 2) k in N/m and k·L0 in N of a row's springs to the rows `ahead`, three each: to
        the column before, the same, the next; 0 where there are none.
    vector
        (3g, d) those springs at rest (m).
    weight
        (3g, pitch) factor of the lower column of each spring, 0 beyond the lattice.
    special
        (pitch / `WIDTH`,) 1 for columns of which a weight is not 1, else 0.
    still
        (2d + 1, size) external force (N), mobility (1/kg, 0 where held) and mass (kg), laid out in
        `rows`.
    """

    shape: tuple[int, ...]
    order: Index
    ahead: Index
    law: Array
    vector: Array
    weight: Array
    special: Index
    still: Array

    @property
    def pitch(self) -> int:
        """Places that a row takes in memory, of which the last are padding."""
        return int(self.weight.shape[1])


@dataclass(frozen=True, eq=False)
class _Way:
    """Springs that lead the same way, a step -1, 0 or 1 along each axis, all alike."""

    step: tuple[int, ...]
    stiffness: Array  # of the lower place's row, over the rows' axes that have room for the step
    weight: Array  # of the lower column
    vector: Array
    rest_length: float


def recognised(network: Network) -> Grid | None:
    """The uniform lattice that a network is, or None. Linear in points and springs."""
    placed = None if network.volumes or network.law.straight else _placed(network)
    if placed is None:
        return None
    place, shape, order = placed
    start, end = place[network.springs.T]
    forward = end > start
    first, second = np.where(forward, start, end), np.where(forward, end, start)
    vector = np.ascontiguousarray(network.vector.T)
    vector = np.where(forward, vector, -vector)
    at = np.array(np.unravel_index(first, shape))
    step = np.array(np.unravel_index(second, shape)) - at
    if np.abs(step).max() > 1:
        return None
    lower, kind = np.minimum(at, at + step), np.ravel_multi_index(step + 1, (3,) * len(step))
    ways = []
    for which in np.flatnonzero(np.bincount(kind)):
        these = np.flatnonzero(kind == which)
        here = vector.take(these, axis=1), step[:, these[0]], lower.take(these, axis=1)
        way = _alike(network, these, *here, shape)
        if way is None:
            return None
        ways.append(way)
    return _grid(network, shape, order, ways)


def _placed(network: Network) -> tuple[Index, tuple[int, ...], Index] | None:
    """Place of each point, row by row; the shape; the point at each place, if not the same.

    Only counts are looked at: whether points are where they should be, springs will show.
    """
    n = len(network.points)
    number, count = [], []
    for x, along in zip(network.points.T, np.abs(network.vector).T, strict=True):
        low, length = x.min(), np.ptp(x)
        steps = along[along > 1e-9 * length]  # what is less is rounding, or no grid
        spacing = steps.min(initial=length) or 1.0
        count.append(round(length / spacing) + 1)
        number.append(np.rint((x - low) / spacing).astype(np.intp))
    if np.prod(count, dtype=float) != n:
        return None
    for axes in permutations(range(len(count))):
        place, shape = _ravelled(number, count, axes)
        if shape[-1] >= WIDTH and np.array_equal(place, np.arange(n)):
            return place, shape, np.empty(0, dtype=np.intp)
    *short, long = np.argsort(count, kind="stable")
    place, shape = _ravelled(number, count, (*reversed(short), long))
    if np.bincount(place, minlength=n).max() > 1:
        return None
    order = np.empty(n, dtype=np.intp)
    order[place] = np.arange(n)
    return place, shape, order


def _ravelled(
    number: list[Index], count: list[int], axes: tuple[int, ...]
) -> tuple[Index, tuple[int, ...]]:
    shape = tuple(count[axis] for axis in axes)
    return np.ravel_multi_index(tuple(number[axis] for axis in axes), shape), shape


def _alike(
    network: Network, these: Index, vector: Array, step: Index, lower: Index, shape: tuple[int, ...]
) -> _Way | None:
    """The springs `these` as one, if they are alike but for factors of rows and columns."""
    room = tuple(np.array(shape) - np.abs(step))
    at = np.ravel_multi_index(tuple(lower), room)
    if np.bincount(at).max() > 1:
        return None
    rounding = ROUNDING * float(np.abs(network.points).max())
    rest_length = network.rest_length[these]
    if max(np.ptp(vector, axis=1).max(), np.ptp(rest_length)) > rounding:
        return None
    k = np.zeros(room)
    k.flat[at] = network.stiffness[these]
    k = k.reshape(-1, room[-1])
    r, c = k.shape[0] // 2, k.shape[1] // 2  # there, so that inner columns have a weight of 1
    if not k[r, c]:
        r, c = divmod(int(k.argmax()), k.shape[1])
    row, weight = k[:, c], k[r] / (k[r, c] or 1.0)
    if (np.abs(k - row[:, None] * weight) > ROUNDING * k).any():
        return None
    mean, rest = vector.mean(axis=1), float(rest_length.mean())
    length = float(np.linalg.norm(mean))
    unstressed = abs(rest - length) <= rounding
    row = row.reshape(room[:-1])
    return _Way(tuple(step.tolist()), row, weight, mean, length if unstressed else rest)


def _grid(network: Network, shape: tuple[int, ...], order: Index, ways: list[_Way]) -> Grid:
    """Springs by the row that they lead to, rising."""
    *across, columns = shape
    strides = [math.prod(across[axis + 1 :]) for axis in range(len(across))]
    nearest = (0,) * (len(across) - 1) + (1,)  # so that there is a row ahead
    groups = sorted({(0,) * len(across), nearest} | {way.step[:-1] for way in ways})
    groups.sort(key=lambda step: int(np.dot(step, strides)))
    pitch = -(-columns // WIDTH) * WIDTH
    stiffness = np.zeros((*across, 3 * len(groups)))
    rest_length, weight = np.zeros(3 * len(groups)), np.zeros((3 * len(groups), pitch))
    vector = np.zeros((3 * len(groups), len(shape)))
    for way in ways:
        kind = 3 * groups.index(way.step[:-1]) + 1 + way.step[-1]
        start: list[slice | int] = [
            slice(max(0, -step), count - max(0, step))
            for step, count in zip(way.step[:-1], across, strict=True)
        ]
        stiffness[(*start, kind)] = way.stiffness
        rest_length[kind], vector[kind] = way.rest_length, way.vector
        weight[kind, : len(way.weight)] = way.weight
    stiffness = stiffness.reshape(-1, 3 * len(groups))
    with np.errstate(over="ignore", divide="ignore"):  # the motion that it gives is refused
        mobility = np.where(network.fixed, 0.0, 1 / network.mass[:, None])
    special = (weight[stiffness.any(axis=0)] != 1).reshape(-1, pitch // WIDTH, WIDTH)
    return Grid(
        shape=shape,
        order=order,
        ahead=np.array([np.dot(step, strides) for step in groups], dtype=np.intp),
        law=np.stack([stiffness, stiffness * rest_length], axis=-1),
        vector=vector,
        weight=weight,
        special=special.any(axis=(0, 2)).astype(np.int64),
        still=in_rows((network.force, mobility, network.mass), order, columns, pitch),
    )
