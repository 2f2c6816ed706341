"""Iterative refinement of a solution, and the error estimate that it provides.

A residual from changes of length gives a correction, that one the next, until only its rounding is
left: with a factor of an assembled, rounded matrix the answer becomes that of the springs
[Wilkinson1963, Demmel2006]. Where the factor is wrong along a few motions the corrections fall
slowly; a least-squares combination of the last ones takes these motions out ([Anderson1965]; for a
linear system it is GMRES preconditioned by the factor [WalkerNi2011]).
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from msvalidate.linear_algebra.norms import EPS, max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass

LARGEST_ERROR = 1e-6
"""Error of a displacement, over the largest one, above which an answer is refused."""
ENOUGH = EPS / 2
"""Error, over the largest displacement, at which refinement stops: rounding to doubles."""
FACTOR_ROUNDING = 8 * EPS
"""Relative backward error of a factor: a few units of assembly and elimination."""
DOUBTFUL = 1e-3
"""Contraction above which a factor is tested on a known motion."""
STANDING = 0.5
"""Ratio of two corrections that indicates rounding of the residuals.

It applies if the factor is trusted.
"""
ROUNDED = 64 * EPS
"""Correction, over the largest displacement, that is rounding where it no longer falls."""
SLOWEST = 0.9
"""Ratio of corrections to which a geometric series of them is summed."""
MOST_STEPS = 10

Residual = Callable[[Array], Array]
"""Residual force (N) at a displacement (m), both (n, d); 0 where fixed."""
Solve = Callable[[Array], Array]
"""Displacement (m) that a factor gives for a force (N), both (n, d)."""


class InaccurateError(SolverError):
    """An answer was found, but its error is above the limit."""


@dataclass(frozen=True, eq=False)
class Refined:
    """A solution (n, d), its error by the last corrections, and their number.

    The error is the largest of a component over the largest component.
    """

    solution: Array
    error: float
    steps: int


def contraction_bound(softness: float) -> float:
    """Upper bound of the error after a correction, relative to the error before.

    The bound holds along the softest motion.

    `softness` is that motion's energy over what its components would cost one by one: a factor is
    wrong by `FACTOR_ROUNDING` of the latter.
    """
    return FACTOR_ROUNDING / max(abs(softness), np.finfo(float).tiny)


def refine_solution(
    residual: Residual, solve: Solve, start: Array, rate: float, solved: float = 0.0
) -> Refined:
    """Correct a solution (n, d) by iterative refinement until it no longer changes.

    `rate` is the part of an error that a correction leaves, as far as the softest motion tells
    (`contraction_bound`); `solved` the size of what the factor gave of `start`, if it did: then the
    first correction tells how much of that it had wrong.

    Source: iterative refinement, [Wilkinson1963], [Demmel2006]; steps combined as in
    [Anderson1965].
    """
    u, error = start, np.inf
    corrections: list[Array] = []
    steps: list[Array] = []
    sizes = [solved] if solved else []
    while len(steps) < MOST_STEPS:
        corrections.append(solve(residual(u)))
        steps.append(_combined_step(corrections, steps))
        size = max_abs(steps[-1])
        if not np.isfinite(size):
            return Refined(u, np.inf, len(steps))
        u = u + steps[-1]
        scale = max_abs(u) or 1.0
        ratios = [after / before for before, after in pairwise([*sizes, size])]
        sizes.append(size)
        # One small ratio may be luck, or the end of an error of another kind.
        part = min(max([rate, *ratios[-2:]]), SLOWEST) if ratios else SLOWEST
        error = 2 * part / (1 - part) * size / scale
        believed = rate <= DOUBTFUL or size <= ROUNDED * scale
        standing = bool(ratios) and ratios[-1] > STANDING and believed
        if not size or standing or error <= ENOUGH:
            break
    return Refined(u, error, len(steps))


def _combined_step(corrections: list[Array], steps: list[Array]) -> Array:
    """The step that the last correction and those before it make together."""
    last = corrections[-1]
    if not steps:
        return last
    # Each column over its size: they shrink from step to step.
    changes = np.column_stack([(b - a).ravel() for a, b in pairwise(corrections)])
    sizes = np.linalg.norm(changes, axis=0)
    sizes[sizes == 0] = 1.0
    part = np.linalg.lstsq(changes / sizes, last.ravel(), rcond=1e-10)[0] / sizes
    moved = np.column_stack([step.ravel() for step in steps]) + changes
    return np.asarray(last - (moved @ part).reshape(last.shape))


def error_amplification(residual: Residual, solve: Solve, rate: float, known: Array) -> float:
    """Ratio of the true to the estimated error of a known motion (n, d).

    `residual` is that of no load, linear. The factor of a matrix that rounding has spoilt may be
    far too stiff along a motion: then corrections are small and errors are not, and this tells.
    """

    def residual_of_known(u: Array) -> Array:
        return residual(u - known)

    start = solve(residual_of_known(np.zeros_like(known)))
    found = refine_solution(residual_of_known, solve, start, rate, max_abs(start))
    error = max_abs(found.solution - known) / max_abs(known)
    return max(1.0, error / max(found.error, EPS))


def refuse_inaccurate(error: float, title: str, why: str) -> None:
    """Raise `InaccurateError` where an error is above `LARGEST_ERROR`."""
    if not error <= LARGEST_ERROR:
        if not error < 1:
            raise InaccurateError(f"{title}: no digit of the displacement is known: {why}")
        raise InaccurateError(
            f"{title}: the error left is {error:.1g} of the largest displacement, more than "
            f"{LARGEST_ERROR:g}: {why}"
        )
