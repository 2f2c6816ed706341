"""The small block that a simulator is tried on, and how forces are read from one step of it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from msvalidate.case.case import Case
from msvalidate.problem import Array, Box, Isotropic, Problem, Support, Traction, Weight
from msvalidate.problem.checks import whole_number
from msvalidate.simulators.exchange.export import export_case
from msvalidate.simulators.exchange.protocol import Answer, Request, SimulatorError

ACROSS = 4
"""Cells across the block, whose side is 1 m: quarters are exact in float32."""
ONE_STEP, MANY_STEPS = 0.5, 0.1
"""Time step over the time that a pressure wave takes through a cell. One step from rest is stable
whatever it is, and the longer it is the more of its velocity is above rounding."""
STRAIN = 2.0**-10
"""Of the pulled block: far above rounding in float32, small beside 1."""


def pulled_block(material: Isotropic, settings: Mapping[str, Any]) -> Request:
    """A block of side 1 m, clamped at its left, pulled at its right to about `STRAIN`."""
    pull = (STRAIN * material.E, *[0.0] * (material.dim - 1))
    return _block(material, settings, lambda box: Traction(box.side("right"), pull))


def hanging_block(material: Isotropic, settings: Mapping[str, Any]) -> Request:
    """The same under a weight that stretches it as much, for programs without nodal forces."""
    weight = STRAIN * material.E / material.density  # over a side of 1 m
    acceleration = (weight, *[0.0] * (material.dim - 1))
    return _block(material, settings, lambda _: Weight(acceleration))


def _block(
    material: Isotropic,
    settings: Mapping[str, Any],
    load: Callable[[Box], Traction | Weight],
) -> Request:
    box = Box((1.0,) * material.dim)
    clamp = Support(box.side("left"), (0.0,) * material.dim)
    problem = Problem(box, material, (clamp,), (load(box),), "block")
    return export_case(Case(problem), cells=ACROSS, settings=settings)


def motion(block: Request, start: Array, steps: int = 1, gravity: Array | None = None) -> Request:
    """The block let go from positions (n, d) in m, in steps short enough to be stable."""
    material = block.material
    stiff = min(material.nu, 0.49)
    modulus = material.E * (1 - stiff) / ((1 + stiff) * (1 - 2 * stiff))
    part = ONE_STEP if steps == 1 else MANY_STEPS
    dt = part / ACROSS * math.sqrt(material.density / modulus)
    none = np.zeros_like(block.force)
    return replace(
        block,
        task="motion",
        start=start,
        # A power of two, so that floats of either kind hold it.
        dt=2.0 ** math.floor(math.log2(dt)),
        steps=whole_number("steps", steps, 1),
        gravity=np.zeros(block.mesh.dim) if gravity is None else gravity,
        force=none,
        held=none.astype(bool),
        value=none,
    )


def epsilon(answer: Answer) -> float:
    """Rounding of the floats that an answer was reckoned in; of float64, where it does not say."""
    single = answer.about.get("precision") == "float32"
    return float(np.finfo(np.float32 if single else np.float64).eps)


def turned(points: Array, angle: float) -> Array:
    """Places (n, d) turned in the plane of the first two axes about their middle."""
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    turn = np.eye(points.shape[1])
    turn[:2, :2] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    return np.asarray((points - middle) @ turn.T + middle)


def forces(request: Request, answer: Answer) -> Array:
    """Force (n, d) in N that the body puts on its nodes, from what one step does to velocities."""
    if answer.force is not None:
        return answer.force
    if answer.velocity is None or request.dt is None:
        raise SimulatorError("answer: neither velocities nor forces")
    return np.asarray(request.mass[:, None] * (answer.velocity / request.dt - request.gravity))
