"""Cells of a grid laid over a body, and the part of each that belongs to each of its corners.

By the outline in the plane and in prisms along z, by the surface in any other solid.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.lattice.corners import corners_of_cell
from msvalidate.lattice.drawn import draw_surface, prism_layers, solid_facets
from msvalidate.lattice.grid_cut import are_enclosed, cell_parts
from msvalidate.lattice.outline import area_moments, outline, outline_gap
from msvalidate.problem import Array, Domain, Index, Mask, ProblemError
from msvalidate.problem.checks import refuse_too_many
from msvalidate.problem.records import dataclass

ROUNDING = 1e-9
"""Part of a cell, or of its side, that is rounding: a cell of which just half or just a sliver is
inside counts as one of those that have no more, and no less, whatever its coordinates round to."""
SLIVER = 1e-2
"""Cells with less than this part of them inside are left out: the tangent is then as well
conditioned as an uncut lattice's, and errors are as without; from 0.1 on what is lost shows. Loads
on the outline there go to the nearest cell that is left."""
DRAWING = 1e-4
"""Part of a solid's volume that may lie between its bent facets and the flat triangles they are
drawn by. A sphere takes some 1e5 triangles; its radius then errs by 3e-5, less than springs do."""
CROSSED = 1e-6
"""Part of a cell by which a body may have more than all of it, or less than none: far above what
rounding leaves."""


@dataclass(frozen=True, eq=False)
class CutCells:
    """Cells with more than a sliver inside.

    They have an `index` (c, d) in the grid; `part` (c, 2^d) of a whole cell is each corner's, in
    VTK's order. Of the body, a part `drawing_error` may lie between bent sides or facets and what
    they are drawn by; if it was cut by its surface, `encloses` tells which points (n, 3) of the
    grid, by indices, lie in it.
    """

    index: Index
    part: Array
    drawing_error: float
    encloses: Callable[[Index], Mask] | None = None


def cut_cells(domain: Domain, h: float, base: Array) -> CutCells:
    """Cells of side h (m) of a grid from `base` (d,) with more than a sliver inside.

    Raises `ProblemError` if there is none, there are too many, or the body's surface crosses
    itself.
    """
    layers = 0 if domain.dim == 2 else prism_layers(domain, h, base[2])
    if domain.dim == 2 or layers:
        found = _by_outline(domain, h, base, layers)
    else:
        found = _by_surface(domain, h, base)
    if not len(found.index):
        raise ProblemError(
            f"cut lattice: no cell of {h:g} m has more than {SLIVER:g} of it inside the body; "
            "choose a smaller spacing"
        )
    return found


def _by_outline(domain: Domain, h: float, base: Array, layers: int) -> CutCells:
    area = outline(domain)
    bounds = np.array(area.bounds).reshape(2, 2)
    first, count = _cover(bounds, h, base[:2], layers + 1)
    index = first + np.stack(np.meshgrid(*map(np.arange, count), indexing="ij"), -1).reshape(-1, 2)
    part = area_moments(area, base[:2] + h * index, h).reshape(-1, 4)[:, [0, 2, 3, 1]]
    kept = part.sum(axis=1) > SLIVER + ROUNDING
    index, part = index[kept], part[kept]
    error = outline_gap(domain) / area.area
    if domain.dim == 2:
        return CutCells(index, part, error)
    z = np.repeat(np.arange(layers), len(index))[:, None]
    stacked = np.concatenate([np.tile(index, (layers, 1)), z], axis=1)
    return CutCells(stacked, np.tile(part, (layers, 2)) / 2, error)


def _by_surface(domain: Domain, h: float, base: Array) -> CutCells:
    _cover(np.array(domain.span).T, h, base, 1)  # before anything is drawn
    drawn = draw_surface(solid_facets(domain), domain.tolerance, gap=DRAWING * domain.volume)
    bounds = np.stack([drawn.corners.min(axis=(0, 1)), drawn.corners.max(axis=(0, 1))])
    first, count = _cover(bounds, h, base, 1)
    inside = (drawn.corners - base) / h - first
    index, part, (least, most), crossings = cell_parts(inside, count, SLIVER + ROUNDING)
    if least < -CROSSED or most > 1 + CROSSED:
        raise ProblemError(
            f"cut lattice: {domain} has from {least:.3g} to {most:.3g} of a cell inside, where 0 "
            "to 1 are possible: its surface crosses itself; mend the mesh"
        )
    by_corner = part[(slice(None), *corners_of_cell(3).T)]

    def encloses(points: Index) -> Mask:
        return are_enclosed(points - first, crossings, count)

    return CutCells(index + first, by_corner, drawn.gap / domain.volume, encloses)


def _cover(bounds: Array, h: float, base: Array, layers: int) -> tuple[Index, Index]:
    """First cell and number of cells along each axis between bounds (2, d) in m.

    `layers` of points there are along what axes are left.
    """
    low, high = (bounds - base) / h
    first, last = np.floor(low + ROUNDING), np.ceil(high - ROUNDING)
    count = np.maximum(last - first, 1)
    refuse_too_many(f"cut lattice of spacing {h:g} m", float(np.prod(count + 1)) * layers)
    return first.astype(int), count.astype(int)
