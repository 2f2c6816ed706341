"""Gaps that a lattice cut to a body bridges, and holes too narrow for its cells."""

from __future__ import annotations

import numpy as np
import shapely

from msvalidate.lattice.cut import CutLattice
from msvalidate.lattice.outline import outline
from msvalidate.problem import Array, ProblemError

FILLED = 0.25
"""Part of a cell from which it is no sliver beside a curve."""
NARROW = 2.0
"""Cells across a hole below which it is hardly one: no whole cell lies in it wherever it is."""


def narrow_holes(lattice: CutLattice) -> Array:
    """Middle (h, 2) and width (h,) in m, as rows (h, 3), of holes narrower than `NARROW` cells.

    Of bodies in the plane, and of prisms along z; none are looked for in others.
    """
    try:
        area = outline(lattice.domain)
    except ProblemError:
        return np.empty((0, 3))
    rings = [r for part in shapely.get_parts(area) for r in part.interiors]
    if not rings:
        return np.empty((0, 3))
    inscribed = shapely.maximum_inscribed_circle(shapely.polygons(rings))
    middle = shapely.get_coordinates(inscribed)[::2]
    found = np.column_stack([middle, 2 * shapely.length(inscribed)])
    return np.asarray(found[found[:, 2] < NARROW * lattice.spacing])


def bridged_gaps(lattice: CutLattice) -> Array:
    """Middles (g, 2) in m of sides between neighbouring cells that the body reaches nowhere.

    Both cells have the body in them and share points off it, so their springs join what the body
    does not. None are looked for in space.
    """
    if lattice.domain.dim != 2:
        return np.empty((0, 2))
    around = np.stack([lattice.cells, np.roll(lattice.cells, -1, axis=1)], axis=2)
    sides = np.sort(around, axis=2)
    filled = np.repeat(lattice.fraction >= FILLED, 4)
    ends = sides.reshape(-1, 2)[filled]
    pairs, count = np.unique(ends, axis=0, return_counts=True)
    shared = pairs[(count == 2) & ~lattice.inside[pairs].any(axis=1)]
    if not len(shared):
        return np.empty((0, 2))
    body = outline(lattice.domain)
    shapely.prepare(body)
    away = ~shapely.intersects(body, shapely.linestrings(lattice.points[shared]))
    return np.asarray(lattice.points[shared[away]].mean(axis=1))
