"""Outline of a 2D body, and the part of each grid square inside it."""

from __future__ import annotations

import numpy as np
import shapely

from msvalidate.problem import (
    SHAPES,
    Array,
    Boundary,
    Box,
    Domain,
    Index,
    Mask,
    Mesh,
    Part,
    Polygon,
    ProblemError,
    corners_of,
)
from msvalidate.problem.checks import format_value
from msvalidate.problem.shapes import FACETS

ARC = 32
"""Number of straight pieces that approximate a curved side.

Their area error is about 1e-4 of the area between the side and its chord.
"""
TOUCHED = 1e-9
"""Relative distance within which a line touches the side or corner of a square."""
NO_PRISM = 1e-3
"""Largest relative deviation of a prism's volume from base × height.

It exceeds the error of the approximation of curved sides.
"""


def outline(domain: Domain) -> shapely.Geometry:
    """Area of a 2D body, or base of a 3D prism, as a shapely geometry.

    Raises `ProblemError` if the body has no one outline.
    """
    if isinstance(domain, Box):
        return shapely.box(0.0, 0.0, *domain.size[:2])
    if isinstance(domain, Polygon):
        return shapely.Polygon(domain.corners)
    if not isinstance(domain, Mesh):
        raise ProblemError(f"outline: a {format_value(domain)}; give a Box, a Polygon or a Mesh")
    sides = domain.surface if domain.dim == 2 else _rim(domain)
    lines = _straight_lines(domain.points[sides][..., :2]).reshape(-1, 2, 2)
    area = shapely.build_area(shapely.multilinestrings(lines))
    if domain.dim == 3:
        _refuse_no_prism(domain, area)
    return area


def _straight_lines(sides: Array) -> Array:
    """Ends (f, pieces, 2, 2) in m of straight pieces of sides (f, 2, 2), or bent ones (f, 3, 2)."""
    if sides.shape[1] == 2:
        return sides[:, None]
    s = np.linspace(0, 1, ARC + 1)
    places = SHAPES["line3"].values(s[:, None]) @ sides
    return np.stack([places[:, :-1], places[:, 1:]], axis=2)


def outline_gap(domain: Domain) -> float:
    """Area (m²) between curved sides of an outline and their straight pieces.

    Two thirds of sagitta times chord, and that less n² times for n pieces (Archimedes).
    """
    if not isinstance(domain, Mesh):
        return 0.0
    sides = domain.surface if domain.dim == 2 else _rim(domain)
    if sides.shape[1] == 2:
        return 0.0
    a, b, middle = np.moveaxis(domain.points[sides][..., :2], 1, 0)
    along, off = b - a, middle - (a + b) / 2
    area = np.abs(along[:, 0] * off[:, 1] - along[:, 1] * off[:, 0]) * 2 / 3
    # Off the straight line by no more than rounding, a side is straight.
    length = np.linalg.norm(along, axis=1)
    return float(area[area > domain.tolerance * length].sum() / ARC**2)


def _rim(mesh: Mesh) -> Index:
    """Nodes (f, 2 or 3) of the rim of a solid's base.

    The base consists of the facets where z is least. Raises `ProblemError` if no facet lies flat
    there.
    """
    z = mesh.points[mesh.surface][..., 2]
    base = mesh.surface[(z <= mesh.span[2][0] + mesh.tolerance).all(axis=1)]
    if not len(base):
        raise ProblemError(f"outline: {mesh} has no flat base where z is least; give a prism")
    ends = FACETS[3, base.shape[1]].facets
    sides = base[:, ends].reshape(-1, ends.shape[1])
    _, first, times = np.unique(
        np.sort(sides[:, :2], axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(sides[first[times == 1]])


def _refuse_no_prism(mesh: Mesh, base: shapely.Geometry) -> None:
    low, high = mesh.span[2]
    if abs(mesh.volume - base.area * (high - low)) > NO_PRISM * mesh.volume:
        raise ProblemError(
            f"outline: {mesh}, {mesh.volume:g} m³, is no prism along z: its base has "
            f"{base.area:g} m² and it is {high - low:g} m high; give one"
        )


def area_moments(body: shapely.Geometry, low: Array, side: float) -> Array:
    """Integrals (c, 2, 2) over the body's part of each square, relative to its area.

    Entry [i, j] is that of N_i(ξ) N_j(η), with N_0(s) = 1 - s and N_1(s) = s, and ξ and η from 0 to
    1 along a square's sides, from the corner `low` (c, 2) in m to `side` (m) further: the area that
    belongs to each of its corners, 1/4 of a square inside. Exact for a body with straight edges: by
    Green's theorem round the edges of what is cut out.
    """
    squares = shapely.box(*low.T, *(low + side).T)
    shapely.prepare(body)
    inside = shapely.contains_properly(body, squares)
    found = np.where(inside[:, None, None], 0.25, np.zeros((1, 2, 2)))
    (cut,) = np.nonzero(~inside & shapely.intersects(body, squares))
    if len(cut):
        found[cut] = _moments(shapely.intersection(body, squares[cut]), low[cut], side)
    return np.asarray(found)


def is_outside(body: shapely.Geometry, points: Array, tolerance: float) -> Mask:
    """Mask (n,) of the points (n, 2) outside a body by more than `tolerance` (m)."""
    return np.asarray(shapely.distance(body, shapely.points(points)) > tolerance)


def straight_pieces(part: Part, domain: Domain) -> Array:
    """Ends (q, 2, 2) in m of the straight pieces of part of an outline.

    In space the part is one of a mesh's walls.

    Raises `ProblemError` if it is no part of the body's sides.
    """
    if isinstance(domain, Mesh):
        places = part.places if isinstance(part, Boundary) else domain.part(part).places
        if domain.dim == 3:  # of walls, the lines that they stand on and end at
            if (np.ptp(places[..., 2], axis=1) <= domain.tolerance).any():
                raise ProblemError(f"{part}: some of its facets lie across z; give walls alone")
            ends = FACETS[3, places.shape[1]].facets
            places = places[:, ends].reshape(-1, ends.shape[1], 3)
        lines = _straight_lines(places[..., :2]).reshape(-1, 2, 2)
        long = np.linalg.norm(lines[:, 1] - lines[:, 0], axis=1) > domain.tolerance
        return np.asarray(lines[long])
    corners = corners_of(part, domain)
    if len(corners) != 2:
        raise ProblemError(f"{part}: no line on the outline; give a side, or a part of one")
    return corners[None]


def crossed_cells(pieces: Array, low: Array, side: float) -> Index:
    """Indices of the grid squares that lines (q, 2, 2) cross.

    The low corners of the squares are (c, 2), in m.

    Or touch: rounding would decide whether a line through a corner meets the squares beside it.
    """
    room = TOUCHED * side
    squares = shapely.STRtree(shapely.box(*(low - room).T, *(low + (side + room)).T))
    return np.unique(squares.query(shapely.linestrings(pieces), predicate="intersects")[1])


def _moments(pieces: Array, low: Array, side: float) -> Array:
    """Integrals, as of `area_moments`, over areas with straight edges: one for each square."""
    polygons, owner = _polygons(pieces)
    rings, of_polygon = shapely.get_rings(polygons, return_index=True)
    hole = np.concatenate([[False], of_polygon[1:] == of_polygon[:-1]])[: len(rings)]
    places, ring = shapely.get_coordinates(rings, return_index=True)
    square = owner[of_polygon[ring]]
    xi, eta = ((places - low[square]) / side).T
    edge = np.flatnonzero(ring[1:] == ring[:-1])
    x0, y0, x1, y1 = xi[edge], eta[edge], xi[edge + 1], eta[edge + 1]
    cross = x0 * y1 - x1 * y0
    terms = (
        cross / 2,
        cross * (x0 + x1) / 6,
        cross * (y0 + y1) / 6,
        cross * (2 * x0 * y0 + x0 * y1 + x1 * y0 + 2 * x1 * y1) / 24,
    )
    # A ring may run either way round; its area is positive unless it bounds a hole.
    turn = np.sign(np.bincount(ring[edge], terms[0], len(rings))) * np.where(hole, -1.0, 1.0)
    one, x, y, xy = (
        np.bincount(square[edge], turn[ring[edge]] * term, len(pieces)) for term in terms
    )
    corners = np.array([[one - x - y + xy, y - xy], [x - xy, xy]])
    return np.asarray(np.maximum(corners.transpose(2, 0, 1), 0.0))


def _polygons(pieces: Array) -> tuple[Array, Index]:
    """The polygons that areas consist of, and which area each belongs to; lines are left out."""
    parts, owner = shapely.get_parts(pieces, return_index=True)
    is_area: Mask = shapely.get_type_id(parts) == shapely.GeometryType.POLYGON
    return parts[is_area], owner[is_area]
