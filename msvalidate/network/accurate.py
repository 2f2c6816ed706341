"""Forces of a network in twice the digits of doubles, from its springs' own vectors.

Points, stiffnesses, rest lengths and loads as they are given are taken as exact: what is summed
here has no rounding but that of `double_double`, some 1e-32 of the terms. An assembled tangent is
rounded by 1e-16 of its entries, which a long body, or a stiff part beside a soft one, multiplies by
1e12 and more. Refinement (`linear_algebra.refine`) needs no more than this to be right to the last
digit.

Lengths are over `length` and forces over `stiffness` x `length`, powers of two, so that no product
leaves the range of doubles. Arrays are (axes, entries).
"""

from __future__ import annotations

import math
from typing import Protocol

import numpy as np

from msvalidate.linear_algebra.double_double import (
    Pair,
    add,
    as_pair,
    divide,
    dot_product,
    ends_of,
    entries_at,
    multiply,
    scale,
    scatter_sum,
    square_root,
    subtract,
    sum_doubles,
)
from msvalidate.network import Network
from msvalidate.network.laws.accurate_cells import (
    Cells,
    Pulls,
    difference_of_motion,
    exact_vectors,
)
from msvalidate.problem import Array

AT_REST = 2.0**-50
"""Stretch up to which a rest length is the distance of a spring's points, rounded to a double: the
spring is at rest there. Taken as given, that rounding would be a prestress, which bends a slender
body more than a small load does."""
CHUNK = 4096
"""Springs whose forces are computed at once."""


class _Part(Protocol):
    """What pulls at points: springs or cells, at one displacement."""

    def pulls(self) -> Pulls:
        """Forces on points."""

    def change(self, motion: Pair) -> Pulls:
        """Change of these forces by a small motion (d, n)."""


class State:
    """A network at a displacement: its forces, and how they change, to some 30 digits.

    Parameters
    ----------
    network
        Its points, constants and rest lengths.
    displacement
        (n, d) in m, as a pair; None at the reference points.
    """

    def __init__(self, network: Network, displacement: Pair | None = None) -> None:
        self.network = network
        self.length = _next_power_of_two(float(np.abs(network.vector).max()))
        self.stiffness = _next_power_of_two(_largest_stiffness(network, self.length))
        u = None if displacement is None else self.scaled_motion(displacement)
        self.springs = _Springs(network, u, self.length, self.stiffness)
        self.parts: list[_Part] = [self.springs]
        if network.volumes is not None:
            kappa = self.length ** (network.dim - 2) / self.stiffness
            self.parts.append(Cells(network.volumes, u, self.length, kappa))

    def scaled_motion(self, motion: Pair) -> Pair:
        """A motion (n, d) in m as (d, n) over `length`."""
        return Pair(*(np.ascontiguousarray(x.T) / self.length for x in motion))

    def force(self) -> Pair:
        """Force (n, d) of all springs and cells on the points, over `stiffness` x `length`."""
        return self._summed([part.pulls() for part in self.parts], None)

    def residual(self, load: Pair, motion: Pair) -> Pair:
        """Load - K motion, (n, d) and (n, d) of one unit, K over `stiffness`."""
        w = Pair(*(np.ascontiguousarray(x.T) for x in motion))
        return self._summed([part.change(w) for part in self.parts], load)

    @property
    def unstressed(self) -> bool:
        """Whether all springs are as long as at rest; at the reference points cells always are."""
        return not self.springs.stressed

    @property
    def pulled(self) -> float:
        """Largest force that a spring as long as the longest has here, as `force`."""
        return float(np.abs(self.springs.slack.hi).max(initial=0.0))

    def _summed(self, pulls: list[Pulls], load: Pair | None) -> Pair:
        n, d = self.network.points.shape
        axes = []
        for axis in range(d):
            parts = [
                part
                for one in pulls
                for part in scatter_sum(entries_at(one.force, axis), one.ends, n)
            ]
            if load is not None:
                parts = [load.hi[:, axis], *parts, load.lo[:, axis]]
            axes.append(sum_doubles(parts))
        return Pair(
            np.stack([one.hi for one in axes], axis=1), np.stack([one.lo for one in axes], axis=1)
        )


class _Springs:
    """Central springs: k (1 - L0/L) v pulls at their ends."""

    def __init__(self, network: Network, u: Pair | None, length: float, stiffness: float) -> None:
        self.springs = network.springs
        self.ends = ends_of(*np.ascontiguousarray(network.springs.T))
        m, d = network.vector.shape
        self.v, self.along, self.slack = _empty((d, m)), _empty((d, m)), _empty((m,))
        k, rest = network.stiffness / stiffness, network.rest_length / length
        x = np.ascontiguousarray(network.points.T) / length
        for part in self.chunks:
            springs = self.springs[part]
            v = exact_vectors(x, springs)
            square = dot_product(v, v)
            L = square_root(square)
            longer = _elongations(L, rest[part])
            if u is not None:
                # L² - D² = (2 v + w)·w has the digits that L shares with the distance D
                w, D = difference_of_motion(u, springs), L
                grown = dot_product(add(scale(v, 2.0), w), w)
                v = add(v, w)
                square = dot_product(v, v)
                L = square_root(square)
                longer = add(longer, divide(grown, add(L, D)))
            own = as_pair(k[part])
            slack = divide(multiply(own, longer), L)
            # k L0/L³ is (k - slack)/L²
            along = multiply(divide(subtract(own, slack), square), v)
            for whole, piece in ((self.v, v), (self.along, along), (self.slack, slack)):
                _insert(whole, part, piece)
        self.stressed = bool(self.slack.hi.any())

    @property
    def chunks(self) -> list[slice]:
        """Springs some thousand at a time: what is made of them stays close to the processor."""
        return [slice(i, i + CHUNK) for i in range(0, len(self.springs), CHUNK)]

    def pulls(self) -> Pulls:
        pull = _empty(self.v.hi.shape)
        if not self.stressed:
            pull.hi[:], pull.lo[:] = 0.0, 0.0
            return Pulls(pull, self.ends)
        for part in self.chunks:
            here = (..., part)
            _insert(pull, part, multiply(entries_at(self.slack, here), entries_at(self.v, here)))
        return Pulls(pull, self.ends)

    def change(self, motion: Pair) -> Pulls:
        pull = _empty(self.v.hi.shape)
        for part in self.chunks:
            here = (..., part)
            w = difference_of_motion(motion, self.springs[part])
            change = multiply(
                dot_product(entries_at(self.v, here), w), entries_at(self.along, here)
            )
            if self.stressed:
                change = add(change, multiply(entries_at(self.slack, here), w))
            _insert(pull, part, change)
        return Pulls(pull, self.ends)


def _elongations(distance: Pair, rest: Array) -> Pair:
    """Distances less rest lengths (m,): 0 where one is the other's rounding."""
    apart = subtract(distance, as_pair(rest))
    strained = np.abs(apart.hi) > AT_REST * distance.hi
    return Pair(np.where(strained, apart.hi, 0.0), np.where(strained, apart.lo, 0.0))


def _empty(shape: tuple[int, ...]) -> Pair:
    return Pair(np.empty(shape), np.empty(shape))


def _insert(whole: Pair, part: slice, piece: Pair) -> None:
    """Put a piece where it belongs."""
    whole.hi[..., part], whole.lo[..., part] = piece


def _next_power_of_two(size: float) -> float:
    """The power of two next above a size; 1 for none."""
    return 2.0 ** math.frexp(size)[1] if size > 0 else 1.0


def _largest_stiffness(network: Network, length: float) -> float:
    """The largest stiffness (N/m) of springs and cells."""
    sizes = [network.stiffness.max(initial=0.0)]
    if network.volumes is not None:
        kappa = np.abs(network.volumes.stiffness).max(initial=0.0)
        sizes.append(kappa * length ** (network.dim - 2))
    return float(max(sizes))
