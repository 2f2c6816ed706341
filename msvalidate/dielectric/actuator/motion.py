"""The report's Algorithm 1 with charges: an actuator moves to rest, charged anew as it goes."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.dielectric.actuator.balance import (
    BalancedState,
    is_balanced,
    positive_factor,
    stiffness,
)
from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.actuator.equilibria import (
    ActuatorEquilibrium,
    make_equilibrium,
    refuse_other_network,
)
from msvalidate.dielectric.actuator.models import Electric, charge_actuator
from msvalidate.problem import Array, ProblemError, SolverError
from msvalidate.problem.checks import finite_number, require_type, whole_number
from msvalidate.springs import kernels
from msvalidate.springs.dynamics.divergence import SPECTRUM_ERROR
from msvalidate.springs.dynamics.integrators import EULER_CROMER, step_factors
from msvalidate.springs.dynamics.relax import LOOSEST
from msvalidate.springs.dynamics.run import DIVERGED, LOOK_EVERY, step_limit
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.step_limits import SAFETY, stability_limit


def relax_actuator(
    actuator: Actuator,
    voltage: float,
    *,
    start: ActuatorEquilibrium | None = None,
    charges_every: int = 1,
    tolerance: float = 1e-8,
) -> ActuatorEquilibrium:
    """Rest at a voltage by Euler-Cromer with virtual viscosity, the report's Algorithm 1.

    The voltage is switched on at once, on a network that has not moved, or at `start`. The time
    step is 0.9 of the stability limit of the network without charges, which only soften it; the
    damping twice its lowest frequency; and the run ends after 20 times the steps that its slowest
    mode needs.

    Parameters
    ----------
    actuator, voltage
        Which, and at how many V.
    start
        Positions to start from, at rest.
    charges_every
        Steps after which charges are solved for anew; between, points keep their forces.
    tolerance
        The run ends when the largest residual is below this times the forces that meet at a point,
        with charges as they are there, and the kinetic energy below its square times the springs'.

    Returns
    -------
    ActuatorEquilibrium
        Its iterations are the steps taken.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If electrodes touch, the motion diverges, is not at rest in time, or rests where it is
        unstable; the message names the voltage.
    """
    require_type("actuator", actuator, Actuator)
    volts = finite_number("voltage", voltage)
    finite_number("tolerance", tolerance, above=0, most=LOOSEST)
    every = whole_number("charges_every", charges_every, 1)
    network, name = actuator.network, f"actuator moving at {volts:.6g} V"
    u = np.array(network.displacement)
    if start is not None:
        refuse_other_network(actuator, start)
        u = np.where(network.fixed, u, start.displacement)
    lowest, highest = extreme_frequencies(network, tolerance=SPECTRUM_ERROR)
    rate = 2 * lowest
    dt = SAFETY * stability_limit(EULER_CROMER, lowest, highest, rate)
    keep, push = (float(f) for f in step_factors(EULER_CROMER)(dt, np.asarray(rate)))
    patience = step_limit(-math.log(tolerance) / (0.5 * lowest * dt))
    motion, inertia = kernels.Motion(network), network.mass[:, None]
    v, force, size = np.zeros_like(u), np.empty_like(u), float(np.ptp(network.points, axis=0).max())
    for step in range(patience + 1):
        is_looked_at = step % LOOK_EVERY == 0
        if is_looked_at or step % every == 0:
            if not np.abs(u).max() < DIVERGED * size:
                raise SolverError(f"{name} diverged by step {step}; take a lower voltage")
            electric, pull = _charge(actuator, u, volts, f"{name}: pulled in by step {step}")
        stored = motion.force_and_energy(u, force)
        balance = np.where(network.fixed, 0.0, force + pull)
        kinetic = 0.5 * float((inertia * v**2).sum())
        is_still = is_looked_at and kinetic <= tolerance**2 * stored
        if is_still and is_balanced(actuator, u, electric, tolerance):
            if positive_factor(stiffness(actuator, network.points + u, electric)) is None:
                raise SolverError(
                    f"{name} came to rest after {step} steps where it is unstable; disturb the "
                    "symmetry or lower the voltage"
                )
            return make_equilibrium(actuator, volts, BalancedState(u, electric, step))
        v = keep * v + push * balance / inertia
        u = u + dt * v
    raise SolverError(
        f"{name} is not at rest after {patience} steps: residual {np.abs(balance).max():.3g} N, "
        f"kinetic energy {kinetic:.3g} J; stay below pull-in"
    )


def _charge(
    actuator: Actuator, displacement: Array, voltage: float, said: str
) -> tuple[Electric, Array]:
    """Charges where the electrodes are, and the pull (n, 2) in N of them and of loads."""
    try:
        with np.errstate(over="ignore", invalid="ignore"):  # refused as coordinates
            place = actuator.network.points + displacement
            electric = charge_actuator(actuator, place, voltage)
    except (ProblemError, SolverError) as error:
        raise SolverError(f"{said}, {error}; or stay at a lower voltage") from error
    pull = np.array(actuator.network.force)
    pull[electric.loaded] += electric.forces()
    return electric, pull
