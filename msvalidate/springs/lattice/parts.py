"""Contribution of each cell to the springs and points of a lattice."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, diags_array

from msvalidate.problem import Array, Index, ProblemError
from msvalidate.problem.shapes import STRAIGHT, incident_pairs
from msvalidate.springs.lattice.corners import corner_volumes
from msvalidate.springs.lattice.cut import CutLattice, cell_gifts
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.lattice.filled import Lattice
from msvalidate.springs.lattice.voronoi import VoronoiLattice


def spring_parts(lattice: Lattice) -> csr_array:
    """Fraction (m, c) of each spring's stiffness from each cell; rows sum to 1.

    A mesh's edges and a cut lattice's springs have it from the rule that made them. In a lattice
    that repeats every cell that holds the spring's middle brings the same: half in each of the two
    beside it in the plane, a quarter along an edge in space, all in the cell that it runs inside.

    Raises `ProblemError` if the lattice has no cells that its springs belong to.
    """
    size = len(lattice.springs), len(lattice.cells)
    if isinstance(lattice, CutLattice):
        of, gifts = cell_gifts(lattice)
    elif isinstance(lattice, EdgeLattice):
        of, gifts = lattice.of, lattice.gifts
    else:
        spring, cell = _holding_cells(lattice, lattice.points[lattice.springs].mean(axis=1))
        return _shared(spring, cell, np.ones(len(spring)), size, lattice)
    part = gifts / np.where(lattice.factor, lattice.factor, 1.0)[of]
    return csr_array((part.ravel(), (of.ravel(), _numbered(of))), shape=size)


def point_parts(lattice: Lattice) -> csr_array:
    """Fraction (n, c) of each point's volume in each cell; rows sum to 1.

    Raises `ProblemError` if the lattice has no cells that its points belong to.
    """
    if isinstance(lattice, CutLattice):
        volume = lattice.corner_volume
    else:
        volume = corner_volumes(lattice.points, lattice.cells)
    point, cell, gift = lattice.cells.ravel(), _numbered(lattice.cells), volume.ravel()
    inside = np.setdiff1d(np.arange(len(lattice.points)), point)
    if len(inside):  # of a cell, beside its corners
        which, holding = _holding_cells(lattice, lattice.points[inside])
        point, cell = np.append(point, inside[which]), np.append(cell, holding)
        gift = np.append(gift, np.ones(len(which)))
    return _shared(point, cell, gift, (len(lattice.points), len(lattice.cells)), lattice)


def _numbered(entries: Index) -> Index:
    """Number of the row of each entry (r, k), one after the other."""
    return np.repeat(np.arange(len(entries)), entries.shape[1])


def _holding_cells(lattice: Lattice, places: Array) -> tuple[Index, Index]:
    """Pairs of a place (q, d) and a cell that holds it, or has it on its rim."""
    if isinstance(lattice, VoronoiLattice):
        raise ProblemError(
            f"zones: the springs of an irregular lattice ({lattice.name}) belong to no cells; take "
            "one that repeats, or a mesh's edges"
        )
    room = lattice.domain.tolerance
    shape = STRAIGHT[lattice.points.shape[1], lattice.cells.shape[1]]
    cell, place = incident_pairs(shape, lattice.points[lattice.cells], places, room)
    return place, cell


def _shared(
    row: Index, cell: Index, gift: Array, size: tuple[int, int], lattice: Lattice
) -> csr_array:
    """Gifts of cells as parts that sum to 1 in each row."""
    gifts = csr_array((gift, (row, cell)), shape=size)
    total, covered = gifts.sum(axis=1), gifts.sum(axis=1) > 0
    if not covered.all():
        raise ProblemError(
            f"zones: the cells of the {lattice.name} lattice do not cover its springs; take one "
            "whose cells fill the body"
        )
    return csr_array(diags_array(1 / total) @ gifts)
