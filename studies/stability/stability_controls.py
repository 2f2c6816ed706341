"""Resolution: what is the smallest fault of a scheme that the study notices?

Question   How wrong may a kick or a damping be before a tolerance fails?
Candidate  Schemes with a known fault put into their step.
Reference  The tolerances of `cost` (closed form of the motion) and `order` (under damping), met
           on one oscillator, which gives the network's linear motion without its rounding.
Expected   A kick that is wrong by a part ε moves the frequency by ε/4 and the state after 20π rad
           by 5π·ε. The fault is noticed if that exceeds the 1.5e-11 of rounding: ε near 1e-12. A
           wrong damping leaves an error that does not fall with the step, where
           a scheme's own error does: the smaller that is, the smaller the fault noticed.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Acceleration, Integrator, MotionState, Step

from . import cost, order, oscillator

CLOSE = 1e-6
"""Relative width at which the search for the smallest fault ends."""
LEAST, MOST = 1e-15, 0.5
RULES = (
    kit.Rule(
        "smallest fault noticed, largest over the kinds",
        1e-6,
        "1",
        "a damping wrong by a part ε moves the end of the motion by 0.2·ε of the amplitude or so, "
        "and 5e-8 of it is noticed: 2.5e-7, and a factor of four; kicks are held closer",
        table="resolution", value="smallest_noticed",
    ),
)  # fmt: skip


def weak_kick(
    size: float, acceleration: Acceleration, now: MotionState, h: float, c: kit.Array | float
) -> MotionState:
    """Velocity Verlet whose second half kick lacks the part `size`."""
    half = now.v + 0.5 * h * (now.a - c * now.v)
    x = now.x + h * half
    a = acceleration(x)
    return MotionState(x, half + (1 - size) * 0.5 * h * (a - c * half), a)


def weak_damping(
    step: Step,
    size: float,
    acceleration: Acceleration,
    now: MotionState,
    h: float,
    c: kit.Array | float,
) -> MotionState:
    """A step whose damping lacks the part `size`."""
    return step(acceleration, now, h, (1 - size) * c)


def with_weak_kick(size: float) -> Integrator:
    """Velocity Verlet, by its claims, with a weak second kick."""
    return replace(INTEGRATORS["velocity_verlet"], step=partial(weak_kick, size))


def with_weak_damping(name: str, size: float) -> Integrator:
    """A scheme, by its claims, with too little damping."""
    scheme = INTEGRATORS[name]
    return replace(scheme, step=partial(weak_damping, scheme.step, size))


def off_closed_form(scheme: Integrator) -> float:
    """Distance of an undamped motion from its closed form, over its tolerance."""
    return cost.errors(scheme, cost.QUICK_EVALUATIONS[-1])[1] / cost.ROUNDING


def damped_order(scheme: Integrator) -> float:
    """Error of the order under damping, over its tolerance."""
    ratio, steps = order.RATIOS[1], np.array(order.QUICK_STEPS)
    exact = order.exact_swing(1.0, ratio)
    errors = [oscillator.swing(scheme, int(n), order.ANGLE, ratio) - exact for n in steps]
    expected = order.on_paper(scheme, ratio, steps)
    limit = order.order_uncertainty(scheme, ratio, steps)
    return abs(kit.observed_order(order.ANGLE / steps, errors) - expected) / limit


FAULTS: dict[str, tuple[Callable[[float], Integrator], Callable[[Integrator], float], str]] = {
    "velocity Verlet's second kick": (with_weak_kick, off_closed_form, "closed form of the motion"),
    "Euler-Cromer's damping": (
        partial(with_weak_damping, "euler_cromer"),
        damped_order,
        "order under damping",
    ),
    "leapfrog's damping": (
        partial(with_weak_damping, "leapfrog"),
        damped_order,
        "order under damping",
    ),
}
"""Fault -> the scheme that has it in some size, what notices it, and that in words."""


def run(setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame(setting.sweep(smallest, FAULTS, "smallest faults"))
    said = ", ".join(f"{row.fault} by {row.smallest_noticed:.1g}" for row in table.itertuples())
    return kit.Evidence(
        tables={"resolution": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(f"Smallest faults that this study notices, as parts: {said}.",),
    )


def smallest(name: str) -> dict[str, object]:
    """The smallest size of a fault from which the tolerance fails, by halving in logarithms."""
    faulty, error, quantity = FAULTS[name]
    low, high = LEAST, MOST
    while high > (1 + CLOSE) * low:
        middle = math.sqrt(low * high)
        low, high = (low, middle) if error(faulty(middle)) > 1 else (middle, high)
    return {"fault": name, "smallest_noticed": high, "noticed_by": quantity}
