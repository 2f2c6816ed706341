"""Floor 1: the compiled loop: spring forces, and Euler-Cromer steps with virtual viscosity.

The only compiled code of the package. Its plain form is `msvalidate.network.spring_force` and the
plain loop of `msvalidate.integrate`; tests hold the two together on random networks. `axes` is a
tuple with one entry per axis: its length is a constant of the compiled form, so inner loops unroll.

Displacements are advanced, not positions: a spring is its vector at rest plus the difference of two
displacements. Positions are rounded to an eps of the body, and stiff modes that decay slowly gather
that rounding over 1/(damping·dt) steps; on long bodies of many points it would keep Algorithm 1
from coming to rest.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from msvalidate.network import Network
from msvalidate.problem import Array, Index


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile at the first call; keep the result on disk where there is a place for it."""
    try:
        return njit(error_model="numpy", cache=True)(function)
    except RuntimeError:  # neither the package's folder nor the user's home can be written
        return njit(error_model="numpy")(function)


def _force(
    axes: Any, u: Any, springs: Any, vector: Any, stiffness: Any, rest_length: Any, out: Any
) -> Any:
    out[:] = 0.0
    energy = 0.0
    now = np.empty(len(axes))
    for e in range(len(springs)):
        i, j = springs[e, 0], springs[e, 1]
        square = 0.0
        for a in range(len(axes)):
            now[a] = vector[e, a] + (u[j, a] - u[i, a])
            square += now[a] * now[a]
        length = np.sqrt(square)
        stretch = length - rest_length[e]
        tension = stiffness[e] * stretch
        energy += 0.5 * tension * stretch
        for a in range(len(axes)):
            pull = tension / length * now[a]
            out[i, a] += pull
            out[j, a] -= pull
    return energy


_force = _compiled(_force)


def _advance(
    axes: Any,
    u: Any,
    v: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    external: Any,
    mobility: Any,
    damping: Any,
    dt: Any,
    steps: Any,
    f: Any,
) -> None:
    for _ in range(steps):
        _force(axes, u, springs, vector, stiffness, rest_length, f)
        for i in range(len(u)):
            for a in range(len(axes)):
                push = mobility[i, a] * (f[i, a] + external[i, a])
                v[i, a] += dt * (push - damping[i] * v[i, a])
                u[i, a] += dt * v[i, a]


_advance = _compiled(_advance)


def force_and_energy(network: Network, displacement: Array, out: Array) -> float:
    """Write the springs' force (n, d) in N at a displacement into `out`; return their energy."""
    axes = tuple(range(network.dim))
    return float(_force(axes, displacement, *_laws(network), out))


def euler_cromer(
    network: Network, displacement: Array, velocity: Array, damping: Array, dt: float, steps: int
) -> None:
    """Advance displacement (m) and velocity (m/s), both (n, d), in place.

    v += dt·((F_spring + F_external)/m - damping·v), then u += dt·v; held components stay.
    `damping` is (n,) in 1/s.
    """
    axes = tuple(range(network.dim))
    mobility = np.where(network.held, 0.0, 1.0 / network.mass[:, None])
    velocity[network.held] = 0.0
    laws, work = _laws(network), np.empty_like(displacement)
    _advance(axes, displacement, velocity, *laws, network.force, mobility, damping, dt, steps, work)


def _laws(network: Network) -> tuple[Index, Array, Array, Array]:
    return network.springs, network.vector, network.stiffness, network.rest_length
