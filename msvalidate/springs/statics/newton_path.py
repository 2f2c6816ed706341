"""Newton's method along a path of loads, and limit points that it passes.

A whole load is tried at once. What would not converge is halved, and so is what takes a spring too
far in one step. An equilibrium may then be found although the branch that begins at the start ends
before: a shallow arch has snapped through. So the way between two equilibria a and b is looked at
once both are known. With the moves m_a and m_b by which the tangents at both ends answer the load
between them, a smooth way meets

    x_b - x_a ≈ (m_a + m_b)/2        and, at half the load,  x ≈ (x_a + x_b)/2 + (m_a - m_b)/8,

exact for ways of second and third degree (trapezoidal rule, Hermite's cubic). It costs a solve
with a factor that is there, and one more with the forces that the cubic leaves out of balance.
Where one of the two is not met, an equilibrium is looked for halfway from a, and both halves are
looked at. A gap that stays down to `RESOLVED` of the load is a limit point if b, led back by so
little of the load, does not return to a.
"""

from __future__ import annotations

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass, field
from msvalidate.springs.network import Configuration
from msvalidate.springs.network.inverse import Regular, Solver
from msvalidate.springs.network.mechanism import is_certain
from msvalidate.springs.network.multigrid import NotConvergedError
from msvalidate.springs.network.residual import force_scale
from msvalidate.springs.statics.path import LoadPath
from msvalidate.springs.statics.tangents import LARGEST_TURN, Tangent, tangent_at

TOLERANCE = 1e-11
"""Relative residual at which Newton's method stops.

It is relative to the forces that meet at a point, and not below their rounding. Convergence is
quadratic, so that the result is usually accurate to rounding.
"""
ITERATIONS = 25
"""Newton steps a load increment may take: far more than quadratic convergence needs."""
SMALLEST_INCREMENT = 2.0**-12
RESOLVED = 2.0**-10
"""Fraction of a path to which a limit point is located."""
BENT, MISSED = 0.15, 0.05
"""Deviations from the trapezoidal rule and from a cubic that need a closer search.

They are relative to the change of the same spring. A shallow arch that has snapped through exceeds
one of them at any load: by 92 and 4 % just past its limit, by 0 and 8 % at 31.8 times it, where its
two rates happen to fit. A cantilever does so from a deflection of a sixth of its length.
"""
SEARCHING = 12
"""Maximum number of Newton steps in the search of a limit point.

The search starts close to it.
"""
SMALL = 0.02
"""Relative change of a spring below which it is ignored."""
SAME = 0.1
"""Fraction of the gap within which a reversed path has returned."""


@dataclass(frozen=True, eq=False)
class PathPoint:
    """An equilibrium on the load path: its parameter t and displacement (n, d) in m."""

    t: float
    displacement: Array


@dataclass(frozen=True, eq=False)
class Arrival:
    """Equilibrium that Newton's method reached from the previous one.

    `smooth` is True if the way there shows no sign of a jump. `factor` is the inverse of the
    tangent at the station, by a factor or by multigrid; it is None if no component is free.
    """

    station: PathPoint
    smooth: bool
    factor: Regular | None


@dataclass(eq=False)
class PathResult:
    """The end of a load path, as far as it was followed.

    Parameters
    ----------
    displacement
        (n, d) in m.
    reached
        t of it: below 1 where no stable equilibrium lies beyond.
    solves
        Linear solves made.
    passed_limit
        t of the first limit point passed; None where none was.
    factor
        Of the tangent at the end, where the signs of its pivots are certain.
    legs
        From a point to the next, and whether the way is smooth; None where nobody has looked.
    """

    displacement: Array
    reached: float = 0.0
    solves: int = 0
    passed_limit: float | None = None
    factor: Regular | None = None
    legs: list[tuple[PathPoint, PathPoint, bool | None]] = field(default_factory=list)


def follow_path(path: LoadPath, solver: Solver) -> PathResult:
    """Follow a load path, halving each step that does not converge.

    `solver` inverts the tangents.

    Raises `SolverError` if the network is a mechanism where it stands.
    """
    found = PathResult(path.start)
    here, increment = PathPoint(0.0, path.start), 1.0
    for stop in path.stops:
        while here.t < stop:
            arrival = _newton_along(path, solver, here, min(stop, here.t + increment), found)
            if arrival is None:
                increment = min(increment, stop - here.t) / 2
                if increment < SMALLEST_INCREMENT:
                    return found
                continue
            found.legs.append((here, arrival.station, arrival.smooth))
            here, increment = arrival.station, 2 * increment
            found.displacement, found.reached = here.displacement, here.t
            end = arrival.factor
            found.factor = end if end is not None and is_certain(end.softness) else None
    found.passed_limit = _find_limit_point(path, solver, found)
    return found


def _newton_along(
    path: LoadPath,
    solver: Solver,
    start: PathPoint,
    t: float,
    result: PathResult,
    steps: int = ITERATIONS,
) -> Arrival | None:
    """The stable equilibrium at `t` that Newton's method finds from a station, if it finds one.

    `result` counts the solves.
    """
    network, u = path.network_at(t), start.displacement
    force, target = path.force(t), path.prescribed(t)
    first, calm = None, True
    for iteration in range(steps):
        ahead = np.where(network.fixed, target - u, 0.0)
        try:
            at = Configuration(network, u)
            balance = at.force() + force
            small = TOLERANCE * force_scale(at) + 4 * network.rounding(network.size + max_abs(u))
            K = tangent_at(at, solver)
        except SolverError:
            if iteration == 0:  # singular where we stand: smaller steps cannot help
                raise
            return None
        result.solves += 1
        # Judged with the tangent of the same place: the one before would miss a bifurcation.
        arrived = max_abs(ahead) <= _rounding(u)
        if arrived and (np.abs(balance) <= small)[~network.fixed].all():
            if not _is_stable(K):
                return None
            there = PathPoint(t, u)
            smooth = first is None or (calm and _is_smooth(path, start, there, first, K))
            return Arrival(there, smooth, K.factorised)
        try:
            move = K.move(balance, ahead)
        except SolverError:  # multigrid met what is not positive, where a factor would go on
            solver.is_indefinite = True
            return None
        if at.largest_rotation(move) > LARGEST_TURN:
            return None
        calm = calm and K.no_pivot_negative
        first = move if first is None else first
        u = u + move
    return None


def _is_stable(K: Tangent) -> bool:
    """Return True if the tangent is positive definite, as far as rounding permits."""
    try:
        return K.is_stable
    except NotConvergedError:  # multigrid cannot tell: a factor may
        raise
    except SolverError:
        return False


def _is_smooth(path: LoadPath, a: PathPoint, b: PathPoint, first: Array, K: Tangent) -> bool:
    """Return True if the path from a to b shows no sign of a jump.

    `first` is m_a, `K` the tangent at b.
    """
    network = path.network_at(b.t)
    i, j = network.springs.T

    def spring(move: Array) -> Array:
        return np.asarray(np.sqrt(((move[j] - move[i]) ** 2).sum(axis=1)))

    change = b.displacement - a.displacement
    force = path.force(a.t), path.force(b.t)
    load = force[1] - force[0]
    if path.present is not None:
        load = load + Configuration(network, b.displacement).force()
        load = load - Configuration(path.network_at(a.t), b.displacement).force()
    last = K.move(load, np.where(network.fixed, change, 0.0))
    size = spring(change)
    size = np.maximum(size, SMALL * size.max(initial=0.0) + _rounding(b.displacement) / MISSED)
    if (spring(change - (first + last) / 2) > BENT * size).any():
        return False
    middle = (a.displacement + b.displacement) / 2 + (first - last) / 8
    try:
        balance = Configuration(path.network_at((a.t + b.t) / 2), middle).force()
        balance += (force[0] + force[1]) / 2
    except SolverError:  # a spring without length
        return False
    return not (spring(K.move(balance, np.zeros(change.shape))) > MISSED * size).any()


def _find_limit_point(path: LoadPath, solver: Solver, result: PathResult) -> float | None:
    """T of the first limit point on the legs of a path; counts the solves it takes.

    Source: limit points as in [Crisfield1991].
    """
    legs = result.legs[::-1]
    while legs:
        a, b, smooth = legs.pop()
        if smooth is None:
            onward = _newton_along(path, solver, a, b.t, result, SEARCHING)
            smooth = onward is not None and _is_same_point(onward.station, b, a) and onward.smooth
        if smooth:
            continue
        if b.t - a.t <= RESOLVED:
            if _is_jump(path, solver, a, b, result):
                return b.t
            continue
        arrival = _point_between(path, solver, a, b.t, result)
        if arrival is None:  # b was leapt to
            return a.t
        legs.append((arrival.station, b, None))
        legs.append((a, arrival.station, arrival.smooth))
    return None


def _point_between(
    path: LoadPath, solver: Solver, a: PathPoint, end: float, result: PathResult
) -> Arrival | None:
    """An equilibrium halfway from a to an end, or nearer to a.

    The distance is halved until an equilibrium is found. None is returned if there is none down to
    half of `RESOLVED` from a.
    """
    t = end
    while True:
        t = (a.t + t) / 2
        arrival = _newton_along(path, solver, a, t, result, SEARCHING)
        if arrival is not None or t - a.t <= RESOLVED / 2:
            return arrival


def _is_jump(
    path: LoadPath, solver: Solver, a: PathPoint, b: PathPoint, result: PathResult
) -> bool:
    """Return True if b, followed back to a's load, does not reach a."""
    try:
        back = _newton_along(path, solver, b, a.t, result, SEARCHING)
    except SolverError:
        return True
    return back is None or not _is_same_point(back.station, a, b)


def _is_same_point(station: PathPoint, other: PathPoint, far: PathPoint) -> bool:
    """Return True if two states coincide, relative to their distance from a third."""
    apart = max_abs(station.displacement - other.displacement)
    way = max_abs(other.displacement - far.displacement)
    return apart <= SAME * way + _rounding(other.displacement)


def _rounding(u: Array) -> float:
    return float(4 * np.finfo(float).eps * max_abs(u))
