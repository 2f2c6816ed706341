"""Stability limits of time integration schemes, and their one-step matrices."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import finite, finite_number, format_value, positive_number
from msvalidate.springs.dynamics.implicit import ModeAcceleration
from msvalidate.springs.dynamics.integrators import choose_integrator
from msvalidate.springs.dynamics.scheme import Integrator, MotionState

SAFETY = 0.9
"""Ratio of the recommended time step to the stability limit.

The tangent stiffens a little as the network deforms.
"""
RATIOS = 400
"""Damping ratios at which the limit is asked for between two: its minimum is flat."""


def stability_limit(
    integrator: Integrator, omega_min: float, omega_max: float, damping: ArrayLike = 0.0
) -> float:
    """Largest stable time step (s) for all frequencies (rad/s) from one to another.

    0 if none is stable, infinite if all are.

    The limit of a mode at a given damping (1/s) rises with its frequency, if at all, before it
    falls, so that the two ends bound the rest: explicit Euler needs both, the others the higher.
    Of rates that differ from point to point, a mode feels some mean: the limit is the least over
    all rates between the smallest and the largest. (Velocity Verlet's is lowest between.)

    Source: roots of `one_step_matrix` within the unit circle, [Jury1964].

    Raises
    ------
    ProblemError
        If a frequency is not above zero, they are in the wrong order, or the damping is negative.
    SolverError
        If the limit is beyond the largest number or below the smallest.
    """
    integrator = choose_integrator("integrator", integrator)
    low = positive_number("lowest frequency", omega_min, "rad/s")
    high = positive_number("highest frequency", omega_max, "rad/s")
    if low > high:
        raise ProblemError(f"frequencies: from {low:g} to {high:g} rad/s; give the lowest first")
    rates = finite("damping", damping).ravel()
    if not rates.size or rates.min() < 0:
        raise ProblemError(
            f"damping: {format_value(damping)} 1/s; a negative rate feeds the motion"
        )
    if math.isinf(integrator.limit(0.0)):
        return math.inf
    limit = min(_limit(integrator, omega, rates) for omega in (low, high))
    if not limit < math.inf:
        raise SolverError(
            f"stability limit: {limit:g} s from {low:g} to {high:g} rad/s with damping "
            f"{rates.max():g} 1/s; choose a unit of time that gives ordinary numbers"
        )
    return limit


def _limit(integrator: Integrator, omega: float, rates: Array) -> float:
    """Least limit (s) of a mode over the rates between the smallest and the largest."""
    with np.errstate(over="ignore"):  # beyond all numbers there is no limit to tell
        least, most = rates.min() / 2 / omega, rates.max() / 2 / omega
    if not math.isfinite(most):
        return math.inf
    ratios = [least, most]
    if most > least:  # beyond a ratio of 2 every limit falls
        ratios += list(np.linspace(least, min(most, 2.0), RATIOS)) if least < 2 else []
    limits = [integrator.limit(float(zeta)) for zeta in ratios]
    at = min(limits) / omega
    return math.inf if at == 0 and min(limits) > 0 else at


def one_step_matrix(integrator: Integrator, omega: float, h: float, damping: float = 0.0) -> Array:
    """Matrix (2, 2) of a step of the mode x'' = -ω²x - c·x'.

    It maps (x, v) to the next (x, v).

    Made by two steps of the scheme itself, which is linear in the state.

    Raises `ProblemError` if an argument is not a finite number.
    """
    omega, h, damping = (
        finite_number(name, value)
        for name, value in (("omega", omega), ("h", h), ("damping", damping))
    )
    acceleration = ModeAcceleration(omega)
    columns = []
    for x, v in ((1.0, 0.0), (0.0, 1.0)):
        start = np.array([x])
        end = integrator.step(
            acceleration, MotionState(start, np.array([v]), acceleration(start)), h, damping
        )
        columns.append([end.x[0], end.v[0]])
    return np.array(columns).T
