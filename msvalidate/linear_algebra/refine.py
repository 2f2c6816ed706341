"""Refinement of a solution by the same factor, and what it says of the error left.

A residual that is right to many more digits than the solution (`accurate`) gives a correction, that
one the next, until no digit moves: with a factor of an assembled, rounded matrix the answer becomes
that of the exact one [Wilkinson1963, Demmel2006]. Where the factor is wrong along a few motions the
corrections fall slowly, or grow; a least-squares combination of the last ones takes these motions
out ([Anderson1965]; for a linear system it is GMRES preconditioned by the factor [WalkerNi2011]).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.linear_algebra.double_double import ROUNDING, Pair, add, as_pair
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass

LARGEST_ERROR = 1e-6
"""Error of a displacement, over the largest one, above which an answer is refused."""
EPS = float(np.finfo(float).eps)
HALF_A_UNIT = 0.5 * EPS
"""Rounding of an answer to doubles, over its largest displacement."""
ENOUGH = EPS / 16
"""Error, over the largest displacement, at which refinement stops: below double precision."""
FACTOR_ROUNDING = 8 * EPS
"""Of what a point meets, that a factor may be wrong by: assembly and elimination, a few units."""
DOUBTFUL = 1e-3
"""Contraction above which a factor is tried on a motion that is known before it is believed."""
MEMORY = 10
"""Corrections that are combined: motions along which a factor may be wrong."""
MOST_STEPS = 60
LATEST = 3
"""Ratios of corrections, the largest of which is taken for what the next one leaves."""
PATIENCE = 8
"""Steps without a smaller correction after which refinement stops."""

Residual = Callable[[Pair], Array]
"""Force left (n, d) at a displacement (n, d), 0 where it is held."""
Solve = Callable[[Array], Array]
"""Displacement (n, d) that a factor gives for a force (n, d)."""


class InaccurateError(SolverError):
    """An answer was found, but its error is above the limit."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A solution, and what is known of its error.

    Parameters
    ----------
    solution
        (n, d), as a pair.
    error
        Largest error of a component over the largest component, by the last corrections.
    steps
        Corrections made.
    converged
        Whether nothing is left to correct; else corrections had ceased to fall.
    """

    solution: Pair
    error: float
    steps: int
    converged: bool = False


def contraction_bound(softness: float) -> float:
    """Part of an error that a correction leaves at the most, along the softest motion.

    `softness` is that motion's energy over what its components would cost one by one: a factor is
    wrong by `FACTOR_ROUNDING` of the latter.
    """
    return FACTOR_ROUNDING / max(abs(softness), np.finfo(float).tiny)


def refine_solution(
    residual: Residual,
    solve: Solve,
    start: Pair,
    rate: float,
    *,
    solved: bool = True,
    patience: int = PATIENCE,
) -> Refined:
    """Correct a solution by iterative refinement until it no longer changes.

    Source: iterative refinement, [Wilkinson1963], [Demmel2006]; steps combined as in
    [Anderson1965].

    Parameters
    ----------
    residual, solve
        What is left over, accurately, and the factor's answer to it.
    start
        (n, d).
    rate
        Part of an error that a correction leaves at the most, as far as is known:
        `contraction_bound`.
    solved
        Whether `start` is the factor's own answer: then what the first correction changes tells how
        much of it the factor had wrong. Otherwise it takes a second to tell.
    patience
        Steps without a smaller correction after which no more is to be had of this factor.
    """
    u, ahead = start, _Combined()
    best, waited, steps, scale = np.inf, 0, 0, 1.0
    before = size = max_abs(start.hi)
    rates: list[float] = []
    while steps < MOST_STEPS and waited < patience:
        step = ahead.step(solve(residual(u)))
        size = max_abs(step)
        if not np.isfinite(size):
            return Refined(u, np.inf, steps)
        u, steps = add(u, as_pair(step)), steps + 1
        scale = max_abs(u.hi)
        if size <= ENOUGH * scale:
            return Refined(u, 2 * size / scale if scale else 0.0, steps, converged=True)
        if solved or steps > 1:
            rates.append(size / before if before else 1.0)
        # One small ratio may be luck, or the end of an error of another kind.
        left = max([rate, *rates[-LATEST:]])
        if len(rates) >= (1 if solved else 2) and left * size <= ENOUGH * scale:
            return Refined(u, left * size / scale, steps, converged=True)
        waited = 0 if size < 0.7 * best else waited + 1
        best, before = min(best, size), size
    return Refined(u, 2 * size / scale if scale else 0.0, steps)


class _Combined:
    """The step that a correction and those before it make together."""

    def __init__(self) -> None:
        self.steps: list[Array] = []
        self.changes: list[Array] = []
        self.last: Array | None = None

    def step(self, correction: Array) -> Array:
        g = correction
        if self.last is not None:
            self.changes.append((g - self.last).ravel())
        self.last = g
        keep = slice(-MEMORY, None)
        self.steps, self.changes = self.steps[keep], self.changes[keep]
        step = g
        if self.changes:
            # Each column over its size: they shrink from step to step.
            columns = np.column_stack(self.changes)
            sizes = np.linalg.norm(columns, axis=0)
            sizes[sizes == 0] = 1.0
            part = np.linalg.lstsq(columns / sizes, g.ravel(), rcond=1e-10)[0] / sizes
            moved = np.column_stack(self.steps) + columns
            step = g - (moved @ part).reshape(g.shape)
        self.steps.append(step.ravel())
        return step


def error_amplification(residual: Residual, solve: Solve, rate: float, known: Array) -> float:
    """Ratio of the true error of a known motion (n, d) to the error that refinement states for it.

    `residual` is that of no load, linear. The factor of a matrix that rounding has spoilt may be
    far too stiff along a motion: then corrections are small and errors are not, and this tells.
    """
    load = residual(as_pair(-known))

    def left(u: Pair) -> Array:
        return residual(add(u, as_pair(-known)))

    found = refine_solution(left, solve, as_pair(solve(load)), rate)
    error = max_abs(add(found.solution, as_pair(-known)).hi) / max_abs(known)
    return max(1.0, error / max(found.error, ENOUGH))


def error_estimate(
    found: Refined, softness: float, times: float = 1.0, pulled: float = 0.0
) -> float:
    """The error to state: corrections, rounding of residuals, and rounding to doubles.

    Residuals are summed from numbers that are right to some 1e-31, and a motion of little stiffness
    takes up what is wrong of that. `pulled` is the largest of these numbers over the stiffness and
    the largest displacement: prestress may be far more than the load.
    """
    rounded = 8 * ROUNDING * max(1.0, pulled) / max(abs(softness), np.finfo(float).tiny)
    return float(times * found.error + rounded + HALF_A_UNIT * (1 + EPS))


def refuse_inaccurate(error: float, title: str, why: str) -> None:
    """Raise `InaccurateError` where an error is above `LARGEST_ERROR`."""
    if not error <= LARGEST_ERROR:
        digits = "not known" if not np.isfinite(error) or error >= 1 else f"{error:.1g}"
        raise InaccurateError(
            f"{title}: the error left is {digits} of the largest displacement, more than "
            f"{LARGEST_ERROR:g}: {why}"
        )


def refuse_underflow(moved: float, title: str) -> None:
    """Raise `SolverError` where a largest displacement (m) is at the lower end of all doubles."""
    if 0 < moved < np.finfo(float).tiny:
        raise SolverError(
            f"{title}: moves by {moved:.3g} m, where doubles run out of digits; choose units that "
            "give ordinary displacements, or raise the load"
        )
