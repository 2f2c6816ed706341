"""Controls: ways to rest with a known fault, and the smallest fault that this study notices.

Question   Which faults make a tolerance fail, and how small may they be?
Candidate  The network's own way with a fault put into its forces, its gap or its stiffness.
Reference  The pull-in voltage of the slab between walls, as `sweep` holds it; of other faults the
           tolerances of the question that is named with them.
Expected   A force that is wrong by a part p moves the pull-in voltage by p/2, its square being in
           the force, and so do springs: what is noticed is twice the tolerance, 2e-6.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import (
    Actuator,
    ActuatorEquilibrium,
    PulledIn,
    at_voltage,
    lowest_modes,
)
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.springs.network import internal_force
from msvalidate.springs.statics.equilibrium import equilibrium

from . import film, pressed, sweep
from .slab import PULL_IN
from .way import SPRINGS, Laws, PullInSolver, last_equilibrium, sliding

PROBE = 1e-3
"""Size of the fault from which the smallest noticed one is extrapolated."""


def stronger(
    size: float,
    actuator: Actuator,
    voltage: float,
    *,
    start: ActuatorEquilibrium | None = None,
    **how: Any,
) -> ActuatorEquilibrium:
    """Electric forces larger by the part `size`: those of a voltage √(1 + size) times as large."""
    times = float(np.sqrt(1 + size))
    before = None if start is None else replace(start, voltage=start.voltage * times)
    try:
        found = at_voltage(actuator, voltage * times, start=before, **how)
    except PulledIn as error:
        last = replace(error.last, voltage=error.last.voltage / times)
        raise PulledIn(str(error), last, error.beyond / times) from None
    return replace(found, voltage=voltage)


def stiffer(
    size: float,
    actuator: Actuator,
    voltage: float,
    *,
    start: ActuatorEquilibrium | None = None,
    **how: Any,
) -> ActuatorEquilibrium:
    """Springs stiffer by the part `size`."""
    changed = replace(actuator, network=actuator.network.scaled(1 + size))
    try:
        found = at_voltage(changed, voltage, start=start, **how)
    except PulledIn as error:
        last = replace(error.last, actuator=actuator)
        raise PulledIn(str(error), last, error.beyond) from None
    return replace(found, actuator=actuator)


def gap_as_it_was(
    actuator: Actuator, voltage: float, *, start: ActuatorEquilibrium | None = None, **how: Any
) -> ActuatorEquilibrium:
    """Charges and their forces are those of the slab at rest, however far its surface has moved."""
    network = actuator.network
    electric = charge_actuator(actuator, network.start, voltage)
    force = np.array(network.force)
    force[electric.loaded] += electric.forces()
    found = equilibrium(replace(network, force=force), "nonlinear")
    balance = internal_force(network, found.position) + force
    left = float(np.abs(balance[~network.fixed]).max())
    return ActuatorEquilibrium(
        actuator, voltage, found.displacement, electric.charges, found.iterations, left
    )


def springs_alone(held: ActuatorEquilibrium, count: int = 1) -> tuple[kit.Array, kit.Array]:
    """Modes of K_mech: at no voltage there is no K_elec."""
    return lowest_modes(replace(held, voltage=0.0), count)


def half_softened(held: ActuatorEquilibrium, count: int = 1) -> tuple[kit.Array, kit.Array]:
    """Modes of K_mech - ½K_elec: K_elec goes with the square of the voltage."""
    return lowest_modes(replace(held, voltage=held.voltage / np.sqrt(2)), count)


def linear_sheet(first: float, second: float) -> float:
    """Energy over μ of a sheet by Hooke's law, the third strain keeping the volume to first order.

    μ·Σe², with e the stretches less 1: half of 2μ·e² along each axis.
    """
    along, across = first - 1, second - 1
    return along**2 + across**2 + (along + across) ** 2


KINDS: dict[str, Callable[..., ActuatorEquilibrium]] = {
    "electric force": stronger,
    "springs": stiffer,
}
"""What may be wrong by a part of itself."""
SOFTER = partial(film.field, ratio=0.49)
FAULTS = {
    "electric force halved": (PullInSolver(partial(stronger, -0.5)), "sweep"),
    "springs 1 % too stiff": (PullInSolver(partial(stiffer, 0.01)), "sweep"),
    "gap and charges as at the start": (PullInSolver(gap_as_it_was), "sweep"),
    "a voltage beyond pull-in is held": (PullInSolver(gap_as_it_was), "beyond"),
    "stiffness without K_elec": (PullInSolver(at_voltage, springs_alone), "instability"),
    "half of K_elec": (PullInSolver(at_voltage, half_softened), "instability"),
    "a lattice without its diagonals": (
        PullInSolver(laws=Laws(lattice=pressed.straight_springs)),
        "which",
    ),
    "a linear sheet in the neo-Hookean one's place": (
        PullInSolver(laws=Laws(sheet=linear_sheet)),
        "which",
    ),
    "a bonded film of a ratio of 0.49": (PullInSolver(laws=Laws(wave=SOFTER)), "which"),
}
"""Fault -> the way that has it, and the question that notices."""


def run() -> kit.Evidence:
    """State the smallest fault of each kind that the study notices."""
    by = sweep.RULES[1]
    right = pulled_in(SPRINGS)
    rows = []
    for kind, faulty in KINDS.items():
        moved = abs(pulled_in(PullInSolver(partial(faulty, PROBE))) / right - 1)
        least = PROBE * by.limit / moved
        rows.append({"fault": kind, "smallest_noticed": least, "noticed_by": by.quantity})
    table = pd.DataFrame(rows)
    largest = kit.Observed(table["smallest_noticed"].max(), 2 * by.limit)
    own = (
        kit.Tolerance(
            "smallest fault noticed, largest over the kinds, against twice the tolerance",
            1e-8, "1",
            "the pull-in voltage goes with the root of a stiffness and of a force: 2e-6; read off "
            "a fault of 1e-3, whose next term is 1e-3 of that at most, and a factor of five",
            observed=largest,
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"resolution": table},
        tolerances=own,
        columns=kit.columns(__file__),
        # The bracket of the voltage over what the probe moves it by.
    )


def pulled_in(way: PullInSolver) -> float:
    """Pull-in voltage (V) of the slab between walls."""
    actuator = sliding(sweep.WALLED_LAYERS)
    return last_equilibrium(way, actuator, 1.05 * PULL_IN.voltage, bracket=sweep.BRACKET)[0].voltage
