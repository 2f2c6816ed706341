"""Multigrid for large bodies in space: conjugate gradients with smoothed aggregation."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array, coo_array, csr_array, csr_matrix, diags_array
from scipy.sparse.csgraph import connected_components
from scipy.sparse.linalg import LinearOperator

from msvalidate.problem import Array, Mask, SolverError, rigid_motions
from reference_fem.discretisation import Discretisation
from reference_fem.effort import within_memory

ERROR = 1e-12
"""Displacement that one cycle makes of the residual left, relative to what it makes of the load.

A cycle is nearly the inverse of the stiffness, so this is the error of the displacement but for the
factor by which they differ: 10 in bodies that take 40 steps, 1000 in those that take 400. The
residual itself hardly knows of a slender body's bending, and says nothing of the displacement."""
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


def multigrid(
    body: Discretisation, held: Mask, K: csr_matrix, load: Array, steps: int = MOST_STEPS
) -> Array:
    """Displacement (f,) in m of the free components under forces (f,) in N.

    Parameters
    ----------
    body
        Whose rigid motions make the coarse spaces.
    held
        Components (n, d) that are held; the others are free.
    K, load
        Stiffness of all components (N/m) and forces on the free ones (N), component-major.
    steps
        Most steps of conjugate gradients, each with one cycle.

    Raises
    ------
    SolverError
        If the error does not come down, or memory does not suffice.
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
    with within_memory(len(load), "unknowns"):
        found = _conjugate_gradients(A, right.ravel(), _cycle(body, free, A), steps)
    return np.asarray(found.reshape(held.shape).T[~held.T] * (largest / unit))


def _conjugate_gradients(A: csr_array, b: Array, cycle: LinearOperator, most: int) -> Array:
    """Solution of A x = b to `ERROR`, from at most so many steps."""
    x, residual = np.zeros(len(b)), b
    ahead = cycle @ residual
    allowed, steps = ERROR * np.linalg.norm(ahead), 0
    while np.linalg.norm(ahead) > allowed:
        direction = ahead  # afresh, from a residual that no recursion has let drift
        while np.linalg.norm(ahead) > allowed:
            force, power = A @ direction, residual @ ahead
            stiff = direction @ force
            if steps == most or not (stiff > 0 and power > 0):  # or rounding is all that is left
                left = np.linalg.norm(ahead) * ERROR / allowed
                raise SolverError(
                    f"finite elements: error {left:.1g} of the displacement after {steps} steps of "
                    "conjugate gradients; take cells of better shape, fewer of them, or a smaller "
                    "nu"
                )
            x = x + power / stiff * direction
            residual = residual - power / stiff * force
            ahead = cycle @ residual
            direction = ahead + residual @ ahead / power * direction
            steps += 1
        residual = b - A @ x
        ahead = cycle @ residual
    return x


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
