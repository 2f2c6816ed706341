"""Motions that rounding hides: positions, or lengths of springs, have no digits for them.

A state carries positions. Where displacements are small against their rounding, a spring that has
been stretched is as long as before and does not pull. Judged are the two ends of a motion; what it
might come to is told by its loads and velocities, so that a few steps of a motion that has digits
are no less than the whole of it.
"""

from __future__ import annotations

import math

import numpy as np

from msvalidate.dynamics.scheme import MotionState
from msvalidate.linear_algebra.norms import EPS, max_abs
from msvalidate.network import Network
from msvalidate.problem import SolverError

DIGITS = 1e-2
"""Part of the largest displacement that rounding may hide: two digits are left, what a plot shows.
Velocities have more. Runs that a pulse begins with e^-18 of its height have that and are ordinary;
below, what is found is soon no motion."""
AT_REST = 8.0
"""Roundings up to which what nothing loads is at rest: as many springs meet at a lattice's points,
each rounded by itself."""


def is_at_rest(network: Network, start: MotionState) -> bool:
    """Whether the network stays at rest: no load, velocity or displacement, springs in balance."""
    free = ~network.held
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
    at = 0.5 * EPS * max_abs(np.where(network.held, 0.0, np.maximum(*ends)))
    along = network.size / float(network.distance.max())
    lost = max(at, 0.5 * EPS * rounded * along)
    if moved * DIGITS >= lost:
        return
    moved = max(moved, _expected_displacement(network, start, end))
    loaded = bool(network.force[~network.held].any())
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
    mass, free = network.mass[:, None], ~network.held
    force = np.maximum(np.abs(start.a) * mass, np.abs(network.force))
    speed = np.maximum(np.abs(start.v), np.abs(end.v))
    with np.errstate(all="ignore"):  # where there are no springs: infinite, if anything acts
        far = np.maximum(force / k, speed * np.sqrt(mass) / np.sqrt(k))
    return float(np.nan_to_num(far[free], nan=0.0, posinf=math.inf).max(initial=0.0))
