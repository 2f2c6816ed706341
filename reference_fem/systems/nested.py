"""Multigrid on meshes that hold each other: conjugate gradients with cycles over all of them.

`children_of` puts children on their parent's own map, so that a field of a mesh is one of the finer
mesh, and shape functions at its nodes take it there. The stiffness of the coarser mesh is then the
finer one's, restricted to such fields (Galerkin's, but for integration in cells that are no
parallelepipeds). Each mesh is smoothed by Chebyshev's polynomial of the stiffness scaled by its
blocks of nodes [Adams2003]; the coarsest is solved as it was before. Nothing is drawn at random.

Steps do not grow with the mesh [Hackbusch1985]: 10 to 20 in cells of good shape, more in long ones.
"""

from __future__ import annotations

from functools import cached_property
from time import perf_counter

import numpy as np
from scipy.sparse import bsr_array, csr_array, csr_matrix, diags_array, eye_array, kron

from msvalidate.linear_algebra.conjugate_gradients import conjugate_gradients
from msvalidate.linear_algebra.multigrid import (
    Level,
    chebyshev,
    diagonal_blocks,
    restrain_in_place,
)
from msvalidate.linear_algebra.norms import dots
from msvalidate.problem import Array, Index, Mask, SolverError
from msvalidate.problem.records import dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.assembly import AT_ONCE, sparsity_pattern
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.systems.cells import ElasticForces
from reference_fem.systems.solver import (
    ACCEPTED,
    RESIDUAL,
    Solver,
    SystemSolution,
    describe_lost_digits,
    refuse_shapes,
)

NESTED = "nested"
"""Name of this solver in `SystemSolution.choice`."""
ERROR = 1e-10
"""Displacement that one cycle makes of the residual left, over the largest, at which to stop."""
MOST_STEPS = 200
PART = 1e-3
"""Relative error after which the residual is computed again, cell by cell."""
SAFETY = 4.0
"""Factor on what the last cycle makes of the residual, which is less than the error left."""
SHRINKS = 0.5
"""Share of what was left before from which on it is rounding, which no step mends."""
POWERS, MARGIN = 10, 1.1
"""Steps of the power method for the largest eigenvalue, and a factor on what they find: from below,
off by 5 % at most as seen."""


@dataclass(frozen=True, eq=False)
class Nested:
    """A body on a mesh that was cut from a coarser one, ready for any load.

    Parameters
    ----------
    body
        The mesh.
    held
        Components (n, d) that are held.
    tensor, number
        As of a `Solver`.
    coarser
        What solves on the coarser mesh.
    finer
        (n, m) takes nodal values of the coarser mesh to this one.
    start
        (n, d) in m, to begin with: the coarser mesh's displacement as a rule.
    """

    body: Discretisation
    held: Mask
    tensor: Array
    number: Index | None
    coarser: Solver | Nested
    finer: csr_matrix
    start: Array

    def solve(self, displacement: Array, force: Array) -> tuple[Array, SystemSolution]:
        """Displacement (n, d) in m under values (n, d) of what is held (m) and forces (n, d) in N.

        Residuals are summed cell by cell, which slender bodies need, before and after the steps.

        Raises
        ------
        SolverError
            If memory does not suffice, the error does not come down, or it may be above `ACCEPTED`.
        """
        refuse_shapes(self.body, displacement=displacement, force=force)
        began, before, rate, steps = perf_counter(), np.inf, 0.0, 0
        inner = ElasticForces(gradients_at_points(self.body), self.tensor, self.number)
        quiet, room = np.errstate(over="ignore", invalid="ignore"), fits_in_memory
        with quiet, room(self.held.size, "unknowns"):
            u = np.where(self.held, displacement, self.start)
            while True:
                residual = self._free * (force - inner(u.T.ravel()).reshape(u.shape[::-1]).T)
                left = _largest(self.correct(residual))
                if not ERROR * _largest(u) < left < SHRINKS * before:  # nor what is no number
                    break
                part = min(ERROR * _largest(u) / left, PART)
                found = conjugate_gradients(
                    self._level.A, residual.ravel(), self._cycle, part, most=MOST_STEPS - steps
                )
                steps += found.steps
                if found.negative or not found.reduction <= part:
                    raise SolverError(
                        f"finite elements: error {found.reduction * left / _largest(u):.1g} of the "
                        f"displacement after {steps} steps over nested meshes; take cells of "
                        "better shape, or a smaller nu"
                    )
                rate = found.reduction ** (1 / max(found.steps, 1))
                u, before = u + found.solution.reshape(u.shape), left
        error = SAFETY * left / (_largest(u) or 1.0) / (1 - rate)
        own = np.abs(diagonal_blocks(self._level.A)[0]) @ np.abs(u)[:, :, None]
        scale = _largest(self._free * own[:, :, 0])  # what is held has a stiffness of no meaning
        if not (error <= ACCEPTED and _largest(residual) <= RESIDUAL * scale):
            raise SolverError(describe_lost_digits(error))
        share, seconds = _largest(residual) / (scale or 1.0), perf_counter() - began
        reason = "a mesh cut from a coarser one"
        return u, SystemSolution(NESTED, reason, share, steps, seconds, error)

    def correct(self, force: Array) -> Array:
        """Nearly the displacements (n, d) in m of forces (n, d) in N, by one cycle.

        Linear, symmetric and positive; zero where components are held.
        """
        return self._cycle(force.ravel()).reshape(force.shape)

    def _cycle(self, force: Array) -> Array:
        d, free = self.body.dim, self._free.ravel()

        def coarser(load: Array) -> Array:
            return self.coarser.correct(load.reshape(-1, d)).ravel()

        return free * self._level.once(None, free * force, coarser)

    @cached_property
    def _free(self) -> Array:
        return (~self.held).astype(float)

    @cached_property
    def _level(self) -> Level:
        """The stiffness by node, what is held cut off, and its smoother."""
        size, identity = self.held.size, eye_array(self.body.dim)
        with fits_in_memory(size, "unknowns"):
            K = _block_stiffness(self.body, self.tensor, self.number)
            restrain_in_place(K, ~self.held)
            inverse = np.linalg.inv(diagonal_blocks(K)[0])
            up = csr_array(diags_array(self._free.ravel()) @ kron(self.finer, identity))
        largest, ahead = 1.0, np.cos(1.7 * np.arange(size)).reshape(-1, self.body.dim, 1)
        for _ in range(POWERS):  # by a wave of every length in no proportion to the mesh
            ahead = inverse @ (K @ ahead.ravel()).reshape(ahead.shape)
            largest = float(np.sqrt(dots(ahead.ravel(), ahead.ravel())))
            ahead /= largest or 1.0
        smooth = chebyshev(K, np.asarray(inverse, dtype=float), MARGIN * largest)
        return Level(K, up, up.T, smooth, smooth)


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _block_stiffness(body: Discretisation, tensor: Array, number: Index | None) -> bsr_array:
    """Stiffness (d·n, d·n) in N/m by node, in blocks: most of the memory, so there is one copy."""
    pattern, d = sparsity_pattern(body.cell_nodes, len(body.points)), body.dim
    slopes, measure = [f.grad for (f,) in body.basis.basis], np.asarray(body.basis.dx)
    C, own = (tensor[None], np.zeros(len(measure), int)) if number is None else (tensor, number)
    blocks, k = np.empty((len(pattern.columns), d, d)), len(slopes)

    def products(a: int, b: int) -> Array:
        found = np.empty((len(measure), k, k))
        for first in range(0, len(measure), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            along = np.stack([each[:, part] for each in slopes], axis=2)  # (d, c, k, q)
            flux = np.einsum("cij,ickq->ckjq", C[own[part], a, :, b], along * measure[part, None])
            other = along.transpose(1, 0, 3, 2).reshape(len(flux), -1, k)
            found[part] = flux.reshape(len(flux), k, -1) @ other
        return found

    pattern.symmetric(d, products, blocks.transpose(1, 2, 0))
    size = d * len(body.points)
    entries = blocks, pattern.columns.astype(np.int32), pattern.start.astype(np.int32)
    return bsr_array(entries, shape=(size, size))
