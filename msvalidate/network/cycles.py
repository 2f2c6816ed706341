"""Multigrid as the inverse of a network's tangent: conjugate gradients, a cycle a step."""

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
from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.network import Configuration
from msvalidate.network.mechanism import NO_STIFFNESS, describe_motion, relative_stiffness
from msvalidate.network.multigrid import make_cycle, softest_motion
from msvalidate.problem import Array, Mask, SolverError
from msvalidate.problem.records import dataclass

PART = 1e-5
"""Of an answer's error that multigrid leaves: refinement takes the rest away in three corrections,
each with a residual of its own, which costs as much as two cycles."""
ROUGHLY = 1e-3
WORN = 60
"""Steps by a cycle of another place from which one of this place is made."""


class NotConvergedError(SolverError):
    """Multigrid did not converge, which says nothing about the network."""


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
        found = self._settled(right / size, part)
        if found.negative or not found.reduction <= part * min(found.lowest, 1.0):
            raise NotConvergedError(
                f"multigrid: {found.reduction:.1g} of the residual is left after {found.steps} "
                "cycles"
            )
        self.steps = max(self.steps, found.steps)
        return found.solution[self._free] * (size / self.cycle.unit)

    @property
    def negative(self) -> int:
        """1 if a motion of negative energy was met, else 0: very likely there is none."""
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
        found = self._settled(load, ROUGHLY)
        return found.solution[self._free], not found.negative and found.reduction <= ROUGHLY

    def _settled(self, right: Array, part: float) -> Iterated:
        """What conjugate gradients make of a load (f,), with a cycle of its own where it must."""
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
        return np.asarray(~self.at.network.held.ravel())


def refuse_mechanism_motion(A: bsr_array, at: Configuration) -> None:
    """Raise `SolverError` if a motion is found that meets no stiffness: a long search.

    `A` is `restrained_tangent` there.
    """
    mode = softest_motion(A, at)
    if mode.any() and not abs(relative_stiffness(at, mode, A.diagonal())) > NO_STIFFNESS:
        raise SolverError(describe_motion(at.network, mode))
