"""Finite elements: their nodes in VTK order, their sides, and what the library calls them."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import skfem

from msvalidate.problem import Array, Index

Rings = tuple[tuple[int, ...], ...]


@dataclass(frozen=True)
class Element:
    """A finite element: its cells in VTK order start with `corners` corner points.

    `integration_order` is the polynomial degree integrated exactly. The library's default is far
    higher: it costs several times as much and differs from the usual Gauss rules. `curved_order`
    is for cells with curved sides, whose gradients are no polynomials. `faces` are the corners of
    its sides, each counter-clockwise as seen from outside. `order` are the corners as the library
    lists them. `middles` are the corners that each further node lies amid. `linear` is the element
    of the corners alone, `side` that of its sides.
    """

    name: str
    dim: int
    corners: int
    degree: int
    integration_order: int
    curved_order: int
    mesh: Any
    function: Any
    linear: Any
    side: Any
    faces: Rings
    order: tuple[int, ...]
    middles: Rings = ()

    @property
    def nodes(self) -> int:
        """Number of nodes of a cell."""
        return self.corners + len(self.middles)

    @property
    def simplex(self) -> bool:
        """Whether its cells are triangles or tetrahedra."""
        return self.corners == self.dim + 1

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

_TRI = (skfem.MeshTri, skfem.ElementTriP1(), skfem.ElementTriP2())
_QUAD = (skfem.MeshQuad, skfem.ElementQuad1(), skfem.ElementQuad2())
_TET = (skfem.MeshTet, skfem.ElementTetP1(), skfem.ElementTetP2())
_HEX = (skfem.MeshHex, skfem.ElementHex1(), skfem.ElementHex2())
_LINE = (skfem.ElementLineP1(), skfem.ElementLineP2())


def _pair(
    letter: str,
    dim: int,
    orders: tuple[int, int, int],
    library: tuple[Any, Any, Any],
    sides: tuple[Any, Any],
    faces: Rings,
    order: tuple[int, ...],
    middles: Rings,
) -> tuple[Element, Element]:
    """The linear and the quadratic element of one shape; `orders` of their integration."""
    mesh, first, second = library
    shape, (low, high, curved) = (faces, order), orders
    corners = len(order)
    return (
        Element(f"{letter}1", dim, corners, 1, low, low, mesh, first, first, sides[0], *shape),
        Element(
            f"{letter}2",
            dim,
            corners,
            2,
            high,
            curved,
            mesh,
            second,
            first,
            sides[1],
            *shape,
            middles,
        ),
    )


ELEMENTS = {
    element.name: element
    for pair in (
        _pair("Q", 2, (2, 4, 4), _QUAD, _LINE, SQUARE, RISING, AMID_SQUARE),
        _pair("P", 2, (1, 2, 4), _TRI, _LINE, TRIANGLE, RISING[:3], TRIANGLE),
        _pair("H", 3, (2, 4, 4), _HEX, _QUAD[1:], CUBE, CUBE_ORDER, AMID_CUBE),
        _pair("T", 3, (1, 2, 4), _TET, _TRI[1:], TETRAHEDRON, RISING, AMID_TETRAHEDRON),
    )
    for element in pair
}
