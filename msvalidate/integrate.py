"""Floor 2: motion of a network in time.

Euler-Cromer is the loop of the report's Algorithm 1: the velocity first, with the old velocity in
the viscous force, then the position with the new velocity.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from msvalidate import kernels
from msvalidate.network import Network, spring_force
from msvalidate.problem import (
    LONGEST,
    Array,
    ProblemError,
    SolverError,
    coordinates,
    finite,
    instance,
    number,
    positive,
    whole,
)


@dataclass(frozen=True, eq=False)
class State:
    """Position (n, d) in m and velocity (n, d) in m/s."""

    position: Array
    velocity: Array


def euler_cromer(
    network: Network,
    state: State,
    dt: float,
    steps: int,
    damping: ArrayLike = 0.0,
    *,
    compiled: bool = True,
) -> State:
    """State after `steps` Euler-Cromer steps of `dt` (s); held components do not move.

    Parameters
    ----------
    network, state
        Positions and velocities must have the shape of the network's points.
    dt
        Time step (s). Stable below `stability_limit`; this function does not check it.
    steps
        Number of steps, 0 or more.
    damping
        Rate (1/s), one number or (n,): the viscous force is -damping·m·v. A viscosity c in N·s/m
        is the rate c/m.
    compiled
        False runs the plain NumPy form, the oracle of the compiled one.

    Raises
    ------
    ProblemError
        If an argument is out of range.
    SolverError
        If the motion grows beyond all numbers.
    """
    instance("network", network, Network)
    instance("state", state, State)
    positive("time step dt", dt, "s")
    whole("steps", steps, 0)
    for name, value in (("position", state.position), ("velocity", state.velocity)):
        if (shape := coordinates(name, value).shape) != network.points.shape:
            raise ProblemError(f"{name}: shape {shape}; give {network.points.shape}")
    x = np.array(state.position, dtype=float)
    v = np.where(network.held, 0.0, state.velocity)
    rate = damping_rate(network, damping)
    with np.errstate(over="ignore", invalid="ignore"):  # refused by _finite_motion
        if compiled:
            u = x - network.points
            kernels.euler_cromer(network, u, v, rate, dt, steps)
            return _finite_motion(State(network.points + u, v), dt)
        for _ in range(steps):
            push = (spring_force(network, x) + network.force) / network.mass[:, None]
            v = np.where(network.held, 0.0, v + dt * (push - rate[:, None] * v))
            x = x + dt * v
            _finite_motion(State(x, v), dt)
    return State(x, v)


def _finite_motion(state: State, dt: float) -> State:
    """The state, refused where the motion has run away: its numbers would be NaN."""
    near = (np.abs(state.position) <= LONGEST).all()  # not so where it is NaN
    if not (near and np.isfinite(state.velocity).all()):
        raise SolverError(
            f"Euler-Cromer: the motion grew beyond all numbers with steps of {dt:.4g} s; take "
            "steps below stability_limit"
        )
    return state


def damping_rate(network: Network, damping: ArrayLike) -> Array:
    """Damping (n,) in 1/s from one number or one value a point.

    Raises
    ------
    ProblemError
        If a value is negative or not finite, or their number is not that of the points.
    """
    instance("network", network, Network)
    rate = finite("damping", damping)
    if rate.ndim and rate.shape != (len(network.points),):
        raise ProblemError(
            f"damping: shape {rate.shape}; give one number or {len(network.points)} values"
        )
    if (rate < 0).any():
        raise ProblemError(f"damping: {rate.min():g} 1/s; a negative rate feeds the motion")
    return np.full(len(network.points), rate) if not rate.ndim else np.array(rate)


def stability_limit(omega_max: float, damping: float = 0.0) -> float:
    """Largest stable time step (s) of Euler-Cromer with the viscous force from the old velocity.

    h = (2/ω)(√(1 + ζ²) - ζ), ζ = damping/(2ω): where an eigenvalue of the one-step matrix of
    x'' = -ω²x - damping·x' reaches -1. Larger ω and larger damping both lower it, so the highest
    frequency (rad/s) and the largest rate (1/s) bound a whole network.

    Raises
    ------
    ProblemError
        If an argument is not one finite number, or the frequency is not above zero.
    SolverError
        If the limit is beyond the largest number or below the smallest.
    """
    positive("highest frequency", omega_max, "rad/s")
    rate = number("damping", damping)
    if rate < 0:
        raise ProblemError(f"damping: {damping} 1/s; a negative rate feeds the motion")
    zeta = rate / (2 * omega_max)
    limit = 2 / (omega_max * (math.sqrt(1 + zeta * zeta) + zeta))  # the same, without cancellation
    if not 0 < limit < math.inf:
        raise SolverError(
            f"stability limit: {limit:g} s at {omega_max:g} rad/s with damping {rate:g} 1/s; "
            "choose a unit of time that gives ordinary numbers"
        )
    return limit
