"""Controls: faulty motions, and the smallest fault of each kind that this study notices.

Question   Which faults of the motion make a tolerance fail, and how small may they be?
Candidate  Euler-Cromer with a known fault.
Reference  The identities: a free velocity is multiplied by 1 - hc a step, and the slowest mode of
           the report's block follows the scheme's recursion.
Expected   Errors grow in proportion to small faults, so the smallest fault noticed is the limit of
           an identity over its error per fault.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.implicit import NetworkAcceleration
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.network import internal_force

from . import direction, figure2
from .bodies import MOTION, MotionSolver

PROBE = 1e-4
"""Size of the fault from which the smallest noticed one is extrapolated."""
RATIO = 0.5
"""Damping over the critical one at which the block's mode is watched."""
NEW_VELOCITY = "viscous force from the new velocity"
FACTOR = direction.FACTOR
RULES = (
    kit.Rule(
        "smallest fault of the motion noticed, largest over the kinds", 1e-6, "1",
        "identities hold to 1e-8 and 1e-7, a fault moves the free velocity by half of itself and "
        "the mode by a thirtieth of itself and more: at most 3e-7, and a factor of three",
        table="resolution", value="smallest_noticed",
    ),
)  # fmt: skip
Fault = Callable[[float, kit.Network, State, float, int, Any], State]


def other_damping(
    size: float, network: kit.Network, state: State, dt: float, steps: int, damping: Any
) -> State:
    """Damping larger by the fraction `size`."""
    return MOTION(network, state, dt, steps, damping * (1 + size))


def other_kick(
    size: float, network: kit.Network, state: State, dt: float, steps: int, damping: Any
) -> State:
    """Springs and loads push harder by the fraction `size`: rest is where it was."""
    return _stepped(1 + size, damping, network, state, dt, steps)


def first_kick(
    size: float, network: kit.Network, state: State, dt: float, steps: int, damping: Any
) -> State:
    """The part `size` of the first kick of a run from rest is lost."""
    if state.velocity.any():
        return MOTION(network, state, dt, steps, damping)
    kick = dt * NetworkAcceleration(network)(state.position - network.points)
    return MOTION(network, State(state.position, -size * kick), dt, steps, damping)


def new_velocity(
    size: float, network: kit.Network, state: State, dt: float, steps: int, damping: Any
) -> State:
    """The part `size` of the viscous force comes from the new velocity instead of the old.

    v' = v + h(a - c(1 - p)v - cpv') is v' = v + h(a - cv)/(1 + hcp), and x' = x + hv' as ever.
    """
    less = 1 / (1 + dt * damping * size)
    return _stepped(less, less * damping, network, state, dt, steps)


def _stepped(
    push: float, drag: Any, network: kit.Network, state: State, dt: float, steps: int
) -> State:
    """Steps v' = v + h(push·a - drag·v), x' = x + hv'.

    With f = √push it is the scheme's own step in h·f for h, drag/f for c and v/f for v.
    """
    f = math.sqrt(push)
    slower = State(state.position, state.velocity / f)
    end = MOTION(network, slower, dt * f, steps, drag / f)
    return State(end.position, end.velocity * f)


def lagged_force(
    size: float, network: kit.Network, state: State, dt: float, steps: int, damping: Any
) -> State:
    """Forces are taken the part `size` of a step late, at the position x - size·dt·v."""
    free, mass = ~network.fixed, network.mass[:, None]
    x, v = state.position, np.where(free, state.velocity, 0.0)
    for _ in range(steps):
        pull = internal_force(network, x - size * dt * v) + network.force
        v = np.where(free, v + dt * (pull / mass - damping * v), 0.0)
        x = x + dt * v
    return State(x, v)


KINDS: dict[str, tuple[Fault, str]] = {
    "damping": (other_damping, "relative"),
    "kick": (other_kick, "relative"),
    "first kick": (first_kick, "part lost"),
    NEW_VELOCITY: (new_velocity, "part"),
    "lagged force": (lagged_force, "part of a step"),
}


def apply_fault(kind: str, size: float) -> MotionSolver:
    """A candidate with a fault of some kind and size."""
    return partial(KINDS[kind][0], size)


def run() -> kit.Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame([smallest(kind) for kind in KINDS])
    return kit.Evidence(
        tables={"resolution": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def smallest(kind: str) -> dict[str, object]:
    """The fault's smallest size that some identity notices, and which."""
    grown = excesses(apply_fault(kind, PROBE))
    quantity = max(grown, key=lambda key: grown[key])
    return {
        "fault": kind,
        "unit": KINDS[kind][1],
        "smallest_noticed": PROBE / grown[quantity],
        "noticed_by": quantity,
    }


def excesses(candidate: MotionSolver) -> dict[str, float]:
    """Errors of the identities over their limits."""
    free = direction.try_direction(candidate, 0, ("free", 0.5))
    factor = float(str(free["factor"])) / float(str(free["factor_predicted"]))
    body = figure2.block()
    _, row = figure2.curve(candidate, body, figure2.shared_step(body), (RATIO, 1))
    return {
        "free velocity": abs(factor - 1) / FACTOR,
        "slowest mode by the recursion": row["from_recursion"] / figure2.RECURSION,
    }
