"""Shapes of cells and facets: reference nodes, maps, areas and point location.

Nodes are numbered as in VTK (and meshio): corners, mid-sides, middles of faces, the middle.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import cached_property
from itertools import product

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem.arrays import Array, Index, Mask
from msvalidate.problem.records import dataclass

GAUSS = {1: 11, 2: 6}
"""Gauss points along each axis of an edge and of a face.

Volumes of quadratic cells (degree 5) are then exact; a strongly curved edge is accurate to 1e-10.
"""
NEWTON_STEPS = 30
"""Maximum number of Newton steps for the inverse map of a cell."""
AT_REST, SINGULAR = 1e-12, 1e-15
"""Convergence limit of the inverse map in the unit cell, and its regularisation."""
AT_ONCE = 20_000
"""Number of pairs of points and cells per batch (40 MB with 27 nodes)."""


@dataclass(frozen=True, eq=False)
class Shape:
    """A cell or facet: `corners` corner nodes, then what lies between them.

    Parameters
    ----------
    name
        meshio's.
    nodes
        (k, dim) places of the nodes in the unit simplex or cube.
    corners
        Number of corners.
    rings
        Corners of each facet, counter-clockwise as seen from outside.
    simplex
        Whether a line (of one axis), triangle or tetrahedron; else a square or cube.
    degree
        1 of straight sides, 2 with mid-sides. Squares and cubes of degree 2 may lack their middles
        (serendipity).
    """

    name: str
    nodes: Array
    corners: int
    rings: tuple[tuple[int, ...], ...]
    simplex: bool
    degree: int

    @property
    def dim(self) -> int:
        """Number of axes of the unit cell: 1 (edge), 2 (face) or 3 (solid)."""
        return int(self.nodes.shape[1])

    @cached_property
    def facets(self) -> Index:
        """Nodes (facets, k) of each facet, corners first, in the order of its shape."""
        ring = np.array(self.rings)
        if self.degree == 1:
            return ring
        return np.array([self._with_middles(corners) for corners in ring])

    @property
    def facet(self) -> Shape:
        """The shape of its facets."""
        return FACETS[self.dim, self.facets.shape[1]]

    @property
    def straight(self) -> Shape:
        """The shape of the corners alone."""
        return SHAPES[self.name.rstrip("0123456789")]

    def _with_middles(self, ring: Index) -> list[int]:
        """Corners of a facet, the middles of its edges, and its own where it has one."""
        following = np.roll(ring, -1)
        groups = [ring] if len(ring) == 2 else list(np.column_stack([ring, following]))
        if len(ring) == 4:
            groups.append(ring)
        middles = [self.nodes[group].mean(axis=0) for group in groups]
        apart = [np.abs(self.nodes - middle).sum(axis=1) for middle in middles]
        there = [int(distance.argmin()) for distance in apart if distance.min() == 0]
        return [*ring.tolist(), *there]

    @cached_property
    def powers(self) -> Index:
        """Exponents (k, dim) of the monomials that the shape functions are made of."""
        every = product(range(self.degree + 1), repeat=self.dim)
        if self.simplex:
            return np.array([p for p in every if sum(p) <= self.degree])
        if len(self.nodes) == (self.degree + 1) ** self.dim:
            return np.array(list(every))
        # Serendipity: of degree 2 but for linear factors [ArnoldAwanou2011].
        return np.array([p for p in every if sum(q for q in p if q > 1) <= self.degree])

    @cached_property
    def _coefficients(self) -> Array:
        return np.asarray(np.linalg.inv(_monomials(self.nodes, self.powers)), dtype=float)

    def values(self, places: Array) -> Array:
        """Shape functions (q, k) at places (q, dim) of the unit cell."""
        return np.asarray(_monomials(places, self.powers) @ self._coefficients)

    def slopes(self, places: Array) -> Array:
        """Derivatives (q, k, dim) of the shape functions at places (q, dim)."""
        parts = []
        for axis in range(self.dim):
            lowered = self.powers.copy()
            lowered[:, axis] = np.maximum(lowered[:, axis] - 1, 0)
            monomials = self.powers[:, axis] * _monomials(places, lowered)
            parts.append(monomials @ self._coefficients)
        return np.stack(parts, axis=2)

    @cached_property
    def bulge(self) -> float:
        """Largest distance of the map beyond its nodes, as a multiple of their distance.

        The largest sum of the shape functions' magnitudes (Lebesgue's constant), from any place:
        5/4 on a line with a middle, 3 in a square without.
        """
        if self.degree == 1:
            return 1.0
        # Of all these it is largest at halves, thirds or quarters of the unit cell.
        at = np.array(list(product(np.linspace(0.0, 1.0, 13), repeat=self.dim)))
        return float(np.abs(self.values(self.clipped(at))).sum(axis=1).max())

    @property
    def middle(self) -> Array:
        """The middle (dim,) of the unit cell."""
        return np.asarray(self.nodes[: self.corners].mean(axis=0))

    def clipped(self, places: Array) -> Array:
        """The places (q, dim), those outside the unit cell moved onto it."""
        inside = np.clip(places, 0.0, 1.0)
        if self.simplex:
            inside /= np.maximum(inside.sum(axis=1, keepdims=True), 1.0)
        return np.asarray(inside)

    @cached_property
    def quadrature(self) -> tuple[Array, Array]:
        """Places (q, dim) and weights (q,) of Gauss's rule, for any shape but tetrahedra.

        The rule of a triangle is that of a square, collapsed: with x = s, y = (1 - s) t the unit
        area of the square becomes 1 - s [Duffy1982].
        """
        x, w = np.polynomial.legendre.leggauss(GAUSS[self.dim])
        x, w = (x + 1) / 2, w / 2
        grid = np.array(list(product(x, repeat=self.dim)))
        weight = np.array([math.prod(each) for each in product(w, repeat=self.dim)])
        if self.simplex and self.dim == 2:
            s, t = grid.T
            return np.column_stack([s, (1 - s) * t]), weight * (1 - s)
        return grid, weight

    @cached_property
    def bernstein(self) -> tuple[Array, Array]:
        """Places (q, dim) and matrix (q, q) from a Jacobian's values there to its coefficients.

        A polynomial lies between the least and the largest of its Bernstein coefficients.
        """
        dim, p = self.dim, self.degree
        if self.simplex:
            order = dim * (p - 1)
            every = product(range(order + 1), repeat=dim)
            index = np.array([[*a, order - sum(a)] for a in every if sum(a) <= order])
            many = [math.factorial(order) / math.prod(map(math.factorial, a)) for a in index]
            places = index[:, :dim] / order if order else np.full((1, dim), 1 / (dim + 1))
            whole = np.column_stack([places, 1 - places.sum(axis=1)])
            matrix = np.array(many) * _monomials(whole, index)
        else:
            order = dim * p - 1
            index = np.array(list(product(range(order + 1), repeat=dim)))
            places = index / order
            many = [math.prod(math.comb(order, i) for i in a) for a in index]
            matrix = np.array(many) * _monomials(places, index)
            matrix *= _monomials(1 - places, order - index)
        return np.asarray(places), np.asarray(np.linalg.inv(matrix), dtype=float)


def _monomials(places: Array, powers: Index) -> Array:
    """Products (q, k) of the coordinates (q, dim) to the powers (k, dim)."""
    return np.asarray(np.prod(places[:, None, :] ** powers, axis=2))


def _shapes(
    corners: Sequence[tuple[int, ...]],
    rings: Sequence[tuple[int, ...]],
    names: Mapping[str, Sequence[tuple[int, ...]]],
) -> list[Shape]:
    """Shapes of the same corners, by meshio's names: each with middles of some groups of them."""
    straight = np.array(corners, dtype=float)
    simplex = len(corners) == straight.shape[1] + 1
    found = []
    for name, groups in names.items():
        middles = [straight[list(group)].mean(axis=0) for group in groups]
        nodes = np.array([*straight, *middles])
        found.append(Shape(name, nodes, len(corners), tuple(rings), simplex, 2 if groups else 1))
    return found


_TRIANGLE = [(0, 1), (1, 2), (2, 0)]
_SQUARE = [(0, 1), (1, 2), (2, 3), (3, 0)]
_TETRAHEDRON = [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]
_CUBE = [(0, 4, 7, 3), (1, 2, 6, 5), (0, 1, 5, 4), (3, 7, 6, 2), (0, 3, 2, 1), (4, 5, 6, 7)]
_CUBE_EDGES = [*_SQUARE, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_UNIT_CUBE = [(x, y, z) for z in (0, 1) for x, y in [(0, 0), (1, 0), (1, 1), (0, 1)]]

SHAPES = {
    shape.name: shape
    for family in (
        _shapes([(0,), (1,)], [(0,), (1,)], {"line": [], "line3": [(0, 1)]}),
        _shapes([(0, 0), (1, 0), (0, 1)], _TRIANGLE, {"triangle": [], "triangle6": _TRIANGLE}),
        _shapes(
            [(0, 0), (1, 0), (1, 1), (0, 1)],
            _SQUARE,
            {"quad": [], "quad8": _SQUARE, "quad9": [*_SQUARE, (0, 1, 2, 3)]},
        ),
        _shapes(
            [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)],
            _TETRAHEDRON,
            {"tetra": [], "tetra10": [*_TRIANGLE, (0, 3), (1, 3), (2, 3)]},
        ),
        _shapes(
            _UNIT_CUBE,
            _CUBE,
            {"hexahedron": [], "hexahedron27": [*_CUBE_EDGES, *_CUBE, tuple(range(8))]},
        ),
    )
    for shape in family
}
CELLS = tuple(name for name, shape in SHAPES.items() if shape.dim > 1)
"""Names of what a mesh may consist of."""
FACETS = {(shape.dim + 1, len(shape.nodes)): shape for shape in SHAPES.values() if shape.dim < 3}
"""Shape of a facet by (number of axes, number of nodes)."""
STRAIGHT = {(shape.dim, shape.corners): shape for shape in SHAPES.values() if shape.degree == 1}
"""The shape of straight cells by their number of axes and of corners."""


def map_facets(places: Array, at: Array) -> tuple[Array, Array]:
    """Map positions of the unit facet to facets, with outward area vectors.

    `places` (f, k, d) in m are the nodes of the facets. They run counter-clockwise as seen from
    outside; in 2D they run counter-clockwise round the body. `at` are positions of the unit facet
    with e = d - 1 coordinates: (q, e) for all facets, or (f, q, e) for each its own.

    Returns the positions (f, q, d) in m and the outward area vectors (f, q, d), in m or m² per unit
    of the unit facet.
    """
    shape, flat = FACETS[places.shape[2], places.shape[1]], at.reshape(-1, at.shape[-1])
    values = shape.values(flat).reshape(*at.shape[:-1], -1)
    slopes = shape.slopes(flat).reshape(*values.shape, shape.dim)
    along = [slopes[..., axis] @ places for axis in range(shape.dim)]
    if shape.dim == 1:
        return values @ places, np.stack([along[0][..., 1], -along[0][..., 0]], axis=-1)
    return values @ places, np.cross(along[0], along[1])


def area_vectors(places: Array) -> tuple[Array, Array]:
    """Compute Gauss points (f, q, d) in m of facets and their outward area vectors.

    The facets have nodes (f, k, d) in m.

    The vectors (f, q, d), in m or m², hold the weights: they sum to integrals.
    """
    at, weights = FACETS[places.shape[2], places.shape[1]].quadrature
    x, normal = map_facets(places, at)
    return x, normal * weights[:, None]


def enclosed_volume(places: Array) -> float:
    """Compute the area (m²) or volume (m³) that closed facets (f, k, d) enclose.

    It is ∮ x·n dA / d by the divergence theorem, and exact.
    """
    middle = places.mean(axis=(0, 1))
    x, normal = area_vectors(places - middle)
    return float(np.einsum("fqd,fqd->", x, normal) / places.shape[2])


def facet_areas(places: Array) -> Array:
    """Compute the length (m) or area (m²) of facets (f, k, d) by Gauss quadrature."""
    _, normal = area_vectors(places)
    return np.asarray(np.linalg.norm(normal, axis=2).sum(axis=1))


def facet_middles(places: Array) -> Array:
    """Midpoints (f, d) in m of facets (f, k, d), straight or curved."""
    shape = FACETS[places.shape[2], places.shape[1]]
    return np.asarray((shape.values(shape.middle[None]) @ places)[:, 0])


def incident_pairs(
    shape: Shape, places: Array, points: Array, tolerance: float
) -> tuple[Index, Index]:
    """Find the pairs of a cell or facet and a point within `tolerance` (m).

    The cells or facets have nodes (f, k, d), the points are (n, d); the pairs are two arrays (p,).

    A tree of the points names those near each cell; Newton's steps then look for the place of the
    unit cell that is mapped there (Gauss's and Newton's where a facet has fewer axes than space).
    """
    if not len(points):
        return np.empty(0, dtype=np.intp), np.empty(0, dtype=np.intp)
    middle = places.mean(axis=1)
    reach = shape.bulge * np.linalg.norm(places - middle[:, None], axis=2).max(axis=1)
    near = KDTree(points).query_ball_point(middle, reach * (1 + 1e-9) + tolerance)
    cell = np.repeat(np.arange(len(places)), [len(each) for each in near])
    point = np.fromiter((i for each in near for i in each), dtype=np.intp, count=len(cell))
    meets = np.zeros(len(cell), dtype=bool)
    for start in range(0, len(cell), AT_ONCE):
        part = slice(start, start + AT_ONCE)
        _, distance = _nearest_place(shape, places[cell[part]], points[point[part]])
        meets[part] = distance <= tolerance
    return cell[meets], point[meets]


def weights_at(shape: Shape, places: Array, points: Array, tolerance: float) -> tuple[Index, Array]:
    """Find the cell (n,) of each point, or -1, and its shape functions there.

    The cells have nodes (c, k, d), the points are (n, d), both in m.

    These are (n, k), at the place of the cell that is mapped to the point.
    """
    cell, point = incident_pairs(shape, places, points, tolerance)
    found = np.full(len(points), -1)
    found[point[::-1]] = cell[::-1]
    inside, weights = found >= 0, np.zeros((len(points), len(shape.nodes)))
    at, _ = _nearest_place(shape, places[found[inside]], points[inside])
    weights[inside] = shape.values(at)
    return found, weights


def is_on_any(shape: Shape, places: Array, points: Array, tolerance: float) -> Mask:
    """Mask (n,) of the points within `tolerance` (m) of any cell or facet.

    The points are (n, d), the cells or facets (f, k, d), in m.
    """
    found = np.zeros(len(points), dtype=bool)
    found[incident_pairs(shape, places, points, tolerance)[1]] = True
    return found


def project_on_facets(places: Array, points: Array) -> tuple[Array, Array]:
    """Project points on facets: coordinates (n, e) in the unit facet and distances.

    The points are (n, d), the distances (n,), in m.

    Each point has a facet of its own, with nodes (n, k, d) in m.
    """
    return _nearest_place(FACETS[places.shape[2], places.shape[1]], places, points)


def _nearest_place(shape: Shape, nodes: Array, x: Array) -> tuple[Array, Array]:
    """Nearest places (p, e) of the unit cell, and distance (p,) in m, exact where it is none."""
    at = np.tile(shape.middle, (len(x), 1))
    moving = np.arange(len(x))
    straight = shape.simplex and shape.degree == 1  # the first step gets there, whatever clips it
    for _ in range(1 if straight else NEWTON_STEPS):
        if not len(moving):
            break
        step = _newton_step(shape, nodes[moving], x[moving], at[moving])
        # Far outside the map may have no inverse.
        after = np.clip(at[moving] + step, -0.5, 1.5)
        still = np.abs(after - at[moving]).max(axis=1) <= AT_REST
        at[moving] = after
        moving = moving[~still]
    inside = shape.clipped(at)
    miss = x - np.einsum("pk,pkd->pd", shape.values(inside), nodes)
    return inside, np.asarray(np.linalg.norm(miss, axis=1))


def _newton_step(shape: Shape, nodes: Array, x: Array, at: Array) -> Array:
    """Newton's step (p, dim), of least squares, from places of the unit cell towards points."""
    miss = x - np.einsum("pk,pkd->pd", shape.values(at), nodes)
    along = np.einsum("pke,pkd->ped", shape.slopes(at), nodes)
    square = np.einsum("ped,pfd->pef", along, along)
    square += SINGULAR * np.einsum("pee->p", square)[:, None, None] * np.eye(shape.dim)
    wanted = np.einsum("ped,pd->pe", along, miss)
    return np.asarray(np.linalg.solve(square, wanted[..., None])[..., 0])
