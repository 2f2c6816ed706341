"""Time integration schemes as records: how one step goes, its order and its limit.

A scheme advances a state (x, v, a): position (m), velocity (m/s) and the acceleration (m/s²) of
springs and loads *without* damping at that position. The viscous acceleration is -c·v, c in 1/s.
Each scheme says from which velocity it takes it. With one more scheme, add its record to
`INTEGRATORS`: its order, its limit and what it conserves are then held to its claims by the tests.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import (
    require_type,
)

Acceleration = Callable[[Array], Array]
"""Acceleration (n, d) in m/s² of springs and loads at positions (n, d) in m."""


class MotionState(NamedTuple):
    """Position (m), velocity (m/s), and the undamped acceleration (m/s²) at that position."""

    x: Array
    v: Array
    a: Array


Step = Callable[[Acceleration, MotionState, float, Array | float], MotionState]
"""One step of `h` (s) with damping `c` (1/s), a number or one a component."""
Factors = Callable[[float, Array], tuple[Array, Array]]
"""(keep, push) of a step of `h` (s) with damping `c` (1/s): v = keep·v + push·a, x += h·v."""


@dataclass(frozen=True)
class Integrator:
    """A time integration scheme.

    Parameters
    ----------
    name, order
        Its name, and the power of the step with which its error on a smooth motion falls, without
        damping: a viscous force from an old velocity is of first order.
    symplectic
        Whether it preserves areas in phase space without damping: its energy then only fluctuates.
    step
        One step.
    staggered
        Whether the velocity belongs to half a step before the position.
    damping
        In words: from which velocity it takes the viscous force.
    limit
        Largest stable h·ω of one mode with damping ratio ζ = c/(2ω), in closed form; the whole
        range below it is stable.
    variant
        Whether it is kept for comparison: a scheme as it was misprinted or is mistaken.
    factors
        Of a scheme that moves with one new velocity: what `kernels.advance` needs of it.
    """

    name: str
    order: int
    symplectic: bool
    step: Step
    damping: str
    limit: Callable[[float], float]
    staggered: bool = False
    variant: bool = False
    factors: Factors | None = None


def _explicit_euler(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    x = now.x + h * now.v
    return MotionState(x, now.v + h * (now.a - c * now.v), acceleration(x))


def _with_one_velocity(
    factors: Factors, acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    """A step whose position moves with the new velocity."""
    keep, push = factors(h, np.asarray(c))
    v = keep * now.v + push * now.a
    x = now.x + h * v
    return MotionState(x, v, acceleration(x))


def _euler_cromer(h: float, c: Array) -> tuple[Array, Array]:
    return 1 - h * c, np.full_like(c, h, dtype=float)


def _leapfrog(h: float, c: Array) -> tuple[Array, Array]:
    half = 0.5 * h * c
    return (1 - half) / (1 + half), h / (1 + half)


def _euler_cromer_as_printed(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    # The report's section 5.4 (2): velocity first, but the position moves with the old one.
    v = now.v + h * (now.a - c * now.v)
    x = now.x + h * now.v
    return MotionState(x, v, acceleration(x))


def _velocity_verlet(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    a = acceleration(x)
    return MotionState(x, half + 0.5 * h * (a - c * half), a)


def _verlet_as_printed(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    # The report's section 5.4 (4): the second half kick starts again from v_t, with F_t.
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    return MotionState(x, half, acceleration(x))


def _verlet_lagged(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    return MotionState(x, half + 0.5 * h * (now.a - c * now.v), acceleration(x))


def _explicit_euler_limit(zeta: float) -> float:
    # |λ|² = 1 - 2ζy + y² up to critical damping; beyond, the faster of two real roots reaches -1:
    # y = 2(ζ - √(ζ² - 1)), written without cancellation.
    return 2 * zeta if zeta <= 1 else 2 / (zeta * (1 + math.sqrt(1 - 1 / zeta / zeta)))


def _euler_cromer_limit(zeta: float) -> float:
    return 2 / (math.hypot(1, zeta) + zeta)  # 2(√(1 + ζ²) - ζ), without cancellation


def _leapfrog_limit(_: float) -> float:
    return 2.0


def _velocity_verlet_limit(zeta: float) -> float:
    """First y = h·ω at which det M = p², tr M = 1 + p² - y²(1 + p)/2, p = 1 - ζy, leave Jury's.

    1 + tr M + det M ≥ 0 is a cubic in y, written for z = 1/y, whose roots stay ordinary numbers
    as ζ vanishes; |det M| ≤ 1 asks for p ≥ -1.

    Source: the criterion of [Jury1964]; the roots of the cubic are derived here.
    """
    if zeta >= 1:
        return 2 / zeta
    roots = np.roots([4, -4 * zeta, 2 * zeta * zeta - 1, 0.5 * zeta])
    crossings = roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 0)]
    return float(1 / max([*crossings, 0.5 * zeta]))


def _verlet_as_printed_limit(zeta: float) -> float:
    return 4 / (math.hypot(math.sqrt(2), zeta) + zeta)  # 2(√(2 + ζ²) - ζ), the same way


def _verlet_lagged_limit(zeta: float) -> float:
    return min(4 * zeta, 1 / zeta) if zeta > 0 else 0.0


OLD = "from the old velocity"
INTEGRATORS = {
    scheme.name: scheme
    for scheme in (
        Integrator("explicit_euler", 1, False, _explicit_euler, OLD, _explicit_euler_limit),
        Integrator(
            "euler_cromer",
            1,
            True,
            partial(_with_one_velocity, _euler_cromer),
            OLD,
            _euler_cromer_limit,
            factors=_euler_cromer,
        ),
        Integrator(
            "leapfrog",
            2,
            True,
            partial(_with_one_velocity, _leapfrog),
            "from the mean of the old and the new velocity",
            _leapfrog_limit,
            staggered=True,
            factors=_leapfrog,
        ),
        Integrator(
            "velocity_verlet",
            2,
            True,
            _velocity_verlet,
            "in each half kick from the velocity before it",
            _velocity_verlet_limit,
        ),
        Integrator(
            "euler_cromer_as_printed",
            1,
            False,
            _euler_cromer_as_printed,
            OLD,
            _explicit_euler_limit,
            variant=True,
        ),
        Integrator(
            "verlet_as_printed",
            1,
            True,
            _verlet_as_printed,
            OLD,
            _verlet_as_printed_limit,
            variant=True,
        ),
        Integrator(
            "verlet_lagged", 1, False, _verlet_lagged, OLD, _verlet_lagged_limit, variant=True
        ),
    )
}
"""Name -> scheme: the report's four in their true forms, and variants."""
EULER_CROMER = INTEGRATORS["euler_cromer"]
LEAPFROG = INTEGRATORS["leapfrog"]


def step_factors(scheme: Integrator) -> Factors:
    """What `kernels.advance` needs of a scheme.

    Raises
    ------
    ProblemError
        If it does not move with one new velocity.
    """
    require_type("scheme", scheme, Integrator)
    if scheme.factors is None:
        able = ", ".join(name for name, one in INTEGRATORS.items() if one.factors)
        raise ProblemError(f"{scheme.name}: more than one velocity a step; choose from: {able}")
    return scheme.factors
