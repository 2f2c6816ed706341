"""Time integration schemes as records of their step and properties (`scheme`).

With one more scheme, add its record to `INTEGRATORS`: tests and the study `stability` hold every
record to its order, limit, error, and to what it conserves.
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import choose_entry
from msvalidate.springs.dynamics.implicit import increment
from msvalidate.springs.dynamics.scheme import (
    Acceleration,
    Factors,
    Integrator,
    MotionState,
    States,
)
from msvalidate.springs.dynamics.variants import OLD, VARIANTS, explicit_euler_limit


def _with_one_velocity(
    factors: Factors, acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    """A step whose position moves with the new velocity."""
    keep, push = factors(h, np.asarray(c))
    v = keep * now.v + push * now.a
    x = now.x + h * v
    return MotionState(x, v, acceleration(x))


def _explicit_euler(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    x = now.x + h * now.v
    return MotionState(x, now.v + h * (now.a - c * now.v), acceleration(x))


def _spiral(growth: float, turn: float, steps: Array) -> States:
    """States of a step that multiplies them by one number, given by the parts of its logarithm."""
    return np.asarray(np.exp(steps * (growth - 1j * turn)))


def _explicit_euler_motion(h: float, steps: Array) -> States:
    return _spiral(0.5 * math.log1p(h * h), math.atan(h), steps)


EXPLICIT_EULER = Integrator(
    "explicit_euler",
    "explicit Euler",
    order=1,
    symplectic=False,
    step=_explicit_euler,
    damping=OLD,
    limit=explicit_euler_limit,
    swelling=1.0,
    undamped_motion=_explicit_euler_motion,
)


def _euler_cromer(h: float, c: Array) -> tuple[Array, Array]:
    return 1 - h * c, np.full_like(c, h, dtype=float)


def _euler_cromer_limit(zeta: float) -> float:
    return 2 / (math.hypot(1, zeta) + zeta)  # 2(√(1 + ζ²) - ζ), without cancellation


def _euler_cromer_motion(h: float, steps: Array) -> States:
    # Its frequency is that of Verlet; positions are half a step ahead of velocities.
    half = math.asin(0.5 * h)
    x, v = np.cos((2 * steps + 1) * half), np.sin(2 * steps * half)
    return (x - 1j * v) / math.cos(half)


EULER_CROMER = Integrator(
    "euler_cromer",
    "Euler-Cromer",
    order=1,
    symplectic=True,
    step=partial(_with_one_velocity, _euler_cromer),
    damping=OLD,
    limit=_euler_cromer_limit,
    undamped_motion=_euler_cromer_motion,
    factors=_euler_cromer,
)


def _verlet_motion(h: float, steps: Array) -> States:
    # Each position is twice the last less the one before, less h²ω² of the last: 2 sin(ωʹh/2) = hω.
    half = math.asin(0.5 * h)
    return np.cos(2 * steps * half) - 1j * math.cos(half) * np.sin(2 * steps * half)


def _leapfrog(h: float, c: Array) -> tuple[Array, Array]:
    half = 0.5 * h * c
    return (1 - half) / (1 + half), h / (1 + half)


def _leapfrog_limit(_: float) -> float:
    return 2.0


LEAPFROG = Integrator(
    "leapfrog",
    "leapfrog",
    order=2,
    symplectic=True,
    step=partial(_with_one_velocity, _leapfrog),
    damping="from the mean of the old and the new velocity",
    limit=_leapfrog_limit,
    damped_order=2,
    staggered=True,
    undamped_motion=_verlet_motion,
    factors=_leapfrog,
)
"""Leapfrog scheme, with the undamped positions of velocity Verlet. Source: [Verlet1967]."""


def _velocity_verlet(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    a = acceleration(x)
    return MotionState(x, half + 0.5 * h * (a - c * half), a)


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


VELOCITY_VERLET = Integrator(
    "velocity_verlet",
    "velocity Verlet",
    order=2,
    symplectic=True,
    step=_velocity_verlet,
    damping="in each half kick from the velocity before it",
    limit=_velocity_verlet_limit,
    undamped_motion=_verlet_motion,
)
"""Velocity Verlet scheme. Source: [Swope1982]."""


def _runge_kutta(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    v1, a1 = now.v, now.a - c * now.v
    v2 = now.v + 0.5 * h * a1
    a2 = acceleration(now.x + 0.5 * h * v1) - c * v2
    v3 = now.v + 0.5 * h * a2
    a3 = acceleration(now.x + 0.5 * h * v2) - c * v3
    v4 = now.v + h * a3
    a4 = acceleration(now.x + h * v3) - c * v4
    x = now.x + h / 6 * (v1 + 2 * v2 + 2 * v3 + v4)
    return MotionState(x, now.v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4), acceleration(x))


REAL_LIMIT = 2.785293563405282
"""Largest stable time step of Runge-Kutta times a real decay rate.

The limit is the positive root z of 1 - z + z²/2 - z³/6 + z⁴/24 = 1. The faster of the two decays of
an overdamped mode decides.
"""


def _runge_kutta_limit(zeta: float) -> float:
    """First y = h·ω at which |R(z)| is 1, z = y·(-ζ ± i√(1 - ζ²)), R the exponential's series.

    |R|² - 1 is a polynomial in y, divided by y here; beyond critical damping the faster of two real
    decays decides.
    """
    if zeta >= 1:
        return REAL_LIMIT / (zeta * (1 + math.sqrt(1 - 1 / zeta / zeta)))
    root = complex(-zeta, math.sqrt(1 - zeta * zeta))
    series = [root**k / math.factorial(k) for k in range(4, -1, -1)]
    square = np.polymul(series, np.conj(series)).real
    # Up to y⁴ it is exp(-2ζy)'s, of which nothing is left as ζ vanishes: without cancellation.
    square[-5:-1] = [(-2 * zeta) ** k / math.factorial(k) for k in (4, 3, 2, 1)]
    roots = np.roots(square[:-1])
    return float(min(roots.real[(np.abs(roots.imag) < 1e-9) & (roots.real > 1)]))


def _runge_kutta_motion(h: float, steps: Array) -> States:
    # The exponential's series to h⁴, whose square is 1 - h⁶/72 + h⁸/576.
    growth = 0.5 * math.log1p(h**6 * (h * h - 8) / 576)
    return _spiral(growth, math.atan2(h - h**3 / 6, 1 - h**2 / 2 + h**4 / 24), steps)


RUNGE_KUTTA = Integrator(
    "runge_kutta",
    "classical Runge-Kutta",
    order=4,
    symplectic=False,
    step=_runge_kutta,
    damping="from the velocity of each of its four stages",
    limit=_runge_kutta_limit,
    damped_order=4,
    evaluations=4,
    undamped_motion=_runge_kutta_motion,
)
"""Classical Runge-Kutta scheme of order four. Source: [Kutta1901]."""


def _average_acceleration(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    # δ = h·(v + v')/2 and v' = v + h·(a - c·v + a' - c·v')/2: the second put into the first.
    p, q = 1 + 0.5 * h * c, 0.25 * h * h
    move, a = increment(acceleration, now.x, now.a, h * now.v + q * now.a, p, q)
    v = ((1 - 0.5 * h * c) * now.v + 0.5 * h * (now.a + a)) / p
    return MotionState(now.x + move, v, a)


def _no_limit(_: float) -> float:
    return math.inf


def _average_acceleration_motion(h: float, steps: Array) -> States:
    return _spiral(0.0, 2 * math.atan(0.5 * h), steps)


AVERAGE_ACCELERATION = Integrator(
    "average_acceleration",
    "average acceleration",
    order=2,
    symplectic=True,
    step=_average_acceleration,
    damping="from the mean of the old and the new velocity",
    limit=_no_limit,
    damped_order=2,
    implicit=True,
    keeps_energy=True,
    undamped_motion=_average_acceleration_motion,
)
"""Newmark's method with β = 1/4 and γ = 1/2, the trapezoidal rule.

In large rotations it conserves the angular momentum only to its order.

Stable at any step is not damped: a mode with large h·ω keeps its amplitude, and changes its sign
at nearly each step; of viscosity it feels 4ζ/(h·ω) a step, from the determinant of its matrix. What
steps do not resolve should be left out of the start and of sudden loads.

Source: [Newmark1959].
"""


INTEGRATORS = {
    scheme.name: scheme
    for scheme in (
        EXPLICIT_EULER,
        EULER_CROMER,
        LEAPFROG,
        VELOCITY_VERLET,
        RUNGE_KUTTA,
        AVERAGE_ACCELERATION,
        *VARIANTS,
    )
}
"""Name -> scheme: the report's four in their true forms, others, and variants."""


def choose_integrator(name: str, value: Integrator | str) -> Integrator:
    """Return an integrator, given as itself or by its name in `INTEGRATORS`."""
    return choose_entry(name, value, Integrator, INTEGRATORS)


def step_factors(scheme: Integrator | str) -> Factors:
    """Factors of a scheme's step, for `springs.kernels.Motion.advance`.

    Raises `ProblemError` if it does not move with one new velocity.
    """
    scheme = choose_integrator("scheme", scheme)
    if scheme.factors is None:
        able = ", ".join(name for name, one in INTEGRATORS.items() if one.factors)
        raise ProblemError(f"{scheme.name}: more than one velocity a step; choose from: {able}")
    return scheme.factors
