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
    """A time integration scheme.

    Parameters
    ----------
    name, title
        Its name in code and tables, and in words.
    order, damped_order
        Power of the step with which its error on a smooth motion falls, without damping and with
        it: a viscous force from an old velocity is of first order.
    symplectic
        Whether it preserves areas in phase space without damping: its energy then only fluctuates.
    keeps_energy
        Whether the energy of a linear undamped motion does not even fluctuate.
    step
        One step.
    damping
        In words: from which velocity it takes the viscous force.
    limit
        Largest stable h·ω of one mode with damping ratio ζ = c/(2ω), in closed form; the whole
        range below it is stable. 0 where no step is stable, infinite where all are.
    evaluations
        Evaluations of the force that a step takes; of an implicit one, where the force is linear.
    implicit
        Whether a step solves for the new position (`dynamics.implicit`).
    staggered
        Whether its step takes the velocity of half a step before the position (`stagger`).
    variant
        Whether it is kept for comparison: a scheme as it was misprinted or is mistaken.
    share
        Part of all forces that it follows (1): below 1 of a misprint.
    swelling
        What (h·ω)² times it is added to an area of phase space in an undamped step, of a scheme
        that no step makes stable (1).
    undamped_motion
        Closed form of its undamped motion, where there is one.
    factors
        Of a scheme that moves with one new velocity: what `kernels.Motion.advance` needs of it.
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
