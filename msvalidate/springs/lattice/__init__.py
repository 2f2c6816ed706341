"""Lattices: positions of points, their springs, and the boundary weights in a body.

A lattice is a function that returns a `Pattern`, what repeats; `patterns` has one a lattice, and
`voronoi` makes random ones. As a `Lattice`, a body: `fill` puts whole cells of any pattern in a
box, `fill_rotated` cuts one at any angle, `cut_lattice` cuts one to an outline, `voronoi_box` fills
one at random, `mesh_lattice` takes a mesh's edges.
"""

from msvalidate.springs.lattice import patterns
from msvalidate.springs.lattice.cut import CutLattice, cut_lattice
from msvalidate.springs.lattice.edges import EDGE_RULES, mesh_lattice
from msvalidate.springs.lattice.filled import (
    WEIGHTS,
    Lattice,
    PatternLattice,
    boundary_weights,
    fill,
)
from msvalidate.springs.lattice.pattern import Constants, Pattern, repeat_cell
from msvalidate.springs.lattice.plane import (
    diagonal_square,
    square,
    trapezium,
    triangular,
    zigzag_block,
)
from msvalidate.springs.lattice.turned import fill_rotated
from msvalidate.springs.lattice.voronoi import STIFFNESS_RULES, VoronoiLattice, voronoi, voronoi_box

__all__ = [
    "EDGE_RULES",
    "STIFFNESS_RULES",
    "WEIGHTS",
    "Constants",
    "CutLattice",
    "Lattice",
    "Pattern",
    "PatternLattice",
    "VoronoiLattice",
    "boundary_weights",
    "cut_lattice",
    "diagonal_square",
    "fill",
    "fill_rotated",
    "mesh_lattice",
    "patterns",
    "repeat_cell",
    "square",
    "trapezium",
    "triangular",
    "voronoi",
    "voronoi_box",
    "zigzag_block",
]
