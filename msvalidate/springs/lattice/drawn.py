"""The surface of a solid drawn by flat triangles: exact where its facets are flat.

Facets with straight edges in one plane are drawn as they are. All others are cut into n x n equal
parts of the unit facet, with n the same for all, so that neighbours keep their common edge, and as
large as the error asked for needs: what lies between a quadratic facet and its triangles falls as
1/n². On the middle of an edge of a triangle the distance d from the facet is measured; a quadratic
facet then lies Σ 4 d_ij λ_i λ_j from the triangle, the mean of d over its edges on average.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Domain, Index, Mask, Mesh, facet_areas
from msvalidate.problem.checks import refuse_too_many
from msvalidate.problem.records import dataclass
from msvalidate.problem.shapes import FACETS, SHAPES, Shape, area_vectors

MOST_TRIANGLES = 2_000_000
"""Maximum number of flat triangles that approximate a surface.

They take 150 MB, and 600 MB while they are made.
"""


@dataclass(frozen=True, eq=False)
class DrawnSurface:
    """Flat triangles that stand for facets.

    Their corners (t, 3, 3) in m run counter-clockwise as seen from outside; each is part of a
    `facet` (t,). `gap` is the volume (m³) between the facets and the triangles, each side of a
    facet counted positive.
    """

    corners: Array
    facet: Index
    gap: float


def draw_surface(
    places: Array, tolerance: float, *, gap: float = np.inf, away: float = np.inf
) -> DrawnSurface:
    """Draw facets (f, k, 3) in m by flat triangles.

    Facets off a plane and straight edges by no more than `tolerance` (m) count as flat. Between
    others and their triangles lies no more than a volume `gap` (m³), and the middles of edges are
    no further `away` (m).

    Raises `ProblemError` if that takes too many triangles.
    """
    shape = FACETS[3, places.shape[1]]
    flat = _is_flat(shape, places, tolerance)
    corners, facet = _split_flat(shape, places, np.flatnonzero(flat))
    if flat.all():
        return DrawnSurface(corners, facet, 0.0)
    bent = np.flatnonzero(~flat)
    n, drawn, between = _draw_bent_enough(shape, places[bent], gap, away, len(corners))
    owner = np.repeat(bent, len(_unit_triangles(shape, n)))
    return DrawnSurface(np.concatenate([corners, drawn]), np.r_[facet, owner], between)


def solid_facets(domain: Domain) -> Array:
    """Facets (f, k, 3) in m of a box or mesh, counter-clockwise from outside."""
    if isinstance(domain, Mesh):
        return np.asarray(domain.points[domain.surface])
    cube = SHAPES["hexahedron"]
    low, high = np.array(domain.span).T
    return np.asarray((low + (high - low) * cube.nodes)[cube.facets])


def true_areas(places: Array, surface: DrawnSurface) -> Array:
    """Area (t,) in m² that each triangle represents.

    The exact area of a facet is distributed in proportion to the areas of its triangles.
    """
    area = triangle_areas(surface.corners)
    wanted = facet_areas(places)
    found = np.bincount(surface.facet, area, len(places))
    return np.asarray(area * (wanted / found)[surface.facet])


def triangle_areas(corners: Array) -> Array:
    """Areas (t,) of triangles with corners (t, 3, 3)."""
    edges = corners[:, 1:] - corners[:, :1]
    return np.asarray(np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2)


def _is_flat(shape: Shape, places: Array, tolerance: float) -> Mask:
    """Facets (f,) whose edges are straight and lie in one plane."""
    k = shape.corners
    ends = places[:, :k]
    across = np.cross(ends[:, 2] - ends[:, 0], ends[:, -1] - ends[:, 1])
    if k == 3:
        across = np.cross(ends[:, 1] - ends[:, 0], ends[:, 2] - ends[:, 0])
    normal = across / np.linalg.norm(across, axis=1, keepdims=True)
    off_plane = np.abs(np.einsum("fkd,fd->fk", places - ends[:, :1], normal))
    flat = off_plane.max(axis=1) <= tolerance
    if shape.degree > 1:
        edge = np.roll(ends, -1, axis=1) - ends
        middle = places[:, k : 2 * k] - ends
        off_edge = np.linalg.norm(np.cross(edge, middle), axis=2) / np.linalg.norm(edge, axis=2)
        flat &= off_edge.max(axis=1) <= tolerance
    return np.asarray(flat)


def _split_flat(shape: Shape, places: Array, facet: Index) -> tuple[Array, Index]:
    """Triangles (t, 3, 3) of flat facets, which are convex, and their numbers (t,)."""
    rings = [[0, 1, 2]] if shape.corners == 3 else [[0, 1, 2], [0, 2, 3]]
    corners = places[facet][:, rings].reshape(-1, 3, 3)
    return corners, np.repeat(facet, len(rings))


def _draw_bent_enough(
    shape: Shape, places: Array, gap: float, away: float, flat: int
) -> tuple[int, Array, float]:
    """Number of subdivisions of each edge that keeps volume and distance errors small.

    With them the triangles (t, 3, 3), and the volume (m³) between.
    """
    n = 4
    while True:
        count = flat + len(places) * len(_unit_triangles(shape, 1)) * float(n) ** 2
        refuse_too_many("bent surface drawn", count, MOST_TRIANGLES, "flat triangles")
        corners, between, distance = _draw_bent(shape, places, n)
        over = max(between / gap, distance / away)
        if over <= 1:
            return n, corners, between
        # What is left falls as 1/n²; 2 % more saves most a second look.
        n = max(n + 1, int(np.ceil(min(n * np.sqrt(over), 1e4) * 1.02)))


def _draw_bent(shape: Shape, places: Array, n: int) -> tuple[Array, float, float]:
    """Triangles (t, 3, 3) of bent facets (f, k, 3), and the volume and distance between."""
    unit = _unit_triangles(shape, n)
    values = shape.values(unit.reshape(-1, 2))
    middles = (unit + np.roll(unit, -1, axis=1)) / 2
    corners = np.einsum("qk,fkd->fqd", values, places).reshape(-1, 3, 3)
    true = np.einsum("qk,fkd->fqd", shape.values(middles.reshape(-1, 2)), places)
    off = true.reshape(-1, 3, 3) - (corners + np.roll(corners, -1, axis=1)) / 2
    edges = corners[:, 1:] - corners[:, :1]
    normal = np.cross(edges[:, 0], edges[:, 1]) / 2
    apart = np.abs(np.einsum("ted,td->te", off, normal)).mean(axis=1)
    return corners, float(apart.sum()), float(np.linalg.norm(off, axis=2).max())


def _unit_triangles(shape: Shape, n: int) -> Array:
    """Corners (t, 3, 2) of the triangles that n parts of each edge make of the unit facet."""
    i, j = (each.ravel() for each in np.meshgrid(*[np.arange(n)] * 2, indexing="ij"))
    low, right, top, far = (
        np.stack([i + a, j + b], axis=1) for a, b in ((0, 0), (1, 0), (0, 1), (1, 1))
    )
    lower = np.stack([low, right, top], axis=1)
    upper = np.stack([right, far, top], axis=1)
    if shape.simplex:
        lower, upper = lower[i + j < n], upper[i + j < n - 1]
    return np.concatenate([lower, upper]) / n


def prism_layers(domain: Domain, spacing: float, base: float) -> int:
    """Number of layers of cells in a prism along z, or 0 if not whole.

    They begin at z = `base` (m). A prism's facets are flat where z is least or most, or stand along
    z.
    """
    low, high = domain.span[2]
    layers = round((high - low) / spacing)
    off = max(abs(base - low), abs(layers * spacing - (high - low)))
    if not layers or off > domain.tolerance:
        return 0
    if isinstance(domain, Mesh):
        places = domain.points[domain.surface]
        z = places[..., 2]
        ends = [(np.abs(z - end) <= domain.tolerance).all(axis=1) for end in (low, high)]
        _, normal = area_vectors(places)
        slope = np.abs(normal[..., 2]) / np.linalg.norm(normal, axis=2)
        standing = (slope <= 1e-9).all(axis=1)
        if not (ends[0] | ends[1] | standing).all():
            return 0
    return layers
