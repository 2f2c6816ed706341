"""A soft slab followed over its voltage or its charge, up to where it pulls in and past it.

`actuated` finds an equilibrium near a start, by field and body in turn; here the way is gone from
rest over the voltage, up to where the slab pulls in.

At a fixed *charge* a thinner slab is not pulled harder, so that equilibria are found past the
largest voltage as well as before: `turning_point` finds that voltage as a maximum, with its
derivative 0.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import minimize_scalar

from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import (
    finite,
    finite_number,
    format_value,
    require_type,
)
from msvalidate.problem.records import dataclass
from reference_fem.actuator.actuated import ActuatedSlab, refuse_start, solve_actuated
from reference_fem.actuator.soft_slab import SoftSlab

RESOLUTION = 1e-3
"""Relative difference of two voltages, one held and one not, that `sweep` stops at."""
CHARGE_STEP = 0.1
"""Relative step of the charge on the way to the largest voltage."""
MOST_CHARGES = 60
FLAT = 1e-4
"""Relative difference of charges at which the largest voltage is known: to the square of it."""


@dataclass(frozen=True, eq=False)
class Sweep:
    """Equilibria at rising voltages.

    Parameters
    ----------
    held
        At the voltages asked for, as far as there are equilibria; then, if some were missed, the
        last that was found.
    pull_in
        The largest voltage (V) that was held and the least that was not; None if all were held.
    why
        What stopped it, in words; empty if all were held.
    """

    held: tuple[ActuatedSlab, ...]
    pull_in: tuple[float, float] | None
    why: str


def equilibrium_at(
    actuator: SoftSlab,
    voltage: float,
    *,
    start: ActuatedSlab | None = None,
    resolution: float = RESOLUTION,
) -> ActuatedSlab:
    """The slab at rest at a voltage, reached from rest or from `start` in steps as large as may be.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If there is no equilibrium: the message names the last voltage that was held.
    """
    found = sweep(actuator, (voltage,), start=start, resolution=resolution)
    if found.pull_in is None:
        return found.held[-1]
    last = found.pull_in[0]
    raise SolverError(
        f"actuator: no equilibrium at {voltage:g} V; the last held is at {last:.6g} V "
        f"({found.why}); stay below, or take `sweep`, which keeps it"
    )


def sweep(
    actuator: SoftSlab,
    voltages: ArrayLike,
    *,
    start: ActuatedSlab | None = None,
    resolution: float = RESOLUTION,
) -> Sweep:
    """Equilibria at rising voltages, each from the one before, up to where the slab pulls in.

    A step of the voltage that finds no equilibrium is halved, down to the resolution.

    Parameters
    ----------
    actuator
        The question.
    voltages
        (v,) in V, rising, the first at 0 or above.
    start
        An equilibrium to start from; rest at 0 V by default.
    resolution
        Relative difference of voltages at which pull-in is bracketed.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    """
    refuse_start(actuator, start)
    wanted = finite("voltages", voltages)
    if wanted.ndim != 1 or not len(wanted) or (np.diff(wanted) <= 0).any() or wanted[0] < 0:
        raise ProblemError(
            f"voltages: {format_value(voltages)}; give them rising, the first at 0 V or above"
        )
    finite_number("resolution", resolution, above=0, below=1)
    if start is not None and start.voltage > wanted[0]:
        raise ProblemError(
            f"start: at {start.voltage:g} V, above the first voltage, {wanted[0]:g} V; start below"
        )
    held: list[ActuatedSlab] = []
    last = start
    for voltage in wanted:
        last, missed, why = _raise_to(actuator, last, float(voltage), resolution)
        if missed is not None:
            below = 0.0 if last is None else last.voltage
            if last is not None and last not in held:
                held.append(last)
            return Sweep(tuple(held), (below, missed), why)
        assert last is not None  # noqa: S101  nothing was missed
        held.append(last)
    return Sweep(tuple(held), None, "")


def _raise_to(
    actuator: SoftSlab, last: ActuatedSlab | None, voltage: float, resolution: float
) -> tuple[ActuatedSlab | None, float | None, str]:
    """The last equilibrium on the way to a voltage; what was missed, if it is not there; and why.

    Between what is held and what was missed the voltage is halved. What was missed from far is
    tried again from near.
    """
    below = 0.0 if last is None else last.voltage
    missed: float | None = None
    tried, why = 0.0, ""
    while last is None or below < voltage:
        target = voltage if missed is None else 0.5 * (below + missed)
        if missed is not None and missed - below <= resolution * max(missed, resolution * voltage):
            if tried == below:
                return last, missed, why
            target = missed
        try:
            last = solve_actuated(actuator, "voltage", target, last)
        except SolverError as error:
            missed, tried, why = target, below, str(error)
        else:
            below = target
            missed = None if missed is not None and below >= missed else missed
    return last, None, ""


def turning_point(actuator: SoftSlab, start: ActuatedSlab) -> ActuatedSlab:
    """The equilibrium with the largest voltage, followed from `start` over the charge.

    The charge is raised until the voltage falls, and then sought between [Brent1973].

    Parameters
    ----------
    actuator
        The question, with two electrodes.
    start
        An equilibrium below it.

    Raises
    ------
    ProblemError
        If an argument is out of range, or the start is of another slab or at 0 V.
    SolverError
        If an equilibrium at a fixed charge is not found, or the voltage rises without end.
    """
    require_type("start", start, ActuatedSlab)
    refuse_start(actuator, start)
    if len(actuator.slab.electrodes) != 2:
        raise ProblemError("turning: more than two electrodes have no one charge; give two")
    if not start.voltage:
        raise ProblemError("turning: start is at 0 V; start from an equilibrium at a voltage")
    found = [start]
    while len(found) < 3 or found[-1].voltage > found[-2].voltage:
        if len(found) > MOST_CHARGES:
            raise SolverError(
                f"actuator: the voltage still rises at {found[-1].voltage:.4g} V, with a thickness "
                f"of {found[-1].ratio:.3g} of that at rest; it has no pull-in there"
            )
        charge = (1 + CHARGE_STEP) * _charge(found[-1])
        found.append(solve_actuated(actuator, "charge", charge, found[-1]))
    low, high = _charge(found[-3]), _charge(found[-1])

    def voltage(charge: float) -> float:
        near = min(found, key=lambda each: abs(_charge(each) - charge))
        found.append(solve_actuated(actuator, "charge", float(charge), near))
        return -found[-1].voltage

    minimize_scalar(voltage, bounds=(low, high), method="bounded", options={"xatol": FLAT * low})
    return max(found, key=lambda each: each.voltage)


def _charge(found: ActuatedSlab) -> float:
    """Charge (C) consistent with the energy ½QV."""
    return found.electric.capacitance * found.voltage
