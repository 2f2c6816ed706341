"""Numbers as sums of two doubles: some 32 digits, by operations whose errors are known.

A pair (hi, lo) of arrays stands for hi + lo, lo below half a unit in hi's last place. Sums and
products of doubles are exact as pairs ([Knuth1997]; [Dekker1971], whose splitting needs no fused
operation). Results are right to a few 1e-32 of the numbers that went in, while these are far from
the ends of the range of doubles: scale by powers of two.
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


def as_pair(hi: Array) -> Pair:
    """Doubles as pairs."""
    return Pair(hi, np.zeros_like(hi))


def entries_at(x: Pair, index: Any) -> Pair:
    """The entries at an index, as of an array."""
    return Pair(x.hi[index], x.lo[index])


def negate(x: Pair) -> Pair:
    """-x."""
    return Pair(-x.hi, -x.lo)


def scale(x: Pair, power: float) -> Pair:
    """X times a power of two, exactly."""
    return Pair(x.hi * power, x.lo * power)


def two_sum(a: Array, b: Array) -> Pair:
    """A + b, exactly (Knuth).

    Source: [Knuth1997], section 4.2.2.
    """
    s = a + b
    c = s - a
    return Pair(s, (a - (s - c)) + (b - c))


def two_product(a: Array, b: Array) -> Pair:
    """a·b, exactly (Dekker).

    Source: [Dekker1971].
    """
    p = a * b
    a1, a2 = _split(a)
    b1, b2 = _split(b)
    return Pair(p, ((a1 * b1 - p) + a1 * b2 + a2 * b1) + a2 * b2)


def add(x: Pair, y: Pair) -> Pair:
    """The sum x + y, rounded relative to the larger of the two.

    Source: [Dekker1971].
    """
    s, e = two_sum(x.hi, y.hi)
    return _renormalise(s, e + (x.lo + y.lo))


def subtract(x: Pair, y: Pair) -> Pair:
    """The difference x - y, rounded relative to the larger of the two.

    Source: [Dekker1971].
    """
    return add(x, negate(y))


def multiply(x: Pair, y: Pair) -> Pair:
    """x·y.

    Source: [Dekker1971].
    """
    p, e = two_product(x.hi, y.hi)
    return _renormalise(p, e + (x.hi * y.lo + x.lo * y.hi))


def divide(x: Pair, y: Pair) -> Pair:
    """X / y.

    Source: [Dekker1971].
    """
    q = x.hi / y.hi
    rest = subtract(x, multiply(y, as_pair(q)))
    r = rest.hi / y.hi
    rest = subtract(rest, multiply(y, as_pair(r)))
    return add(_renormalise(q, r), as_pair(rest.hi / y.hi))


def square_root(x: Pair) -> Pair:
    """√x of numbers above zero, and 0 of 0.

    Source: [Dekker1971].
    """
    s = np.sqrt(x.hi)
    divisor = np.where(s > 0, 2 * s, 1.0)
    rest = subtract(x, two_product(s, s))
    first = _renormalise(s, rest.hi / divisor)
    rest = subtract(x, multiply(first, first))
    return add(first, as_pair(rest.hi / divisor))


def sum_pairs(parts: list[Pair]) -> Pair:
    """Sum of pairs."""
    out = parts[0]
    for part in parts[1:]:
        out = add(out, part)
    return out


def scatter_sum(x: Pair, ends: Ends, count: int) -> list[Array]:
    """Sums of entries (m,) by where they belong, for `count` places: parts that add up to it.

    The leading parts are multiples of one unit and sum without rounding
    [RumpOgitaOishi2008]; what two of them leave of the largest entry is below 1e-27, and
    rounded by another 1e-16.
    """
    rest = x.hi
    largest = float(max(rest.max(initial=0.0), -rest.min(initial=0.0)))
    if not 0 < largest < np.inf:
        return [scatter_sum_doubles(rest, ends, count)]
    bits = math.ceil(math.log2(max(ends.most, 1))) + 1
    unit = 2.0 ** (math.ceil(math.log2(largest)) + bits)
    parts = []
    for _ in range(2):
        leading = (unit + rest) - unit
        rest = rest - leading
        parts.append(scatter_sum_doubles(leading, ends, count))
        unit *= 2.0 ** (bits + 1 - _DIGITS)
    return [*parts, scatter_sum_doubles(rest + x.lo, ends, count)]


def scatter_sum_doubles(values: Array, ends: Ends, count: int) -> Array:
    """Sums of entries (m,) by where they belong, for `count` places, in doubles."""
    out = np.asarray(np.bincount(ends.first, values, count), dtype=float)
    return out if ends.second is None else out - np.bincount(ends.second, values, count)


def sum_doubles(parts: list[Array]) -> Pair:
    """Sum of doubles as a pair, the largest first."""
    out = as_pair(parts[0])
    for part in parts[1:]:
        out = add(out, as_pair(part))
    return out


def _split(a: Array) -> tuple[Array, Array]:
    """Two numbers of 26 digits that add up to a."""
    c = _SPLIT * a
    high = c - (c - a)
    return high, a - high


def _renormalise(s: Array, e: Array) -> Pair:
    """S + e where e is the smaller."""
    hi = s + e
    return Pair(hi, e - (hi - s))


def dot_product(a: Pair, b: Pair) -> Pair:
    """Scalar products (m,) of vectors (d, m)."""
    product = multiply(a, b)
    return sum_pairs([entries_at(product, axis) for axis in range(product.hi.shape[0])])


def cross_product(a: Pair, b: Pair) -> Pair:
    """Cross products (3, c)."""
    rows = []
    for p, q in ((1, 2), (2, 0), (0, 1)):
        rows.append(
            subtract(
                multiply(entries_at(a, p), entries_at(b, q)),
                multiply(entries_at(a, q), entries_at(b, p)),
            )
        )
    return stack_rows(rows)


def matrix_product(a: Pair, b: Pair) -> Pair:
    """Products of matrices (d, d, n)."""
    d = a.hi.shape[0]
    rows = []
    for i in range(d):
        entries = [
            sum_pairs([multiply(entries_at(a, (i, c)), entries_at(b, (c, j))) for c in range(d)])
            for j in range(d)
        ]
        rows.append(stack_rows(entries))
    return stack_rows(rows)


def transpose(a: Pair) -> Pair:
    """Transposes of matrices (d, d, n)."""
    return Pair(a.hi.swapaxes(0, 1), a.lo.swapaxes(0, 1))


def symmetric_part(a: Pair) -> Pair:
    """Symmetric parts of matrices (d, d, n)."""
    return halve(add(a, transpose(a)))


def halve(a: Pair) -> Pair:
    """Half of it, exactly."""
    return scale(a, 0.5)


def stack_rows(rows: list[Pair]) -> Pair:
    """Rows under each other."""
    return Pair(np.stack([one.hi for one in rows]), np.stack([one.lo for one in rows]))


def invert_symmetric(
    A: dict[tuple[int, int], Pair], d: int, joined: Mask
) -> dict[tuple[int, int], Pair]:
    """Inverses of symmetric matrices, entry by entry; those of points that are not joined are 1."""
    one = {
        (a, b): Pair(np.where(joined, A[a, b].hi, float(a == b)), np.where(joined, A[a, b].lo, 0.0))
        for a in range(d)
        for b in range(d)
    }
    if d == 2:
        minor = {(0, 0): one[1, 1], (1, 1): one[0, 0], (0, 1): negate(one[0, 1])}
    else:
        minor = {}
        for a in range(3):
            for b in range(a, 3):
                (p, q), (r, s) = (
                    ((x + 1) % 3 for x in (a, a + 1)),
                    ((x + 1) % 3 for x in (b, b + 1)),
                )
                minor[a, b] = subtract(
                    multiply(one[p, r], one[q, s]), multiply(one[p, s], one[q, r])
                )
    for a, b in list(minor):
        minor[b, a] = minor[a, b]
    det = sum_pairs([multiply(one[0, b], minor[0, b]) for b in range(d)])
    return {at_: divide(entry, det) for at_, entry in minor.items()}
