"""Laplacians with a weight, for what has one unknown a node: potentials, and how air follows."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.linear_algebra.factor import Factor
from msvalidate.problem import Array, Index
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.assembly import basis_gradients
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.systems.direct import elimination_order, factor_of


def weighted_laplacian(body: Discretisation, weight: Array) -> csr_matrix:
    """∫w ∇φi·∇φj (n, n) of a weight (c,) for each cell."""
    with fits_in_memory(len(body.points), "nodes"):
        slope, measure = basis_gradients(body.basis)
        weighed = slope * (weight[:, None] * measure)
        products = np.einsum("iacq,jacq->cij", weighed, slope, optimize=True)
        return body.pattern.matrix(body.pattern.symmetric(1, lambda *_: products)[0, 0])


def scalar_factor(body: Discretisation, K: csr_matrix, free: Index) -> Factor:
    """Factor of the free part (f, f) of a matrix with one unknown a node."""
    held = np.ones((len(body.points), 1), dtype=bool)
    held[free] = False
    with fits_in_memory(len(free), "unknowns"):
        return factor_of(body, K[free][:, free], elimination_order(body, held), free)
