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
from scipy.sparse import bsr_array, csr_matrix

from msvalidate.problem import Array, Index, Mask, SolverError
from msvalidate.problem.records import dataclass
from reference_fem.effort import fits_in_memory
from reference_fem.mesh.assembly import AT_ONCE, sparsity_pattern
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import gradients_at_points
from reference_fem.systems.cells import ElasticForces
from reference_fem.systems.multigrid import dot
from reference_fem.systems.solver import (
    ACCEPTED,
    RESIDUAL,
    Solver,
    SystemSolution,
    describe_lost_digits,
    refuse_shapes,
)

NESTED = "nested"
"""What `SystemSolution.choice` says of it."""
ERROR = 1e-10
"""Displacement that one cycle makes of the residual left, over the largest, at which to stop."""
MOST_STEPS = 200
SAFETY = 4.0
"""Factor on what the last cycle makes of the residual, which is less than the error left."""
SHRINKS = 0.5
"""Share of what was left before from which on it is rounding, which no step mends."""
DEGREE, SMOOTHED = 2, 8.0
"""Degree of the smoother, and the ratio of the largest eigenvalue to the least that it is made for.
Of degrees 2 to 4 and ratios from 5 to 20 the fewest products for a digit, on a bracket of H2."""
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
                ahead = self.correct(residual)
                left = _largest(ahead)
                if not ERROR * _largest(u) < left < SHRINKS * before:  # nor what is no number
                    break
                change, taken, rate = self._conjugate_gradients(residual, ahead, u, steps)
                u, steps, before = u + change, steps + taken, left
        error = SAFETY * left / (_largest(u) or 1.0) / (1 - rate)
        scale = _largest(np.abs(self._system[1]) @ np.abs(u)[:, :, None])
        if not (error <= ACCEPTED and _largest(residual) <= RESIDUAL * scale):
            raise SolverError(describe_lost_digits(error))
        share, seconds = _largest(residual) / (scale or 1.0), perf_counter() - began
        reason = "a mesh cut from a coarser one"
        return u, SystemSolution(NESTED, reason, share, steps, seconds, error)

    def correct(self, force: Array) -> Array:
        """Nearly the displacements (n, d) in m of forces (n, d) in N, by one cycle.

        Linear, symmetric and positive; zero where components are held.
        """
        found, left = self._smoothed(self._free * force)
        coarse = self.finer @ self.coarser.correct(self.finer.T @ left) * self._free
        found += coarse
        return np.asarray(found + self._smoothed(left - self._forces(coarse), last=True)[0])

    def _conjugate_gradients(
        self, residual: Array, ahead: Array, u: Array, done: int
    ) -> tuple[Array, int, float]:
        """Correction (n, d) of u, the steps it took, and by what share one makes the error fall."""
        found, direction, steps = np.zeros_like(u), ahead, 0
        first, power = _largest(ahead), dot(residual.ravel(), ahead.ravel())
        left = first
        while left > ERROR / 2 * _largest(u + found):
            force = self._forces(direction)
            stiff = dot(direction.ravel(), force.ravel())
            if done + steps == MOST_STEPS or not (stiff > 0 and power > 0):
                raise SolverError(
                    f"finite elements: error {left / _largest(u + found):.1g} of the "
                    f"displacement after {done + steps} steps over nested meshes; take cells of "
                    "better shape, or a smaller nu"
                )
            found += power / stiff * direction
            residual = residual - power / stiff * force
            ahead = self.correct(residual)
            before, power = power, dot(residual.ravel(), ahead.ravel())
            direction = ahead + power / before * direction
            left, steps = _largest(ahead), steps + 1
        return found, steps, (left / first) ** (1 / steps) if steps else 0.0

    def _smoothed(self, residual: Array, *, last: bool = False) -> tuple[Array, Array]:
        """Displacements (n, d) of forces by Chebyshev's polynomial, and the forces left.

        The last have no forces left that were made for nothing.
        """
        _, _, inverse, largest = self._system
        middle, half = (largest + largest / SMOOTHED) / 2, (largest - largest / SMOOTHED) / 2
        share, found = half / middle, np.zeros_like(residual)
        change = _by_node(inverse, residual) / middle
        for step in range(1, DEGREE + 1):
            found += change
            if last and step == DEGREE:
                break
            residual = residual - self._forces(change)
            following = 1 / (2 * middle / half - share)
            more = _by_node(inverse, residual)
            change = following * (share * change + 2 / half * more)
            share = following
        return found, residual

    def _forces(self, u: Array) -> Array:
        """Forces (n, d) in N on the free components of displacements (n, d) in m."""
        return np.asarray(self._free * (self._system[0] @ u.ravel()).reshape(u.shape))

    @cached_property
    def _free(self) -> Array:
        return (~self.held).astype(float)

    @cached_property
    def _system(self) -> tuple[bsr_array, Array, Array, float]:
        """Stiffness by node, its blocks (n, d, d) on the diagonal, inverse ones, an eigenvalue.

        The inverse leaves out what is held; the eigenvalue is the largest of what it scales.
        """
        free, d = self._free, self.body.dim
        with fits_in_memory(self.held.size, "unknowns"):
            K = _block_stiffness(self.body, self.tensor, self.number)
            row = np.repeat(np.arange(len(free), dtype=K.indices.dtype), np.diff(K.indptr))
            own = K.data[K.indices == row]
            kept = own * free[:, :, None] * free[:, None]
            kept[:, range(d), range(d)] += 1 - free
            inverse = np.linalg.inv(kept)
        largest, ahead = 1.0, np.cos(1.7 * np.arange(free.size)).reshape(free.shape)
        for _ in range(POWERS):  # by a wave of every length in no proportion to the mesh
            ahead = _by_node(inverse, free * (K @ (free * ahead).ravel()).reshape(free.shape))
            largest = dot(ahead.ravel(), ahead.ravel()) ** 0.5
            ahead /= largest or 1.0
        return K, own, inverse, MARGIN * largest


def _by_node(blocks: Array, values: Array) -> Array:
    return np.asarray(np.einsum("nab,nb->na", blocks, values))


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
