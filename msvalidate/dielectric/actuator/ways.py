"""Two ways to an equilibrium at a voltage: Newton's method on all at once, or in turns."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal

import numpy as np

from msvalidate.dielectric.actuator.balance import (
    BalancedState,
    factor_at,
    find_equilibrium,
    is_balanced,
)
from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.models import Electric, charge_actuator
from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass

Way = Literal["newton", "staggered"]
ROUNDS = 60
"""Charges laid anew before the staggered way gives up: a dozen serve within 1e-4 of pull-in, and
beyond it they never settle."""
LEAST, MOST = 0.1, 50.0
"""Part of a round's move that is made."""


def solve_newton(
    actuator: Actuator, u: Array, voltage: float, tolerance: float
) -> BalancedState | None:
    """Stable equilibrium near a displacement (n, 2) in m: charges follow within each step."""

    def charged(place: Array) -> Electric:
        return charge_actuator(actuator, place, voltage)

    return find_equilibrium(actuator, u, charged, tolerance)


def solve_staggered(
    actuator: Actuator, u: Array, voltage: float, tolerance: float
) -> BalancedState | None:
    """The same in turns: the network rests under the forces it has, then is charged anew.

    A round leaves the part λ(K_mech⁻¹·K_elec) of an error, which is 1 at pull-in; Aitken's factor
    makes up for one such part.

    Source: [KuettlerWall2008].
    """
    solves, part, before = 0, 1.0, None
    for _ in range(ROUNDS):
        x = actuator.network.points + u
        electric = charge_actuator(actuator, x, voltage)
        if is_balanced(actuator, u, electric, tolerance):
            stable = factor_at(actuator, x, electric) is not None
            return BalancedState(u, electric, solves) if stable else None
        frozen = FrozenCharges(electric.charges, electric.loaded, electric.forces())
        # Below the tolerance of the whole: what is left in a round ends up in the next.
        rest = find_equilibrium(actuator, u, lambda _, kept=frozen: kept, 0.1 * tolerance)  # type: ignore[misc]
        if rest is None:
            return None
        move, solves = rest.displacement - u, solves + rest.solves
        if before is not None:
            change = move - before
            part *= -float(np.vdot(before, change) / np.vdot(change, change))
            part = float(np.clip(part, LEAST, MOST))
        u, before = u + part * move, move
    return None


WAYS: dict[Way, Callable[[Actuator, Array, float, float], BalancedState | None]] = {
    "newton": solve_newton,
    "staggered": solve_staggered,
}
"""Name -> what looks for a stable equilibrium near a displacement (n, 2) in m at a voltage (V)."""


@dataclass(frozen=True, eq=False)
class FrozenCharges:
    """Charges that stay as they are, and push with the forces they had."""

    charges: Any
    loaded: Index
    force: Array

    def forces(self) -> Array:
        """(k, 2) in N."""
        return self.force

    def tangent(self) -> Array:
        """(2k, 2k): none."""
        return np.zeros((2 * len(self.loaded), 2 * len(self.loaded)))
