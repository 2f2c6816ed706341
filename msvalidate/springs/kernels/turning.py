"""Four vectors side by side turned into their components, and back: what springs of a list need.

A row is what memory holds of a point: in the plane its place at rest and its displacement, in space
a vector and a 0.
"""

from __future__ import annotations

from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.lanes import picked
from msvalidate.springs.kernels.values import Lane

first_halves = picked(0, 1, 4, 5)
second_halves = picked(2, 3, 6, 7)
crossed = picked(2, 3, 4, 5)
"""The second half of one value, then the first of another."""
_even = picked(0, 4, 2, 6)
_odd = picked(1, 5, 3, 7)


@compiled(inner=True)
def halves_added(a: Lane, b: Lane, c: Lane, d: Lane) -> tuple[Lane, Lane]:
    """Components x and y of the sums of the halves of four rows."""
    ab, cd = _even(a, b), _even(c, d)
    x = first_halves(ab, cd) + second_halves(ab, cd)
    ab, cd = _odd(a, b), _odd(c, d)
    return x, first_halves(ab, cd) + second_halves(ab, cd)


@compiled(inner=True)
def components(a: Lane, b: Lane, c: Lane, d: Lane) -> tuple[Lane, Lane, Lane]:
    """Components x, y and z of four rows."""
    ab, cd, odd_ab, odd_cd = _even(a, b), _even(c, d), _odd(a, b), _odd(c, d)
    return first_halves(ab, cd), first_halves(odd_ab, odd_cd), second_halves(ab, cd)


@compiled(inner=True)
def pairs(x: Lane, y: Lane) -> tuple[Lane, Lane]:
    """Pairs (x, y), two in a value: those of numbers 0 and 2, then those of 1 and 3."""
    return _even(x, y), _odd(x, y)


@compiled(inner=True)
def rows(x: Lane, y: Lane, z: Lane, w: Lane) -> tuple[Lane, Lane, Lane, Lane]:
    """Four rows (x, y, z, w)."""
    even, odd, further_even, further_odd = _even(x, y), _odd(x, y), _even(z, w), _odd(z, w)
    return (
        first_halves(even, further_even),
        first_halves(odd, further_odd),
        second_halves(even, further_even),
        second_halves(odd, further_odd),
    )
