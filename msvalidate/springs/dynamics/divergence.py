"""Motions that blow up, or that rounding hides: refused with what is at fault.

Of one that blows up is warned before its first step; it is told from its time step, the scheme's
limit, and how far it may go.

A state carries positions. Where displacements are small against their rounding, a spring that has
been stretched is as long as before and does not pull. Judged are the two ends of a motion; what it
might come to is told by its loads and velocities, so that a few steps of a motion that has digits
are no less than the whole of it.
"""

from __future__ import annotations

import math
import warnings

import numpy as np

from msvalidate.linear_algebra.norms import EPS, max_abs
from msvalidate.problem import LONGEST, Array, ProblemError, SolverError
from msvalidate.problem.records import dataclass
from msvalidate.springs.dynamics.implicit import ConvergenceError
from msvalidate.springs.dynamics.scheme import Integrator, MotionState
from msvalidate.springs.dynamics.spectrum import extreme_frequencies, highest_frequency
from msvalidate.springs.dynamics.step_limits import stability_limit
from msvalidate.springs.network import Network, frequency_bound
from msvalidate.springs.network.ground import Ground

SPECTRUM_ERROR = 1e-4
"""Relative error of the squared frequencies that determine limits.

Their last digits cost the most.
"""
RUNAWAY = 1e6
"""Relative distance from the start beyond which a motion has diverged.

It is relative to the size of the body plus the distance that a free point would move.
"""
LONGEST_STEP = 1e7
"""Largest h·ω of an unconditionally stable scheme.

There, masses are 4e-14 of h²/4 times the stiffness.
"""
FARTHEST = 1e12
"""Largest distance of a point in lengths of the shortest spring.

Three digits of that length remain.
"""
DIGITS = 1e-2
"""Largest relative rounding of a displacement, so that two digits remain.

A plot shows no more, and velocities have more digits. Ordinary runs that start with a pulse of
e^-18 of its height have that much rounding; below it, the result is soon meaningless.
"""
AT_REST = 8.0
"""Force, in units of rounding, up to which an unloaded network is in equilibrium.

It is the number of springs at a lattice point, each rounded by itself.
"""


class StabilityWarning(UserWarning):
    """A run is about to start with a time step beyond its stability limit."""


@dataclass(frozen=True, eq=False)
class Stepping:
    """Time stepping parameters of a run.

    `network` and `scheme` are what moves and by which scheme; `dt` and `steps` the time step (s)
    and the number of steps; `rate` the damping (n,) in 1/s; `ground` the ground springs, if any.
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
        if scheme.limit(0.0) > 0 and run.dt <= stability_limit(scheme, bound, bound, run.rate):
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


def _limit(run: Stepping) -> float | None:
    """Stability limit (s) at the reference positions; None where it is not known."""
    network, scheme = run.network, run.scheme
    if math.isinf(scheme.limit(0.0)):
        return math.inf
    if scheme.limit(0.0) == run.rate.min() == 0:  # also of a mechanism
        return 0.0
    try:
        if scheme.limit(0.0) > 0:  # the highest frequency alone decides
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
    flight = time * (max_abs(start.v) + time * max_abs(start.a))
    reach = RUNAWAY * (size + flight)
    return reach if reach < LONGEST else LONGEST  # nor is it NaN


def refuse_diverged(run: Stepping, start: MotionState, now: MotionState, reach: float) -> None:
    """Refuse a motion that exceeds its reach (m), before its numbers are NaN."""
    near = (np.abs(now.x - start.x) <= reach).all()  # not so where it is NaN
    if not (near and np.isfinite(now.v).all()):
        raise SolverError(_describe(run, start))


def refuse_long_step(run: Stepping, start: MotionState, error: SolverError) -> None:
    """Refuse a step that failed because it is too long.

    Other causes keep their own error.

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
    speed, pull = (max_abs(values) for values in (start.v, start.a))
    shortest = float(np.linalg.norm(run.network.vector, axis=1).min(initial=LONGEST))
    count, far = max(run.steps, 1), FARTHEST * shortest
    bounds = (
        (far, count * speed),
        (math.sqrt(far), count * math.sqrt(pull)),
        (LONGEST_STEP, frequency_bound(run.network)),
    )
    return min((top / each for top, each in bounds if each > 0), default=math.inf)


def is_at_rest(network: Network, start: MotionState) -> bool:
    """Return True if an unloaded, undisplaced network stays in equilibrium.

    It then has no displacement or velocity, no load on a free component, and no internal force
    beyond rounding. False does not mean that it moves: a loaded or displaced network may be in
    equilibrium too.
    """
    free = ~network.fixed
    if start.x.any() or start.v.any() or network.force[free].any():
        return False
    with np.errstate(over="ignore"):
        left = np.abs(np.where(free, start.a, 0.0)) * network.mass[:, None]
        return bool((left <= AT_REST * network.rounding(network.size)).all())


def refuse_lost_digits(
    network: Network, scheme: str, start: MotionState, end: MotionState, rounded: float
) -> None:
    """Raise `SolverError` for a motion with fewer digits than `DIGITS` asks for.

    `rounded` (m) is the largest length that is rounded whenever forces are computed: it comes back
    in the displacements of as many springs as the body is long. What nothing loads may come to
    rest, in many calls: positions tell its end as they tell its start, and from there a few
    roundings of a velocity are no motion.
    """
    moved = max(max_abs(start.x), max_abs(end.x))
    ends = [np.abs(network.points + one.x) for one in (start, end)]
    at = 0.5 * EPS * max_abs(np.where(network.fixed, 0.0, np.maximum(*ends)))
    along = network.size / float(network.distance.max())
    lost = max(at, 0.5 * EPS * rounded * along)
    if moved * DIGITS >= lost:
        return
    moved = max(moved, _expected_displacement(network, start, end))
    loaded = bool(network.force[~network.fixed].any())
    if not loaded and (start.x.any() or moved <= AT_REST * at):
        return
    if 0 < moved * DIGITS < lost:
        raise SolverError(
            f"{scheme}: displacements of about {moved:.1g} m where rounding of positions and "
            f"lengths is {lost:.1g} m; move the body to the origin, or raise loads and "
            f"velocities {2 * lost / DIGITS / moved:.1g} times"
        )


def _expected_displacement(network: Network, start: MotionState, end: MotionState) -> float:
    """Displacement (m) that loads and velocities come to against a point's own springs alone.

    v/ω and f/k with ω² = k/m, k all that meets at the point: no less than these does a free point
    move, if it has the time.
    """
    size = network.size
    k = network.rounding(size) / (EPS * size)
    mass, free = network.mass[:, None], ~network.fixed
    force = np.maximum(np.abs(start.a) * mass, np.abs(network.force))
    speed = np.maximum(np.abs(start.v), np.abs(end.v))
    with np.errstate(all="ignore"):  # where there are no springs: infinite, if anything acts
        far = np.maximum(force / k, speed * np.sqrt(mass) / np.sqrt(k))
    return float(np.nan_to_num(far[free], nan=0.0, posinf=math.inf).max(initial=0.0))
