"""The end of a nonlinear solution: Newton's corrections with accurate residuals.

The state is the displacement, as a pair of doubles: positions far from the origin, or of a long
body, have no digits left for small strains. Elongations come from the springs' own vectors
(`accurate`). The tangent needs no more than its usual digits, so one factor serves several
corrections; each leaves a small part of the error before it, which is how the error is known.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from msvalidate.linear_algebra.double_double import ROUNDING, Pair, add, as_pair
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.linear_algebra.refine import (
    DOUBTFUL,
    ENOUGH,
    LARGEST_ERROR,
    Refined,
    error_amplification,
    error_estimate,
    refine_solution,
    refuse_inaccurate,
    refuse_underflow,
)
from msvalidate.network import Network
from msvalidate.network.accurate import State
from msvalidate.problem import Array, SolverError
from msvalidate.tangent.inverse import Regular, Solver
from msvalidate.tangent.multigrid import Cycle, conjugate_gradients, make_cycle, restrained_tangent
from msvalidate.tangent.rounding import explain_rounding, is_unloaded, trial_motion
from msvalidate.tangent.stability import negative_modes

TITLE = "nonlinear equilibrium"
FAR = 4.0
"""Largest coordinate, in sizes of the body, at which positions have the digits of a tangent."""
LARGEST_TURN = 0.5
"""Change of a spring in all corrections, relative to its length, beyond which another equilibrium
may have been found."""
SAME_TANGENT = 1e-3
"""Such a change up to which the tangent's signs are those of where it was made."""
FACTORS = 10
"""Tangents made at the most."""
FEW = 2
"""Corrections that may fail to fall before a new tangent is made."""
DIGITS = 64 * ROUNDING / LARGEST_ERROR
"""Displacement over the body's size below which rounding of positions, in twice the digits of
doubles, is more than may be left, if the softest motion meets as much as any; some room with it."""
SMALLEST_STRAIN = 1e-16
"""Displacement over the body's size below which no double shows what is not linear."""
CYCLES_PART = 1e-4
"""What conjugate gradients leave of a correction."""


class RefinedEquilibrium(NamedTuple):
    """An equilibrium: displacement (n, d) in m and the digits that it lacks, its error, and solves.

    The error is of the displacement, over the largest.
    """

    displacement: Array
    remainder: Array
    error: float
    steps: int


def centre_points(network: Network) -> Network:
    """The network with its points counted from one of them, where they are far from the origin.

    Differences of points are kept, to the rounding of the body's own size. Displacements and forces
    stay the same.
    """
    points = network.points
    size = float(np.ptp(points, axis=0).max())
    if np.abs(points).max() <= FAR * size:
        return network
    moved = points - points[len(points) // 2]
    volumes = network.volumes
    return replace(
        network,
        points=moved,
        volumes=None if volumes is None else replace(volumes, points=moved),
    )


def out_of_balance_force(
    network: Network, displacement: Array, remainder: Array | None = None
) -> Array:
    """Force (n, d) in N that springs, cells and loads leave at a displacement (n, d) in m.

    `remainder` (n, d) are the digits that it lacks.
    """
    lacks = np.zeros_like(displacement) if remainder is None else remainder
    return _Nonlinear(network, Pair(displacement, lacks)).balance()


def refine_equilibrium(
    network: Network, displacement: Array, found: Regular | None, solver: Solver
) -> RefinedEquilibrium:
    """The equilibrium near a displacement, refined to double precision, and its error.

    Parameters
    ----------
    network
        With all of its load and prescribed displacement.
    displacement
        (n, d) in m, close to the equilibrium.
    found
        Inverse of the tangent there, where it is at hand.
    solver
        Which makes others.

    Raises
    ------
    SolverError
        If the network is a mechanism or unstable there, or no trustworthy digits are left.
    """
    u = as_pair(np.where(network.held, network.displacement, displacement))
    if network.held.all():
        return RefinedEquilibrium(u.hi, u.lo, 0.0, 0)
    if is_unloaded(network, State(network)) and not u.hi.any():
        return RefinedEquilibrium(u.hi, u.lo, 0.0, 0)
    near, before = centre_points(network), u.hi
    system = _Nonlinear(network, u, near, found, solver)
    moved = system.refined()
    if not (
        moved.converged and _largest_rotation(network, moved.solution.hi - u.hi) <= SAME_TANGENT
    ):
        system, moved = _solve_newton(network, u, near, solver)
    u = moved.solution
    _refuse_far(_largest_rotation(network, u.hi - before))
    refuse_underflow(max_abs(u.hi), TITLE)
    error = system.stated(moved)
    refuse_inaccurate(
        error, TITLE, _explain_missing_digits(network, max_abs(u.hi), system.found.softness)
    )
    system.refuse_unstable()
    return RefinedEquilibrium(u.hi, u.lo, error, moved.steps)


def _explain_missing_digits(network: Network, moved: float, softness: float) -> str:
    """Why digits are missing where the largest displacement is `moved` (m), and what to do."""
    part = moved / float(np.ptp(network.points, axis=0).max())
    least = DIGITS / max(abs(softness), np.finfo(float).tiny)
    if not 0 < part < least <= SMALLEST_STRAIN:
        return explain_rounding(network, softness)
    return (
        f"it moves the body by {part:.1g} of its size, which positions have no digits for; take "
        f"geometry 'linear', or {least / part:.1g} times the load"
    )


def _solve_newton(
    network: Network, u: Pair, near: Network, solver: Solver
) -> tuple[_Nonlinear, Refined]:
    """Newton's method, each step refined on its own: the last system, and what was reached."""
    sizes, steps, error = [], 0, np.inf
    for _ in range(FACTORS):
        system = _Nonlinear(network, u, near, None, solver)
        step = system.newton_step()
        steps += step.steps + 1
        sizes.append(max_abs(step.solution.hi))
        if (
            not np.isfinite(sizes[-1])
            or _largest_rotation(network, step.solution.hi) > LARGEST_TURN
        ):
            break
        u = add(u, step.solution)
        scale = max_abs(u.hi) or 1.0
        if sizes[-1] <= ENOUGH * scale:
            return system, Refined(u, 2 * sizes[-1] / scale, steps, converged=True)
        error = 2 * sizes[-1] / scale
    return system, Refined(u, error, steps)


def error_of_displacement(
    network: Network, displacement: Array, found: Regular | Cycle | None = None
) -> float:
    """Error of a displacement (n, d) in m close to an equilibrium, over the largest displacement.

    By corrections that are not applied; infinite where they do not lead to an equilibrium.
    `found` is a factor of the tangent there, or a multigrid cycle close by, where there is one.
    Without a factor conjugate gradients make one correction.
    """
    size = max_abs(displacement)
    if network.held.all() or not size:
        return 0.0 if network.held.all() else _error_of_nothing(network)
    start = as_pair(displacement)
    near = centre_points(network)
    solver = Solver(near)
    if isinstance(found, Cycle) or (found is None and not solver.is_direct):
        step = _correct_by_multigrid(network, start, near, found)
        return 2 * max_abs(step) / size
    try:
        known_one = found if isinstance(found, Regular) else None
        system = _Nonlinear(network, start, near, known_one, solver)
        moved = system.refined()
    except SolverError:
        return math.inf
    apart = max_abs(add(moved.solution, as_pair(-displacement)).hi)
    return (apart * 1.01) / size + system.stated(moved) * max_abs(moved.solution.hi) / size


def _error_of_nothing(network: Network) -> float:
    """Of a displacement of nothing: 0 if nothing acts."""
    left = np.where(
        network.held, 0.0, out_of_balance_force(network, np.zeros(network.points.shape))
    )
    return math.inf if left.any() else 0.0


class _Nonlinear:
    """Forces at a displacement over powers of two, and the factor of a tangent close by."""

    def __init__(
        self,
        network: Network,
        u: Pair,
        near: Network | None = None,
        found: Regular | None = None,
        solver: Solver | None = None,
    ) -> None:
        self.network, self.free, self.place = network, ~network.held, u.hi
        self.state = State(network, u)
        self.unit = self.state.length
        if near is None:
            return
        place = near.points + u.hi
        self.found = found or (solver or Solver(near)).regular(near, place)

    def refuse_unstable(self) -> None:
        """Raise `SolverError` if some motion from here has negative energy."""
        if negative_modes(self.state, self.found, self.free):
            raise SolverError(
                f"{TITLE}: the network is unstable under its full load; reduce the load or stiffen "
                "the network"
            )

    def left(self, state: State) -> Array:
        """Force (n, d) that is left, over `state.stiffness` x `state.length`."""
        load = as_pair(self.network.force / state.stiffness / state.length)
        return add(state.force(), load).hi

    def balance(self) -> Array:
        """Force (n, d) in N that is left where this is."""
        return self.left(self.state) * (self.state.stiffness * self.state.length)

    def residual(self, u: Pair) -> Array:
        """Force left where it is free, at a displacement (n, d) in m."""
        state = self.state if u.hi is self.place else State(self.network, u)
        return np.where(self.free, self.left(state), 0.0)

    def solve(self, force: Array) -> Array:
        """Displacement (n, d) in m that the factor gives for a force, scaled as `left`."""
        motion = np.zeros(force.shape)
        right = force[self.free]  # over the tangent a small one may leave the range of doubles
        size = 2.0 ** (math.frexp(max_abs(right))[1] - 1)
        solved = self.found.inverse.solve(right / size) * self.state.stiffness
        motion[self.free] = solved * (size * self.unit)
        return motion

    def newton_step(self) -> Refined:
        """The step of Newton's method from here (n, d) in m, itself refined."""
        force = np.where(self.free, self.left(self.state), 0.0)
        load = as_pair(force)

        def left(step: Pair) -> Array:
            return np.where(self.free, self.state.residual(load, step).hi, 0.0)

        start = as_pair(self._solve_linear(force))
        found = refine_solution(left, self._solve_linear, start, self.found.rate)
        return replace(found, solution=Pair(*(x * self.unit for x in found.solution)))

    def refined(self) -> Refined:
        """Corrections from here, all by one factor."""
        rate = self.found.rate
        start = Pair(self.place, np.zeros_like(self.place))
        return refine_solution(self.residual, self.solve, start, rate, solved=False, patience=FEW)

    def stated(self, moved: Refined) -> float:
        """The error to state of what was refined."""
        if not moved.solution.hi.any():
            return np.inf if self.residual(moved.solution).any() else 0.0
        rate, times = self.found.rate, 1.0
        if rate > DOUBTFUL:
            times = error_amplification(
                self._linear, self._solve_linear, rate, trial_motion(self.free, self.found.mode)
            )
        pulled = self.state.pulled * self.unit / max_abs(moved.solution.hi)
        return error_estimate(moved, self.found.softness, times, pulled)

    def _linear(self, motion: Pair) -> Array:
        zero = as_pair(np.zeros(self.free.shape))
        return np.where(self.free, self.state.residual(zero, motion).hi, 0.0)

    def _solve_linear(self, force: Array) -> Array:
        return self.solve(force) / self.unit


def _correct_by_multigrid(network: Network, u: Pair, near: Network, cycle: Cycle | None) -> Array:
    """One correction by conjugate gradients with a multigrid cycle."""
    x = near.points + u.hi
    A = restrained_tangent(near, x)
    cycle = cycle or make_cycle(A, near, x)
    force = np.where(network.held, 0.0, out_of_balance_force(network, u.hi)).ravel()
    if not force.any():
        return np.zeros(network.points.shape)
    found = conjugate_gradients(A, force, cycle, CYCLES_PART)
    return np.asarray(found.solution).reshape(network.points.shape)


def _refuse_far(turn: float) -> None:
    if not turn <= LARGEST_TURN:
        raise SolverError(
            f"{TITLE}: corrections turn a spring by {turn:.2g} of its length: rounding hides the "
            "equilibrium; take a larger load, or stiffnesses that are closer together"
        )


def _largest_rotation(network: Network, move: Array) -> float:
    i, j = network.springs.T
    length = np.linalg.norm(network.vector, axis=1)
    change = np.linalg.norm(move[j] - move[i], axis=1) / length
    return float(np.nan_to_num(change, nan=np.inf).max(initial=0.0))
