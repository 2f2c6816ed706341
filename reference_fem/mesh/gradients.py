"""Gradients in cells from differences of nodal values, and the nodal forces of fluxes.

A matrix keeps its entries to 1e-16 of their size, so that a rigid motion of a cell is felt by it as
a strain of that size. In a slender body the strains are smaller still against the motion of its
end. Here each cell's first value, and its first node's place, are taken from the others before
anything is multiplied: a common motion of a cell cancels exactly, and places far from the origin
lose nothing.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.discretisation import Discretisation


@dataclass(frozen=True, eq=False)
class Gradients:
    """Slopes of a mesh's functions at its points of integration.

    Parameters
    ----------
    nodes
        (k, c) of the cells, in the library's order.
    count
        Number of nodes of the mesh.
    reference
        (d·q, k) slopes of the functions of a unit cell, at its points.
    inverse
        (d, d, q, c) ∂ξ_j/∂x_i, as [j, i].
    measure
        (q, c) length, area or volume that each point stands for.
    """

    nodes: Index
    count: int
    reference: Array
    inverse: Array
    measure: Array

    def of(self, values: Array) -> Array:
        """∂u_a/∂x_i (m, d, q, c) of nodal values (m, n)."""
        each = values[:, self.nodes]
        each -= each[:, :1].copy()
        local = (self.reference @ each).reshape(len(values), *self.inverse.shape[1:])
        return _sum(local[:, j, None] * along for j, along in enumerate(self.inverse))

    def gathered(self, flux: Array) -> Array:
        """Σ F_ai ∂_i φ (m, n) by node, of fluxes F (m, d, q, c) that hold the measure already."""
        local = _sum(flux[:, i, None] * self.inverse[:, i] for i in range(len(self.inverse)))
        each = self.reference.T @ local.reshape(len(flux), -1, flux.shape[-1])
        each[:, 0] = -each[:, 1:].sum(axis=1)  # a cell brings nothing in all, to the last bit
        nodes = self.nodes.ravel()
        return np.array([np.bincount(nodes, part.ravel(), self.count) for part in each])


def _sum(terms: Iterator[Array]) -> Array:
    """Sum of arrays, in the first."""
    found = next(terms)
    for other in terms:
        found += other
    return found


def gradients_at_points(body: Discretisation) -> Gradients:
    """Slopes at the points that the body's stiffness is integrated at."""
    kind, X, weights = body.element, np.asarray(body.basis.X), np.asarray(body.basis.W)
    nodes = np.ascontiguousarray(body.cell_nodes.T)
    reference = np.concatenate(kind.functions(X.T)[1].transpose(1, 2, 0))
    shapes, corners = reference, nodes
    if not body.curved:  # cells are mapped by their corners alone
        corners = nodes[: kind.corners]
        each = [kind.linear.lbasis(X, i)[1] for i in range(kind.corners)]
        shapes = np.concatenate(np.array(each).transpose(1, 2, 0))
    x = body.points.T[:, corners]
    x = x - x[:, :1]
    d, q = X.shape
    jacobian = (shapes @ x).reshape(d, d, q, -1).transpose(2, 3, 0, 1)  # [q, c, i, j]
    inverse = np.ascontiguousarray(np.linalg.inv(jacobian).transpose(2, 3, 0, 1))
    measure = np.abs(np.linalg.det(jacobian)) * weights[:, None]
    return Gradients(nodes, len(body.points), reference, inverse, measure)
