"""The linear equilibrium of a network: one inverse, and refinement to the last digit."""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.double_double import Pair, add, as_pair, negate
from msvalidate.linear_algebra.refine import (
    DOUBTFUL,
    InaccurateError,
    error_amplification,
    error_estimate,
    refine_solution,
    refuse_inaccurate,
    refuse_underflow,
)
from msvalidate.network import Network, tangent_blocks
from msvalidate.network.accurate import State
from msvalidate.problem import Array, Mask, SolverError
from msvalidate.problem.records import dataclass
from msvalidate.tangent.cycles import NotConvergedError
from msvalidate.tangent.inverse import Choice, Regular, Solver
from msvalidate.tangent.rounding import explain_rounding, is_unloaded, trial_motion
from msvalidate.tangent.stability import negative_modes

TITLE = "linear equilibrium"
TOO_FAR = "linear equilibrium: forces beyond all numbers; choose units that give ordinary forces"


@dataclass(frozen=True, eq=False)
class LinearSolution:
    """A linear equilibrium.

    Parameters
    ----------
    displacement, remainder
        (n, d) in m, and what it lacks in digits.
    balance
        (n, d) force (N) that is left over: where it is held, minus the supports' reaction.
    error
        Largest error of a component of the displacement over the largest component.
    steps
        Corrections made.
    held
        (n, d) components whose displacement is prescribed.
    choice
        How the tangent was inverted; None where nothing had to be solved.
    """

    displacement: Array
    remainder: Array
    balance: Array
    error: float
    steps: int
    held: Mask
    choice: Choice | None = None

    @property
    def reaction(self) -> Array:
        """(n, d) force (N) of the supports, 0 where nothing is held."""
        return np.where(self.held, -self.balance, 0.0)


def solve_linear(network: Network, wanted: str = "auto") -> LinearSolution:
    """The linear equilibrium of a network from its reference points.

    `wanted` is one of `inverse.SOLVERS`.

    Raises
    ------
    SolverError
        If the network is a mechanism or unstable, or no trustworthy digits are left.
    """
    system, solver = _System(network), Solver(network, wanted)
    while True:
        if not network.held.all():
            system.invert(solver)
        if is_unloaded(network, system.state):
            zero = np.zeros(network.points.shape)
            choice = None if network.held.all() else solver.choice
            return LinearSolution(zero, zero, network.force + zero, 0.0, 0, network.held, choice)
        try:
            return system.solution(solver)
        except SolverError as error:
            if solver.is_direct or not isinstance(error, NotConvergedError | InaccurateError):
                raise
            solver.give_way(error)


class _System:
    """K u = load over powers of two: K over `stiffness` (N/m), u over `unit` (m)."""

    regular: Regular  # of what is free, if anything is

    def __init__(self, network: Network) -> None:
        self.network, self.free = network, ~network.held
        self.state = State(network)
        k, length = self.state.stiffness, self.state.length
        inner = self.state.force()
        outer = network.force / k
        sizes = [np.abs(outer).max(), np.abs(inner.hi).max() * length]
        largest = float(max(*sizes, np.abs(network.displacement).max()))
        if not math.isfinite(largest):
            raise SolverError(TOO_FAR)
        refuse_underflow(largest, TITLE)
        self.unit = 2.0 ** math.frexp(largest)[1] if largest else 1.0
        inner = Pair(*(x * (length / self.unit) for x in inner))
        self.pulled = 0.0 if self.state.unstressed else self.state.pulled * length / self.unit
        self.load = add(as_pair(outer / self.unit), inner)
        self.prescribed = network.displacement / self.unit
        self.left = np.zeros(network.points.shape)
        self.K: bsr_array | None = None

    def invert(self, solver: Solver) -> None:
        """Tangent and its inverse; refuses what is unstable or a mechanism."""
        self.K = tangent_blocks(self.network, self.network.points)
        self.regular = solver.regular(self.network, self.network.points, self.K)
        if negative_modes(self.state, self.regular, self.free):
            if self.state.unstressed and not self.network.volumes:
                # Springs at rest resist every motion or none: the sign is rounding.
                refuse_inaccurate(math.inf, TITLE, self._explain_rounding())
            raise SolverError(
                "linear equilibrium: the network is unstable at its reference points (its tangent "
                "stiffness has a negative mode); relieve its prestress or hold it better"
            )

    def solve(self, force: Array) -> Array:
        """Motion that the inverse gives for a force, both (n, d)."""
        motion = np.zeros(self.free.shape)
        motion[self.free] = self.regular.inverse.solve(force[self.free]) * self.state.stiffness
        return motion

    def residual(self, motion: Pair) -> Array:
        """What a motion leaves of the load, where it is free."""
        self.place = motion
        moves = motion.hi.any()
        self.left = self.state.residual(self.load, motion).hi if moves else self.load.hi
        return np.where(self.free, self.left, 0.0)

    def solution(self, solver: Solver) -> LinearSolution:
        """Solve, refine, and judge what is left."""
        u, error, steps = as_pair(self.prescribed), 0.0, 0
        first = self.residual(u)
        if self.free.any():
            soft, rate = self.regular.softness, self.regular.rate
            u = add(u, as_pair(self.solve(first)))
            found = refine_solution(self.residual, self.solve, u, rate)
            u, steps, times = found.solution, found.steps, 1.0
            if rate > DOUBTFUL:
                times = error_amplification(self._without_load, self.solve, rate, self._known())
            moved = float(np.abs(u.hi).max())
            refuse_underflow(moved * self.unit, TITLE)
            error = error_estimate(found, soft, times, self.pulled / moved) if moved else 0.0
            refuse_inaccurate(error, TITLE, self._explain_rounding())
        choice = solver.choice if self.free.any() else None
        whole, lacks = u.hi * self.unit, u.lo * self.unit
        return LinearSolution(
            whole, lacks, self._balance(u), error, steps, self.network.held, choice
        )

    def _balance(self, u: Pair) -> Array:
        """Force (n, d) in N that is left: the last residual, less what the last correction took."""
        step = add(u, negate(self.place)).hi
        left = self.left * self.state.stiffness
        if self.K is not None:
            left = left - (self.K @ step.ravel()).reshape(step.shape)
        return np.asarray(left * self.unit)

    def _without_load(self, motion: Pair) -> Array:
        zero = as_pair(np.zeros(self.free.shape))
        return np.where(self.free, self.state.residual(zero, motion).hi, 0.0)

    def _known(self) -> Array:
        """A motion to try a factor on: of all kinds at once, the softest among them."""
        return trial_motion(self.free, self.regular.mode)

    def _explain_rounding(self) -> str:
        """How far apart its stiffnesses are, and what to do."""
        return explain_rounding(self.network, self.regular.softness)
