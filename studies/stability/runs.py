"""A network that is loaded suddenly, run until it leaves a box around itself: no NaN comes out."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from msvalidate import kit
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.lattice import Lattice

from .networks import REPORTED, Body, clamped

BODY = Body("square", 6)


class Run(NamedTuple):
    """Positions (steps + 1, n, d) in m while all are inside; the step that left, 0 if none."""

    positions: kit.Array
    left: int


class LeftError(Exception):
    """A point has gone farther than the picture reaches; carries nothing, ends a run."""


def block(traction: tuple[float, float]) -> tuple[Lattice, kit.Network]:
    """The report's 6 x 6 particles, k2 = 2 k1, all springs of a kind alike; traction in N/m²."""
    return clamped(BODY, REPORTED, weights="equal", traction=traction)


def release_network(
    network: kit.Network, scheme: Integrator, dt: float, steps: int, damping: float, reach: float
) -> Run:
    """Motion from rest under the network's load until a point is farther away than `reach` (m)."""
    start = State(network.points, np.zeros_like(network.points))
    seen = [start.position]

    def watch(_: int, now: State) -> None:
        if np.abs(now.position - network.points).max() > reach:
            raise LeftError
        seen.append(now.position)

    try:
        motion(network, start, scheme, dt, steps, damping, watch, warn=False)
    except (
        LeftError,
        kit.SolverError,
    ):  # the latter where one step went from inside beyond all numbers
        return Run(np.array(seen), len(seen))
    return Run(np.array(seen), 0)
