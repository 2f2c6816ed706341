"""Iterative refinement in doubles: residuals from differences within cells, and what error is left.

A factor of a slender body's matrix is off by the rounding of the entries times the condition. The
residual of an answer is had far more exactly from differences of displacements (`Gradients`), and
the same factor turns it into a correction ([Wilkinson1963], chapter 3; [Higham2002], chapter 12).
Corrections tell the error where they shrink. A factor that rounding has made far too stiff in some
motion makes small ones of a large error, so a known motion is tried first: its forces have to bring
it back.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import Array, Mask
from msvalidate.problem.records import dataclass

MOST = 10
FIRST, ENOUGH = 1e-12, 1e-14
"""A first and a later correction this small, relative to the answer, are the last. A later one may
by chance be much smaller than what rounding leaves; a first one has the factor's rounding too."""
SETTLED = 1e-9
"""Corrections below this that no longer shrink are what rounding leaves in the residual."""
SHRINKS = 0.5
"""Share of the correction before, or of a known motion, from which on none is believed."""
KNOWN = 0.2
"""Share of a known motion up to which what is left of it need not be looked at again."""
SAFETY = 16.0
"""Factor on the larger of the last two that rounding made: one in 25 normal variables is that much
smaller than its like."""
LEAST = 1e-12
"""Relative rounding of the equations themselves, which no correction reveals.

It comes from constants, points and weights of integration; long cells have up to 1e-12.
"""

Vectors = Callable[[Array], Array]
"""Forces of unknowns, or unknowns that forces bring about; both (N,), and zero where held."""


@dataclass(frozen=True, eq=False)
class Refined:
    """Unknowns (N,), their largest error relative to the largest, and the number of corrections."""

    value: Array
    error: float
    corrections: int


def refine_solution(
    force: Vectors,
    inverse: Vectors,
    start: Array,
    load: Array,
    share: float,
    counted: slice = slice(None),
    enough: float = FIRST,
) -> Refined:
    """The solution of force(u) = load that a start (N,) with what is held at its values leads to.

    Parameters
    ----------
    force, inverse
        The equations, and nearly their inverse.
    start, load
        (N,) each.
    share
        Of an error, what a correction leaves, as `share_left` has it.
    counted
        Unknowns whose error is judged.
    enough
        The first correction that is the last as well, relative to the answer.
    """
    u, size, slowest = start, np.inf, share
    for count in range(1, MOST + 1):
        change = inverse(load - force(u))
        u, last, size = u + change, size, _ratio(change[counted], u[counted])
        if count > 1 and size > SETTLED:
            slowest = max(slowest, size / last)
        if size <= (enough if count == 1 else ENOUGH) or not size < SHRINKS * last:
            break
    if not (np.isfinite(size) and slowest < SHRINKS):
        return Refined(u, np.inf, count)
    left = max(size, last) if size >= SHRINKS * last else size
    known = LEAST if u[counted].any() else 0.0
    return Refined(u, SAFETY * left / (1 - slowest) + known, count)


def share_left(
    force: Vectors, inverse: Vectors, points: Array, free: Mask, components: int
) -> float:
    """Share of an error that a correction leaves, by a known smooth motion of points (n, d).

    Of the unknowns (N,) the first are so many components of n points, and the others stay zero.
    """
    d, rng = points.shape[1], np.random.default_rng(0)
    place = (points - points.mean(axis=0)) / np.ptp(points, axis=0).max()
    waves = np.sin(place @ rng.normal(scale=np.pi, size=(d, 2 * d)) + rng.uniform(0, 6, 2 * d))
    counted, motion = slice(components * len(points)), np.zeros(len(free))
    motion[counted] = (waves @ rng.normal(size=(2 * d, components))).T.ravel()
    motion *= free
    left = motion - inverse(force(motion))
    share = _ratio(left[counted], motion[counted])
    if KNOWN < share < SHRINKS:
        share = max(share, _ratio((left - inverse(force(left)))[counted], left[counted]))
    return share


def _ratio(part: Array, whole: Array) -> float:
    """Largest of a part, relative to the largest of the whole."""
    size, largest = (float(np.abs(each).max(initial=0.0)) for each in (part, whole))
    return size / largest if largest else (np.inf if size else 0.0)
