"""Record that defines a time integration scheme: its step and its properties.

A scheme advances a state (x, v, a): position (m), velocity (m/s) and the acceleration (m/s²) of
springs and loads *without* damping at that position. The viscous acceleration is -c·v, c in 1/s.
Each scheme says from which velocity it takes it.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass

Acceleration = Callable[[Array], Array]
"""Acceleration (n, d) in m/s² of springs and loads at positions (n, d) in m."""


class MotionState(NamedTuple):
    """Position (m), velocity (m/s), and the undamped acceleration (m/s²) at that position."""

    x: Array
    v: Array
    a: Array


Step = Callable[[Acceleration, MotionState, float, Array | float], MotionState]
"""Function that advances a state by a step `h` (s) with damping `c` (1/s).

The damping is a number or one per component.
"""
Factors = Callable[[float, Array], tuple[Array, Array]]
"""Factors (keep, push) of a step `h` (s) with damping `c` (1/s).

v = keep·v + push·a and x += h·v.
"""


def stagger(now: MotionState, half: float, c: Array | float) -> MotionState:
    """State with its velocity `half` (s) earlier: v - half·(a - c·v).

    Source: the Störmer-Verlet scheme in its leapfrog form, [HairerLubichWanner2006], section I.1.4.
    """
    return now._replace(v=now.v - half * (now.a - c * now.v))


def synchronise(now: MotionState, half: float, c: Array | float) -> MotionState:
    """State with the velocity of its position's time: the inverse of `stagger`.

    Of leapfrog it is the mean of the velocities before and after that time.
    """
    return now._replace(v=(now.v + half * now.a) / (1 + half * c))


States = NDArray[np.complex128]
"""States x + i·v/ω (n,) of an oscillator, relative to its amplitude.

Position and velocity belong to the same time.
"""
UndampedMotion = Callable[[float, Array], States]
"""States from rest at 1 by h·ω (rad) and numbers of steps (n,)."""


@dataclass(frozen=True)
class Integrator:
    """Time integration scheme: its step and its properties.

    Parameters
    ----------
    name, title
        Name in code and tables, and in sentences.
    order, damped_order
        Order of convergence for a smooth motion, without and with damping. A viscous force from an
        old velocity gives order 1.
    symplectic
        True if the undamped scheme preserves areas in phase space, so that the energy only
        fluctuates.
    keeps_energy
        True if the energy of a linear undamped motion is constant.
    step
        Function that performs one step.
    damping
        Description of the velocity that determines the viscous force.
    limit
        Function of the damping ratio ζ = c/(2ω) that returns the largest stable h·ω of a mode. 0 if
        no step is stable, infinite if every step is.
    evaluations
        Force evaluations per step; for an implicit scheme, those with a linear force.
    implicit
        True if a step solves for the new position.
    staggered
        True if a step uses the velocity of half a step before the position.
    variant
        True for a misprinted or mistaken scheme that is included for comparison.
    share
        Fraction of all forces that the scheme applies; below 1 for a misprint.
    swelling
        Growth of an area in phase space per undamped step, in units of (h·ω)², for a scheme that is
        unstable at every step.
    undamped_motion
        Closed form of the undamped motion, if known.
    factors
        Factors of the step, for a scheme that moves positions with one new velocity.
    """

    name: str
    title: str
    order: int
    symplectic: bool
    step: Step
    damping: str
    limit: Callable[[float], float]
    damped_order: int = 1
    evaluations: int = 1
    implicit: bool = False
    staggered: bool = False
    variant: bool = False
    share: float = 1.0
    swelling: float = 0.0
    keeps_energy: bool = False
    undamped_motion: UndampedMotion | None = None
    factors: Factors | None = None
