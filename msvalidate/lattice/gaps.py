"""Gaps of a plane body that a lattice cut to it bridges, as they are narrower than its cells."""

from __future__ import annotations

import numpy as np
import shapely

from msvalidate.lattice.cut import CutLattice
from msvalidate.lattice.outline import outline
from msvalidate.problem import Array

FILLED = 0.25
"""Part of a cell from which it is no sliver beside a curve."""


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
