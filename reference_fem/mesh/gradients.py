"""Gradients in cells from differences of nodal values, and the nodal forces of fluxes.

A matrix keeps its entries to 1e-16 of their size, so that a rigid motion of a cell is felt by it as
a strain of that size. In a slender body the strains are smaller still against the motion of its
end. Here each cell's first value, and its first node's place, are taken from the others before
anything is multiplied: a common motion of a cell cancels exactly, and places far from the origin
lose nothing.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.maps import determinant


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

    def of(self, values: Array, rest: Array | None = None) -> Array:
        """∂u_a/∂x_i (m, d, q, c) of nodal values (m, n), and of what these lack in digits."""
        found = np.empty((len(values), *self.inverse.shape[1:]))
        for a, value in enumerate(values):
            each = value[self.nodes]
            each = each - each[0]
            if rest is not None:
                less = rest[a][self.nodes]
                each += less - less[0]
            local = (self.reference @ each).reshape(self.inverse.shape[1:])
            for i in range(len(self.inverse)):
                _accumulate_products(zip(local, self.inverse[:, i], strict=True), found[a, i])
        return found

    def gathered(self, flux: Array) -> Array:
        """Σ F_ai ∂_i φ (m, n) by node, of fluxes F (m, d, q, c) that hold the measure already."""
        return self._by_node(self._each(flux))

    def _each(self, flux: Array) -> Array:
        """What each cell brings to its nodes (m, k, c): in all nothing, to the last bit but one."""
        each = np.array([self.reference.T @ local for local in self._local(flux)])
        each[:, 0] = -each[:, 1:].sum(axis=1)
        return each

    def _local(self, flux: Array) -> Array:
        """Fluxes along a unit cell's axes, (m, d·q, c)."""
        local = np.empty(flux.shape)
        for a in range(len(flux)):
            for j in range(len(self.inverse)):
                _accumulate_products(zip(flux[a], self.inverse[j], strict=True), local[a, j])
        return local.reshape(len(flux), -1, flux.shape[-1])

    def _by_node(self, each: Array) -> Array:
        nodes = self.nodes.ravel()
        return np.array([np.bincount(nodes, part.ravel(), self.count) for part in each])


def _accumulate_products(pairs: Iterable[tuple[Array, Array]], out: Array) -> None:
    """Σ a b into an array."""
    for number, (a, b) in enumerate(pairs):
        if number == 0:
            np.multiply(a, b, out=out)
        else:
            out += a * b


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
    # columns[j]: ∂x/∂ξ_j, (q·c, d)
    along = (shapes @ x).reshape(d, d, q, -1)  # [i, j, q, c]
    columns = [along[:, j].reshape(d, -1).T for j in range(d)]
    jacobian = determinant(columns)
    inverse = np.empty((d, d, jacobian.size))
    for j in range(d):
        for i in range(d):
            unit = np.broadcast_to(np.eye(d)[i], columns[0].shape)
            inverse[j, i] = determinant([*columns[:j], unit, *columns[j + 1 :]]) / jacobian
    measure = np.abs(jacobian).reshape(q, -1) * weights[:, None]
    return Gradients(nodes, len(body.points), reference, inverse.reshape(along.shape), measure)
