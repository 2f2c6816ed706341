"""Relaxation by motion under a virtual viscosity: the report's Algorithm 1, and leapfrog.

The report's loop is Euler-Cromer ``while max(velocity) > eps``, which never starts from rest, and
stops wrongly wherever a swinging body turns round; here `relax` asks for small residual forces and
a small kinetic energy.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from functools import partial

from numpy.typing import ArrayLike

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import positive_number
from msvalidate.springs.dynamics.damping import decay
from msvalidate.springs.dynamics.divergence import StabilityWarning
from msvalidate.springs.dynamics.integrate import damping_rate
from msvalidate.springs.dynamics.integrators import EULER_CROMER, step_factors
from msvalidate.springs.dynamics.run import MOST_STEPS, PATIENCE, Method, Run, step_limit
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import SAFETY, stability_limit


def viscous(
    scheme: Integrator,
    *,
    dt: float | None = None,
    damping: ArrayLike | None = None,
    name: str = "viscous",
    title: str | None = None,
) -> Method:
    """Relaxation by motion under a virtual viscosity.

    Source: [Papadrakakis1981] for leapfrog with centred damping; Euler-Cromer's loop is that of
    [Report], section 4.

    Parameters
    ----------
    scheme
        An integrator with one velocity a step: Euler-Cromer or leapfrog.
    dt
        Time step (s); by default 0.9 of the stability limit for the network's frequencies. A longer
        step than the limit gives a warning.
    damping
        Rate (1/s), one number or (n,): F = -damping·m·v. A viscosity c in N·s/m is c/m. By default
        twice the lowest frequency, which damps the slowest mode critically.
    name, title
        What tables and messages call it.

    Raises
    ------
    ProblemError
        If the step is not above zero, or the scheme has more than one velocity.
    """
    step_factors(scheme)
    if dt is not None:
        positive_number("time step dt", dt, "s")
    return Method(
        name,
        title or f"viscous {scheme.name}",
        partial(_viscous, scheme, dt, damping),
    )


def _viscous(
    scheme: Integrator, dt: float | None, damping: ArrayLike | None, run: Run
) -> Iterator[None]:
    if damping is not None:
        damping_rate(run.network, damping)  # refused before frequencies are solved for
    lowest, highest = run.frequencies
    run.rate = damping_rate(run.network, 2 * lowest if damping is None else damping)
    run.limit = stability_limit(scheme, lowest, highest, run.rate)
    run.dt = SAFETY * run.limit if dt is None else dt
    if run.dt > run.limit:
        warnings.warn(
            f"{run.title}: {run.time_step}the motion will grow", StabilityWarning, stacklevel=2
        )
    run.look_seldom()
    run.most_steps = partial(_predicted_steps, lowest, run.rate, run.dt, run.tolerance)
    if scheme.staggered:  # the velocity of half a step before the start at rest
        run.velocity[:] = -0.5 * run.dt * run.balance() / run.network.mass[:, None]
    keep, push = step_factors(scheme)(run.dt, run.rate)
    while True:
        yield
        done, *_ = run.motion.advance(run.displacement, run.velocity, keep, push, run.dt, run.block)
        run.moved(done, done)


def _predicted_steps(lowest: float, rate: Array, dt: float, tolerance: float) -> int:
    """`PATIENCE` times the steps in which the slowest mode decays to `tolerance`."""
    slowest = min(float(rate.min()) / 2, decay(lowest, float(rate.max())))
    if slowest <= 0:
        raise ProblemError(
            f"damping: {rate.min():g} 1/s with no max_steps: the motion never ends, or none can "
            "say when; give a positive rate, leave it out, or set max_steps"
        )
    needed = -math.log(min(tolerance, 0.5))
    if PATIENCE * needed > MOST_STEPS * slowest * dt:
        raise ProblemError(
            f"damping: {rate.max():.4g} 1/s: the slowest motion would take more than "
            f"{MOST_STEPS / PATIENCE:.2g} steps of {dt:.4g} s to die out; leave damping and dt to "
            "their defaults, or set max_steps"
        )
    return step_limit(needed / (slowest * dt))


ALGORITHM1 = viscous(EULER_CROMER, name="algorithm1", title="Algorithm 1")
