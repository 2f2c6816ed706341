"""Floor 1: the compiled loops: spring forces, and steps of a network that moves by them.

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


def _curvature(
    axes: Any, u: Any, way: Any, springs: Any, vector: Any, stiffness: Any, rest_length: Any
) -> Any:
    total = 0.0
    for e in range(len(springs)):
        i, j = springs[e, 0], springs[e, 1]
        square = apart = along = 0.0
        for a in range(len(axes)):
            now = vector[e, a] + (u[j, a] - u[i, a])
            change = way[j, a] - way[i, a]
            square += now * now
            apart += change * change
            along += now * change
        stretched = along * along / square
        slack = 1 - rest_length[e] / np.sqrt(square)
        total += stiffness[e] * (stretched + slack * (apart - stretched))
    return total


_curvature = _compiled(_curvature)


def _advance(
    axes: Any,
    u: Any,
    v: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    external: Any,
    mass: Any,
    keep: Any,
    kick: Any,
    dt: Any,
    steps: Any,
    kinetic: Any,
    to_peak: Any,
    f: Any,
) -> Any:
    for step in range(steps):
        _force(axes, u, springs, vector, stiffness, rest_length, f)
        twice = 0.0
        for i in range(len(u)):
            square = 0.0
            for a in range(len(axes)):
                v[i, a] = keep[i] * v[i, a] + kick[i, a] * (f[i, a] + external[i, a])
                u[i, a] += dt * v[i, a]
                square += v[i, a] * v[i, a]
            twice += mass[i] * square
        if to_peak and 0.5 * twice < kinetic:
            return step + 1, 0.5 * twice, True
        kinetic = 0.5 * twice
    return steps, kinetic, False


_advance = _compiled(_advance)


def force_and_energy(network: Network, displacement: Array, out: Array) -> float:
    """Write the springs' force (n, d) in N at a displacement into `out`; return their energy."""
    axes = tuple(range(network.dim))
    return float(_force(axes, displacement, *_laws(network), out))


def curvature(network: Network, displacement: Array, way: Array) -> float:
    """Second derivative (N·m) of the springs' energy along `way` (n, d) in m: wayᵀ K way."""
    axes = tuple(range(network.dim))
    return float(_curvature(axes, displacement, way, *_laws(network)))


def advance(
    network: Network,
    displacement: Array,
    velocity: Array,
    keep: Array,
    push: Array,
    dt: float,
    steps: int,
    *,
    kinetic: float = 0.0,
    to_peak: bool = False,
) -> tuple[int, float, bool]:
    """Advance displacement (m) and velocity (m/s), both (n, d), in place; held components stay.

    v = keep·v + push·(F_spring + F_external)/m, then u += dt·v, with `keep` (n,) and `push` (n,) in
    s: every scheme with one velocity a step and viscosity. Returns the steps done, the kinetic
    energy (J) of the last, and whether it ended there because that fell: `to_peak` stops after the
    first such step, counted from `kinetic`.
    """
    axes = tuple(range(network.dim))
    with np.errstate(over="ignore"):  # the motion that it gives is refused
        kick = np.where(network.held, 0.0, (push / network.mass)[:, None])
    velocity[network.held] = 0.0
    done, energy, fell = _advance(
        axes,
        displacement,
        velocity,
        *_laws(network),
        network.force,
        network.mass,
        keep,
        kick,
        dt,
        steps,
        kinetic,
        to_peak,
        np.empty_like(displacement),
    )
    return int(done), float(energy), bool(fell)


def _laws(network: Network) -> tuple[Index, Array, Array, Array]:
    return network.springs, network.vector, network.stiffness, network.rest_length
