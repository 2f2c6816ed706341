"""Compiled forces of springs, and steps of what moves by them; plain form: `msvalidate.network`."""

from __future__ import annotations

from typing import Any

import numpy as np

from msvalidate.kernels.cells import volume_curvature, volume_force
from msvalidate.kernels.compiling import compiled


def force_and_energy(
    axes: Any,
    u: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    volumes: Any,
    out: Any,
) -> Any:
    """Write the force into `out`; return the energy."""
    out[:] = 0.0
    energy = 0.0
    if len(volumes[1]):
        energy = volume_force(axes, u, volumes, out)
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


force_and_energy = compiled(force_and_energy)


def curvature(
    axes: Any,
    u: Any,
    way: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    volumes: Any,
) -> Any:
    """Second derivative of the energy along `way`."""
    total = 0.0
    if len(volumes[1]):
        total = volume_curvature(axes, u, way, volumes)
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


curvature = compiled(curvature)


def advance(
    axes: Any,
    u: Any,
    v: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    volumes: Any,
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
    """Steps done, kinetic energy of the last, and whether it ended there because that fell."""
    for step in range(steps):
        force_and_energy(axes, u, springs, vector, stiffness, rest_length, volumes, f)
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


advance = compiled(advance)
