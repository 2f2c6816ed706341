"""Equilibrium of an actuator at a voltage, by Newton's method on springs and charges at once.

Newton's tangent is K_mech - K_elec, charges free to follow: sparse, with a dense block among the
electrodes' points, factorised once a step. Its pivots tell whether what was found is stable. The
walk from a lower voltage is in steps, halved where there is no stable equilibrium near by, so that
nothing folds. A sweep goes on from voltage to voltage, to pull-in where it is met.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric.actuator.balance import BalancedState, find_equilibrium, residual_force
from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.models import charge_actuator
from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import finite, finite_number, format_value, require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.statics.equilibrium import equilibrium

TOLERANCE = 1e-10
"""Residual at which an equilibrium is found, over the forces that meet at a point. Newton's last
step squares what was left, so what is reached is usually rounding."""
LOOSEST = 1e-3
BRACKET = 1e-4
"""Step in the voltage, over the voltage, below which pull-in is found. Beside it the displacement
goes with the root of what is missing."""


@dataclass(frozen=True, eq=False)
class ActuatorEquilibrium:
    """An actuator at rest at a voltage, stable by the signs of its tangent's pivots.

    Parameters
    ----------
    actuator, voltage
        Which, and at how many V.
    displacement
        (n, 2) from the network's points (m).
    charges
        As its model describes them; of the "plane" model `charges.moments.Charges`.
    iterations
        Linear solves on the way from the start, without those of refused steps.
    residual
        Largest out-of-balance force (N) on a free component.
    """

    actuator: Actuator
    voltage: float
    displacement: Array
    charges: Any
    iterations: int
    residual: float

    @property
    def position(self) -> Array:
        """(n, 2) in m."""
        return self.actuator.network.points + self.displacement

    @property
    def top(self) -> Array:
        """(k, 2) positions of the top electrode's points (m)."""
        return self.position[self.actuator.electrodes[0]]


class PulledIn(SolverError):  # noqa: N818  # it says what happened
    """No stable equilibrium at a voltage: the actuator is pulled in on the way there.

    Parameters
    ----------
    message
        What is said.
    last
        The equilibrium held at the highest voltage reached.
    beyond
        A voltage (V) a small step further at which none was found.
    """

    def __init__(self, message: str, last: ActuatorEquilibrium, beyond: float) -> None:
        super().__init__(message)
        self.last, self.beyond = last, beyond


def at_voltage(
    actuator: Actuator,
    voltage: float,
    *,
    start: ActuatorEquilibrium | None = None,
    bracket: float = BRACKET,
) -> ActuatorEquilibrium:
    """Stable equilibrium at a voltage, on the branch that starts at zero voltage.

    Parameters
    ----------
    actuator
        At 0 V it must be stable under its own supports, loads and prestress.
    voltage
        V, from the bottom electrode to the top one.
    start
        An equilibrium to walk from; by default that at 0 V.
    bracket
        Step over the voltage at which the walk gives up.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    PulledIn
        A `SolverError` that names the voltage and the last one held, and keeps that equilibrium.
    """
    require_type("actuator", actuator, Actuator)
    goal = finite_number("voltage", voltage)
    finite_number("bracket", bracket, above=0, most=LOOSEST)
    if start is None:
        held = _rest_without_charge(actuator)
        if goal == 0:
            return held
    else:
        refuse_other_network(actuator, start)
        held = replace(start, iterations=0)
    step, easy = goal - held.voltage, False
    while True:
        last = abs(goal - held.voltage) <= abs(step)
        target = goal if last else held.voltage + step
        found = _step_to_voltage(actuator, held, target)
        if found is not None:
            held = replace(found, iterations=held.iterations + found.iterations)
            if last:
                return held
            # Once a step was refused, twice as long a one is tried after two that were not.
            step, easy = step * (2 if easy else 1), not easy
            continue
        if target == held.voltage:
            raise SolverError(
                f"actuator: no stable equilibrium near the start at {goal:.6g} V; start at a lower "
                "voltage"
            )
        if abs(target - held.voltage) <= bracket * abs(target):
            raise PulledIn(
                f"actuator: no stable equilibrium at {goal:.6g} V; it is pulled in at "
                f"{target:.6g} V, the last voltage held is {held.voltage:.6g} V; stay below",
                held,
                target,
            )
        step, easy = 0.5 * (target - held.voltage), False


def refuse_other_network(actuator: Actuator, start: ActuatorEquilibrium) -> None:
    """Raise `ProblemError` unless `start` is of a network of as many points as the actuator's."""
    require_type("start", start, ActuatorEquilibrium)
    if start.displacement.shape != actuator.network.points.shape:
        raise ProblemError(
            f"start: displacements {start.displacement.shape} of another network; this one has "
            f"{actuator.network.points.shape}"
        )


def _rest_without_charge(actuator: Actuator) -> ActuatorEquilibrium:
    """Rest under loads, supports and prestress alone."""
    try:
        found = equilibrium(actuator.network, "nonlinear")
    except SolverError as error:
        raise SolverError(
            "actuator: no stable equilibrium at 0 V; lower its loads or prestress, or hold it "
            "better"
        ) from error
    electric = charge_actuator(actuator, found.position, 0.0)
    state = BalancedState(np.array(found.displacement), electric, found.iterations)
    return make_equilibrium(actuator, 0.0, state)


def _step_to_voltage(
    actuator: Actuator, held: ActuatorEquilibrium, voltage: float
) -> ActuatorEquilibrium | None:
    """Stable equilibrium at a voltage near that of `held`, None if none is found."""
    network = actuator.network
    u = np.where(network.fixed, network.displacement, held.displacement)
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # refused by the residual
            found = find_equilibrium(
                actuator, u, lambda place: charge_actuator(actuator, place, voltage), TOLERANCE
            )
    except (ProblemError, SolverError):  # electrodes touch, or springs have no length
        return None
    return None if found is None else make_equilibrium(actuator, voltage, found)


def make_equilibrium(
    actuator: Actuator, voltage: float, found: BalancedState
) -> ActuatorEquilibrium:
    """Build the equilibrium at a voltage from the result of a search."""
    displacement, electric, solves = found
    balance = residual_force(actuator, displacement, electric)[~actuator.network.fixed]
    displacement.setflags(write=False)
    residual = float(np.abs(balance).max(initial=0.0))
    return ActuatorEquilibrium(actuator, voltage, displacement, electric.charges, solves, residual)


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
    bracket: float = BRACKET,
) -> Sweep:
    """Equilibria at rising voltages, each found from the one before.

    Parameters
    ----------
    actuator
        At 0 V it must be stable.
    voltages
        (k,) in V, rising from above 0.
    bracket
        As in `at_voltage`; pull-in is known to this times the voltage.

    Raises
    ------
    ProblemError
        If voltages do not rise, or an argument is out of range.
    SolverError
        If the actuator is not stable at 0 V. Pull-in is no error: the sweep ends there.
    """
    require_type("actuator", actuator, Actuator)
    asked = _check_voltages(voltages)
    held = [at_voltage(actuator, 0.0)]
    for voltage in asked:
        try:
            found = at_voltage(actuator, voltage, start=held[-1], bracket=bracket)
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
