"""Motions that rounding hides: positions, or lengths of springs, have no digits for them.

A state carries positions. Where displacements are small against their rounding, a spring that has
been stretched is as long as before and does not pull. Judged are the two ends of a motion; what it
might come to is told by its loads and velocities, so that a few steps of a motion that has digits
are no less than the whole of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from msvalidate.dynamics.scheme import MotionState
from msvalidate.linear_algebra.norms import max_abs
from msvalidate.network import Network
from msvalidate.network.residual import force_roundoff
from msvalidate.problem import Array, SolverError

DIGITS = 1e-2
"""Part of the largest displacement that rounding may hide: two digits are left, what a plot shows.
Velocities have more. Runs that a pulse begins with e^-18 of its height have that and are ordinary;
below, what is found is soon no motion."""
AT_REST = 8.0
"""Roundings up to which what nothing loads is at rest: as many springs meet at a lattice's points,
each rounded by itself."""
EPS = float(np.finfo(float).eps)


class MotionRecord(NamedTuple):
    """A motion: scheme, displacements, velocities and accelerations at its start, and its end.

    `rounded` (m) is the largest length that is rounded whenever forces are computed.
    """

    scheme: str
    start: MotionState
    end: MotionState
    rounded: float


def is_at_rest(network: Network, start: MotionState) -> bool:
    """Whether the network stays at rest: no load, velocity or displacement, springs in balance."""
    free = ~network.held
    if start.x.any() or start.v.any() or network.force[free].any():
        return False
    with np.errstate(over="ignore"):
        left = np.abs(np.where(free, start.a, 0.0)) * network.mass[:, None]
        return bool((left <= AT_REST * force_roundoff(network, network.size)).all())


def refuse_lost_digits(network: Network, run: MotionRecord) -> None:
    """Raise `SolverError` for a motion with fewer digits than `DIGITS` asks for.

    What nothing loads may come to rest, in many calls: positions tell its end as they tell its
    start, and from there a few roundings of a velocity are no motion.
    """
    moved = max(max_abs(run.start.x), max_abs(run.end.x))
    at, lengths = _position_rounding(network, run), EPS * run.rounded
    slender = lengths * max(network.size / float(network.rest_length.min()), 1.0)
    if moved * DIGITS >= max(at, slender):
        return
    local = _expected_displacement(network, run)
    loaded = bool(network.force[~network.held].any())
    if not loaded and (run.start.x.any() or max(moved, local) <= AT_REST * at):
        return
    if 0 < max(moved, local) * DIGITS < at:
        raise SolverError(
            f"{run.scheme}: displacements of about {max(moved, local):.1g} m where rounding of "
            f"positions is {at:.1g} m; move the body to the origin, or raise loads and "
            f"velocities {at / DIGITS / max(moved, local):.1g} times"
        )
    local = max(
        local, _largest_elongation(network, run.start.x), _largest_elongation(network, run.end.x)
    )
    if 0 < local * DIGITS < lengths and moved * DIGITS < slender:
        raise SolverError(
            f"{run.scheme}: elongations of about {local:.1g} m where rounding of lengths is "
            f"{lengths:.1g} m; raise loads and velocities {lengths / DIGITS / local:.1g} times, or "
            "take springs alone in the plain form"
        )


def _expected_displacement(network: Network, run: MotionRecord) -> float:
    """Displacement (m) that loads and velocities come to against a point's own springs alone.

    v/ω and f/k with ω² = k/m, k all that meets at the point: no less than these does a free point
    move, if it has the time.
    """
    size = network.size
    k = force_roundoff(network, size) / (EPS * size)
    mass, free = network.mass[:, None], ~network.held
    force = np.maximum(np.abs(run.start.a) * mass, np.abs(network.force))
    speed = np.maximum(np.abs(run.start.v), np.abs(run.end.v))
    with np.errstate(all="ignore"):  # where there are no springs: infinite, if anything acts
        far = np.maximum(force / k, speed * np.sqrt(mass) / np.sqrt(k))
    return float(np.nan_to_num(far[free], nan=0.0, posinf=math.inf).max(initial=0.0))


def _largest_elongation(network: Network, displacement: Array) -> float:
    """Largest elongation (m) by a displacement (n, d) in m, to its first order."""
    i, j = network.springs.T
    v, w = network.vector, displacement[j] - displacement[i]
    along = (v / np.linalg.norm(v, axis=1)[:, None] * w).sum(axis=1)
    return max_abs(along)


def _position_rounding(network: Network, run: MotionRecord) -> float:
    """Rounding (m) of the largest coordinate that is free to move."""
    ends = [np.abs(network.points + one.x) for one in (run.start, run.end)]
    return 0.5 * EPS * max_abs(np.where(network.held, 0.0, np.maximum(*ends)))
