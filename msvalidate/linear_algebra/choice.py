"""A factor or multigrid: by what a factor takes, which is counted before it is made.

A factor is certain, and cheap while it stays sparse: in the plane, of slender and of small bodies.
In space its entries grow as n^(4/3) and its work as n²; conjugate gradients with multigrid take
work in proportion to n.
"""

from __future__ import annotations

from typing import NamedTuple

from msvalidate.linear_algebra.order import Dissection, nested_dissection
from msvalidate.problem import Array, Index

MOST_PRODUCTS = 2e3
"""Products of a factor for each entry of the matrix that take as long as multigrid with its looks
for stability and its corrections: on plates and cubes it is 1e3 to 2e3. Plates of square-8 springs
have so many from 225,000 points on, cubes of cubic-18 from 2,000, of hexahedra from 3,500. Where
both take as long, a factor is the more certain."""
MOST_ENTRIES = 6e7
"""Entries of one triangle up to which a factor is chosen: both take 1.5 GB, and as much again while
their pivots are looked at. A plate of 300,000 points has so many."""
MOST_IN_NEED = 2e8
"""Entries up to which a factor is made where multigrid fails: 5 GB."""
WORTH_CHOLMOD = 20_000
"""Unknowns from which on CHOLMOD is taken where it is there and the matrix known to be positive.
Below, either factor takes a second at most, and answers are the same bits with it and without."""
BYTES = 24
"""Of an entry in one triangle and its like in the other."""


class Choice(NamedTuple):
    """The way that was taken, "direct" or "multigrid", and the reason in words."""

    name: str
    reason: str


ASKED = "asked for"
SMALL = "a factor of so small, plane or slender a body is cheap"
LARGE = "a large body, whose factor fills up"


def choose(
    points: Array, pairs: Index, block: int, entries: float, wide: float = 1.0
) -> tuple[Choice, Dissection]:
    """What takes less time for a matrix of blocks, and what a factor takes, as far as counted.

    Parameters
    ----------
    points, pairs
        As of `nested_dissection`.
    block
        Unknowns of a point.
    entries
        Numbers that the matrix has.
    wide
        Unknown points in a cut, for each of these points.
    """
    found = nested_dissection(points, pairs, MOST_PRODUCTS * entries / (block * wide) ** 3)
    if len(found.order) and (block * wide) ** 2 * found.entries <= MOST_ENTRIES:
        return Choice("direct", SMALL), found
    return Choice("multigrid", LARGE), found
