"""Floor 1: where the points sit, which of them are joined, and what of a spring a body shares.

A lattice is a function that returns a `Pattern`, what repeats; `patterns` has one a lattice, and
`voronoi` makes random ones. As a `Lattice`, a body: `fill` puts whole cells of any pattern in a
box, `turned` cuts one at any angle, `voronoi_box` fills one at random.
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
from msvalidate.lattice.turned import turned
from msvalidate.lattice.voronoi import STIFFNESS_RULES, voronoi, voronoi_box

__all__ = [
    "SIN60",
    "STIFFNESS_RULES",
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
    "turned",
    "voronoi",
    "voronoi_box",
    "zigzag_block",
]
