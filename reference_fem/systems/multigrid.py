"""Multigrid for large bodies in space: conjugate gradients with smoothed aggregation."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import bsr_array, csr_array, csr_matrix, diags_array
from scipy.sparse.linalg import LinearOperator

from msvalidate.problem import Array, Mask, SolverError, rigid_motions
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.discretisation import Discretisation

ROUGH = 1e-3
"""Error to stop at from which on no recursion has drifted."""
ERROR = 5e-12
"""Displacement that one cycle makes of the residual left, relative to what it makes of the load.

A cycle is nearly the inverse of the stiffness, so this is the error of the displacement but for the
factor by which they differ: 10 in bodies that take 40 steps, 1000 in those that take 400. The
residual itself hardly knows of a slender body's bending, and says nothing of the displacement."""
MOST_STEPS = 500
"""Cells of good shape take 20 to 40, cells ten times as long as wide 100, nu = 0.499 takes 200."""


class Hierarchy:
    """Levels of a supported body's stiffness, ready for any load.

    Parameters
    ----------
    body
        Whose rigid motions make the coarse spaces.
    held
        Components (n, d) that are held; the others are free.
    K
        Stiffness (N/m) of all components, component-major.

    Raises
    ------
    SolverError
        If memory does not suffice.
    """

    def __init__(self, body: Discretisation, held: Mask, K: csr_matrix) -> None:
        self._held, self._unit = held, float(K.diagonal().max())
        self._numbers = bool(np.finfo(float).tiny <= self._unit and np.isfinite(K.data).all())
        if not self._numbers:
            return
        free = ~held.ravel()
        # By node: what is held keeps its rows, so that every node has a block.
        by_node = np.arange(held.size).reshape(body.dim, -1).T.ravel()
        inside = diags_array(free.astype(float))
        with fits_in_memory(int(free.sum()), "unknowns"):
            scaled = K[by_node][:, by_node] / self._unit
            self._A = inside @ scaled @ inside + diags_array(1.0 - free)
            self._cycle = _cycle(body, free, self._A)

    def correct(self, force: Array) -> Array:
        """Nearly the displacements (n, d) in m of forces (n, d) in N, by one cycle."""
        right = np.where(self._held, 0.0, force / self._unit)
        return np.asarray((self._cycle @ right.ravel()).reshape(right.shape))

    def solve(
        self, load: Array, steps: int = MOST_STEPS, error: float = ERROR
    ) -> tuple[Array, int]:
        """Displacement (f,) in m of the free components under forces (f,) in N, and steps taken.

        Parameters
        ----------
        load
            Forces on the free components, component-major.
        steps
            Most steps of conjugate gradients, each with one cycle.
        error
            To stop at, as `ERROR` is.

        Raises
        ------
        SolverError
            If the error does not come down.
        """
        largest = float(np.abs(load).max())
        if largest == 0:
            return np.zeros(load.shape), 0
        if not (self._numbers and np.isfinite(largest)):
            return np.full(load.shape, np.nan), 0  # which no residual allows
        right = np.zeros(self._held.shape)
        right.T[~self._held.T] = load / largest
        with fits_in_memory(len(load), "unknowns"):
            found, taken = _conjugate_gradients(self._A, right.ravel(), self._cycle, steps, error)
        free = found.reshape(self._held.shape).T[~self._held.T]
        return np.asarray(free * (largest / self._unit)), taken


def _conjugate_gradients(
    A: csr_array, b: Array, cycle: LinearOperator, most: int, error: float
) -> tuple[Array, int]:
    """Solution of A x = b to an error as `ERROR` is, and its steps, at most so many.

    Source: [HestenesStiefel1952].
    """
    x, residual = np.zeros(len(b)), b
    ahead = cycle @ residual
    allowed, steps = error * _norm(ahead), 0
    while _norm(ahead) > allowed:
        direction = ahead  # afresh, from a residual that no recursion has let drift
        while _norm(ahead) > allowed:
            force, power = A @ direction, dot(residual, ahead)
            stiff = dot(direction, force)
            if steps == most or not (stiff > 0 and power > 0):  # or rounding is all that is left
                left = _norm(ahead) * error / allowed
                raise SolverError(
                    f"finite elements: error {left:.1g} of the displacement after {steps} steps of "
                    "conjugate gradients; take cells of better shape, fewer of them, or a smaller "
                    "nu"
                )
            x = x + power / stiff * direction
            residual = residual - power / stiff * force
            ahead = cycle @ residual
            direction = ahead + dot(residual, ahead) / power * direction
            steps += 1
        if error >= ROUGH:
            break
        residual = b - A @ x
        ahead = cycle @ residual
    return x, steps


def dot(a: Array, b: Array) -> float:
    """Sum of products, in one order: that of BLAS, and the last digits, depend on its threads."""
    return float(np.einsum("i,i", a, b))


def _norm(a: Array) -> float:
    return math.sqrt(dot(a, a))


def _cycle(body: Discretisation, free: Mask, A: csr_array) -> LinearOperator:
    """One cycle over levels whose coarse spaces hold the rigid motions: nearly the inverse of A.

    Source: smoothed aggregation, [Vanek1996].
    """
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
