"""The report's Algorithm 1 with charges: an actuator moves to rest, charged anew as it goes."""

from __future__ import annotations

import math

import numpy as np

from msvalidate import kernels
from msvalidate.dielectric.actuator.balance import BalancedState, factor_at, is_balanced
from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.equilibria import (
    ActuatorEquilibrium,
    make_equilibrium,
    refuse_other_network,
)
from msvalidate.dielectric.actuator.models import Electric, charge_actuator
from msvalidate.dynamics.divergence import SPECTRUM_ERROR
from msvalidate.dynamics.integrators import EULER_CROMER, step_factors
from msvalidate.dynamics.relax import LOOSEST
from msvalidate.dynamics.run import DIVERGED, LOOK_EVERY, step_limit
from msvalidate.dynamics.spectrum import extreme_frequencies
from msvalidate.dynamics.step_limits import SAFETY, stability_limit
from msvalidate.network import Network
from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import finite_number, positive_number, require_type, whole_number
from msvalidate.problem.records import dataclass


@dataclass(frozen=True, eq=False)
class RelaxedActuator:
    """A motion that came to rest.

    Parameters
    ----------
    equilibrium
        Where; its iterations are the steps taken.
    dt, damping
        Time step (s) and damping rate (1/s).
    """

    equilibrium: ActuatorEquilibrium
    dt: float
    damping: float


def relax_actuator(
    actuator: Actuator,
    voltage: float,
    *,
    start: ActuatorEquilibrium | None = None,
    dt: float | None = None,
    damping: float | None = None,
    charges_every: int = 1,
    tolerance: float = 1e-8,
    max_steps: int | None = None,
) -> RelaxedActuator:
    """Rest at a voltage by Euler-Cromer with virtual viscosity, the report's Algorithm 1.

    The voltage is switched on at once, on a network that has not moved, or at `start`.

    Parameters
    ----------
    actuator, voltage
        Which, and at how many V.
    start
        Positions to start from, at rest.
    dt
        Time step (s); by default 0.9 of the stability limit of the network without charges, which
        only soften it.
    damping
        Rate (1/s), F = -damping·m·v; by default twice the lowest frequency without charges.
    charges_every
        Steps after which charges are solved for anew; between, points keep their forces.
    tolerance
        The run ends when the largest residual is below this times the forces that meet at a point,
        with charges as they are there, and the kinetic energy below its square times the springs'.
    max_steps
        By default 20 times what the slowest mode needs without charges.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If electrodes touch, the motion diverges, is not at rest within `max_steps`, or rests where
        it is unstable; the message names the voltage.
    """
    require_type("actuator", actuator, Actuator)
    volts = finite_number("voltage", voltage)
    finite_number("tolerance", tolerance, above=0, most=LOOSEST)
    every = whole_number("charges_every", charges_every, 1)
    step, rate, patience = _time_stepping(actuator.network, dt, damping, tolerance, max_steps)
    run = _Run(actuator, volts, start, step, rate)
    for count in range(patience + 1):
        is_looked_at = count % LOOK_EVERY == 0
        if is_looked_at or count % every == 0:
            run.charge(count)
        if is_looked_at and run.is_at_rest(tolerance):
            return RelaxedActuator(run.equilibrium(count), step, rate)
        run.advance()
    raise SolverError(
        f"{run.name} is not at rest after {patience} steps: residual "
        f"{np.abs(run.balance()).max():.3g} N, kinetic energy {run.kinetic:.3g} J; raise "
        "max_steps, or stay below pull-in"
    )


def _time_stepping(
    network: Network,
    dt: float | None,
    damping: float | None,
    tolerance: float,
    max_steps: int | None,
) -> tuple[float, float, int]:
    """Time step (s), damping rate (1/s) and most steps; by default what suits it uncharged."""
    lowest, highest = extreme_frequencies(network, tolerance=SPECTRUM_ERROR)
    rate = 2 * lowest if damping is None else positive_number("damping", damping, "1/s")
    limit = stability_limit(EULER_CROMER, lowest, highest, rate)
    step = SAFETY * limit if dt is None else positive_number("time step dt", dt, "s")
    if max_steps is not None:
        return step, rate, whole_number("max_steps", max_steps, 1)
    decay = min(0.5 * rate, lowest**2 / rate) if rate > lowest else 0.5 * rate
    return step, rate, step_limit(-math.log(tolerance) / (decay * step))


class _Run:
    """State of the motion: displacement, velocity and present charges."""

    def __init__(
        self,
        actuator: Actuator,
        voltage: float,
        start: ActuatorEquilibrium | None,
        dt: float,
        rate: float,
    ) -> None:
        network = actuator.network
        self.actuator, self.voltage, self.dt = actuator, voltage, dt
        self.keep, self.push = (float(f) for f in step_factors(EULER_CROMER)(dt, np.asarray(rate)))
        self.name = f"actuator moving at {voltage:.6g} V"
        self.motion = kernels.Motion(network)
        moved = np.array(network.displacement)
        if start is not None:
            refuse_other_network(actuator, start)
            moved = np.where(network.held, moved, start.displacement)
        self.displacement, self.velocity = moved, np.zeros_like(moved)
        self.free, self.inertia = ~network.held, network.mass[:, None]
        self.force, self.stored = np.empty_like(moved), 0.0
        self.size = float(np.ptp(network.points, axis=0).max())
        self.electric: Electric | None = None
        self.pull = np.zeros_like(moved)

    @property
    def position(self) -> Array:
        return self.actuator.network.points + self.displacement

    def charge(self, step: int) -> None:
        """Solve for the charges where the electrodes are."""
        self.refuse_diverged(step)
        try:
            with np.errstate(over="ignore", invalid="ignore"):  # refused as coordinates
                self.electric = charge_actuator(self.actuator, self.position, self.voltage)
        except (ProblemError, SolverError) as error:
            raise SolverError(
                f"{self.name}: pulled in by step {step}, {error}; or stay at a lower voltage"
            ) from error
        self.pull = np.array(self.actuator.network.force)
        self.pull[self.electric.loaded] += self.electric.forces()

    def balance(self) -> Array:
        """Out-of-balance force (n, 2) in N, 0 where it is held."""
        self.stored = self.motion.force_and_energy(self.displacement, self.force)
        return np.where(self.free, self.force + self.pull, 0.0)

    def advance(self) -> None:
        """One step of Euler-Cromer."""
        self.velocity = self.keep * self.velocity + self.push * self.balance() / self.inertia
        self.displacement = self.displacement + self.dt * self.velocity

    def refuse_diverged(self, step: int) -> None:
        """Raise `SolverError` if a point is far away, or nowhere."""
        if not np.abs(self.displacement).max() < DIVERGED * self.size:
            raise SolverError(
                f"{self.name} diverged by step {step}; take a smaller dt, or a lower voltage"
            )

    @property
    def kinetic(self) -> float:
        """Kinetic energy (J)."""
        return 0.5 * float((self.inertia * self.velocity**2).sum())

    def is_at_rest(self, tolerance: float) -> bool:
        """Whether forces balance and nothing moves."""
        self.balance()  # what springs store there
        if self.kinetic > tolerance**2 * self.stored or self.electric is None:
            return False
        return is_balanced(self.actuator, self.displacement, self.electric, tolerance)

    def equilibrium(self, steps: int) -> ActuatorEquilibrium:
        """Where it rests, if that is stable."""
        assert self.electric is not None  # noqa: S101  # charged before any row
        if factor_at(self.actuator, self.position, self.electric) is None:
            raise SolverError(
                f"{self.name} came to rest after {steps} steps where it is unstable; disturb the "
                "symmetry or lower the voltage"
            )
        return make_equilibrium(
            self.actuator, self.voltage, BalancedState(self.displacement, self.electric, steps)
        )
