"""Forces of cells and shear springs in twice the digits of doubles; see `accurate`."""

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
    dot_product,
    ends_of,
    entries_at,
    halve,
    invert_symmetric,
    matrix_product,
    multiply,
    negate,
    scatter_sum,
    stack_rows,
    subtract,
    sum_doubles,
    sum_pairs,
    symmetric_part,
    transpose,
    two_sum,
)
from msvalidate.network.laws.local_shear import LocalShear
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


class ShearSprings:
    """Springs that resist shear, by the deformation gradients at their ends: see `local_shear`."""

    def __init__(self, shear: LocalShear, u: Pair | None, length: float, stiffness: float) -> None:
        self.springs, self.count = shear.springs, len(shear.points)
        self.ends = np.ascontiguousarray(shear.springs.T)
        self.opposite = ends_of(*self.ends)
        self.both = ends_of(self.ends.ravel())
        self.D = exact_vectors(shear.points.T / length, self.springs)
        self.square = dot_product(self.D, self.D)
        self.k = as_pair(shear.stiffness / stiffness)
        self.reach = self._reach(as_pair(shear.weights))
        d = shear.dim
        one = as_pair(np.repeat(np.eye(d)[:, :, None], self.count, axis=2))
        if u is None:
            self.F, self.M = one, as_pair(np.zeros(one.hi.shape))
            return
        H = self._gradient(u)
        self.F = add(one, H)
        # E without the digits that FᵀF shares with 1
        E = symmetric_part(add(H, halve(matrix_product(transpose(H), H))))
        self.M = self._moments(self._shift(E))

    def pulls(self) -> Pulls:
        """Forces on points, over `stiffness` x `length` of the state."""
        return self._pulled(matrix_product(self.F, self.M))

    def change(self, motion: Pair) -> Pulls:
        """Change of these forces by a small motion (d, n)."""
        H = self._gradient(motion)
        moments = self._moments(self._shift(symmetric_part(matrix_product(transpose(self.F), H))))
        change = matrix_product(self.F, moments)
        if self.M.hi.any():
            change = add(change, matrix_product(H, self.M))
        return self._pulled(change)

    def _reach(self, weight: Pair) -> list[Pair]:
        """Vectors (d, m) in the least squares of both ends: w A⁻¹D."""
        d = self.D.hi.shape[0]
        outer = {}
        for a in range(d):
            for b in range(a, d):
                product = multiply(weight, multiply(entries_at(self.D, a), entries_at(self.D, b)))
                both = Pair(*(np.concatenate([x, x]) for x in product))
                outer[a, b] = outer[b, a] = sum_doubles(scatter_sum(both, self.both, self.count))
        weights = invert_symmetric(outer, d, np.bincount(self.both.first, minlength=self.count) > 0)
        out = []
        for end in self.ends:
            rows = [
                sum_pairs(
                    [
                        multiply(entries_at(weights[b, c], end), entries_at(self.D, c))
                        for c in range(d)
                    ]
                )
                for b in range(d)
            ]
            out.append(multiply(weight, stack_rows(rows)))
        return out

    def _gradient(self, u: Pair) -> Pair:
        """∂u_a/∂X_b (d, d, n)."""
        w = difference_of_motion(u, self.springs)
        d = w.hi.shape[0]
        rows = []
        for a in range(d):
            row = []
            for b in range(d):
                ends = [multiply(entries_at(one, b), entries_at(w, a)) for one in self.reach]
                both = Pair(*(np.concatenate(x) for x in zip(*ends, strict=True)))
                row.append(sum_doubles(scatter_sum(both, self.both, self.count)))
            rows.append(stack_rows(row))
        return stack_rows(rows)

    def _shift(self, E: Pair) -> Pair:
        """Shear s (d, m) of the springs: what the mean strain does across them."""
        i, j = self.ends
        mean = halve(add(entries_at(E, (..., i)), entries_at(E, (..., j))))
        d = self.D.hi.shape[0]
        turned = stack_rows([dot_product(entries_at(mean, a), self.D) for a in range(d)])
        along = divide(dot_product(turned, self.D), self.square)
        return subtract(turned, multiply(along, self.D))

    def _moments(self, shift: Pair) -> Pair:
        """∂U/∂E (d, d, n): a quarter of k_t (s⊗D + D⊗s) of every spring at each of its ends."""
        pull = multiply(self.k, shift)
        d = pull.hi.shape[0]
        rows = []
        for a in range(d):
            row = []
            for b in range(d):
                one = add(
                    multiply(entries_at(pull, a), entries_at(self.D, b)),
                    multiply(entries_at(pull, b), entries_at(self.D, a)),
                )
                both = Pair(*(np.concatenate([x, x]) / 4 for x in one))
                row.append(sum_doubles(scatter_sum(both, self.both, self.count)))
            rows.append(stack_rows(row))
        return stack_rows(rows)

    def _pulled(self, stress: Pair) -> Pulls:
        """Forces of moments F M (d, d, n) through the gradients that they work on."""
        d = stress.hi.shape[0]
        sums = []
        for a in range(d):
            shares = [
                multiply(entries_at(stress, (a, b, end)), entries_at(reach, b))
                for end, reach in zip(self.ends, self.reach, strict=True)
                for b in range(d)
            ]
            sums.append(sum_pairs(shares))
        return Pulls(stack_rows(sums), self.opposite)


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
