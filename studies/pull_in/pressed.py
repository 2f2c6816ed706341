"""The uniform slab, pressed charge by charge: past the pull-in without an unstable step.

At a given charge per area σ a uniform field pulls with σ²/(2ε) whatever the gap, so equilibrium is
an ordinary one under a dead load, stable beyond the pull-in too. The voltage is σ·l·h/ε, and has
its largest value at the pull-in. Neither an actuator nor its charges are needed for it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize_scalar

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.lattice import square
from msvalidate.springs.statics.equilibrium import equilibrium
from reference_fem import box_discretisation
from reference_fem.large_strain import Solid, deform, square_fibres

from .slab import AXIAL, DIAGONAL, HEIGHT, PERMITTIVITY

UP = 2
"""Cells up a column one cell wide: it stays uniform, so that few do."""
CLOSE = 1e-7
"""To which the charge of the largest voltage is found, relative: the voltage is flat there."""


class State(NamedTuple):
    """Charge per area σ (C/m²), thickness l (1), voltage (V)."""

    charge: float
    thickness: float
    voltage: float


def column() -> kit.Box:
    """A column of the slab (m), its sides sliding."""
    return kit.Box((HEIGHT / UP, HEIGHT))


def springs(pressure: float, diagonal: float = DIAGONAL) -> float:
    """Thickness l (1) of a column of lattice under a pressure (N/m²), by Newton's method."""
    box = column()
    grid = square(box, (1, UP))
    sides = tuple(kit.Support(box.side(name), (0.0, None)) for name in ("left", "right"))
    problem = kit.Problem(
        box,
        kit.Anisotropic(interior_tensor(grid, (AXIAL, DIAGONAL), "shared")),
        (kit.Support(box.side("bottom"), (0.0, 0.0)), *sides),
        (kit.Traction(box.side("top"), (0.0, -pressure)),),
        name="column of the slab",
    )
    found = equilibrium(lattice_network(problem, grid, (AXIAL, diagonal)), "nonlinear")
    return float(found.position[:, 1].max() / HEIGHT)


def elements(pressure: float) -> float:
    """The same of finite elements with the energy of the lattice's springs."""
    box = column()
    body = box_discretisation(box, (1, UP), "Q1")
    bottom, top = (np.isclose(body.points[:, 1], level) for level in (0.0, HEIGHT))
    held = np.column_stack([np.ones(len(bottom), dtype=bool), bottom])
    force = np.zeros(body.points.shape)
    force[top, 1] = -pressure * box.size[0] / 2
    solid = Solid(body, square_fibres(AXIAL, DIAGONAL), held)
    found = deform(solid, np.zeros(force.shape), force)
    return float(1 + found.displacement[top, 1].mean() / HEIGHT)


def state(law: Callable[[float], float], charge: float) -> State:
    """What a charge per area (C/m²) makes of a slab, by a law pressure -> l."""
    part = law(charge**2 / (2 * PERMITTIVITY))
    return State(charge, part, charge * part * HEIGHT / PERMITTIVITY)


def pull_in(law: Callable[[float], float]) -> State:
    """The state of the largest voltage, charges of up to a stress of 0.6·k1 being tried."""
    most = float(np.sqrt(2 * PERMITTIVITY * 0.6 * AXIAL))
    found = minimize_scalar(
        lambda charge: -state(law, charge).voltage,
        bounds=(0.2 * most, most),
        method="bounded",
        options={"xatol": CLOSE * most},
    )
    return state(law, float(found.x))


straight_springs = partial(springs, diagonal=0.0)
"""A column without diagonals: its stress is linear, k1·(1 - l)."""
