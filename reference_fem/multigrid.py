"""Multigrid for large bodies in space: conjugate gradients with smoothed aggregation."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array, csr_matrix, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator, cg

from msvalidate.problem import Array, Mask, SolverError, rigid_motions
from reference_fem.discretisation import Discretisation

ERROR = 1e-12
"""Residual left, relative to the load, in the Euclidean norm."""
MOST_STEPS = 500
"""Cells of good shape take 20 to 40, cells ten times as long as wide 100, nu = 0.499 takes 200."""


def in_one_piece(body: Discretisation) -> bool:
    """Whether all cells hang together by faces.

    Its cells bend for no motion but rigid ones, and two with a common face move as one: such a body
    has no mechanism, and supports that stop its rigid motions hold it.
    """
    faces = body.faces
    each = np.sort(faces.reshape(-1, faces.shape[2]), axis=1)
    _, number = np.unique(each, axis=0, return_inverse=True)
    cell = np.repeat(np.arange(len(faces)), faces.shape[1])
    number = number.ravel() + len(faces)  # a graph of cells and faces
    size = number.max() + 1
    graph = coo_array((np.ones(len(cell)), (cell, number)), shape=(size, size))
    return bool(connected_components(graph, directed=False)[0] == 1)


def multigrid(body: Discretisation, held: Mask, K: csr_matrix, load: Array) -> Array:
    """Displacement (f,) in m of the free components under forces (f,) in N.

    Parameters
    ----------
    body
        Whose rigid motions make the coarse spaces.
    held
        Components (n, d) that are held; the others are free.
    K, load
        Stiffness of all components (N/m) and forces on the free ones (N), component-major.

    Raises
    ------
    SolverError
        If the residual does not come down, or memory does not suffice.
    """
    unit, largest = float(K.diagonal().max()), float(np.abs(load).max())
    if largest == 0:
        return np.zeros(load.shape)
    if not (np.isfinite(largest) and np.finfo(float).tiny <= unit and np.isfinite(K.data).all()):
        return np.full(load.shape, np.nan)  # which no residual allows
    free = ~held.ravel()
    # By node: what is held keeps its rows, so that every node has a block.
    by_node = np.arange(held.size).reshape(body.dim, -1).T.ravel()
    inside = diags_array(free.astype(float))
    A = inside @ (K[by_node][:, by_node] / unit) @ inside + diags_array(1.0 - free)
    right = np.zeros(held.shape)
    right.T[~held.T] = load / largest
    try:
        cycle = _cycle(body, free, A)
    except MemoryError as error:
        raise SolverError(
            f"finite elements: {len(load)} unknowns take more memory than there is; take fewer "
            "cells"
        ) from error
    found, info = cg(A, right.ravel(), rtol=ERROR, maxiter=MOST_STEPS, M=cycle)
    if info:
        left = np.linalg.norm(right.ravel() - A @ found) / np.linalg.norm(right)
        raise SolverError(
            f"finite elements: residual {left:.1g} of the load after {info} steps of conjugate "
            "gradients; take cells of better shape, fewer of them, or a smaller nu"
        )
    return np.asarray(found.reshape(held.shape).T[~held.T] * (largest / unit))


def _cycle(body: Discretisation, free: Mask, A: csr_array) -> LinearOperator:
    """One cycle over levels whose coarse spaces hold the rigid motions: nearly the inverse of A."""
    from pyamg import smoothed_aggregation_solver  # noqa: PLC0415  half a second for one method

    centred = body.points - body.points.mean(axis=0)
    rigid = rigid_motions(centred / np.abs(centred).max()).reshape(free.size, -1)
    levels = smoothed_aggregation_solver(
        bsr_array(A, blocksize=(body.dim,) * 2),
        B=rigid * free[:, None],
        # Weights from row sums: the default draws random vectors, so that answers differ by run.
        smooth=("jacobi", {"omega": 4 / 3, "weighting": "local"}),
        improve_candidates=None,
        # Cells ten times as long as wide: weak links left out, two thirds of the steps.
        strength=("symmetric", {"theta": 0.05}),
    )
    return levels.aspreconditioner()
