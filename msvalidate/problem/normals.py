"""Outward normals of a body's sides, and tractions that press along them."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array, triu
from scipy.spatial import KDTree

from msvalidate.problem.arrays import Array, Field, Index
from msvalidate.problem.checks import finite_number
from msvalidate.problem.domain import Box, Domain
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.loads import Traction
from msvalidate.problem.mesh import Mesh
from msvalidate.problem.region import Boundary, Part, Region
from msvalidate.problem.shapes import FACETS, map_facets, project_on_facets

BENT, MANY, PART_BENT = (0.5, 40.0), 6, 0.1
"""Range of angles (degrees) between facets of a curve; their minimum number and share."""
FLAT = 1e-9
"""Difference of normals below which a side is flat."""
CANDIDATES = 6
"""Facets whose middles are nearest to a place, of which one is the nearest."""
MISSED = 1e-2
"""Distance from the nearest candidate beyond which all facets are searched.

It is relative to the largest distance of that facet's nodes from their mean.
"""


def pressure(region: Part, domain: Domain, value: float) -> Traction:
    """Return the traction -p n of a pressure (Pa) on a side, positive inwards.

    Raises `ProblemError` if the pressure is not finite, or the part is not on the body's sides.
    """
    p = finite_number("pressure", value)
    places, normals = _facets(region, domain)
    if np.abs(normals - normals[0]).max() <= FLAT:
        return Traction(region, tuple((-p * normals[0]).tolist()))
    return Traction(region, _normal_field(places, -p))


def is_faceted(mesh: Mesh) -> bool:
    """Return True if straight facets seem to approximate a curved side.

    Many of them then meet at small angles.
    """
    if mesh.kind.degree > 1:
        return False
    normal = _normals(mesh.points[mesh.surface]).mean(axis=1)
    ridges = _ridges(mesh.surface, mesh.dim)
    cosine = np.clip(np.einsum("rd,rd->r", normal[ridges[:, 0]], normal[ridges[:, 1]]), -1, 1)
    angle = np.degrees(np.arccos(cosine))
    bent = (angle > BENT[0]) & (angle < BENT[1])
    return int(bent.sum()) >= MANY and float(bent.mean()) >= PART_BENT


def _ridges(facets: Index, dim: int) -> Index:
    """Pairs (r, 2) of facets that share a corner, in space an edge."""
    facet = np.repeat(np.arange(len(facets)), facets.shape[1])
    has = csr_array((np.ones(facets.size), (facet, facets.ravel())))
    common = triu(has @ has.T, k=1)
    beside = common.data == dim - 1
    return np.column_stack([common.row[beside], common.col[beside]])


def nearest_on_facets(places: Array, points: Array) -> tuple[Array, Array]:
    """Find the nearest positions (n, d) in m on facets and their distances (n,).

    The facets have nodes (f, k, d), the points are (n, d), both in m.
    """
    tree = KDTree(places.mean(axis=1))
    facet, distance, at = _nearest_facet(tree, places, points, CANDIDATES)
    return map_facets(places[facet], at[:, None])[0][:, 0], distance


def _facets(region: Part, domain: Domain) -> tuple[Array, Array]:
    """Nodes (f, k, d) in m of the facets of a part, and their unit normals outwards (m, d)."""
    if isinstance(domain, Mesh):
        part = region if isinstance(region, Boundary) else domain.part(region)
        return part.places, _normals(part.places).reshape(-1, domain.dim)
    corners = region.corners(domain.span)
    if isinstance(domain, Box):
        outward = corners.mean(axis=0) - np.array(domain.size) / 2
        if isinstance(region, Region) and region.is_facet:
            (axis,) = region.normal_axes
            return corners[None], np.sign(outward[axis]) * np.eye(domain.dim)[[axis]]
        along = corners[1] - corners[0]
        normal = np.array([[along[1], -along[0]]]) / np.linalg.norm(along)
        return corners[None], np.copysign(1.0, normal @ outward) * normal
    edge = domain.edge_with(corners)
    if edge is None:
        raise ProblemError(f"pressure on {region}: not on one side of the {domain}; name one side")
    along = edge[1] - edge[0]
    return edge[None], np.array([[along[1], -along[0]]]) / np.linalg.norm(along)


def _normals(places: Array) -> Array:
    """Unit normals (f, q, d) of facets (f, k, d) at Gauss's places and in the middle."""
    shape = FACETS[places.shape[2], places.shape[1]]
    return _unit_normals(places, np.vstack([shape.quadrature[0], shape.middle[None]]))


def _unit_normals(places: Array, at: Array) -> Array:
    """Unit normals (f, q, d) outwards of facets (f, k, d), at places as of `map_facets`."""
    normal = map_facets(places, at)[1]
    return np.asarray(normal / np.linalg.norm(normal, axis=2, keepdims=True))


def _normal_field(places: Array, factor: float) -> Field:
    """A factor times the normal of the nearest facet, as a field of points (n, d)."""
    tree = KDTree(places.mean(axis=1))
    size = np.linalg.norm(places - places.mean(axis=1, keepdims=True), axis=2).max(axis=1)

    def field(points: Array) -> Array:
        facet, distance, at = _nearest_facet(tree, places, points, CANDIDATES)
        (doubtful,) = np.nonzero(distance > MISSED * size[facet])
        if len(doubtful):  # facets of very unequal size: the middle of the right one is far
            found = _nearest_facet(tree, places, points[doubtful], len(places))
            facet[doubtful], at[doubtful] = found[0], found[2]
        return factor * _unit_normals(places[facet], at[:, None])[:, 0]

    return field


def _nearest_facet(
    tree: KDTree, places: Array, points: Array, many: int
) -> tuple[Index, Array, Array]:
    """Nearest facet (n,) of those whose middles are, its distance (n,) in m, and where (n, e).

    The place is one of the unit facet.
    """
    count = min(many, len(places))
    near = tree.query(points, k=np.arange(count) + 1)[1]
    best, least = np.zeros(len(points), dtype=np.intp), np.full(len(points), np.inf)
    where = np.zeros((len(points), places.shape[2] - 1))
    for facet in near.T:
        at, distance = project_on_facets(places[facet], points)
        better = distance < least
        where[better], least[better], best[better] = at[better], distance[better], facet[better]
    return best, least, where
