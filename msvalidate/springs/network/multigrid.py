"""Multigrid as the inverse of a network's tangent: conjugate gradients, a cycle a step.

And the motion that the tangent resists least.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.conjugate_gradients import (
    MOST_STEPS,
    Iterated,
    answer_to_random_load,
    conjugate_gradients,
)
from msvalidate.linear_algebra.multigrid import Cycle, aggregate, diagonal_blocks, restrain_in_place
from msvalidate.problem import Array, Index, Mask, SolverError, rigid_motions
from msvalidate.problem.records import dataclass
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.mechanism import NO_STIFFNESS, describe_motion, relative_stiffness

PART = 1e-5
"""Relative error of a multigrid solution before refinement.

Refinement removes the rest in three corrections, whose residuals cost as much as two cycles each.
"""
ROUGHLY = 1e-3
WORN = 60
"""Steps by a cycle of another place from which one of this place is made."""
LOOSE = 1e-8
"""Relative shift of the diagonal in the search for modes without stiffness.

It is a hundred times the rounding that the library's inverses of blocks assume.
"""
SWEEPS, MOST_SWEEPS = 2, 12
"""Number of inverse iterations.

Each reduces modes of relative stiffness 1e-4 by 1e-4; modes of stiff points among soft ones have
less. The first iterations need no more digits than an assembled stiffness has.
"""
STANDING = 1e-13
"""Change of a mode per iteration that ends the search.

The error of its energy is the square of that change.
"""
MOST_UNSETTLED = 3
"""Sweeps that conjugate gradients may leave unsettled: more bring a motion no nearer."""
CLEAN = 1e-10
"""Relative residual of an iteration's solve.

It leaves 1e-14 of other modes in one without stiffness, by `LOOSE`.
"""
LARGE_RATIO = 3.0
"""Mean difference of point numbers per spring beyond which points are sorted.

It is in points of a layer: lattices have less than 1, random numbers n^(1/d)/3.
"""


class NotConvergedError(SolverError):
    """Multigrid gives no answer; a factor may give one.

    Multigrid did not converge, or the softest motion has so little stiffness that rounding hides
    its sign. Neither means that the network is unstable or a mechanism.
    """


@dataclass(eq=False)
class Cycles:
    """Multigrid as an inverse: conjugate gradients, with one cycle a step.

    `A`: tangent, restrained. `at`: whose tangent it is. `cycle`: of this tangent, or of one close
    by. `is_own`: whether of this tangent. `steps`: of conjugate gradients, the most in one
    solution.
    """

    A: bsr_array
    at: Configuration
    cycle: Cycle
    is_own: bool
    steps: int = 0

    def solve(self, right: Array, part: float = PART) -> Array:
        """Solution (f,) for a right-hand side (f,), to a part of itself.

        Raises `NotConvergedError` if conjugate gradients do not get there.
        """
        largest = float(np.abs(right).max(initial=0.0))
        if not largest:
            return np.zeros(len(right))
        size = 2.0 ** math.frexp(largest)[1]
        found = self._iterate(right / size, part)
        if found.negative or not found.reduction <= part * min(found.lowest, 1.0):
            raise NotConvergedError(
                f"multigrid: {found.reduction:.1g} of the residual is left after {found.steps} "
                "cycles"
            )
        self.steps = max(self.steps, found.steps)
        return found.solution[self._free] * (size / self.cycle.unit)

    @property
    def negative(self) -> int:
        """1 if a direction of negative curvature was found, else 0.

        If it is 0, there is very likely none.
        """
        return self.probed[1]

    @cached_property
    def probed(self) -> tuple[Array, int, bool]:
        """Motion (f,) that resists least; whether one has negative energy; whether that is told.

        By `answer_to_random_load`.
        """
        found, told = answer_to_random_load(self.A, self.cycle, self._free)
        if not (told or self.is_own):
            self.cycle, self.is_own = make_cycle(self.A, self.at), True
            found, told = answer_to_random_load(self.A, self.cycle, self._free)
        falling = self.cycle.indefinite_motion
        falls = falling is not None and bool(falling @ (self.A @ falling) <= 0)
        if falls or found.negative:
            mode = softest_motion(self.A, self.at)
            if not mode.any():
                mode = falling if falls and falling is not None else found.solution
            return mode[self._free], 1, True
        return found.solution[self._free], 0, told

    def softer(self, mode: Array) -> tuple[Array, bool]:
        """Another step of inverse iteration from a motion (f,); whether it was told."""
        weight = self.A.diagonal()[self._free]
        load = weight / weight.max() * (mode / np.abs(mode).max())
        found = self._iterate(load, ROUGHLY)
        return found.solution[self._free], not found.negative and found.reduction <= ROUGHLY

    def _iterate(self, right: Array, part: float) -> Iterated:
        """Solve for a load (f,) by conjugate gradients, with a new cycle if needed."""
        while True:
            load = np.zeros(self.A.shape[0])
            load[self._free] = right * self.cycle.unit
            most = MOST_STEPS if self.is_own else WORN
            found = conjugate_gradients(self.A, load, self.cycle, part, most=most, spectral=True)
            settled = not found.negative and found.reduction <= part * min(found.lowest, 1.0)
            if self.is_own or settled:
                return found
            self.cycle, self.is_own = make_cycle(self.A, self.at), True

    @cached_property
    def _free(self) -> Mask:
        return np.asarray(~self.at.network.fixed.ravel())


def refuse_mechanism_motion(A: bsr_array, at: Configuration) -> None:
    """Raise `SolverError` if a motion is found that meets no stiffness: a long search.

    `A` is `restrained_tangent` there.
    """
    mode = softest_motion(A, at)
    if mode.any() and not abs(relative_stiffness(at, mode, A.diagonal())) > NO_STIFFNESS:
        raise SolverError(describe_motion(at.network, mode))


def restrained_tangent(at: Configuration) -> bsr_array:
    """Tangent stiffness (n·d, n·d) with fixed components uncoupled by `restrain_in_place`."""
    K = at.tangent()
    restrain_in_place(K, ~at.network.fixed)
    return K


def make_cycle(A: bsr_array, at: Configuration) -> Cycle:
    """A cycle whose coarse spaces hold the rigid motions of the points there.

    `A` is `restrained_tangent` there. The same system has the same cycle, to the last digit.
    """
    network, free = at.network, ~at.network.fixed
    centred = network.points - network.points.mean(axis=0)
    centred += at.displacement - at.displacement.mean(axis=0)
    rigid = rigid_motions(centred / np.abs(centred).max()).reshape(free.size, -1)
    return aggregate(A, rigid * free.reshape(-1, 1), _order_by_place(network))


def _order_by_place(network: Network) -> Index | None:
    """Points (n,) in layers, rows and along them, as lattices have them; alike ones by number.

    None where they are numbered with regard to their places: else cycles take more steps.
    """
    (n, d), (i, j) = network.points.shape, network.springs.T
    if np.abs(i - j).mean() <= LARGE_RATIO * n ** (1 - 1 / d):
        return None
    spacing = float(np.linalg.norm(network.vector, axis=1).mean())
    layers = np.floor((network.points - network.points.min(axis=0)) / spacing + 0.25)
    return np.lexsort(layers.T)


def softest_motion(A: bsr_array, at: Configuration) -> Array:
    """Motion (n·d,) that meets the least stiffness, its largest component 1, by inverse iteration.

    `A` is `restrained_tangent` there. It is stiffened by a part ε of what each point meets, D, so
    that a mechanism has an inverse too. A sweep (A + εD)⁻¹ εD x is made as x - (A + εD)⁻¹ A x at
    last, A x from the springs' own elongations: rounding in stiff springs
    would else deform the soft ones beside them. Without an answer, of a network that is unstable,
    all are 0.

    Source: inverse iteration, [GolubVanLoan2013], section 8.2.
    """
    d = at.network.dim
    blocks, row = diagonal_blocks(A)
    met = np.repeat(blocks.trace(axis1=1, axis2=2), d)
    met /= np.abs(met).max()
    data = A.data.copy()
    data[A.indices == row] += LOOSE * A.data.max() * (met.reshape(-1, d, 1) * np.eye(d))
    stiffened = bsr_array((data, A.indices, A.indptr), shape=A.shape)
    free = ~at.network.fixed
    cycle = make_cycle(stiffened, at)
    mode = np.where(free, np.random.default_rng(0).normal(size=free.shape), 0.0).ravel()
    unsettled = 0
    for sweep in range(MOST_SWEEPS):
        exact, before = sweep >= SWEEPS, mode
        load = force_against(at, mode) if exact else met * mode * cycle.unit
        outcome = conjugate_gradients(stiffened, load, cycle, CLEAN)
        mode = mode - outcome.solution if exact else outcome.solution
        size = np.abs(mode).max()
        if outcome.negative or not size:
            return np.zeros_like(mode)
        mode = mode / size
        unsettled += not outcome.reduction <= CLEAN
        if exact and (np.abs(mode - before).max() <= STANDING or unsettled > MOST_UNSETTLED):
            break
    return mode


def force_against(at: Configuration, motion: Array) -> Array:
    """Force (n·d,) in N that a motion (n·d,) in m meets, where it is free.

    By the springs' own vectors: sums of large entries would lose what meets little.
    """
    held = at.network.fixed
    return np.where(held, 0.0, -at.force_change(motion.reshape(held.shape))).ravel()


def free_force(at: Configuration, mode: Array) -> Array:
    """As `force_against`, of and on what is free (f,)."""
    free = ~at.network.fixed.ravel()
    motion = np.zeros(free.shape)
    motion[free] = mode
    return force_against(at, motion)[free]
