"""Floor 1: forces of a network in twice the digits of doubles, from its springs' own vectors.

Points, stiffnesses, rest lengths and loads as they are given are taken as exact: what is summed
here has no rounding but that of `double_double`, some 1e-32 of the terms. An assembled tangent is
rounded by 1e-16 of its entries, which a long body, or a stiff part beside a soft one, multiplies by
1e12 and more. Refinement (`msvalidate.refine`) needs no more than this to be right to the last
digit.

Lengths are over `length` and forces over `stiffness` x `length`, powers of two, so that no product
leaves the range of doubles. Arrays are (axes, entries).
"""

from __future__ import annotations

import math
from typing import NamedTuple, Protocol

import numpy as np

from msvalidate.double_double import (
    Ends,
    Pair,
    added,
    at,
    cross,
    dot,
    ends_of,
    gathered,
    half,
    inverse,
    negative,
    over,
    pair,
    product,
    root,
    stacked,
    summed,
    symmetric,
    taken,
    times,
    total,
    transposed,
    two_sum,
)
from msvalidate.local_shear import LocalShear
from msvalidate.network import Network
from msvalidate.problem import Array, Index
from msvalidate.volumes import Volumes

AT_REST = 2.0**-50
"""Stretch up to which a rest length is the distance of a spring's points, rounded to a double: the
spring is at rest there. Taken as given, that rounding would be a prestress, which bends a slender
body more than a small load does."""
CHUNK = 4096
"""Springs whose forces are computed at once."""


class Pulls(NamedTuple):
    """Forces (d, e) on points, and which: on `ends.first`, and the opposite on `ends.second`."""

    force: Pair
    ends: Ends


class _Part(Protocol):
    """What pulls at points: springs, cells, or shear springs, at one displacement."""

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
        self.length = _power(float(np.abs(network.vector).max()))
        self.stiffness = _power(_stiffest(network, self.length))
        u = None if displacement is None else self.scaled_motion(displacement)
        self.springs = _Springs(network, u, self.length, self.stiffness)
        self.parts: list[_Part] = [self.springs]
        if network.volumes is not None:
            kappa = self.length ** (network.dim - 2) / self.stiffness
            self.parts.append(_Cells(network.volumes, u, self.length, kappa))
        if network.shear is not None:
            self.parts.append(_Shear(network.shear, u, self.length, self.stiffness))

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

    def _summed(self, pulls: list[Pulls], load: Pair | None) -> Pair:
        n, d = self.network.points.shape
        axes = []
        for axis in range(d):
            parts = [part for one in pulls for part in gathered(at(one.force, axis), one.ends, n)]
            if load is not None:
                parts = [load.hi[:, axis], *parts, load.lo[:, axis]]
            axes.append(summed(parts))
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
            v = _between(x, springs)
            L0 = _at_rest(root(dot(v, v)), rest[part])
            if u is not None:
                v = added(v, _apart(u, springs))
            square = dot(v, v)
            L, own = root(square), pair(k[part])
            slack = over(times(own, taken(L, L0)), L)
            # k L0/L³ is (k - slack)/L²
            along = times(over(taken(own, slack), square), v)
            for whole, piece in ((self.v, v), (self.along, along), (self.slack, slack)):
                _set(whole, part, piece)
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
            _set(pull, part, times(at(self.slack, here), at(self.v, here)))
        return Pulls(pull, self.ends)

    def change(self, motion: Pair) -> Pulls:
        pull = _empty(self.v.hi.shape)
        for part in self.chunks:
            here = (..., part)
            w = _apart(motion, self.springs[part])
            change = times(dot(at(self.v, here), w), at(self.along, here))
            if self.stressed:
                change = added(change, times(at(self.slack, here), w))
            _set(pull, part, change)
        return Pulls(pull, self.ends)


def _at_rest(distance: Pair, rest: Array) -> Pair:
    """Rest lengths (m,): the distance itself where they are its rounding, else as given."""
    same = np.abs(taken(distance, pair(rest)).hi) <= AT_REST * distance.hi
    return Pair(np.where(same, distance.hi, rest), np.where(same, distance.lo, 0.0))


class _Cells:
    """Cells that resist a change of volume: -κ (V/V0 - 1) ∂V/∂x pulls at their corners."""

    def __init__(self, volumes: Volumes, u: Pair | None, length: float, unit: float) -> None:
        self.volumes, self.cells = volumes, np.ascontiguousarray(volumes.cells.T)
        self.ends = ends_of(self.cells.ravel())
        x = self._local(volumes.points.T / length)
        V0 = self._volume(x)
        self.moved = u is not None
        if u is not None:
            x = added(x, self._taken(u))
        kappa = pair(volumes.stiffness * unit)
        self.x, self.slope = x, self._gradient(x)
        self.hard = over(kappa, V0)
        zero = pair(np.zeros(len(volumes.cells)))
        self.pressure = times(self.hard, taken(self._volume(x), V0)) if self.moved else zero

    def pulls(self) -> Pulls:
        return self._spread(times(negative(self.pressure), self.slope))

    def change(self, motion: Pair) -> Pulls:
        w = self._taken(motion)
        share = times(self.slope, w)
        d, k = share.hi.shape[:2]
        growth = total([at(share, (a, c)) for a in range(d) for c in range(k)])
        pull = times(negative(times(self.hard, growth)), self.slope)
        if self.moved:
            pull = taken(pull, times(self.pressure, self._gradient_change(w)))
        return self._spread(pull)

    def _spread(self, force: Pair) -> Pulls:
        d = force.hi.shape[0]
        return Pulls(Pair(*(x.reshape(d, -1) for x in force)), self.ends)

    def _local(self, x: Array) -> Pair:
        """Points (d, n) at corners (d, k, c), from each cell's first."""
        return two_sum(x[:, self.cells], -x[:, self.cells[:1]])

    def _taken(self, u: Pair) -> Pair:
        return taken(at(u, (slice(None), self.cells)), at(u, (slice(None), self.cells[:1])))

    def _volume(self, x: Pair) -> Pair:
        """By Euler: V is homogeneous, of degree d."""
        share = times(x, self._gradient(x))
        d, k = share.hi.shape[:2]
        whole = total([at(share, (a, c)) for a in range(d) for c in range(k)])
        return over(whole, pair(np.full(whole.hi.shape, float(d))))

    def _gradient(self, x: Pair) -> Pair:
        """∂V/∂x (d, k, c)."""
        return self._polar(x, x)

    def _gradient_change(self, w: Pair) -> Pair:
        if self.volumes.dim == 2:
            return self._polar(w, w)  # linear in the corners
        return added(self._polar(w, self.x), self._polar(self.x, w))

    def _polar(self, x: Pair, y: Pair) -> Pair:
        """Sums of cross products that are ∂V/∂x where y is x: in the plane half a chord, turned."""
        k = len(self.cells)
        if self.volumes.dim == 2:
            after, before = np.roll(np.arange(k), -1), np.roll(np.arange(k), 1)
            chord = taken(at(x, (slice(None), after)), at(x, (slice(None), before)))
            return Pair(*(np.stack([one[1], -one[0]]) / 2 for one in chord))
        triangles, part = self.volumes.surface
        corners: list[list[Pair]] = [[] for _ in range(k)]
        for p, q, r in triangles:
            for first, second, third in ((p, q, r), (q, r, p), (r, p, q)):
                a, b = at(x, (slice(None), second)), at(y, (slice(None), third))
                corners[first].append(cross(a, b))
        sums = [total(one) for one in corners]
        gradient = Pair(
            np.stack([one.hi for one in sums], axis=1), np.stack([one.lo for one in sums], axis=1)
        )
        share = over(pair(np.ones(1)), pair(np.array([round(1 / part)], dtype=float)))
        return times(gradient, share)


class _Shear:
    """Springs that resist shear, by the deformation gradients at their ends: see `local_shear`."""

    def __init__(self, shear: LocalShear, u: Pair | None, length: float, stiffness: float) -> None:
        self.springs, self.count = shear.springs, len(shear.points)
        self.ends = np.ascontiguousarray(shear.springs.T)
        self.opposite = ends_of(*self.ends)
        self.both = ends_of(self.ends.ravel())
        self.D = _between(shear.points.T / length, self.springs)
        self.square = dot(self.D, self.D)
        self.k = pair(shear.stiffness / stiffness)
        self.reach = self._reach(pair(shear.weights))
        d = shear.dim
        one = pair(np.repeat(np.eye(d)[:, :, None], self.count, axis=2))
        if u is None:
            self.F, self.M = one, pair(np.zeros(one.hi.shape))
            return
        H = self._gradient(u)
        self.F = added(one, H)
        # E without the digits that FᵀF shares with 1
        E = symmetric(added(H, half(product(transposed(H), H))))
        self.M = self._moments(self._shift(E))

    def pulls(self) -> Pulls:
        return self._pulled(product(self.F, self.M))

    def change(self, motion: Pair) -> Pulls:
        H = self._gradient(motion)
        moments = self._moments(self._shift(symmetric(product(transposed(self.F), H))))
        change = product(self.F, moments)
        if self.M.hi.any():
            change = added(change, product(H, self.M))
        return self._pulled(change)

    def _reach(self, weight: Pair) -> list[Pair]:
        """Vectors (d, m) in the least squares of both ends: w A⁻¹D."""
        d = self.D.hi.shape[0]
        outer = {}
        for a in range(d):
            for b in range(a, d):
                product = times(weight, times(at(self.D, a), at(self.D, b)))
                both = Pair(*(np.concatenate([x, x]) for x in product))
                outer[a, b] = outer[b, a] = summed(gathered(both, self.both, self.count))
        weights = inverse(outer, d, np.bincount(self.both.first, minlength=self.count) > 0)
        out = []
        for end in self.ends:
            rows = [
                total([times(at(weights[b, c], end), at(self.D, c)) for c in range(d)])
                for b in range(d)
            ]
            out.append(times(weight, stacked(rows)))
        return out

    def _gradient(self, u: Pair) -> Pair:
        """∂u_a/∂X_b (d, d, n)."""
        w = _apart(u, self.springs)
        d = w.hi.shape[0]
        rows = []
        for a in range(d):
            row = []
            for b in range(d):
                ends = [times(at(one, b), at(w, a)) for one in self.reach]
                both = Pair(*(np.concatenate(x) for x in zip(*ends, strict=True)))
                row.append(summed(gathered(both, self.both, self.count)))
            rows.append(stacked(row))
        return stacked(rows)

    def _shift(self, E: Pair) -> Pair:
        """Shear s (d, m) of the springs: what the mean strain does across them."""
        i, j = self.ends
        mean = half(added(at(E, (..., i)), at(E, (..., j))))
        d = self.D.hi.shape[0]
        turned = stacked([dot(at(mean, a), self.D) for a in range(d)])
        along = over(dot(turned, self.D), self.square)
        return taken(turned, times(along, self.D))

    def _moments(self, shift: Pair) -> Pair:
        """∂U/∂E (d, d, n): a quarter of k_t (s⊗D + D⊗s) of every spring at each of its ends."""
        pull = times(self.k, shift)
        d = pull.hi.shape[0]
        rows = []
        for a in range(d):
            row = []
            for b in range(d):
                one = added(times(at(pull, a), at(self.D, b)), times(at(pull, b), at(self.D, a)))
                both = Pair(*(np.concatenate([x, x]) / 4 for x in one))
                row.append(summed(gathered(both, self.both, self.count)))
            rows.append(stacked(row))
        return stacked(rows)

    def _pulled(self, stress: Pair) -> Pulls:
        """Forces of moments F M (d, d, n) through the gradients that they work on."""
        d = stress.hi.shape[0]
        sums = []
        for a in range(d):
            shares = [
                times(at(stress, (a, b, end)), at(reach, b))
                for end, reach in zip(self.ends, self.reach, strict=True)
                for b in range(d)
            ]
            sums.append(total(shares))
        return Pulls(stacked(sums), self.opposite)


def _empty(shape: tuple[int, ...]) -> Pair:
    return Pair(np.empty(shape), np.empty(shape))


def _set(whole: Pair, part: slice, piece: Pair) -> None:
    """Put a piece where it belongs."""
    whole.hi[..., part], whole.lo[..., part] = piece


def _between(x: Array, springs: Index) -> Pair:
    """Vectors (d, m) between points (d, n), exactly."""
    i, j = springs.T
    return two_sum(x[:, j], -x[:, i])


def _apart(u: Pair, springs: Index) -> Pair:
    """Differences (d, m) of a motion (d, n)."""
    i, j = springs.T
    first, second = (Pair(*(x.take(end, axis=1) for x in u)) for end in (i, j))
    return taken(second, first)


def _power(size: float) -> float:
    """The power of two next above a size; 1 for none."""
    return 2.0 ** math.frexp(size)[1] if size > 0 else 1.0


def _stiffest(network: Network, length: float) -> float:
    """The largest stiffness (N/m) of springs, cells and shear springs."""
    sizes = [network.stiffness.max(initial=0.0)]
    if network.volumes is not None:
        kappa = np.abs(network.volumes.stiffness).max(initial=0.0)
        sizes.append(kappa * length ** (network.dim - 2))
    if network.shear is not None:
        sizes.append(np.abs(network.shear.stiffness).max(initial=0.0))
    return float(max(sizes))
