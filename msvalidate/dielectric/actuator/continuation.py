"""Equilibria over a range of voltages, to pull-in where it is met."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.equilibria import (
    BRACKET,
    TOLERANCE,
    ActuatorEquilibrium,
    PulledIn,
    at_voltage,
)
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import finite, format_value, require_type
from msvalidate.problem.records import dataclass


@dataclass(frozen=True, eq=False)
class Sweep:
    """Stable equilibria of an actuator at rising voltages.

    Parameters
    ----------
    equilibria
        At 0 V, at each voltage that was reached, and at the last one before pull-in.
    pull_in
        The last voltage held and one a small step further without a stable equilibrium (V); None
        if it was not met.
    """

    equilibria: tuple[ActuatorEquilibrium, ...]
    pull_in: tuple[float, float] | None

    @property
    def voltages(self) -> Array:
        """(k,) in V."""
        return np.array([one.voltage for one in self.equilibria])

    @property
    def last(self) -> ActuatorEquilibrium:
        """The equilibrium at the highest voltage."""
        return self.equilibria[-1]


def sweep(
    actuator: Actuator,
    voltages: ArrayLike,
    *,
    tolerance: float = TOLERANCE,
    bracket: float = BRACKET,
) -> Sweep:
    """Equilibria at rising voltages, each found from the one before.

    Parameters
    ----------
    actuator
        At 0 V it must be stable.
    voltages
        (k,) in V, rising from above 0.
    tolerance, bracket
        As in `at_voltage`; pull-in is known to `bracket` times the voltage.

    Raises
    ------
    ProblemError
        If voltages do not rise, or an argument is out of range.
    SolverError
        If the actuator is not stable at 0 V. Pull-in is no error: the sweep ends there.
    """
    require_type("actuator", actuator, Actuator)
    asked = _check_voltages(voltages)
    held = [at_voltage(actuator, 0.0, tolerance=tolerance)]
    for voltage in asked:
        try:
            found = at_voltage(
                actuator, voltage, start=held[-1], tolerance=tolerance, bracket=bracket
            )
        except PulledIn as error:
            if error.last.voltage > held[-1].voltage:
                held.append(error.last)
            return Sweep(tuple(held), (held[-1].voltage, error.beyond))
        held.append(found)
    return Sweep(tuple(held), None)


def _check_voltages(voltages: ArrayLike) -> list[float]:
    given = finite("voltages", voltages)
    if given.ndim != 1 or not len(given) or given[0] <= 0 or (np.diff(given) <= 0).any():
        raise ProblemError(
            f"voltages: {format_value(voltages)}; give a list that rises from above 0 V"
        )
    return [float(one) for one in given]
