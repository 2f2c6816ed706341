"""Newton's method at full load: tangents factorised, or inverted by multigrid.

With multigrid a linear solve goes no further than the next tangent can use (Eisenstat and Walker),
and one hierarchy serves all tangents, for as long as it serves them.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial

import numpy as np

from msvalidate.linear_algebra.conjugate_gradients import conjugate_gradients
from msvalidate.linear_algebra.multigrid import Cycle, restrain_in_place
from msvalidate.problem import Array, SolverError
from msvalidate.springs.dynamics.run import Method, Run
from msvalidate.springs.network import Configuration
from msvalidate.springs.network.inverse import Solver
from msvalidate.springs.network.multigrid import WORN, make_cycle
from msvalidate.springs.statics.tangents import LARGEST_TURN, refuse_mechanism, tangent_at

NEWTON_STEPS = 50
"""Linear solves after which Newton's method is given up."""
FIRST_PART = 1e-3
"""Relative residual of the first solve.

The tangent is accurate only up to a strain of 1e-3.
"""
LEAST_PART = 1e-9
"""Smallest relative residual of a linear solve: the rounding of a stiff system."""
ENOUGH = 0.2
"""Fraction of the allowed residual that the last solve leaves."""
_LESS = "reduce the load, or use equilibrium, which raises it in increments"

Move = Callable[[Array, Array], Array]
"""Motion (n, d) in m that balances a load (n, d) in N.

Fixed components move by a given (n, d).
"""


def _newton(mover: Callable[[Run], Move], run: Run) -> Iterator[None]:
    """Newton's method at full load, shortened where a step would stretch or turn a spring far.

    Source: [NocedalWright2006], section 11.1.
    """
    run.most_steps = lambda: NEWTON_STEPS
    network, move = run.network, mover(run)
    run.displacement[:] = run.begun  # what is held goes along with the first steps
    run.moved()
    while True:
        yield
        ahead = network.displacement - run.displacement
        step = move(run.balance(), ahead)
        turn = Configuration(network, run.displacement).largest_rotation(step)
        part = min(1.0, LARGEST_TURN / max(turn, 1e-300))
        run.displacement += part * step
        if part == 1:
            run.displacement[network.fixed] = network.displacement[network.fixed]
        run.moved(1, 1)


def _direct_moves(run: Run) -> Move:
    """By a factor of each tangent, [SuperLU]."""
    solver = Solver(run.network, "direct")

    def move(load: Array, ahead: Array) -> Array:
        K = tangent_at(Configuration(run.network, run.displacement.copy()), solver)
        if not K.is_stable:
            raise SolverError(
                f"{run.title}: the tangent has a negative mode at iteration {run.steps + 1}; "
                f"{_LESS}"
            )
        return K.move(load, ahead)

    return move


class _Multigrid:
    """Linear solves of one run, with their common hierarchy and tolerance.

    Source: [Vanek1996], [EisenstatWalker1996]; hierarchy by [PyAMG2022].
    """

    def __init__(self, run: Run) -> None:
        self.run, self.free = run, ~run.network.fixed
        self.residual = 0.0
        self.cycle: Cycle | None = None

    def __call__(self, load: Array, ahead: Array) -> Array:
        run = self.run
        at = Configuration(run.network, run.displacement.copy())
        K = at.tangent()
        held = np.where(self.free, 0.0, ahead).ravel()
        right = np.where(self.free, load - (K @ held).reshape(load.shape), 0.0).ravel()
        restrain_in_place(K, self.free)
        if self.cycle is None:
            self.cycle = make_cycle(K, at)
        part = self.needed(float(np.abs(right).max()))
        if held.any():  # such a load stands in a few rows, and measures none that is spread
            self.residual = 0.0
        found = conjugate_gradients(K, right, self.cycle, part)
        run.moved(0, found.steps)
        if not found.reduction <= part:
            refuse_mechanism(run.network)
        if found.negative:
            raise SolverError(f"{run.title}: the tangent is not positive; {_LESS}")
        if not found.reduction <= part:
            raise SolverError(
                f"{run.title}: residual {found.reduction:.1g} of the first after {found.steps} "
                f"cycles; {_LESS}"
            )
        run.cycle = self.cycle
        if found.steps > WORN:
            self.cycle = None
        return np.asarray(found.solution + held).reshape(load.shape)

    def needed(self, residual: float) -> float:
        """Relative residual that a solve may leave, from the largest force (N).

        The square of what the last step left (choice 2 of Eisenstat and Walker, with γ = 1, α = 2),
        but no less than rest asks for.
        """
        before, self.residual = self.residual, residual
        if not before:
            return FIRST_PART
        enough = ENOUGH * self.run.test.allowed()
        part = max((residual / before) ** 2, enough / max(residual, 1e-300))
        return min(FIRST_PART, max(LEAST_PART, part))


NEWTON = Method("newton", "Newton's method", partial(_newton, _direct_moves), look_every=1)
NEWTON_MULTIGRID = Method(
    "newton_multigrid", "Newton's method by multigrid", partial(_newton, _Multigrid), look_every=1
)
