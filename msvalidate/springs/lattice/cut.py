"""Lattice cut to a body: grid cells, each weighted by its part inside the body.

A spring of a whole cell belongs to it as the boundary weights of a filled box have it: half of a
side in the plane, a quarter of an edge in space, all of a diagonal inside. That part is an integral
over the cell: of the product of N over the axes *across* the spring, where N falls linearly from 1
at the spring to 0 at the cell's other side. In a cell that the outline cuts, the same integral runs
over the part of the cell inside the body: it takes the area inside and where that lies. In a
ring under pressure, 32 cells to its inner radius, displacements err by 2e-4. Were the area inside
spread evenly over the cell it would be 7e-4, and 1e-2 with whole cells alone.

In the plane, and in prisms along z of whole layers of cells, the outline is cut; any other solid is
cut by its surface (`springs.lattice.grid_cut`). Both are exact for straight sides and flat
facets; what bent ones are off by is `CutLattice.drawing_error`.

A cell is one, whatever the parts of the body in it. Where it reaches both sides of a gap, as of a
slit or crack narrower than a cell, it joins them: take cells smaller than the gap.
"""

from __future__ import annotations

from itertools import combinations

import numpy as np
import shapely
from scipy.spatial import cKDTree

from msvalidate.problem import Array, Domain, Index, Mask, Mesh, ProblemError
from msvalidate.problem.checks import (
    finite_coordinates,
    format_value,
    length_in_metres,
    require_type,
)
from msvalidate.problem.records import dataclass
from msvalidate.springs.lattice.corners import corners_of_cell
from msvalidate.springs.lattice.filled import Lattice, PatternLattice
from msvalidate.springs.lattice.grid_cut import ROUNDING, CutCells, cut_cells
from msvalidate.springs.lattice.outline import outline
from msvalidate.springs.lattice.pattern import Pattern
from msvalidate.springs.lattice.ties import level_numbers

BESIDE = 0.1
"""Distance from curved facets, relative to a cell, within which the exact body decides.

It is far more than the distance between a curved facet and its flat approximation.
"""


FILLED = 0.25
"""Fraction of a cell inside a curved body from which it is no sliver."""
NARROW = 2.0
"""Width of a hole, in cells, below which no whole cell may lie in it."""


@dataclass(frozen=True, eq=False, kw_only=True)
class CutLattice(PatternLattice):
    """Lattice with cut boundary cells, whose points may lie up to one cell outside.

    Parameters
    ----------
    fraction
        Fraction of each cell inside the body, shape (c,).
    corner_volume
        Area (m²) or volume (m³) of each cell that belongs to each of its corners, shape
        (c, corners).
    inside
        Mask (n,) of the points in the body or on its surface.
    drawing_error
        Upper bound of the area or volume between curved sides and their straight or flat
        approximation, relative to the body; 0 for straight sides.
    by_surface
        True for a solid that is no prism of whole layers, and is cut by its surface.
    """

    fraction: Array
    corner_volume: Array
    inside: Mask
    drawing_error: float
    by_surface: bool
    boundary: str = "cut"

    def weights_at(self, places: Array) -> tuple[Index, Array]:
        """Points (q, corners) and weights (q, corners) that interpolate at places (q, d) in m.

        Linear along each axis of the cell at the place, or of the nearest cell that is there; of
        cells as near, the first along x, then y, then z.

        Raises `ProblemError` if the places do not fit the lattice's dimension, or are not finite.
        """
        places = finite_coordinates("places", places, "q", self.points.shape[1])
        return cell_weights(self.points, self.cells, self.spacing, places)


def cell_weights(points: Array, cells: Index, side: float, places: Array) -> tuple[Index, Array]:
    """Find the corners (q, corners) of the cell of each place, and interpolation weights.

    The grid consists of square or cubic cells (c, corners); the weights have the shape of the
    result.

    As `CutLattice.weights_at`: `points` (n, d), `side` of the cells and `places` (q, d) in m.
    """
    low, d = points[cells[:, 0]], places.shape[1]
    cell = _nearest_cell(low, side, places)
    s = (places - low[cell]) / side
    weights = [
        np.prod([s[:, a] if up[a] else 1 - s[:, a] for a in range(d)], axis=0)
        for up in corners_of_cell(d)
    ]
    return cells[cell], np.stack(weights, axis=1)


def _nearest_cell(low: Array, side: float, places: Array) -> Index:
    """The cell (q,), of low corners (c, d) in m, nearest to each place (q, d).

    By the distance from the whole cell: from its middle, a place beside one cell may be as far from
    several, and a tree then takes any of them.
    """
    near = min(3 ** low.shape[1], len(low))
    # Whatever is nearest is among those whose middles are: cells lie in a grid.
    cells = cKDTree(low + side / 2).query(places, k=np.arange(near) + 1, p=np.inf)[1]
    from_low = (places[:, None] - low[cells]) / side
    past = np.maximum(np.maximum(-from_low, from_low - 1), 0.0)
    apart = level_numbers(np.linalg.norm(past, axis=2), ROUNDING, axis=1)
    step = np.rint((low - low.min(axis=0)) / side)[cells]
    order = np.lexsort((*np.moveaxis(step, 2, 0)[::-1], apart), axis=1)
    return np.asarray(np.take_along_axis(cells, order[:, :1], axis=1)[:, 0])


def cut_lattice(
    pattern: Pattern,
    domain: Domain,
    spacing: float,
    *,
    origin: tuple[float, ...] | None = None,
) -> CutLattice:
    """Cut a square or cubic lattice to the outline or surface of a body.

    Points may lie up to one cell outside the body. Each spring of a cut cell has the share of
    stiffness that lies inside, an integral over the part of the cell in the body.

    Parameters
    ----------
    pattern
        Unit cell with one point, square or cubic, whose springs join corners of the same cell, such
        as ``patterns.square()`` or ``patterns.cubic18()``.
    domain
        Body of the same dimension d.
    spacing
        Side (m) of the cells.
    origin
        Coordinates (m) of one lattice point, default (0, 0). Lattice lines should coincide with
        supports. In 3D, z is optional; by default a lattice plane lies at the lower end of the
        body.

    Returns
    -------
    CutLattice
        Points (n, d) in m, springs (m, 2) and cells; ``fraction`` (c,) is the part of each cell
        that lies inside the body.

    Raises
    ------
    ProblemError
        If the pattern or the dimension does not fit, no cell remains, there are too many points,
        the surface crosses itself, or a value is out of its range.

    Examples
    --------
    >>> from msvalidate import Polygon, cut_lattice, patterns
    >>> wedge = Polygon(((0.0, 0.0), (0.3, 0.0), (0.0, 0.3)))
    >>> lattice = cut_lattice(patterns.square(), wedge, spacing=0.1)
    >>> lattice.fraction.round(6).tolist()
    [1.0, 1.0, 0.5, 1.0, 0.5, 0.5]
    """
    require_type("pattern", pattern, Pattern)
    if not joins_corners(pattern):
        raise ProblemError(
            f"{pattern.name} lattice: not of one point in cubes or squares, with springs between "
            "corners of one; cut square, cubic18 or such"
        )
    h = length_in_metres("cut lattice: spacing", spacing)
    require_type("body", domain, Domain)
    if pattern.dim != domain.dim:
        raise ProblemError(
            f"{pattern.name} lattice: a {format_value(domain)}; give one of {pattern.dim}D"
        )
    d = domain.dim
    base = _origin(origin, domain, h)
    kept = cut_cells(domain, h, base)
    number_of, cells = _number_points(kept.index)
    points = base + h * number_of
    springs, kind, factor = _springs(pattern, cells, kept.part)
    corner_volume = kept.part * h**d
    return CutLattice(
        name=f"{pattern.name}, cut",
        domain=domain,
        points=points,
        springs=springs,
        kind=kind,
        cells=cells,
        facets=np.empty((0, 2 ** (d - 1)), dtype=np.intp),
        point_volume=np.bincount(cells.ravel(), corner_volume.ravel()).astype(float),
        factor=factor,
        pattern=pattern,
        spacing=h,
        regular=False,
        fraction=kept.part.sum(axis=1),
        corner_volume=corner_volume,
        inside=_inside(kept, domain, points, number_of, cells, h),
        drawing_error=kept.drawing_error,
        by_surface=kept.encloses is not None,
    )


def _inside(
    cut_cells: CutCells, domain: Domain, points: Array, number_of: Index, cells: Index, h: float
) -> Mask:
    """Points (n,) in the body or on its surface; next to bent sides as they are, not as drawn."""
    whole = cells[cut_cells.part.sum(axis=1) > 1 - ROUNDING]
    inside = np.bincount(whole.ravel(), minlength=len(points)) == cells.shape[1]
    (near,) = np.nonzero(~inside)
    x = points[near]
    if not isinstance(domain, Mesh):
        inside[near] = domain.contains(x)
    elif cut_cells.encloses is None:  # of a prism: as one point of a column is, all are
        _, first, column = np.unique(
            number_of[near, :2], axis=0, return_index=True, return_inverse=True
        )
        inside[near] = domain.contains(x[first])[column.ravel()]
    else:
        on = domain.whole_surface.select(x, domain.tolerance)
        inside[near] = cut_cells.encloses(number_of[near]) | on
        if cut_cells.drawing_error:
            beside = domain.whole_surface.select(x, BESIDE * h) & ~on
            inside[near[beside]] = domain.contains(x[beside])
    return np.asarray(inside)


def joins_corners(pattern: Pattern) -> bool:
    """Return True if a pattern is a grid whose springs join corners of one cell.

    The grid is square or cubic.

    Such can be cut to a body, and interpolated in each cell.
    """
    return bool(
        len(pattern.points) == 1 and np.abs(pattern.image).max() <= 1 and not np.ptp(pattern.size)
    )


def _origin(origin: tuple[float, ...] | None, domain: Domain, h: float) -> Array:
    """Lattice point (d,) in m equivalent to `origin`, less than a spacing from 0 along each axis.

    Along z in 3D it is the lower end of the body if no z is given or a lattice plane lies there.
    """
    base = np.zeros(domain.dim)
    given = base[:2] if origin is None else finite_coordinates("cut lattice: origin", origin)
    if given.shape not in {(2,), (domain.dim,)}:
        need = "two coordinates" if domain.dim == 2 else "two or three coordinates"
        raise ProblemError(f"cut lattice: origin {format_value(origin)}; give {need}")
    base[: len(given)] = np.fmod(given, h)  # exact, where steps of h from far away would be rounded
    if domain.dim == 3:
        low = domain.span[2][0]
        steps = (low - base[2]) / h if len(given) == 3 else 0.0
        if abs(steps - np.rint(steps)) * h <= domain.tolerance:
            base[2] = low
    return base


def _number_points(index: Index) -> tuple[Index, Index]:
    """Indices (n, d) of the grid's points at cells, and the cells' points (c, 2^d)."""
    at = index[:, None] + corners_of_cell(index.shape[1])
    low = at.min(axis=(0, 1))
    size = tuple(at.max(axis=(0, 1)) - low + 1)
    flat = np.ravel_multi_index(tuple(np.moveaxis(at - low, -1, 0))[::-1], size[::-1])
    used, cells = np.unique(flat, return_inverse=True)
    points = np.stack(np.unravel_index(used, size[::-1])[::-1], axis=1) + low
    return points, cells.reshape(flat.shape)


def cell_gifts(lattice: CutLattice) -> tuple[Index, Array]:
    """Numbers (c, e) of each cell's springs, and what it brings to their factors."""
    part = lattice.corner_volume / lattice.spacing ** lattice.points.shape[1]
    pairs, _, gifts = _gifts(lattice.pattern, lattice.cells, part)
    n = len(lattice.points)
    return np.searchsorted(lattice.springs @ (n, 1), pairs @ (n, 1)), gifts  # springs are sorted


def _springs(pattern: Pattern, cells: Index, part: Array) -> tuple[Index, Index, Array]:
    """Springs (m, 2), their kinds (m,) and their factors (m,): what all cells give them."""
    pairs, kinds, gifts = _gifts(pattern, cells, part)
    n = int(cells.max()) + 1
    key, which = np.unique(pairs @ (n, 1), return_inverse=True)
    kind_of = np.zeros(len(key), dtype=np.intp)
    kind_of[which.reshape(gifts.shape)] = kinds
    factor = np.bincount(which.ravel(), gifts.ravel())
    return np.stack(np.divmod(key, n), axis=1), kind_of, factor.astype(float)


def _gifts(pattern: Pattern, cells: Index, part: Array) -> tuple[Index, Index, Array]:
    """Ends (c, e, 2) of the springs in each cell, their kinds (e,), what it gives them (c, e)."""
    corners = corners_of_cell(pattern.dim).tolist()
    ends, kinds, gifts = [], [], []
    for step, kind, factor in zip(pattern.image, pattern.kind, pattern.factor, strict=True):
        for start, corner in enumerate(corners):
            end = [a + b for a, b in zip(corner, step, strict=True)]
            if end not in corners:
                continue
            # All corners that agree with the spring across it: N of those axes alone is left.
            near = [c for c, other in enumerate(corners) if _are_beside(other, corner, step)]
            ends.append((start, corners.index(end)))
            kinds.append(kind)
            gifts.append(factor * part[:, near].sum(axis=1))
    return np.sort(cells[:, ends], axis=2), np.array(kinds), np.stack(gifts, axis=1)


def _are_beside(other: list[int], corner: list[int], step: Array) -> bool:
    """Return True if two corners agree along all axes across a spring."""
    return all(a == b or s for a, b, s in zip(other, corner, step, strict=True))


# Gaps and holes narrower than cells ---------------------------------------------------------------


def narrow_holes(lattice: CutLattice) -> Array:
    """Centre and width (m) of holes narrower than `NARROW` cells, as rows (h, 3).

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


def bridged_gaps(lattice: Lattice) -> Array:
    """Middle and width (m) of bridged gaps and holes by width, shape (g, 3).

    Around a gap, the body has several parts in the three by three cells about one of them; their
    springs share points, and join what the body does not. A hole narrower than a cell is bridged
    too. None are looked for in solids that are no prisms along z, nor in lattices that are not cut.
    """
    none = np.empty((0, 3))
    if not isinstance(lattice, CutLattice):
        return none
    try:
        body = outline(lattice.domain)
    except ProblemError:
        return none
    h, low = lattice.spacing, lattice.points[lattice.cells[lattice.fraction >= FILLED, 0], :2]
    low = h * np.unique(np.round(low / h, 6), axis=0)  # of solids one layer
    shapely.prepare(body)
    low = low[~shapely.covers(body, shapely.box(*(low - h).T, *(low + 2 * h).T))]
    holes = narrow_holes(lattice)
    found = [holes[holes[:, 2] < h]]
    for x, y in low:
        parts = shapely.get_parts(shapely.clip_by_rect(body, x - h, y - h, x + 2 * h, y + 2 * h))
        parts = parts[shapely.area(parts) >= FILLED * h**2]
        for one, other in combinations(parts, 2):
            across = shapely.shortest_line(one, other)
            middle = shapely.get_coordinates(across).mean(axis=0)
            found.append(np.array([(*middle, shapely.length(across))]))
    gaps = np.concatenate([none, *found])
    return np.asarray(gaps[gaps[:, 2].argsort(kind="stable")])
