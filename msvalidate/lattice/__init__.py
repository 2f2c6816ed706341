"""Floor 1: where the points sit, which of them are joined, and what of a spring a body shares.

A lattice is a function that returns a `Pattern`, what repeats; `patterns` has one a lattice. `fill`
puts whole cells of any pattern in a box.
"""

from msvalidate.lattice import patterns
from msvalidate.lattice.filled import WEIGHTS, Lattice, boundary_weights, fill
from msvalidate.lattice.pattern import Constants, Pattern, repeated
from msvalidate.lattice.plane import (
    SIN60,
    diagonal_square,
    square,
    trapezium,
    triangular,
    zigzag_block,
)

__all__ = [
    "SIN60",
    "WEIGHTS",
    "Constants",
    "Lattice",
    "Pattern",
    "boundary_weights",
    "diagonal_square",
    "fill",
    "patterns",
    "repeated",
    "square",
    "trapezium",
    "triangular",
    "zigzag_block",
]
