"""Solves with a network's tangent stiffness, its stability, and what is singular in it."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.factor import Factor
from msvalidate.linear_algebra.multigrid import Cycle
from msvalidate.problem import Array, Index, SolverError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.inverse import Regular, Solver
from msvalidate.springs.network.mechanism import is_certain
from msvalidate.springs.network.multigrid import refuse_mechanism_motion, restrained_tangent
from msvalidate.springs.network.stability import negative_modes

LARGEST_TURN = 0.5
"""Largest relative change of a spring vector in one Newton step.

Longer steps lead to folded and inverted equilibria.
"""


@dataclass(frozen=True, eq=False)
class Tangent:
    """A tangent stiffness, and the inverse of its free part.

    `free`: (f,) numbers of the free components. `K`: (n·d, n·d) in N/m. `factorised`: inverse of
    the free rows and columns, and their softest motion; None where nothing is free.
    """

    free: Index
    K: bsr_array
    factorised: Regular | None

    @property
    def is_stable(self) -> bool:
        """Return True if the tangent is positive definite.

        The signs of the pivots decide where they are no rounding. Raises `SolverError` as
        `negative_modes` if the signs remain unknown.
        """
        return self.factorised is None or negative_modes(self.factorised) == 0

    @property
    def no_pivot_negative(self) -> bool:
        """Return True if no pivot is negative, or their signs may be rounding.

        Multigrid has no pivots: it does not solve with what it finds to be negative.
        """
        if self.factorised is None or not isinstance(self.factorised.inverse, Factor):
            return True
        if self.factorised.negative == 0:
            return True
        return not is_certain(self.factorised.softness)

    def move(self, load: Array, fixed: Array) -> Array:
        """Motion (n, d) in m that balances a load (n, d) in N.

        The fixed components move by `fixed`.
        """
        move = np.array(fixed, dtype=float).ravel()
        move[self.free] = 0.0
        if self.factorised is not None:
            right = load.ravel() - self.K @ move if move.any() else load.ravel()
            move[self.free] = self.factorised.inverse.solve(right[self.free])
        return move.reshape(load.shape)


def tangent_at(at: Configuration, solver: Solver) -> Tangent:
    """The tangent there, and its inverse as a solver has it.

    Raises `SolverError` if some motion meets no stiffness.
    """
    free = np.flatnonzero(~at.network.fixed.ravel())
    K = at.tangent()
    return Tangent(free, K, solver.regular(at, K) if len(free) else None)


def is_stable(at: Configuration, cycle: Cycle | None = None) -> bool:
    """Return True if the tangent of a configuration is positive definite.

    Where `inverse.Solver` takes a factor the signs of pivots decide. Elsewhere a random load
    does: a yes is then very likely, as `Cycles.probed` says, and a no may be for want of a
    factor. `cycle` is a multigrid cycle of the same network close by, where there is one.
    """
    require_type("configuration", at, Configuration)
    if at.network.fixed.all():
        return True
    try:
        return negative_modes(Solver(at.network, cycle=cycle).regular(at)) == 0
    except SolverError:  # a mechanism, or nothing tells
        return False


def refuse_mechanism(network: Network) -> None:
    """Raise `SolverError` if some motion from the reference points meets no stiffness.

    Networks too large for a factor are asked by multigrid, which may overlook one; a motion that
    it does name meets none.
    """
    if network.fixed.all():
        return
    at, solver = Configuration(network), Solver(network)
    if solver.is_direct:
        solver.regular(at)
    else:
        refuse_mechanism_motion(restrained_tangent(at), at)
