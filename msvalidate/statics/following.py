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

from dataclasses import dataclass, field

import numpy as np

from msvalidate.linear_algebra.norms import largest
from msvalidate.network import Network, internal_force
from msvalidate.network.residual import force_roundoff, force_scale
from msvalidate.problem import Array, SolverError
from msvalidate.statics.path import Way
from msvalidate.statics.tangents import (
    LARGEST_TURN,
    Tangent,
    beyond_doubt,
    is_positive_at,
    largest_turn,
    tangent_at,
)
from msvalidate.tangent.cycles import UnsettledError
from msvalidate.tangent.inverse import Regular, Solver

TOLERANCE = 1e-11
"""Newton stops at this residual, relative to the forces that meet at a point (and not below their
rounding). Convergence is quadratic, so what is reached is usually rounding."""
ITERATIONS = 25
"""Newton steps a load increment may take: far more than quadratic convergence needs."""
SMALLEST_INCREMENT = 2.0**-12
RESOLVED = 2.0**-10
"""Part of a path to which a limit point is placed."""
BENT, MISSED = 0.15, 0.05
"""Differences from the trapezoidal rule and from the cubic's middle, over the change of the same
spring on the way, above which a way is looked at more closely. A shallow arch that has snapped
through is beyond one or the other at any load: by 92 and 4 % just past its limit, by 0 and 8 % at
31.8 times it, where its two rates happen to fit. A cantilever is so from a sixth of its length."""
SEARCHING = 12
"""Newton steps that a solve in search of a limit point may take: it starts close by."""
SMALL = 0.02
"""Change of a spring, over the largest of all, below which it says nothing of the way."""
SAME = 0.1
"""Part of the gap within which a way back has returned."""


@dataclass(frozen=True, eq=False)
class Station:
    """An equilibrium on the way: its place t, and position (n, d) in m."""

    t: float
    position: Array


@dataclass(frozen=True, eq=False)
class Arrival:
    """What Newton's method found, from one station to the next.

    Parameters
    ----------
    station
        The next; None where there is no stable one near.
    solves
        Linear solves made.
    smooth
        Whether the way there shows no sign of a jump.
    factor
        Of the tangent there.
    """

    station: Station | None
    solves: int
    smooth: bool = True
    factor: Regular | None = None


@dataclass(eq=False)
class Followed:
    """The end of a way, as far as it was found.

    Parameters
    ----------
    position
        (n, d) in m.
    reached
        t of it: below 1 where no stable equilibrium lies beyond.
    solves
        Linear solves made.
    passed_limit
        t of the first limit point passed; None where none was.
    factor
        Of the tangent at the end, where the signs of its pivots are beyond doubt.
    """

    position: Array
    reached: float = 0.0
    solves: int = 0
    passed_limit: float | None = None
    factor: Regular | None = None
    legs: list[tuple[Station, Station, bool | None]] = field(default_factory=list)


def follow(way: Way, solver: Solver) -> Followed:
    """Raise what is applied along a way, in halves of what would not converge.

    `solver` inverts the tangents.

    Raises
    ------
    SolverError
        If the network is a mechanism where it stands.
    """
    found = Followed(way.start)
    here, increment = Station(0.0, way.start), 1.0
    for stop in way.stops:
        while here.t < stop:
            arrival = newton(way, solver, here, min(stop, here.t + increment))
            found.solves += arrival.solves
            if arrival.station is None:
                increment = min(increment, stop - here.t) / 2
                if increment < SMALLEST_INCREMENT:
                    return found
                continue
            found.legs.append((here, arrival.station, arrival.smooth))
            here, increment = arrival.station, 2 * increment
            found.position, found.reached = here.position, here.t
            end = arrival.factor
            found.factor = end if end is not None and beyond_doubt(end) else None
    found.passed_limit = _limit(way, solver, found)
    return found


def newton(way: Way, solver: Solver, start: Station, t: float, steps: int = ITERATIONS) -> Arrival:
    """The stable equilibrium at `t` that Newton's method finds from a station, if it finds one."""
    network, x = way.network_at(t), start.position
    force, target = way.force(t), network.points + way.moved(t)
    rounding = 4 * force_roundoff(network)
    first, calm = None, True
    for iteration in range(steps):
        ahead = np.where(network.held, target - x, 0.0)
        try:
            balance = internal_force(network, x) + force
            small = TOLERANCE * force_scale(network, x) + rounding
            K = tangent_at(network, x, solver)
        except SolverError:
            if iteration == 0:  # singular where we stand: smaller steps cannot help
                raise
            return Arrival(None, iteration)
        # Judged with the tangent of the same place: the one before would miss a bifurcation.
        arrived = largest(ahead) <= _rounding(x)
        if arrived and (np.abs(balance) <= small)[~network.held].all():
            if not _is_stable(network, x, K):
                return Arrival(None, iteration + 1)
            there = Station(t, x)
            smooth = first is None or (calm and _is_smooth(way, start, there, first, K))
            return Arrival(there, iteration + 1, smooth, K.found)
        try:
            move = K.move(balance, ahead)
        except SolverError:  # multigrid met what is not positive, where a factor would go on
            solver.met_negative = True
            return Arrival(None, iteration + 1)
        if largest_turn(network, x, move) > LARGEST_TURN:
            return Arrival(None, iteration + 1)
        calm = calm and K.calm
        first = move if first is None else first
        x = x + move
    return Arrival(None, steps)


def _is_stable(network: Network, x: Array, K: Tangent) -> bool:
    """Whether every free motion meets stiffness, as far as can be told."""
    try:
        return K.found is None or is_positive_at(network, x - network.points, K.found)
    except UnsettledError:  # multigrid cannot tell: a factor may
        raise
    except SolverError:
        return False


def _is_smooth(way: Way, a: Station, b: Station, first: Array, K: Tangent) -> bool:
    """Whether the way from a to b has no sign of a jump; `first` is m_a, `K` the tangent at b."""
    network = way.network_at(b.t)
    i, j = network.springs.T

    def spring(move: Array) -> Array:
        return np.asarray(np.sqrt(((move[j] - move[i]) ** 2).sum(axis=1)))

    change = b.position - a.position
    force = way.force(a.t), way.force(b.t)
    load = force[1] - force[0]
    if way.present is not None:
        load = load + internal_force(network, b.position)
        load = load - internal_force(way.network_at(a.t), b.position)
    last = K.move(load, np.where(network.held, change, 0.0))
    size = spring(change)
    size = np.maximum(size, SMALL * size.max(initial=0.0) + _rounding(b.position) / MISSED)
    if (spring(change - (first + last) / 2) > BENT * size).any():
        return False
    middle = (a.position + b.position) / 2 + (first - last) / 8
    try:
        balance = internal_force(way.network_at((a.t + b.t) / 2), middle)
        balance += (force[0] + force[1]) / 2
    except SolverError:  # a spring without length
        return False
    return not (spring(K.move(balance, np.zeros(change.shape))) > MISSED * size).any()


def _limit(way: Way, solver: Solver, found: Followed) -> float | None:
    """T of the first limit point on the legs of a way; counts the solves it takes."""
    legs = found.legs[::-1]
    while legs:
        a, b, smooth = legs.pop()
        if smooth is None:
            onward = newton(way, solver, a, b.t, SEARCHING)
            found.solves += onward.solves
            same = onward.station is not None and _is_near(onward.station, b, a)
            smooth = same and onward.smooth
        if smooth:
            continue
        if b.t - a.t <= RESOLVED:
            if _is_gap(way, solver, a, b, found):
                return b.t
            continue
        arrival = _within(way, solver, a, b.t, found)
        if arrival.station is None:  # b was leapt to
            return a.t
        legs.append((arrival.station, b, None))
        legs.append((a, arrival.station, arrival.smooth))
    return None


def _within(way: Way, solver: Solver, a: Station, end: float, found: Followed) -> Arrival:
    """An equilibrium halfway from a to an end, or nearer to a where none is found there."""
    t = end
    while True:
        t = (a.t + t) / 2
        arrival = newton(way, solver, a, t, SEARCHING)
        found.solves += arrival.solves
        if arrival.station is not None or t - a.t <= RESOLVED / 2:
            return arrival


def _is_gap(way: Way, solver: Solver, a: Station, b: Station, found: Followed) -> bool:
    """Whether b, led back to the load of a, is not a."""
    try:
        back = newton(way, solver, b, a.t, SEARCHING)
    except SolverError:
        return True
    found.solves += back.solves
    return back.station is None or not _is_near(back.station, a, b)


def _is_near(station: Station, other: Station, far: Station) -> bool:
    """Whether two stations are one, beside how far they are from a third."""
    apart = largest(station.position - other.position)
    return apart <= SAME * largest(other.position - far.position) + _rounding(other.position)


def _rounding(x: Array) -> float:
    return float(4 * np.finfo(float).eps * np.abs(x).max())


def is_stressed(network: Network) -> bool:
    """Whether some spring is off its rest length at the reference points, by more than rounding."""
    length = np.linalg.norm(network.vector, axis=1)
    return bool((np.abs(network.rest_length / length - 1) > 1e-12).any())
