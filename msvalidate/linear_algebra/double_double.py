"""Numbers as sums of two doubles: some 32 digits, by operations whose errors are known.

A pair (hi, lo) of arrays stands for hi + lo, lo below half a unit in hi's last place. Sums and
products of doubles are exact as pairs (Knuth 1969; Dekker 1971, doi:10.1007/BF01397083, whose
splitting needs no fused operation). Results are right to a few 1e-32 of the numbers that went in,
while these are far from the ends of the range of doubles: scale by powers of two.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from msvalidate.problem import Array, Index, Mask

ROUNDING = 2.0**-104
"""Relative rounding of one operation on pairs, from above."""
_SPLIT = 134217729.0  # 2^27 + 1
_DIGITS = 53


class Pair(NamedTuple):
    """An array as the sum of two: its nearest doubles, and what they leave.

    Parameters
    ----------
    hi, lo
        Of one shape.
    """

    hi: Array
    lo: Array


class Ends(NamedTuple):
    """Where entries belong: they count at `first` (m,), and their opposites at `second` (m,).

    `most` is how many may meet at one place.
    """

    first: Index
    second: Index | None
    most: int


def ends_of(first: Index, second: Index | None = None) -> Ends:
    """Ends with their count."""
    met = np.bincount(first, minlength=1)
    if second is not None:
        more = np.bincount(second, minlength=len(met))
        met = more + np.pad(met, (0, len(more) - len(met)))
    return Ends(first, second, int(met.max()))


def pair(hi: Array) -> Pair:
    """Doubles as pairs."""
    return Pair(hi, np.zeros_like(hi))


def at(x: Pair, index: Any) -> Pair:
    """The entries at an index, as of an array."""
    return Pair(x.hi[index], x.lo[index])


def negative(x: Pair) -> Pair:
    """-x."""
    return Pair(-x.hi, -x.lo)


def scaled(x: Pair, power: float) -> Pair:
    """X times a power of two, exactly."""
    return Pair(x.hi * power, x.lo * power)


def two_sum(a: Array, b: Array) -> Pair:
    """A + b, exactly (Knuth)."""
    s = a + b
    c = s - a
    return Pair(s, (a - (s - c)) + (b - c))


def two_product(a: Array, b: Array) -> Pair:
    """a·b, exactly (Dekker)."""
    p = a * b
    a1, a2 = _halves(a)
    b1, b2 = _halves(b)
    return Pair(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2)


def added(x: Pair, y: Pair) -> Pair:
    """X + y; rounded beside the larger of the two."""
    s, e = two_sum(x.hi, y.hi)
    return _normal(s, e + (x.lo + y.lo))


def taken(x: Pair, y: Pair) -> Pair:
    """X - y; rounded beside the larger of the two."""
    return added(x, negative(y))


def times(x: Pair, y: Pair) -> Pair:
    """x·y."""
    p, e = two_product(x.hi, y.hi)
    return _normal(p, e + (x.hi * y.lo + x.lo * y.hi))


def over(x: Pair, y: Pair) -> Pair:
    """X / y."""
    q = x.hi / y.hi
    rest = taken(x, times(y, pair(q)))
    r = rest.hi / y.hi
    rest = taken(rest, times(y, pair(r)))
    return added(_normal(q, r), pair(rest.hi / y.hi))


def root(x: Pair) -> Pair:
    """√x of numbers above zero, and 0 of 0."""
    s = np.sqrt(x.hi)
    divisor = np.where(s > 0, 2 * s, 1.0)
    rest = taken(x, two_product(s, s))
    first = _normal(s, rest.hi / divisor)
    rest = taken(x, times(first, first))
    return added(first, pair(rest.hi / divisor))


def total(parts: list[Pair]) -> Pair:
    """Sum of pairs."""
    out = parts[0]
    for part in parts[1:]:
        out = added(out, part)
    return out


def gathered(x: Pair, ends: Ends, count: int) -> list[Array]:
    """Sums of entries (m,) by where they belong, for `count` places: parts that add up to it.

    The leading parts are multiples of one unit and sum without rounding (Rump, Ogita and Oishi
    2008, doi:10.1137/050645671); what two of them leave of the largest entry is below 1e-27, and
    rounded by another 1e-16.
    """
    rest = x.hi
    largest = float(max(rest.max(initial=0.0), -rest.min(initial=0.0)))
    if not 0 < largest < np.inf:
        return [at_ends(rest, ends, count)]
    bits = math.ceil(math.log2(max(ends.most, 1))) + 1
    unit = 2.0 ** (math.ceil(math.log2(largest)) + bits)
    parts = []
    for _ in range(2):
        leading = (unit + rest) - unit
        rest = rest - leading
        parts.append(at_ends(leading, ends, count))
        unit *= 2.0 ** (bits + 1 - _DIGITS)
    return [*parts, at_ends(rest + x.lo, ends, count)]


def at_ends(values: Array, ends: Ends, count: int) -> Array:
    """Sums of entries (m,) by where they belong, for `count` places, in doubles."""
    out = np.asarray(np.bincount(ends.first, values, count), dtype=float)
    return out if ends.second is None else out - np.bincount(ends.second, values, count)


def summed(parts: list[Array]) -> Pair:
    """Sum of doubles as a pair, the largest first."""
    out = pair(parts[0])
    for part in parts[1:]:
        out = added(out, pair(part))
    return out


def _halves(a: Array) -> tuple[Array, Array]:
    """Two numbers of 26 digits that add up to a."""
    c = _SPLIT * a
    high = c - (c - a)
    return high, a - high


def _normal(s: Array, e: Array) -> Pair:
    """S + e where e is the smaller."""
    hi = s + e
    return Pair(hi, e - (hi - s))


def dot(a: Pair, b: Pair) -> Pair:
    """Scalar products (m,) of vectors (d, m)."""
    product = times(a, b)
    return total([at(product, axis) for axis in range(product.hi.shape[0])])


def cross(a: Pair, b: Pair) -> Pair:
    """Cross products (3, c)."""
    rows = []
    for p, q in ((1, 2), (2, 0), (0, 1)):
        rows.append(taken(times(at(a, p), at(b, q)), times(at(a, q), at(b, p))))
    return stacked(rows)


def product(a: Pair, b: Pair) -> Pair:
    """Products of matrices (d, d, n)."""
    d = a.hi.shape[0]
    rows = []
    for i in range(d):
        entries = [total([times(at(a, (i, c)), at(b, (c, j))) for c in range(d)]) for j in range(d)]
        rows.append(stacked(entries))
    return stacked(rows)


def transposed(a: Pair) -> Pair:
    """Transposes of matrices (d, d, n)."""
    return Pair(a.hi.swapaxes(0, 1), a.lo.swapaxes(0, 1))


def symmetric(a: Pair) -> Pair:
    """Symmetric parts of matrices (d, d, n)."""
    return half(added(a, transposed(a)))


def half(a: Pair) -> Pair:
    """Half of it, exactly."""
    return scaled(a, 0.5)


def stacked(rows: list[Pair]) -> Pair:
    """Rows under each other."""
    return Pair(np.stack([one.hi for one in rows]), np.stack([one.lo for one in rows]))


def inverse(A: dict[tuple[int, int], Pair], d: int, joined: Mask) -> dict[tuple[int, int], Pair]:
    """Inverses of symmetric matrices, entry by entry; those of points that are not joined are 1."""
    one = {
        (a, b): Pair(np.where(joined, A[a, b].hi, float(a == b)), np.where(joined, A[a, b].lo, 0.0))
        for a in range(d)
        for b in range(d)
    }
    if d == 2:
        minor = {(0, 0): one[1, 1], (1, 1): one[0, 0], (0, 1): negative(one[0, 1])}
    else:
        minor = {}
        for a in range(3):
            for b in range(a, 3):
                (p, q), (r, s) = (
                    ((x + 1) % 3 for x in (a, a + 1)),
                    ((x + 1) % 3 for x in (b, b + 1)),
                )
                minor[a, b] = taken(times(one[p, r], one[q, s]), times(one[p, s], one[q, r]))
    for a, b in list(minor):
        minor[b, a] = minor[a, b]
    det = total([times(one[0, b], minor[0, b]) for b in range(d)])
    return {at_: over(entry, det) for at_, entry in minor.items()}
