"""A body at large strain: its energy, the forces on its nodes, its tangent.

    f = ∫ P(F):∂φ/∂X dX,    F = I + ∂u/∂X,

over the undeformed body: the total Lagrangian form.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.problem import VOIGT, Array, Index, Mask, ProblemError, refuse_free_motions
from msvalidate.problem.checks import positive_number
from msvalidate.problem.records import dataclass
from reference_fem.large_strain.by_cell import CellLaws, each_law
from reference_fem.large_strain.hyperelastic import Law, refuse_other_laws, stress_by_gradient
from reference_fem.mesh.assembly import sum_to_nodes
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import Gradients, gradients_at_points
from reference_fem.systems.direct import elimination_order
from reference_fem.systems.solver import refuse_no_mask

ROUNDED = 4 * float(np.finfo(float).eps)
"""Relative rounding of a displacement and of differences of a few of them."""


@dataclass(frozen=True, eq=False)
class Solid:
    """A supported body, ready for loads.

    Parameters
    ----------
    body
        The mesh of the undeformed body.
    law
        Its energy density; `laws_of` has that of a problem, with its zones.
    held
        Components (n, d) that are held.
    thickness
        Of a plane body (m); 1 of a solid.

    Raises
    ------
    ProblemError
        If the parts do not fit together, or a rigid motion is free.
    """

    body: Discretisation
    law: Law
    held: Mask
    thickness: float = 1.0

    def __post_init__(self) -> None:
        refuse_no_mask(self.body, self.held)
        refuse_other_laws(self.law)
        if self.law.dim != self.body.dim:
            raise ProblemError(f"law: {self.law.dim}D, the body {self.body.dim}D")
        if isinstance(self.law, CellLaws) and len(self.law.number) != len(self.body.cells):
            raise ProblemError(
                f"laws: of {len(self.law.number)} cells; the mesh has {len(self.body.cells)}"
            )
        if positive_number("thickness", self.thickness, "m") != 1 and self.body.dim == 3:
            raise ProblemError(f"thickness: {self.thickness} m; a solid has none, leave it at 1")
        refuse_free_motions("body at large strain", self.body.points, self.held)

    @cached_property
    def free(self) -> Index:
        """Free components (f,), component-major, in the order to eliminate them in."""
        order = elimination_order(self.body, self.held)
        return np.asarray(np.flatnonzero(~self.held.T.ravel())[order])

    def gradient(self, displacement: Array) -> Array:
        """F = I + ∂u/∂X (c, q, d, d) at the points of integration, of displacements (n, d)."""
        return np.asarray(np.eye(self.body.dim) + self._slope(displacement))

    def _slope(self, displacement: Array) -> Array:
        """∂u/∂X (c, q, d, d), of differences within the cells."""
        u = displacement[self._nodes]
        return np.asarray((u - u[:, :1]).transpose(0, 2, 1)[:, None] @ self._slopes)

    def energy(self, displacement: Array) -> float:
        """∫ W dX in J."""
        F = self.gradient(displacement)
        return float(self._weights.ravel() @ self.law.energy(F.reshape(-1, *F.shape[2:])))

    def internal_force(self, displacement: Array) -> tuple[Array, Array]:
        """∫ P:∂φ/∂X dX (n, d) in N, and the sizes (n, d) that add up to it."""
        H = self._slope(displacement)
        P = stress_by_gradient(self.law, H.reshape(-1, *H.shape[2:])).reshape(H.shape)
        # A cell's forces, (c, k, d): its points and the axis J are one sum.
        each = np.einsum("cqkJ,cqiJ,cq->cki", self._slopes, P, self._weights, optimize=True)
        return self._gathered(each), self._gathered(np.abs(each))

    def rounding(self, displacement: Array) -> float:
        """Largest force (N) on a node that the rounding of the displacements themselves makes.

        Where a body moves as a whole its strain may be tiny: forces that cancel at a node do not
        tell what the differences of displacements have lost.
        """
        moved = np.abs(displacement).max(axis=1)[self._nodes]
        size = np.einsum("cqkJ,ck->cq", np.abs(self._slopes), moved) * self._weights
        each = np.einsum("cqkJ,cq->ck", np.abs(self._slopes), size, optimize=True)
        felt = np.bincount(self._nodes.ravel(), each.ravel())
        return float(ROUNDED * self._modulus * felt.max())

    @cached_property
    def _modulus(self) -> float:
        """Largest entry (Pa) of a law's tangent at rest."""
        return float(np.abs(self.at_rest).max())

    @cached_property
    def at_rest(self) -> Array:
        """Each law's tangent (Pa) at rest as a Voigt tensor: (laws, 3, 3) or (laws, 6, 6)."""
        pairs, found = VOIGT[self.body.dim], []
        for law in each_law(self.law):
            (A,) = law.tangent(np.eye(self.body.dim)[None])
            found.append([[A[i, j, k, m] for k, m in pairs] for i, j in pairs])
        return np.array(found)

    def tangent(self, displacement: Array) -> csr_matrix:
        """∂f/∂u (d·n, d·n) in N/m, component-major and symmetric."""
        F = self.gradient(displacement)
        d, g = self.body.dim, self._slopes
        A = self.law.tangent(F.reshape(-1, d, d)).reshape(*F.shape[:2], d, d, d, d)
        A = A * self._weights[:, :, None, None, None, None]
        cells, _, k, _ = g.shape
        left = g.transpose(0, 2, 1, 3).reshape(cells, k, -1)

        def products(a: int, b: int) -> Array:
            right = A[:, :, a, :, b] @ g.transpose(0, 1, 3, 2)
            return np.asarray(left @ right.reshape(cells, -1, k))

        shared = self.body.pattern
        return shared.component_major(shared.symmetric(d, products))

    def by_node(self, components: Array) -> Array:
        """Values (n, d) of what is component-major (d·n,), as the tangent is."""
        return components.reshape(self.held.shape[::-1]).T

    def is_upright(self, displacement: Array) -> bool:
        """Return True if det F > 0 at all integration points."""
        return bool((np.linalg.det(self.gradient(displacement)) > 0).all())

    def turned(self, displacement: Array) -> int | None:
        """The first cell that is turned inside out at one of its nodes; None if there is none."""
        (bad,) = np.nonzero(~(self.body.swelling(self.body.points + displacement) > 0))
        return int(bad[0]) if len(bad) else None

    def _gathered(self, each: Array) -> Array:
        """Sums (n, d) by node of what cells (c, k, d) bring."""
        return sum_to_nodes(self._nodes, np.moveaxis(each, 2, 0), len(self.body.points))

    @cached_property
    def _nodes(self) -> Index:
        """Nodes (c, k) of the cells in the library's order."""
        return self.body.cell_nodes

    @cached_property
    def _slopes(self) -> Array:
        """∂φ/∂X (c, q, k, d) at the points of integration."""
        cells = self._gradients
        d, q = len(cells.inverse), len(cells.measure)
        local = cells.reference.reshape(d, q, -1)
        each = np.einsum("jqk,jJqc->cqkJ", local, cells.inverse, optimize=True)
        return np.ascontiguousarray(each)

    @cached_property
    def _weights(self) -> Array:
        """Volume (c, q) in m³ that each point of integration stands for."""
        return np.ascontiguousarray(self.thickness * self._gradients.measure.T)

    @cached_property
    def _gradients(self) -> Gradients:
        return gradients_at_points(self.body)
