"""Solves with a network's tangent stiffness, its stability, and what is singular in it."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.double_double import as_pair
from msvalidate.linear_algebra.factor import Factor
from msvalidate.linear_algebra.refine import DOUBTFUL, contraction_bound
from msvalidate.network import Network, tangent_blocks
from msvalidate.network.accurate import State
from msvalidate.problem import Array, Index, SolverError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass
from msvalidate.statics.polish import centre_points
from msvalidate.tangent.cycles import refuse_mechanism_motion
from msvalidate.tangent.inverse import Regular, Solver
from msvalidate.tangent.multigrid import Cycle, is_positive, make_cycle, restrained_tangent
from msvalidate.tangent.stability import negative_modes

LARGEST_TURN = 0.5
"""Change of a spring in one Newton step, relative to its length, beyond which a step is too long:
longer ones land on folded and inside-out equilibria."""


@dataclass(frozen=True, eq=False)
class Tangent:
    """A tangent stiffness, and the inverse of its free part.

    Parameters
    ----------
    free
        (f,) numbers of the free components.
    K
        (n·d, n·d) in N/m.
    found
        Inverse of the free rows and columns, and their softest motion; None where nothing is free.
    """

    free: Index
    K: bsr_array
    found: Regular | None

    @property
    def is_positive_definite(self) -> bool:
        """Whether no pivot is negative, or their signs may be rounding.

        Multigrid has no pivots: it does not solve with what it finds to be negative.
        """
        if self.found is None or not isinstance(self.found.inverse, Factor):
            return True
        if self.found.negative == 0:
            return True
        return not is_inertia_certain(self.found)

    def move(self, load: Array, held: Array) -> Array:
        """Move (n, d) in m that balances a load (n, d) in N, held components moving by `held`."""
        move = np.array(held, dtype=float).ravel()
        move[self.free] = 0.0
        if self.found is not None:
            right = load.ravel() - self.K @ move if move.any() else load.ravel()
            move[self.free] = self.found.inverse.solve(right[self.free])
        return move.reshape(load.shape)


def tangent_at(network: Network, x: Array, solver: Solver) -> Tangent:
    """The tangent at `x` (n, d) in m, and its inverse as a solver has it.

    Raises
    ------
    SolverError
        If some motion meets no stiffness.
    """
    free = np.flatnonzero(~network.held.ravel())
    K = tangent_blocks(network, x)
    return Tangent(free, K, solver.regular(network, x, K) if len(free) else None)


def first_order_move(
    network: Network, x: Array, load: Array, held: Array, solver: Solver
) -> tuple[Array, bool]:
    """Move (n, d) in m from `x` that balances `load` (n, d) in N to first order; is K positive.

    `held` is the move of the held components.

    Raises
    ------
    SolverError
        If some motion meets no stiffness.
    """
    found = tangent_at(network, x, solver)
    positive = found.found is None or is_positive_definite_at(
        network, x - network.points, found.found
    )
    return found.move(load, held), positive


def largest_rotation(network: Network, x: Array, move: Array) -> float:
    """Largest change of a spring's vector in a move, relative to its length; infinite for NaN."""
    i, j = network.springs.T
    length = np.linalg.norm(x[j] - x[i], axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        change = np.linalg.norm(move[j] - move[i], axis=1) / length
    return float(np.nan_to_num(change, nan=np.inf).max(initial=0.0))


def is_stable(network: Network, position: Array, cycle: Cycle | None = None) -> bool:
    """Whether the tangent at `position` (n, d) in m is positive definite: no negative mode.

    Where `inverse.Solver` takes a factor the signs of pivots decide. Elsewhere a random load
    does: a yes is then very likely, as `multigrid.is_positive` says. `cycle` is a multigrid cycle
    of the same network close by, where there is one.
    """
    require_type("network", network, Network)
    if network.held.all():
        return True
    solver = Solver(network)
    if not solver.is_direct:
        A = restrained_tangent(network, position)
        if cycle is not None and is_positive(A, network, position, cycle):
            return True
        own = make_cycle(A, network, position)  # a no needs its own cycle
        return is_positive(A, network, position, own)
    near, displacement = centre_points(network), position - network.points
    try:
        found = solver.regular(near, near.points + displacement)
    except SolverError:  # a mechanism
        return False
    return is_positive_definite_at(network, displacement, found)


def is_positive_definite_at(network: Network, displacement: Array, found: Regular) -> bool:
    """Whether a tangent is: by the signs of pivots where these are no rounding."""
    if is_inertia_certain(found):
        return found.negative == 0
    return negative_modes(State(network, as_pair(displacement)), found, ~network.held) == 0


def is_inertia_certain(found: Regular) -> bool:
    """Whether the signs of a factor's pivots are those of the exact tangent."""
    return contraction_bound(found.softness) <= DOUBTFUL


def refuse_mechanism(network: Network, solver: Solver | None = None) -> None:
    """Raise `SolverError` if some motion from the reference points meets no stiffness.

    Networks too large for a factor are asked by multigrid, which may overlook one; a motion that
    it does name meets none.
    """
    x = network.points
    if network.held.all():
        return
    solver = solver or Solver(network)
    if solver.is_direct:
        solver.regular(network, x)
        return
    refuse_mechanism_motion(restrained_tangent(network, x), network, x)
