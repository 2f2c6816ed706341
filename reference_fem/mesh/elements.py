"""Finite elements, a row of `ELEMENTS` each: all that is known by an element's name stands here.

Nodes are in VTK order. Modules and tests ask the rows, so that a new element is a new row, and one
of `msvalidate.problem.shapes` where a mesh may consist of its cells.
"""

from __future__ import annotations

from functools import cached_property
from itertools import permutations
from typing import Any

import numpy as np
import skfem
from skfem.element import BOUNDARY_ELEMENT_MAP

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass

Rings = tuple[tuple[int, ...], ...]
CURVED_ORDER = 4
"""Degree integrated exactly in cells with curved sides, whose gradients are no polynomials."""


@dataclass(frozen=True)
class Element:
    """A finite element: its cells in VTK order start with their corners.

    Parameters
    ----------
    name, shape
        Its name, and meshio's of its cells: a row of `msvalidate.problem.SHAPES`.
    complete
        Degree of the polynomials that it holds on any cells with straight edges. Below `degree` the
        error in the mean falls by an order less on cells that are no parallelograms
        [ArnoldBoffiFalk2002].
    function, mesh
        The library's element, and its mesh of such cells.
    faces
        Corners of its sides, each counter-clockwise as seen from outside.
    order
        The corners as the library lists them.
    block
        The cells that one block of a box's grid is cut into: the corners (x, y) or (x, y, z), each
        0 or 1, of each.
    most_nodes
        Nodes of a mesh beyond which none is made: what 16 GB hold, as measured.
    middles
        The corners that each further node lies amid.
    """

    name: str
    shape: str
    complete: int
    function: Any
    mesh: Any
    faces: Rings
    order: tuple[int, ...]
    block: tuple[Rings, ...]
    most_nodes: int
    middles: Rings = ()

    @property
    def degree(self) -> int:
        """Polynomial degree on parallelograms, parallelepipeds and simplices."""
        return 2 if self.middles else 1

    @property
    def integration_order(self) -> int:
        """Polynomial degree integrated exactly in cells with straight edges.

        The library's default is far higher: it costs several times as much and differs from the
        usual Gauss rules.
        """
        return self.degree if self.simplex else 2 * self.degree

    @cached_property
    def linear(self) -> Any:
        """The library's element of the corners alone."""
        return self.mesh.elem()

    @cached_property
    def side(self) -> Any:
        """The library's element of its sides."""
        return BOUNDARY_ELEMENT_MAP.get(type(self.function), skfem.ElementLineP2)()

    @property
    def dim(self) -> int:
        """Number of axes."""
        return len(self.block[0][0])

    @property
    def corners(self) -> int:
        """Number of corners of a cell."""
        return len(self.order)

    @property
    def nodes(self) -> int:
        """Number of nodes of a cell."""
        return self.corners + len(self.middles)

    @property
    def simplex(self) -> bool:
        """True for triangles and tetrahedra."""
        return self.corners == self.dim + 1

    @property
    def locks(self) -> bool:
        """Return True if coarse meshes show volumetric locking.

        Of the first degree they do (`locking`); of the second they lose an order at most.
        """
        return self.degree == 1

    @property
    def first(self) -> Element:
        """The element of the first degree on cells of the same corners."""
        return next(kind for kind in ELEMENTS.values() if kind.mesh is self.mesh)

    @property
    def raised(self) -> tuple[str, ...]:
        """Names of the elements of the second degree on cells of the same corners."""
        same = (kind for kind in ELEMENTS.values() if kind.mesh is self.mesh)
        return tuple(kind.name for kind in same if kind.degree == 2)

    @cached_property
    def means(self) -> Array:
        """Matrix (nodes, corners) that takes corners to the nodes of a cell with straight edges."""
        rows = [[float(i == j) for i in range(self.corners)] for j in range(self.corners)]
        rows += [
            [float(i in amid) / len(amid) for i in range(self.corners)] for amid in self.middles
        ]
        return np.array(rows)

    @cached_property
    def places(self) -> Array:
        """Local coordinates (nodes, d) of the nodes in VTK order."""
        corners = np.asarray(self.function.doflocs)[np.argsort(self.order, kind="stable")]
        return np.asarray(self.means @ corners)

    @cached_property
    def listed(self) -> Index:
        """Node, in VTK order, of each of the library's functions on a cell."""
        apart = np.asarray(self.function.doflocs)[:, None] - self.places
        return np.asarray(np.abs(apart).sum(axis=2).argmin(axis=1))

    @cached_property
    def in_block(self) -> tuple[Index, ...]:
        """Places (nodes, d) of each cell's nodes in a block, in steps of the grid of all nodes."""
        cells = (np.round(self.degree * self.means @ np.array(each)) for each in self.block)
        return tuple(places.astype(int) for places in cells)

    @cached_property
    def facets(self) -> Rings:
        """Nodes of its sides: the corners in their ring, the mid-sides in theirs, the centre."""
        number = {frozenset(amid): self.corners + i for i, amid in enumerate(self.middles)}

        def nodes(ring: tuple[int, ...]) -> tuple[int, ...]:
            edges = zip(ring, (*ring[1:], ring[0]), strict=True)
            wanted = [frozenset(edge) for edge in edges][: 1 if self.dim == 2 else None]
            if self.dim == 3:
                wanted.append(frozenset(ring))
            return (*ring, *(number[amid] for amid in wanted if amid in number))

        return tuple(nodes(ring) for ring in self.faces)

    def functions(self, local: Array) -> tuple[Array, Array]:
        """Values (nodes, q) and slopes (nodes, d, q) of its functions at local coordinates (q, d).

        In the library's order.
        """
        found = [self.function.lbasis(local.T, i) for i in range(self.nodes)]
        value = [np.broadcast_to(each[0], len(local)) for each in found]
        slope = [np.broadcast_to(each[1], (self.dim, len(local))) for each in found]
        return np.array(value), np.array(slope)

    def in_library_order(self, cells: Index) -> Index:
        """The cells (c, nodes) in VTK order, as the library lists their nodes.

        It turns simplices so that the numbers of their corners rise.
        """
        if not self.simplex:
            return cells[:, self.listed]
        turn = np.argsort(cells[:, : self.corners], axis=1, kind="stable")
        amid = np.zeros((self.corners, self.corners), dtype=np.intp)
        for i, (a, b) in enumerate(self.middles):
            amid[a, b] = amid[b, a] = self.corners + i
        pairs = [self.middles[k - self.corners] for k in self.listed[self.corners :]]
        columns = [turn, *(amid[turn[:, a], turn[:, b]][:, None] for a, b in pairs)]
        return np.take_along_axis(cells, np.concatenate(columns, axis=1), axis=1)


TRIANGLE = ((0, 1), (1, 2), (2, 0))
SQUARE = ((0, 1), (1, 2), (2, 3), (3, 0))
TETRAHEDRON = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))
CUBE = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (0, 4, 7, 3))
# Listed so, the corners have in the library's unit cube the coordinates that VTK gives them.
CUBE_ORDER = (6, 2, 5, 7, 1, 3, 4, 0)
RISING = (0, 1, 2, 3)
AMID_SQUARE = (*SQUARE, RISING)
AMID_TETRAHEDRON = (*TRIANGLE, (0, 3), (1, 3), (2, 3))
# VTK's triquadratic hexahedron: twelve edges, the faces across x, y and z (low, high), the centre.
CUBE_EDGES = (*SQUARE, (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7))
CUBE_FACES = (CUBE[5], CUBE[3], CUBE[2], CUBE[4], CUBE[0], CUBE[1])
AMID_CUBE = (*CUBE_EDGES, *CUBE_FACES, tuple(range(8)))


UNIT_SQUARE = ((0, 0), (1, 0), (1, 1), (0, 1))
UNIT_CUBE = tuple((x, y, z) for z in (0, 1) for x, y in UNIT_SQUARE)
# Cut along the diagonal that rises to the right.
HALVES = (((0, 0), (1, 0), (1, 1)), ((0, 0), (1, 1), (0, 1)))


def _six_tetrahedra() -> tuple[Rings, ...]:
    """The six that share a unit cube's rising diagonal [Kuhn1960].

    Each goes from the lowest corner to the highest along three edges, one for each order of axes.
    """
    found = []
    for first, second, third in permutations(np.eye(3, dtype=int)[::-1]):  # along z first
        path = [0 * first, first, first + second, first + second + third]
        if np.linalg.det([first, second, third]) < 0:
            path[1], path[2] = path[2], path[1]
        found.append(tuple(tuple(place.tolist()) for place in path))
    return tuple(found)


MOST_IN_PLANE, MOST_IN_SPACE, MOST_OF_H2 = 4_000_000, 1_000_000, 400_000
"""Nodes: assembly takes 4 kB for each in the plane (Q2) and 15 kB in space (H1), as measured, so
that 16 GB hold these; of H2 40 kB, as each shares a cell with 60 others."""

_QUADRILATERAL = (skfem.MeshQuad, SQUARE, RISING, (UNIT_SQUARE,), MOST_IN_PLANE)
_TRIANGLE = (skfem.MeshTri, TRIANGLE, RISING[:3], HALVES, MOST_IN_PLANE)
_HEXAHEDRON = (skfem.MeshHex, CUBE, CUBE_ORDER, (UNIT_CUBE,))
_TETRAHEDRON = (skfem.MeshTet, TETRAHEDRON, RISING, _six_tetrahedra(), MOST_IN_SPACE)

ELEMENTS = {
    element.name: element
    for element in (
        Element("Q1", "quad", 1, skfem.ElementQuad1(), *_QUADRILATERAL),
        Element("Q2", "quad9", 2, skfem.ElementQuad2(), *_QUADRILATERAL, AMID_SQUARE),
        # Serendipity: without x²y², so that in cells that are no parallelograms it holds planes
        # alone. Near nu = 1/2 it errs as Q2 does in parallelograms, twice as much in others; mixed
        # (S2-Q1) as Q2-Q1.
        Element("S2", "quad8", 1, skfem.ElementQuadS2(), *_QUADRILATERAL, SQUARE),
        Element("P1", "triangle", 1, skfem.ElementTriP1(), *_TRIANGLE),
        Element("P2", "triangle6", 2, skfem.ElementTriP2(), *_TRIANGLE, TRIANGLE),
        Element("H1", "hexahedron", 1, skfem.ElementHex1(), *_HEXAHEDRON, MOST_IN_SPACE),
        Element("H2", "hexahedron27", 2, skfem.ElementHex2(), *_HEXAHEDRON, MOST_OF_H2, AMID_CUBE),
        Element("T1", "tetra", 1, skfem.ElementTetP1(), *_TETRAHEDRON),
        Element("T2", "tetra10", 2, skfem.ElementTetP2(), *_TETRAHEDRON, AMID_TETRAHEDRON),
    )
}


def of_dimension(dim: int) -> list[str]:
    """Names of the elements of so many axes."""
    return [name for name, kind in ELEMENTS.items() if kind.dim == dim]


def of_shape(shape: str) -> Element:
    """The element that has the nodes of a mesh's cells, named as in `msvalidate.problem.SHAPES`."""
    return next(kind for kind in ELEMENTS.values() if kind.shape == shape)
