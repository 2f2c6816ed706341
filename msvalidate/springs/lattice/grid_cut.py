"""Grid cells over a body, and the part of each that belongs to its corners.

By the outline in the plane and in prisms along z. The surface of any other solid is drawn by
triangles, which are cut along the planes of the grid.

A triangle's piece in one cell stands over all that is below it in its column of cells. Of a closed
surface the parts under triangles that look upwards, less those under triangles that look downwards,
are the body (Gauss's theorem with a field along z). In the cell of the piece the integral of a
corner's weight runs from the cell's floor to the piece; in the cells below it, over their whole
height. Both are polynomials of degree 4 at most over a flat triangle, so a quadrature of that
degree is exact, whichever way the surface runs through the cell. Triangles along planes of the grid
need no care: what is on either side of one weighs the same.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from msvalidate.problem import Array, Domain, Index, Mask, ProblemError
from msvalidate.problem.checks import refuse_too_many
from msvalidate.problem.records import dataclass
from msvalidate.springs.lattice.corners import corners_of_cell
from msvalidate.springs.lattice.drawn import draw_surface, prism_layers, solid_facets
from msvalidate.springs.lattice.outline import area_moments, outline, outline_gap

PIECES = 60_000
"""Approximate number of pieces per batch, some 60 MB.

The pieces of one triangle are never split.
"""
SHIFT = 1e-7 * np.array([0.7548776662466927, 0.5698402909980532])
"""Shift of vertical test lines along x and y, relative to a cell.

No edge of a triangle that follows the grid intersects a shifted line.
"""
SLAB = 500_000
"""Cells of the grid that are looked into at once: 100 MB."""

_ROOT = np.sqrt(38 - 44 * np.sqrt(2 / 5)) * np.array([1, -1])
_AT = (8 - np.sqrt(10) + _ROOT) / 18
RULE = (
    np.concatenate([s + (1 - 3 * s) * np.eye(3) for s in _AT]),
    np.repeat((620 + np.sqrt(213125 - 53320 * np.sqrt(10)) * np.array([1, -1])) / 3720, 3),
)
"""Barycentric places (6, 3) and weights (6,) that are exact to degree 4 [Dunavant1985]."""

ROUNDING = 1e-9
"""Relative size of rounding in a cell or its side.

A cell that is half inside, or a sliver, is then classified the same for all roundings of its
coordinates.
"""
SLIVER = 1e-2
"""Fraction inside the body below which a cell is removed.

The tangent is then as well conditioned as that of an uncut lattice, with the same errors; from 0.1
on the loss is noticeable. Loads on the outline there go to the nearest remaining cell.
"""
DRAWING = 1e-4
"""Largest volume between curved facets and their flat triangles, relative to a solid.

A sphere takes some 1e5 triangles; the error of its radius is then 3e-5, below that of the springs.
"""
CROSSED = 1e-6
"""Tolerance for fractions below 0 or above 1, which reveal a self-crossing surface.

It is far above rounding.
"""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Pieces of triangles, each within one grid cell: `corners` (p, 3, 3) in cells.

    `owner` (p,) is the number of the triangle, `cell` (p, 3) the indices of the cell.
    """

    corners: Array
    owner: Index
    cell: Index

    @property
    def places(self) -> Array:
        """Places (p, 6, 3) of the quadrature."""
        return np.asarray(np.einsum("qv,pvd->pqd", RULE[0], self.corners))


def cut_to_grid(corners: Array, count: Index | None = None) -> Iterator[Pieces]:
    """Pieces of triangles (t, 3, 3), given in cells, between the planes at whole numbers.

    They come in groups, so that memory stays small. Indices are held below `count` (3,).
    """
    owner = np.arange(len(corners))
    group = (np.cumsum(_expected_pieces(corners)) // PIECES).astype(int)
    ends = np.flatnonzero(np.diff(group, append=-1)) + 1
    start = 0
    for end in ends.tolist():
        some, whose = corners[start:end], owner[start:end]
        for axis in range(3):
            some, whose = _cut_across(some, whose, axis)
        cell = np.floor(some.mean(axis=1)).astype(np.intp)
        if count is not None:
            cell = np.clip(cell, 0, np.asarray(count) - 1)
        yield Pieces(some, whose, cell)
        start = end


def _expected_pieces(corners: Array) -> Array:
    """Pieces (t,) that triangles will be cut into, at most about."""
    planes = np.floor(corners.max(axis=1)) - np.floor(corners.min(axis=1)) + 1
    return np.asarray((planes * np.roll(planes, 1, axis=1)).sum(axis=1))


def _turned(corners: Array, first: Index) -> tuple[Array, Array, Array]:
    """Corners of triangles, each (t, 3), begun at one of them."""
    each = np.arange(len(corners))
    return tuple(corners[each, (first + i) % 3] for i in range(3))  # type: ignore[return-value]


def _cut_across(corners: Array, owner: Index, axis: int) -> tuple[Array, Index]:
    """Triangles cut at each whole number along an axis: at the middle one first."""
    done: list[tuple[Array, Index]] = []
    while len(corners):
        low, high = corners[..., axis].min(axis=1), corners[..., axis].max(axis=1)
        first, last = np.floor(low) + 1, np.ceil(high) - 1
        crossed = first <= last
        done.append((corners[~crossed], owner[~crossed]))
        plane = np.clip(np.rint((low + high) / 2), first, last)[crossed]
        corners, owner = _halve(corners[crossed], owner[crossed], axis, plane)
    return np.concatenate([one for one, _ in done]), np.concatenate([one for _, one in done])


def _halve(corners: Array, owner: Index, axis: int, plane: Array) -> tuple[Array, Index]:
    """Triangles on either side of a plane that each is cut by: two or three of each."""
    above = corners[..., axis] > plane[:, None]
    # The corner that is alone on its side.
    lone = np.where(above.sum(axis=1) == 1, above.argmax(axis=1), (~above).argmax(axis=1))
    a, b, c = _turned(corners, lone)
    p, q = (_meet(a, end, axis, plane) for end in (b, c))
    parts = [np.stack(part, axis=1) for part in ((a, p, q), (p, b, c), (p, c, q))]
    there = [np.ones(len(a), dtype=bool), (p != b).any(axis=1), (q != c).any(axis=1)]
    corners = np.concatenate([part[some] for part, some in zip(parts, there, strict=True)])
    return corners, np.concatenate([owner[some] for some in there])


def _meet(a: Array, b: Array, axis: int, plane: Array) -> Array:
    """Intersect lines from a to b, each (t, 3), with a plane."""
    s = ((plane - a[:, axis]) / (b[:, axis] - a[:, axis]))[:, None]
    met = (1 - s) * a + s * b  # b itself where s is 1
    met[:, axis] = plane  # or a corner less than rounding away would be cut off again and again
    return np.asarray(met)


def cell_parts(
    corners: Array, count: Index, least: float
) -> tuple[Index, Array, tuple[float, float], Array]:
    """Grid cells (c, 3) with more than a fraction `least` inside a closed surface.

    The grid has `count` (3,) cells from 0, the surface triangles (t, 3, 3) in cells,
    counter-clockwise from outside. With the cells' indices come the part (c, 2, 2, 2) of a whole
    cell that is each corner's, by steps along x, y and z; the least fraction inside any cell, or 0,
    and the largest; and the crossings that `are_enclosed` takes. Unless the surface crosses itself,
    these fractions lie between 0 and 1, up to rounding.
    """
    key, own, over, crossings = _surface_cells(corners, count)
    layer = int(count[1] * count[2])
    step = max(SLAB // layer, 1)
    index, part, lowest, highest = [], [], 0.0, 0.0
    for start in range(0, int(count[0]), step):
        end = min(start + step, int(count[0]))
        some = slice(*np.searchsorted(key, [start * layer, end * layer]))
        shape = (end - start, int(count[1]), int(count[2]))
        found = _fill_columns(key[some] - start * layer, own[some], over[some], shape)
        inside = found.sum(axis=(1, 2, 3))
        lowest, highest = min(lowest, inside.min()), max(highest, inside.max())
        kept = np.flatnonzero(inside > least)
        i, j, k = np.unravel_index(kept, shape)
        index.append(np.stack([i + start, j, k], axis=1))
        part.append(np.maximum(found[kept], 0.0))
    return np.concatenate(index), np.concatenate(part), (lowest, highest), crossings


def _fill_columns(key: Index, parts: Array, over: Array, shape: tuple[int, int, int]) -> Array:
    """Parts (cells, 2, 2, 2) of cells inside the surface, by corner.

    The cells are those of a slab. `key` (s,) are the cells with pieces of the surface, `parts` (s,
    2, 2, 2) the integrals under these in the cell, and `over` (s, 2, 2) those that count for all
    cells below.
    """
    above = np.zeros((shape[0] * shape[1] * shape[2], 2, 2))
    above[key] = over
    column = above.reshape(-1, shape[2], 2, 2)
    under = np.cumsum(column[:, ::-1], axis=1)[:, ::-1] - column
    part = np.repeat(under.reshape(-1, 2, 2, 1) / 2, 2, axis=3)
    part[key] += parts
    return part


def _surface_cells(corners: Array, count: Index) -> tuple[Index, Array, Array, Array]:
    """Cells (s,) that pieces lie in, by number; ∫ (s, 2, 2, 2) under them in the cell, and above.

    The next (s, 2, 2) are integrals of the weights along x and y alone, over the pieces' shadows;
    the last are the pieces' crossings.
    """
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    lying: Mask = np.abs(normal[:, 2]) > 1e-15 * np.linalg.norm(normal, axis=1)
    keys, sums, crossings = [np.empty(0, dtype=np.intp)], [np.empty((0, 12))], []
    for pieces in cut_to_grid(corners[lying], count):
        key = np.ravel_multi_index(tuple(pieces.cell.T), tuple(count))
        one, which = np.unique(key, return_inverse=True)
        found = _integrals(pieces)
        keys.append(one)
        sums.append(sum_groups(which.ravel(), found, len(one)))
        crossings.append(_crossings(pieces, count))
    key, which = np.unique(np.concatenate(keys), return_inverse=True)
    total = sum_groups(which.ravel(), np.concatenate(sums), len(key))
    met = np.concatenate(crossings)
    return key, total[:, :8].reshape(-1, 2, 2, 2), total[:, 8:].reshape(-1, 2, 2), met


def sum_groups(which: Index, values: Array, count: int) -> Array:
    """Sums (count, k) of the rows of values (p, k) that belong to each group."""
    columns = [np.bincount(which, column, count) for column in values.T]
    return np.stack(columns, axis=1)


def _integrals(pieces: Pieces) -> Array:
    """For each piece (p, 12) the integrals under it in its cell (8) and over its shadow (4)."""
    x, y, z = np.moveaxis(np.clip(pieces.places - pieces.cell[:, None], 0.0, 1.0), 2, 0)
    edges = pieces.corners[:, 1:, :2] - pieces.corners[:, :1, :2]
    shadow = (edges[:, 0, 0] * edges[:, 1, 1] - edges[:, 0, 1] * edges[:, 1, 0]) / 2
    weight = shadow[:, None] * RULE[1]
    along = [(weight * u * v) for u in (1 - x, x) for v in (1 - y, y)]
    up = (z - z**2 / 2, z**2 / 2)
    own = [(flat * height).sum(axis=1) for flat in along for height in up]
    return np.stack([*own, *(flat.sum(axis=1) for flat in along)], axis=1)


def _crossings(pieces: Pieces, count: Index) -> Array:
    """Intersect pieces with the vertical line at the low corner of their column.

    Rows (m, 3): number of the column, height, and 1 where the line leaves the body, or -1.
    """
    flat = pieces.corners[..., :2] - pieces.cell[:, None, :2] - SHIFT
    (ax, bx, cx), (ay, by, cy) = flat.transpose(2, 1, 0)
    share = np.stack([bx * cy - by * cx, cx * ay - cy * ax, ax * by - ay * bx], axis=1)
    turn = np.sign(share.sum(axis=1))
    meets = (share * turn[:, None] > 0).all(axis=1)
    share, turn, cell = share[meets], turn[meets], pieces.cell[meets]
    z = (share * pieces.corners[meets, :, 2]).sum(axis=1) / share.sum(axis=1)
    return np.column_stack([cell[:, 0] * (count[1] + 1) + cell[:, 1], z, turn])


def are_enclosed(points: Index, crossings: Array, count: Index) -> Mask:
    """Mask (n,) of the grid points (n, 3) inside a closed surface.

    Coordinates are integers from 0 to `count` (3,).

    On a line upwards from a point inside, the surface is left once more than it is entered. Points
    within a cell's 1e-7 of the surface may count as either.
    """
    line = points[:, 0] * (count[1] + 1) + points[:, 1]
    column, z, sign = crossings.T
    height = count[2] + 2.0  # of one line above the other
    at = column * height + z
    order = np.argsort(at, kind="stable")
    before = np.concatenate([[0.0], np.cumsum(sign[order])])
    ends = line * height + points[:, 2], (line + 1) * height - 0.5
    first, last = (np.searchsorted(at[order], end) for end in ends)
    return np.asarray(before[last] - before[first] > 0.5)


# Cells of a grid laid over a body -----------------------------------------------------------------


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
    """Grid cells with side h (m) from `base` (d,) that are not slivers.

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
