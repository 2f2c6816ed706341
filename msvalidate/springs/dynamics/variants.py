"""Schemes that are kept for comparison, as they were misprinted or are mistaken.

What they share with the true ones of `integrators`, explicit Euler's limit, stands here.
"""

from __future__ import annotations

import math

from msvalidate.problem import Array
from msvalidate.springs.dynamics.scheme import Acceleration, Integrator, MotionState

OLD = "from the old velocity"


def explicit_euler_limit(zeta: float) -> float:
    """Explicit Euler's largest stable h·ω at a damping ratio."""
    # |λ|² = 1 - 2ζy + y² up to critical damping; beyond, the faster of two real roots reaches -1:
    # y = 2(ζ - √(ζ² - 1)), written without cancellation.
    return 2 * zeta if zeta <= 1 else 2 / (zeta * (1 + math.sqrt(1 - 1 / zeta / zeta)))


def _euler_cromer_as_printed(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    # The report's section 5.4 (2): velocity first, but the position moves with the old one.
    v = now.v + h * (now.a - c * now.v)
    x = now.x + h * now.v
    return MotionState(x, v, acceleration(x))


EULER_CROMER_AS_PRINTED = Integrator(
    "euler_cromer_as_printed",
    "Euler-Cromer as printed",
    order=1,
    symplectic=False,
    step=_euler_cromer_as_printed,
    damping=OLD,
    limit=explicit_euler_limit,
    variant=True,
    swelling=1.0,
)


def _verlet_as_printed(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    # The report's section 5.4 (4): the second half kick starts again from v_t, with F_t.
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    return MotionState(x, half, acceleration(x))


def _verlet_as_printed_limit(zeta: float) -> float:
    return 4 / (math.hypot(math.sqrt(2), zeta) + zeta)  # 2(√(2 + ζ²) - ζ), the same way


VERLET_AS_PRINTED = Integrator(
    "verlet_as_printed",
    "Verlet as printed",
    order=1,
    symplectic=True,
    step=_verlet_as_printed,
    damping=OLD,
    limit=_verlet_as_printed_limit,
    variant=True,
    share=0.5,
)


def _verlet_lagged(
    acceleration: Acceleration, now: MotionState, h: float, c: Array | float
) -> MotionState:
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    return MotionState(x, half + 0.5 * h * (now.a - c * now.v), acceleration(x))


def _verlet_lagged_limit(zeta: float) -> float:
    return min(4 * zeta, 1 / zeta) if zeta > 0 else 0.0


VERLET_LAGGED = Integrator(
    "verlet_lagged",
    "Verlet with the old force",
    order=1,
    symplectic=False,
    step=_verlet_lagged,
    damping=OLD,
    limit=_verlet_lagged_limit,
    variant=True,
    swelling=0.5,
)


VARIANTS = (EULER_CROMER_AS_PRINTED, VERLET_AS_PRINTED, VERLET_LAGGED)
