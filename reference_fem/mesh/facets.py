"""Integrals over the sides of cells: edges in the plane, faces in space, straight or curved."""

from __future__ import annotations

from functools import cached_property

import numpy as np
import skfem

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.discretisation import Discretisation

CURVED_ORDER = 19
"""Degree integrated exactly over curved sides, whose lengths are no polynomials: an edge bent by a
quarter of its length is measured to 4e-10, one bent by a tenth to rounding. Pressure along normals
is a polynomial and exact. It is the library's highest for triangles."""


@dataclass(frozen=True, eq=False)
class Facets:
    """Sides of a mesh's cells, mapped by their own nodes, with points to integrate at.

    The library would look for the points in the cells by iterating to an absolute 1e-12, and not
    find them in cells that are small or graded.

    Parameters
    ----------
    body
        The mesh.
    nodes
        (f, k) nodes of the sides, corners first, then mid-sides in the same turn, then the centre.
    """

    body: Discretisation
    nodes: Index

    @cached_property
    def values(self) -> Array:
        """Shape functions (k, q) at the points of a side."""
        return self._functions[0]

    @cached_property
    def places(self) -> Array:
        """Points (f, q, d) in m."""
        return np.asarray(np.einsum("kq,fkd->fqd", self.values, self._corners))

    @cached_property
    def measure(self) -> Array:
        """Length (m) or area (m²) that each point (f, q) stands for."""
        return np.asarray(np.linalg.norm(self._stretched, axis=2) * self._functions[2])

    @property
    def normals(self) -> Array:
        """Unit normals (f, q, d) at the points, outwards where the sides are of `body.surface`."""
        size = np.linalg.norm(self._stretched, axis=2, keepdims=True)
        return np.asarray(self._stretched / size)

    def integrated(self, field: Array) -> Array:
        """∫ φ_i f over the sides, as (n, d) by node, of a field (f, q, d) at the points."""
        share = np.einsum("kq,fq,fqd->fkd", self.values, self.measure, field)
        total = np.zeros(self.body.points.shape)
        np.add.at(total, self.nodes, share)
        return total

    @cached_property
    def _stretched(self) -> Array:
        """Normals (f, q, d), as long as the map stretches the side."""
        x = self._corners
        sides = np.einsum("keq,fkd->efqd", self._functions[1], x - x[:, :1])
        if len(sides) == 2:
            return np.asarray(np.cross(*sides))
        return np.stack([sides[0][..., 1], -sides[0][..., 0]], axis=-1)

    @property
    def _corners(self) -> Array:
        return self.body.points[self.nodes]

    @cached_property
    def _functions(self) -> tuple[Array, Array, Array]:
        kind = self.body.element
        order = CURVED_ORDER if self.body.curved else 2 * kind.degree + 2
        X, weights = skfem.quadrature.get_quadrature(kind.side, order)
        found = [kind.side.lbasis(X, i) for i in range(self.nodes.shape[1])]
        value = np.array([np.broadcast_to(each[0], len(weights)) for each in found])
        slope = np.array([np.broadcast_to(each[1], (kind.dim - 1, len(weights))) for each in found])
        return value, slope, weights
