"""Supports and tractions of a lattice cut to a solid, anywhere on its surface.

Facets are drawn by flat triangles and cut along the planes of the lattice, so that each piece lies
in one cell. A traction does the work that it does on the motion interpolated there: exact for one
that is linear on a flat facet, and whose area is the facet's own on a bent one.

A support holds the points of the cells that its facets run through, but for those deeper in the
body than half a cell; it is then met to first order in the spacing. Facets in a plane of the
lattice hold that plane's points alone, of all cells that have body at them; and beyond the body's
rim one point more, for a cell there may be cut too.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem import (
    Array,
    Boundary,
    Domain,
    Index,
    Mask,
    Mesh,
    Part,
    Traction,
    corners_of,
    vectors_at,
)
from msvalidate.springs.lattice.corners import corners_of_cell
from msvalidate.springs.lattice.cut import CutLattice
from msvalidate.springs.lattice.drawn import draw_surface, triangle_areas, true_areas
from msvalidate.springs.lattice.grid_cut import RULE, Pieces, cut_to_grid, sum_groups

AWAY = 1e-3
"""Largest distance between curved facets and their triangles, relative to a cell."""
DEEPEST = 0.5 + 1e-9
"""Depth in the body, in cells, to which a support fixes points.

The fixed part then begins too early as often as too late. For a turned block with a hole, clamped
at one end and loaded at the other, with 16 cells per metre, displacements have an error of 0.5 %;
with all points of the cells fixed, as in 2D, 11 %; and with none inside, 10 %. A linear
displacement on the whole surface, which all points would reproduce exactly, has an error of some
1 %.
"""
TOUCHED = 1e-9
"""Smallest part of a cell's face in a surface that crosses the cell.

Otherwise rounding would decide about a cell that the surface touches along an edge.
"""
AT_ONCE = 20_000
"""Number of places in removed cells whose nearest cell is searched per batch."""


def _numbered(places: Array, low: Array, spacing: float) -> KDTree:
    """Places (n, 3) in m of a lattice by whole numbers, `low` being the first along each axis."""
    return KDTree(np.rint((places - low) / spacing))


def _find(numbered: KDTree, number: Index) -> Index:
    """Index (q,) of the place with each number (q, 3), or -1."""
    found = numbered.query(number, distance_upper_bound=0.5)[1]
    return np.where(found < numbered.n, found, -1)


def fixed_points(part: Part, lattice: CutLattice) -> Mask:
    """Points (n,) of the lattice that a support on a part of the surface holds.

    Raises
    ------
    ProblemError
        If it is no part of the surface.
    """
    facets, h = _facets(part, lattice.domain), lattice.spacing
    low = lattice.points.min(axis=0)
    numbered = _numbered(lattice.points, low, h)
    level, room = (facets - low) / h, lattice.domain.tolerance / h
    off_plane = np.abs(level - np.rint(level[:, :1])).max(axis=1)
    axis_of = np.where((off_plane <= room).any(axis=1), off_plane.argmin(axis=1), -1)
    held = np.zeros(len(lattice.points), dtype=bool)
    for axis in np.unique(axis_of).tolist():
        corners = _touched_corners(facets[axis_of == axis], lattice, low, axis)
        found = _find(numbered, corners)
        held[found[found >= 0]] = True
        if axis >= 0:
            held[_beyond_rim(corners, lattice, numbered, axis)] = True
    return held


def traction_on_solid(load: Traction, lattice: CutLattice) -> Array:
    """Forces (n, 3) in N on the lattice's points that a traction amounts to.

    Raises
    ------
    ProblemError
        If it acts on no part of the surface, or a field of it is not finite there.
    """
    facets, h = _facets(load.region, lattice.domain), lattice.spacing
    low = lattice.points.min(axis=0)
    cells = _numbered(lattice.points[lattice.cells[:, 0]], low, h)
    drawn = draw_surface(facets, lattice.domain.tolerance, away=AWAY * h)
    per_area = true_areas(facets, drawn) / triangle_areas(drawn.corners)
    force = np.zeros(lattice.points.shape)
    for pieces in cut_to_grid((drawn.corners - low) / h):
        area = triangle_areas(pieces.corners) * h**2 * per_area[pieces.owner]
        places = (low + h * pieces.places).reshape(-1, 3)
        pull = vectors_at(f"traction on {load.region}", load.traction, places)
        pull = (area[:, None] * RULE[1]).reshape(-1, 1) * pull
        points, weights = _weights_in(pieces, places, lattice, cells)
        for axis in range(3):
            gift = (weights * pull[:, axis, None]).ravel()
            force[:, axis] += np.bincount(points.ravel(), gift, len(force))
    return force


def _facets(part: Part, domain: Domain) -> Array:
    """Facets (f, k, 3) in m of part of a surface.

    Their nodes run counter-clockwise as seen from outside. A part of a box is one rectangle. Raises
    `ProblemError` as `Mesh.part` or `corners_of`.
    """
    if isinstance(part, Boundary):
        return part.places
    if isinstance(domain, Mesh):
        return domain.part(part).places
    corners = corners_of(part, domain)[[0, 1, 3, 2]]
    outward = corners.mean(axis=0) - np.array(domain.span).mean(axis=1)
    normal = np.cross(corners[1] - corners[0], corners[3] - corners[0])
    return (corners if normal @ outward >= 0 else corners[::-1])[None]


def _touched_corners(facets: Array, lattice: CutLattice, low: Array, axis: int) -> Index:
    """Numbers (q, 3) of corners of the cells that facets (f, k, 3) run through.

    Of facets in planes of the lattice across an axis, if it is not -1, those in the plane alone; of
    others those that lie no deeper in the body than `DEEPEST`.
    """
    drawn = draw_surface(facets, lattice.domain.tolerance, away=AWAY * lattice.spacing)
    cells, sums = [], []
    for pieces in cut_to_grid((drawn.corners - low) / lattice.spacing):
        cell = pieces.cell.copy()
        if axis >= 0:
            cell[:, axis] = np.rint(pieces.corners[:, 0, axis])
        some, which = np.unique(cell, axis=0, return_inverse=True)
        cells.append(some)
        sums.append(sum_groups(which.ravel(), _areas_and_middles(pieces.corners), len(some)))
    cell, which = np.unique(np.concatenate(cells), axis=0, return_inverse=True)
    total = sum_groups(which.ravel(), np.concatenate(sums), len(cell))
    through = total[:, 0] > TOUCHED
    cell, total = cell[through], total[through]
    steps = corners_of_cell(3)
    if axis >= 0:
        steps = steps[steps[:, axis] == 0]
    corners = cell[:, None] + steps
    middle, outward = total[:, 1:4] / total[:, :1], total[:, 4:]
    length = np.linalg.norm(outward, axis=1)[:, None]
    above = np.einsum("cvd,cd->cv", corners - middle[:, None], outward)
    near = (above >= -DEEPEST * length) if axis < 0 else np.ones(above.shape, dtype=bool)
    return np.unique(corners[near], axis=0)


def _areas_and_middles(corners: Array) -> Array:
    """Columns (t, 7) of triangles (t, 3, 3): area, area × middle, area vector."""
    edges = corners[:, 1:] - corners[:, :1]
    vector = np.cross(edges[:, 0], edges[:, 1]) / 2
    area = np.linalg.norm(vector, axis=1)[:, None]
    return np.concatenate([area, area * corners.mean(axis=1), vector], axis=1)


def _beyond_rim(corners: Index, lattice: CutLattice, numbered: KDTree, axis: int) -> Index:
    """Points beside some in a plane across an axis that lie in it and outside the body."""
    steps = np.array([s for s in np.ndindex(3, 3, 3) if s[axis] == 1]) - 1
    beside = _find(numbered, np.unique((corners[:, None] + steps).reshape(-1, 3), axis=0))
    beside = beside[beside >= 0]
    return beside[~lattice.domain.contains(lattice.points[beside])]


def _weights_in(
    pieces: Pieces, places: Array, lattice: CutLattice, cells: KDTree
) -> tuple[Index, Array]:
    """As `CutLattice.weights_at`, of places (q, 3) in m in pieces whose cells are known."""
    number, cell = _cells_beside(pieces, cells)
    cell = np.repeat(cell, len(RULE[1]))
    s = np.clip(pieces.places - number[:, None], 0.0, 1.0).reshape(-1, 3)
    weights = np.stack([np.where(up, s, 1 - s).prod(axis=1) for up in corners_of_cell(3)], axis=1)
    points = lattice.cells[cell]
    (lost,) = np.nonzero(cell < 0)
    for some in np.split(lost, range(AT_ONCE, len(lost), AT_ONCE)):
        if len(some):
            points[some], weights[some] = lattice.weights_at(places[some])
    return points, weights


def _cells_beside(pieces: Pieces, cells: KDTree) -> tuple[Index, Index]:
    """Number (p, 3) of each piece's cell, and which cell it is, or -1.

    Of pieces in a plane between two cells that which is there; if both are, the one below.
    """
    middle = pieces.corners.mean(axis=1)
    number = np.floor(middle - TOUCHED).astype(np.intp)
    cell = _find(cells, number)
    other = np.floor(middle + TOUCHED).astype(np.intp)[cell < 0]
    number[cell < 0] = other
    cell[cell < 0] = _find(cells, other)
    return number, cell
