"""Floor 2: static equilibrium of a network, by one linear solve or by Newton's method."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from msvalidate.accurate import State
from msvalidate.double_double import pair
from msvalidate.linear import is_factored
from msvalidate.linear_solution import solved
from msvalidate.mechanism import Regular, is_loose, named, regular
from msvalidate.multigrid import Cycle, cycle_of, is_positive, restrained, softest_motion
from msvalidate.network import Network, internal_force, tangent
from msvalidate.polish import balance, centred, polished
from msvalidate.problem import (
    Array,
    SolverError,
    chosen,
    instance,
    refuse_free_motions,
)
from msvalidate.refine import DOUBTFUL, contraction
from msvalidate.residual import force_roundoff, force_scale
from msvalidate.stability import negative_modes

TOLERANCE = 1e-11
"""Newton stops at this residual, relative to the forces that meet at a point (and not below their
rounding). Convergence is quadratic, so what is reached is usually rounding."""
ITERATIONS = 25
"""Newton steps a load increment may take: far more than quadratic convergence needs."""
SMALLEST_INCREMENT = 2.0**-12
LARGEST_TURN = 0.5
"""Change of a spring in one Newton step, relative to its length, beyond which the load increment is
halved: longer steps land on folded and inside-out equilibria."""


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A network at rest under its supports and loads.

    Parameters
    ----------
    displacement
        (n, d) from the reference points (m).
    position
        (n, d) in m.
    reaction
        (n, d) force (N) of the supports on the held components, 0 elsewhere.
    residual
        Largest out-of-balance force (N) on a free component.
    iterations
        Linear solves that it took, or time steps.
    error
        Largest error of a component of the displacement over the largest component: an estimate
        from what refinement says, above the rounding that is known. 0 where nothing moves, NaN
        where it was not estimated.
    """

    displacement: Array
    position: Array
    reaction: Array
    residual: float
    iterations: int
    error: float = math.nan


def equilibrium(
    network: Network, geometry: Literal["linear", "nonlinear"] = "linear"
) -> Equilibrium:
    """Static equilibrium of a network.

    Parameters
    ----------
    network
        Supports must hold every rigid motion.
    geometry
        "linear": one solve with the tangent at the reference points, valid to first order in the
        displacement. "nonlinear": Newton's method, in load increments where one step is too many.
        Either way the tangent must be positive: the network is stable where it is linearised.
        It is factorised at any size; `relax` by "newton_multigrid" takes less of large networks.

    Raises
    ------
    ProblemError
        If supports leave a rigid motion free; the message names it.
    SolverError
        If the network is a mechanism or unstable, or no equilibrium is found at full load.
    """
    instance("network", network, Network)
    refuse_free_motions("network", network.points, network.held)
    chosen("geometry", geometry, ("linear", "nonlinear"))
    with np.errstate(over="ignore", invalid="ignore"):  # the residual refuses what has no numbers
        return _linear(network) if geometry == "linear" else _nonlinear(network)


def at_rest(
    network: Network, displacement: Array, iterations: int, *, error: float = math.nan
) -> Equilibrium:
    """The equilibrium at a displacement (n, d) in m, with the residual and reactions found there.

    Forces come from the displacement: positions have lost digits where coordinates are large.
    """
    left = balance(network, displacement)
    displacement.setflags(write=False)
    return Equilibrium(
        displacement=displacement,
        position=network.points + displacement,
        reaction=np.where(network.held, -left, 0.0),
        residual=_largest(left[~network.held]),
        iterations=iterations,
        error=error,
    )


def is_stable(network: Network, position: Array, cycle: Cycle | None = None) -> bool:
    """Whether every free motion from `position` (n, d) in m meets stiffness: no negative mode.

    Up to `linear.LARGEST_FACTORED` components the signs of pivots decide. Beyond, a random load
    does: a yes is then very likely, as `multigrid.is_positive` says. `cycle` is a multigrid cycle
    of the same network close by, where there is one.
    """
    instance("network", network, Network)
    free = ~network.held
    if not is_factored(free):
        A = restrained(network, position)
        if cycle is not None and is_positive(A, network, position, cycle):
            return True
        own = cycle_of(A, network, position)  # a no needs its own cycle
        return is_positive(A, network, position, own)
    if network.held.all():
        return True
    inside = np.flatnonzero(free.ravel())
    near, displacement = centred(network), position - network.points
    x = near.points + displacement
    try:
        found = regular(near, x, csr_array(tangent(near, x)[inside][:, inside]))
    except SolverError:  # a mechanism
        return False
    return _is_positive(network, displacement, found)


def _is_positive(network: Network, displacement: Array, found: Regular) -> bool:
    """Whether a tangent is: by the signs of pivots where these are no rounding."""
    if contraction(found.softness) <= DOUBTFUL:
        return found.factor.negative == 0
    return negative_modes(State(network, pair(displacement)), found, ~network.held) == 0


def _linear(network: Network) -> Equilibrium:
    found = solved(network)
    return Equilibrium(
        displacement=found.displacement,
        position=network.points + found.displacement,
        reaction=found.reaction,
        residual=_largest(found.balance[~network.held]),
        iterations=1 + found.steps,
        error=found.error,
    )


def _nonlinear(network: Network) -> Equilibrium:
    """Raise load and prescribed displacement together, in halves of what would not converge."""
    given, network = network, centred(network)
    position, reached, increment, iterations = network.points, 0.0, 1.0, 0
    while reached < 1:
        target = min(1.0, reached + increment)
        found, taken, factor = _newton(network, position, target)
        iterations += taken
        if found is not None:
            position, reached, increment = found, target, 2 * increment
            continue
        increment /= 2
        if increment < SMALLEST_INCREMENT:
            raise SolverError(
                "nonlinear equilibrium: no stable equilibrium found beyond "
                f"{reached:.4g} of the load (after {iterations} linear solves); reduce the load or "
                "stiffen the network"
            )
    end = polished(given, position - network.points, factor)
    return at_rest(given, end.displacement, iterations + end.steps, error=end.error)


def _newton(
    network: Network, position: Array, fraction: float
) -> tuple[Array | None, int, Regular | None]:
    """Stable equilibrium at a fraction of the load, None if there is none near; solves; factor."""
    x = position
    floor = 4 * force_roundoff(network)
    for iteration in range(ITERATIONS):
        ahead = network.points + fraction * network.displacement - x
        try:
            balance = internal_force(network, x) + fraction * network.force
            small = TOLERANCE * force_scale(network, x) + floor
            move, stable, found = tangent_moved(network, x, tangent(network, x), balance, ahead)
        except SolverError:
            if iteration == 0:  # singular where we stand: smaller steps cannot help
                raise
            return None, iteration, None
        # Judged with the tangent of the same place: the one before would miss a bifurcation.
        arrived = _largest(ahead[network.held]) <= _rounding(x)
        if arrived and (np.abs(balance) <= small)[~network.held].all():
            return (x if stable else None), iteration + 1, found
        if largest_turn(network, x, move) > LARGEST_TURN:
            return None, iteration + 1, None
        x = x + move
    return None, ITERATIONS, None


def largest_turn(network: Network, x: Array, move: Array) -> float:
    """Largest change of a spring's vector in a move, relative to its length; infinite for NaN."""
    i, j = network.springs.T
    length = np.linalg.norm(x[j] - x[i], axis=1)
    with np.errstate(over="ignore", invalid="ignore"):
        change = np.linalg.norm(move[j] - move[i], axis=1) / length
    return float(np.nan_to_num(change, nan=np.inf).max(initial=0.0))


class Moved(NamedTuple):
    """A move (n, d) in m, whether the tangent is positive, and its factor if anything is free."""

    move: Array
    stable: bool
    found: Regular | None


def tangent_move(
    network: Network, x: Array, K: csr_array, load: Array, held: Array
) -> tuple[Array, bool]:
    """As `tangent_moved`, without the factor."""
    return tangent_moved(network, x, K, load, held)[:2]


def tangent_moved(network: Network, x: Array, K: csr_array, load: Array, held: Array) -> Moved:
    """Move (n, d) in m from `x` that balances `load` (n, d) in N to first order; is K positive.

    `K` is the tangent at `x`, `held` the move of the held components. The factor serves `polished`
    where `x` is the equilibrium.

    Raises
    ------
    SolverError
        If some motion meets no stiffness.
    """
    free = np.flatnonzero(~network.held.ravel())
    move = np.where(network.held, held, 0.0).ravel()
    if not len(free):
        return Moved(move.reshape(load.shape), True, None)
    rows = K[free]
    found = regular(network, x, rows[:, free])
    move[free] = found.factor.solve(load.ravel()[free] - rows @ move)
    stable = _is_positive(network, x - network.points, found)
    return Moved(move.reshape(load.shape), stable, found)


def refuse_mechanism(network: Network) -> None:
    """Raise `SolverError` if some motion from the reference points meets no stiffness.

    Networks too large for a factor are asked by multigrid, which may overlook one; a motion that
    it does name meets none.
    """
    x = network.points
    if network.held.all():
        return
    if is_factored(~network.held):
        free = np.flatnonzero(~network.held.ravel())
        regular(network, x, tangent(network, x)[free][:, free])
        return
    A = restrained(network, x)
    mode = softest_motion(A, network, x)
    if mode.any() and is_loose(network, x, mode, A.diagonal()):
        raise SolverError(named(network, mode))


def _rounding(x: Array) -> float:
    return float(4 * np.finfo(float).eps * np.abs(x).max())


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))
