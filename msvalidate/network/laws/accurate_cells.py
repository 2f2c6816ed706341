"""Forces of cells in twice the digits of doubles; see `accurate`."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from msvalidate.linear_algebra.double_double import (
    Ends,
    Pair,
    add,
    as_pair,
    cross_product,
    divide,
    ends_of,
    entries_at,
    multiply,
    negate,
    subtract,
    sum_pairs,
    two_sum,
)
from msvalidate.network.laws.volumes import Volumes
from msvalidate.problem import Array, Index


class Pulls(NamedTuple):
    """Forces (d, e) on points, and which: on `ends.first`, and the opposite on `ends.second`."""

    force: Pair
    ends: Ends


class Cells:
    """Cells that resist a change of volume: -κ (V/V0 - 1) ∂V/∂x pulls at their corners."""

    def __init__(self, volumes: Volumes, u: Pair | None, length: float, unit: float) -> None:
        self.volumes, self.cells = volumes, np.ascontiguousarray(volumes.cells.T)
        self.ends = ends_of(self.cells.ravel())
        x = self._local(volumes.points.T / length)
        slope = self._gradient(x)
        V0 = self._volume(x, slope)
        self.hard = divide(as_pair(volumes.stiffness * unit), V0)
        self.moved = u is not None
        self.pressure = as_pair(np.zeros(len(volumes.cells)))
        if u is not None:
            w = self._taken(u)
            self.pressure = multiply(self.hard, self._growth(x, slope, w))
            x = add(x, w)
            slope = self._gradient(x)
        self.x, self.slope = x, slope

    def pulls(self) -> Pulls:
        """Forces on points, over `stiffness` x `length` of the state."""
        return self._spread(multiply(negate(self.pressure), self.slope))

    def change(self, motion: Pair) -> Pulls:
        """Change of these forces by a small motion (d, n)."""
        w = self._taken(motion)
        pull = multiply(negate(multiply(self.hard, _over_corners(self.slope, w))), self.slope)
        if self.moved:
            pull = subtract(pull, multiply(self.pressure, self._gradient_change(w)))
        return self._spread(pull)

    def _spread(self, force: Pair) -> Pulls:
        d = force.hi.shape[0]
        return Pulls(Pair(*(x.reshape(d, -1) for x in force)), self.ends)

    def _local(self, x: Array) -> Pair:
        """Points (d, n) at corners (d, k, c), from each cell's first."""
        return two_sum(x[:, self.cells], -x[:, self.cells[:1]])

    def _taken(self, u: Pair) -> Pair:
        return subtract(
            entries_at(u, (slice(None), self.cells)), entries_at(u, (slice(None), self.cells[:1]))
        )

    def _volume(self, x: Pair, slope: Pair) -> Pair:
        """By Euler: V is homogeneous, of degree d."""
        whole = _over_corners(slope, x)
        return divide(whole, as_pair(np.full(whole.hi.shape, float(len(x.hi)))))

    def _growth(self, x: Pair, slope: Pair, w: Pair) -> Pair:
        """V(x + w) - V(x), with the digits that the two share: its terms in w, w² and w³."""
        squares = self._gradient(w)
        growth = add(_over_corners(slope, w), self._volume(w, squares))
        if self.volumes.dim == 2:
            return growth
        return add(growth, _over_corners(squares, x))

    def _gradient(self, x: Pair) -> Pair:
        """∂V/∂x (d, k, c)."""
        return self._polar(x, x)

    def _gradient_change(self, w: Pair) -> Pair:
        if self.volumes.dim == 2:
            return self._polar(w, w)  # linear in the corners
        return add(self._polar(w, self.x), self._polar(self.x, w))

    def _polar(self, x: Pair, y: Pair) -> Pair:
        """Sums of cross products that are ∂V/∂x where y is x: in the plane half a chord, turned."""
        k = len(self.cells)
        if self.volumes.dim == 2:
            after, before = np.roll(np.arange(k), -1), np.roll(np.arange(k), 1)
            chord = subtract(
                entries_at(x, (slice(None), after)), entries_at(x, (slice(None), before))
            )
            return Pair(*(np.stack([one[1], -one[0]]) / 2 for one in chord))
        triangles, part = self.volumes.surface
        corners: list[list[Pair]] = [[] for _ in range(k)]
        for p, q, r in triangles:
            for first, second, third in ((p, q, r), (q, r, p), (r, p, q)):
                a, b = entries_at(x, (slice(None), second)), entries_at(y, (slice(None), third))
                corners[first].append(cross_product(a, b))
        sums = [sum_pairs(one) for one in corners]
        gradient = Pair(
            np.stack([one.hi for one in sums], axis=1), np.stack([one.lo for one in sums], axis=1)
        )
        share = divide(as_pair(np.ones(1)), as_pair(np.array([round(1 / part)], dtype=float)))
        return multiply(gradient, share)


def _over_corners(a: Pair, b: Pair) -> Pair:
    """Scalar products (c,) of what stands at the corners of cells, (d, k, c)."""
    share = multiply(a, b)
    d, k = share.hi.shape[:2]
    return sum_pairs(
        [entries_at(share, (axis, corner)) for axis in range(d) for corner in range(k)]
    )


def exact_vectors(x: Array, springs: Index) -> Pair:
    """Vectors (d, m) between points (d, n), exactly."""
    i, j = springs.T
    return two_sum(x[:, j], -x[:, i])


def difference_of_motion(u: Pair, springs: Index) -> Pair:
    """Differences (d, m) of a motion (d, n)."""
    i, j = springs.T
    first, second = (Pair(*(x.take(end, axis=1) for x in u)) for end in (i, j))
    return subtract(second, first)
