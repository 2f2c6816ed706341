"""Conjugate gradients, for one right-hand side or many, and what they tell of a matrix."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.linalg import eigh_tridiagonal
from scipy.sparse import bsr_array

from msvalidate.linear_algebra.norms import dots
from msvalidate.problem import Array, Mask
from msvalidate.problem.records import dataclass

MOST_STEPS = 300
"""Maximum number of iterations: 10 to 30 are usual, slender bodies take hundreds."""
UNSEEN = 1e-4
"""Relative share of a random load below which a mode is overlooked.

A normal variable is smaller than that once in 12,500 times.
"""


@dataclass(frozen=True, eq=False)
class Iterated:
    """Result of conjugate gradients.

    Parameters
    ----------
    solution
        (N,) or (N, v).
    steps
        Each with one cycle and one product.
    reduction
        Residual and error, the larger of all columns, relative to those of no motion.
    negative
        Whether a motion of no or negative energy was met: then the system is not positive definite.
    lowest
        Lowest eigenvalue of the matrix times a cycle, as far as the load has it; infinite where
        it was not asked for.
    direction
        In which such a motion was met, if one was.
    """

    solution: Array
    steps: int
    reduction: float
    negative: bool = False
    lowest: float = math.inf
    direction: Array | None = None


def conjugate_gradients(
    A: Any,
    force: Array,
    cycle: Callable[[Array], Array],
    part: float,
    *,
    most: int = MOST_STEPS,
    spectral: bool = False,
    stop: Callable[[Array], bool] | None = None,
) -> Iterated:
    """Solve A x = force by conjugate gradients, column by column.

    The force is (N,) or (N, v).

    Until the residual and the error are `part` of the first, or a residual is small enough for
    `stop`. The error is what a cycle makes of the residual: that hardly knows of a slender body's
    bending. If `spectral`, both are to be smaller by the lowest eigenvalue, of which the error may
    be one over as large: conjugate gradients know it (Lanczos; [GolubVanLoan2013], section 11.3).

    Source: [HestenesStiefel1952].
    """
    x, residual = np.zeros_like(force), force.copy()
    ahead = cycle(residual)
    first = _sizes(force, ahead)
    direction, power, lowest = ahead.copy(), dots(residual, ahead), math.inf
    there = (first > 0).all(axis=0)
    if not there.any():  # no load, or one whose squares are too small for numbers
        return Iterated(x, 0, float(force.any()))
    reduction = there.astype(float)
    lengths: list[float] = []
    turns: list[float] = []
    for steps in range(most + 1):
        going = reduction > part * min(lowest, 1.0)
        if steps == most or (stop(residual) if stop else not going.any()):
            break
        push = A @ direction
        stiff = dots(direction, push)
        if not ((stiff > 0) & (power > 0))[going].all():
            negative = bool(((stiff <= 0) | (power <= 0))[going].any())  # or no number at all
            return Iterated(x, steps, float(reduction.max()), negative, lowest, direction)
        length = np.where(going, power / np.where(going, stiff, 1.0), 0.0)
        x += length * direction
        push *= length
        residual -= push
        ahead = cycle(residual)
        over = _sizes(residual, ahead) / np.where(there, first, np.inf)
        reduction = np.where(going, over.max(axis=0), reduction)
        power, before = dots(residual, ahead), power
        turn = np.where(going, power / np.where(going, before, 1.0), 0.0)
        direction *= turn
        direction += ahead
        if spectral:
            lengths.append(float(length))
            turns.append(float(turn))
            if reduction <= part:
                lowest = _lowest_eigenvalue(np.array(lengths), np.array(turns))
    return Iterated(x, steps, float(reduction.max()), lowest=lowest)


def _sizes(*vectors: Array) -> Array:
    """Lengths of vectors or columns, a row each."""
    return np.stack([np.sqrt(dots(each, each)) for each in vectors])


def answer_to_random_load(
    A: bsr_array, cycle: Callable[[Array], Array], free: Mask, floating: int = 0
) -> tuple[Iterated, bool]:
    """Response to a fixed random load, and whether it contains every mode.

    Its part along a motion without stiffness never falls, nor does that along one of negative
    energy (the residual is a polynomial in the matrix, 1 at 0 and more below, times the load). Each
    component of the load is random as the root of what it meets by itself, so along each motion it
    has the same spread: once the residual is `UNSEEN` of that, no such motion is overlooked but
    once in 12,500 times.

    Parameters
    ----------
    A, cycle
        (N, N), and nearly its inverse.
    free
        (N,) what may move.
    floating
        As of the cycle.
    """
    own = np.where(free, np.abs(A.diagonal()), 0.0)
    unit = float(own.max(initial=0.0)) or 1.0
    load = np.sqrt(own / unit) * np.random.default_rng(0).normal(size=own.shape)
    if floating:
        parts = load.reshape(-1, floating)
        load = (parts - parts.mean(axis=0)).ravel()
    weight = np.divide(unit, own, out=np.zeros_like(own), where=own > 0)
    found = conjugate_gradients(
        A, load, cycle, 0.0, stop=lambda residual: bool(residual**2 @ weight <= UNSEEN**2)
    )
    return found, not found.negative and found.steps < MOST_STEPS


def _lowest_eigenvalue(lengths: Array, turns: Array) -> float:
    """Lowest eigenvalue that steps of conjugate gradients have met, by their Lanczos matrix.

    Source: [Lanczos1950].
    """
    diagonal = 1 / lengths
    diagonal[1:] += turns[:-1] / lengths[:-1]
    beside = np.sqrt(np.abs(turns[:-1])) / lengths[:-1]
    values = eigh_tridiagonal(diagonal, beside, eigvals_only=True, select="i", select_range=(0, 0))
    return float(values[0])
