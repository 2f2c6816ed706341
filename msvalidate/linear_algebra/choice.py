"""Choice of a factor or multigrid, from the size of the factor.

A factor is certain, and cheap while it stays sparse: in the plane, of slender and of small bodies.
In space its entries grow as n^(4/3) and its work as n²; conjugate gradients with multigrid take
work in proportion to n.
"""

from __future__ import annotations

from typing import NamedTuple

from msvalidate.linear_algebra.order import Dissection, nested_dissection
from msvalidate.problem import Array, Index

MOST_PRODUCTS = 2e3
"""Products of a factor per matrix entry that take as long as multigrid.

Multigrid includes the checks of stability and the corrections: on plates and cubes it is 1e3 to
2e3. Plates of square lattices reach the value at 225,000 points, cubes of cubic-18 at 2,000, of
hexahedra at 3,500. At equal time a factor is more reliable.
"""
MOST_ENTRIES = 6e7
"""Maximum entries of one triangle for which a factor is chosen.

Both take 1.5 GB, and as much again while the pivots are checked. A plate of 300,000 points has as
many.
"""
MOST_IN_NEED = 2e8
"""Entries up to which a factor is made where multigrid fails: 5 GB."""
WORTH_CHOLMOD = 20_000
"""Number of unknowns from which CHOLMOD is used, if it is installed.

The matrix must be positive definite. Below it, either factor takes a second at most, and results
are bitwise equal with it and without.
"""
BYTES = 24
"""Memory (bytes) of an entry in one triangle and its mirror image in the other."""


class Choice(NamedTuple):
    """The way that was taken, "direct" or "multigrid", and the reason in words."""

    name: str
    reason: str


QUESTIONS = "asked for"
SMALL = "a factor of so small, plane or slender a body is cheap"
LARGE = "a large body, whose factor fills up"


def choose(
    points: Array, pairs: Index, block: int, entries: float, wide: float = 1.0
) -> tuple[Choice, Dissection]:
    """Choose the faster solver for a block matrix, and count its factor.

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
