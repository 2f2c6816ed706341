"""Floor 1: the compiled loop: spring forces, and Euler-Cromer steps with virtual viscosity.

The only compiled code of the package. Its plain form is `msvalidate.network.spring_force` and the
plain loop of `msvalidate.integrate`; tests hold the two together on random networks. The number of
axes is a constant of each compiled form, so that the inner loops unroll.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numba import njit

from msvalidate.network import Network
from msvalidate.problem import Array


def _compile(d: int) -> tuple[Callable[..., Any], Callable[..., Any]]:
    """Compiled force and step loops for d axes; compilation happens at the first call."""

    def force(x, springs, stiffness, rest_length, out):  # type: ignore[no-untyped-def]
        out[:] = 0.0
        energy = 0.0
        vector = np.empty(d)
        for e in range(len(springs)):
            i, j = springs[e, 0], springs[e, 1]
            square = 0.0
            for a in range(d):
                vector[a] = x[j, a] - x[i, a]
                square += vector[a] * vector[a]
            length = np.sqrt(square)
            stretch = length - rest_length[e]
            tension = stiffness[e] * stretch
            energy += 0.5 * tension * stretch
            for a in range(d):
                pull = tension / length * vector[a]
                out[i, a] += pull
                out[j, a] -= pull
        return energy

    compiled_force = njit(error_model="numpy", cache=True)(force)

    def advance(  # type: ignore[no-untyped-def]
        x, v, springs, stiffness, rest_length, external, mobility, damping, dt, steps, f
    ):
        for _ in range(steps):
            compiled_force(x, springs, stiffness, rest_length, f)
            for i in range(len(x)):
                for a in range(d):
                    push = mobility[i, a] * (f[i, a] + external[i, a])
                    v[i, a] += dt * (push - damping[i] * v[i, a])
                    x[i, a] += dt * v[i, a]

    return compiled_force, njit(error_model="numpy", cache=True)(advance)


_COMPILED = {d: _compile(d) for d in (2, 3)}


def force_and_energy(network: Network, position: Array, out: Array) -> float:
    """Write the springs' force (n, d) in N at `position` into `out`; return their energy (J)."""
    force, _ = _COMPILED[network.dim]
    springs, k, rest = network.springs, network.stiffness, network.rest_length
    return float(force(position, springs, k, rest, out))


def euler_cromer(
    network: Network, position: Array, velocity: Array, damping: Array, dt: float, steps: int
) -> None:
    """Advance position (m) and velocity (m/s), both (n, d), in place.

    v += dt·((F_spring + F_external)/m - damping·v), then x += dt·v; held components stay.
    `damping` is (n,) in 1/s.
    """
    _, advance = _COMPILED[network.dim]
    mobility = np.where(network.held, 0.0, 1.0 / network.mass[:, None])
    laws = network.springs, network.stiffness, network.rest_length
    work = np.empty_like(position)
    advance(position, velocity, *laws, network.force, mobility, damping, dt, steps, work)
