"""Runs that blow up: warned of before their first step, refused with what is at fault.

A run is told from its time step, the scheme's limit, and how far its motion may go.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from msvalidate.dynamics.implicit import ConvergenceError
from msvalidate.dynamics.scheme import Integrator, MotionState
from msvalidate.dynamics.spectrum import extreme_frequencies, highest_frequency
from msvalidate.dynamics.step_limits import stability_limit
from msvalidate.network import Network, frequency_bound
from msvalidate.network.ground import Ground
from msvalidate.problem import LONGEST, Array, ProblemError, SolverError
from msvalidate.problem.records import dataclass

SPECTRUM_ERROR = 1e-4
"""Of the squared frequencies from which limits are told: their last digits cost the most."""


RUNAWAY = 1e6
"""Times the body's size, and the distance that a free point would go in a run: a motion that is
farther from its start has blown up."""


LONGEST_STEP = 1e7
"""h·ω of a scheme without a limit: masses beside h²/4 times the stiffness are 4e-14 there."""
FARTHEST = 1e12
"""Lengths of the shortest spring that a point may go: three digits of that length are left."""


class StabilityWarning(UserWarning):
    """A run is about to start with a time step beyond its stability limit."""


@dataclass(frozen=True, eq=False)
class Stepping:
    """What a run's steps are.

    `network`, `scheme`: what moves, and by which scheme. `dt`, `steps`: time step (s) and how many
    there are. `rate`: damping (n,) in 1/s. `ground`: ground springs, if there are any.
    """

    network: Network
    scheme: Integrator
    dt: float
    steps: int
    rate: Array
    ground: Ground | None = None

    def highest(self, omega: float) -> float:
        """Bound (rad/s) of frequencies with the ground springs, `omega` that without."""
        return math.hypot(omega, self.ground.frequency) if self.ground else omega


def warn_beyond_limit(run: Stepping) -> None:
    """Warn of a step beyond the limit; where Gershgorin's bound allows it, at no cost.

    Nothing is said of a mechanism under a scheme whose limit depends on the lowest frequency.
    """
    bound, scheme = run.highest(frequency_bound(run.network)), run.scheme
    if not (bound > 0 and math.isfinite(bound)):
        return
    try:
        if _has_one_end(scheme) and run.dt <= stability_limit(scheme, bound, bound, run.rate):
            return
    except (ProblemError, SolverError):
        return
    limit = _limit(run)
    if limit is not None and run.dt > limit:
        warnings.warn(
            f"{scheme.name}: steps of {run.dt:.4g} s are beyond the stability limit, {limit:.4g} s "
            f"at damping {run.rate.max():.4g} 1/s; the motion will grow",
            StabilityWarning,
            stacklevel=3,
        )


def _has_one_end(scheme: Integrator) -> bool:
    """Whether the highest frequency alone decides on a scheme's limit."""
    return scheme.limit(0.0) > 0


def _limit(run: Stepping) -> float | None:
    """Stability limit (s) at the reference positions; None where it is not known."""
    network, scheme = run.network, run.scheme
    if math.isinf(scheme.limit(0.0)):
        return math.inf
    if scheme.limit(0.0) == run.rate.min() == 0:  # also of a mechanism
        return 0.0
    try:
        if _has_one_end(scheme):
            highest = highest_frequency(network, tolerance=SPECTRUM_ERROR)
            highest = lowest = run.highest(highest)
        else:
            lowest, highest = extreme_frequencies(network, tolerance=SPECTRUM_ERROR)
        return stability_limit(scheme, lowest, highest, run.rate)
    except (ProblemError, SolverError):
        return None


def largest_reach(run: Stepping, start: MotionState) -> float:
    """Distance (m) from the start beyond which a motion has blown up."""
    size = float(np.ptp(run.network.points, axis=0).max())
    time = run.dt * run.steps
    flight = time * (float(np.abs(start.v).max()) + time * float(np.abs(start.a).max()))
    reach = RUNAWAY * (size + flight)
    return reach if reach < LONGEST else LONGEST  # nor is it NaN


def refuse_diverged(run: Stepping, start: MotionState, now: MotionState, reach: float) -> None:
    """Refuse what is farther than its reach (m) from its start, before its numbers are NaN."""
    near = (np.abs(now.x - start.x) <= reach).all()  # not so where it is NaN
    if not (near and np.isfinite(now.v).all()):
        raise SolverError(_describe(run, start))


def refuse_long_step(run: Stepping, start: MotionState, error: SolverError) -> None:
    """Refuse a step that failed for being too long; what else it failed for, its error tells.

    A motion that grows leaves no digits of a spring's length, say, long before its bounds.
    """
    limit = _limit(run)
    most = _largest_ordinary_step(run, start) if limit == math.inf else limit
    if most is not None and run.dt > most and not isinstance(error, ConvergenceError):
        raise SolverError(_describe(run, start)) from error


def _describe(run: Stepping, start: MotionState) -> str:
    """A run that has blown up, in one line: its step, the limit, the remedy."""
    limit = _limit(run)
    remedy = "take smaller steps"
    if limit is None:
        remedy = "take steps below stability_limit"
    elif limit == 0:
        remedy = f"unstable at any step with damping {run.rate.max():g} 1/s: take another scheme"
    elif run.dt > limit:
        remedy = f"take steps below stability_limit, {limit:.4g} s"
    elif limit < math.inf:
        remedy = f"the limit, {limit:.4g} s, is that of small motions: {remedy}"
    elif run.dt > (most := _largest_ordinary_step(run, start)):
        remedy = f"stable at any step, but digits are lost beyond {most:.4g} s: take smaller ones"
    name = run.scheme.name
    return f"{name}: the motion grew beyond all bounds with steps of {run.dt:.4g} s; {remedy}"


def _largest_ordinary_step(run: Stepping, start: MotionState) -> float:
    """Step (s) up to which numbers hold a motion by a scheme that is stable at any.

    A free point stays where springs keep digits of their lengths, and masses are seen beside the
    stiffness.
    """
    speed, pull = (float(np.abs(values).max()) for values in (start.v, start.a))
    shortest = float(np.linalg.norm(run.network.vector, axis=1).min(initial=LONGEST))
    count, far = max(run.steps, 1), FARTHEST * shortest
    bounds = (
        (far, count * speed),
        (math.sqrt(far), count * math.sqrt(pull)),
        (LONGEST_STEP, frequency_bound(run.network)),
    )
    return min((top / each for top, each in bounds if each > 0), default=math.inf)
