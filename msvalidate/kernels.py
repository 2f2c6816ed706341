"""Floor 1: the compiled loops: forces of springs and cells, and steps of what moves by them.

The only compiled code of the package. Its plain form is `msvalidate.network.internal_force` and the
plain loop of `msvalidate.integrate`; tests hold the two together on random networks. `axes` is a
tuple with one entry per axis: its length is a constant of the compiled form, so inner loops unroll.
Cells have three axes always, in the plane the normal as one more corner: see `msvalidate.volumes`.

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
from msvalidate.problem import Array, ProblemError


def _compiled(function: Callable[..., Any]) -> Callable[..., Any]:
    """Compile at the first call; keep the result on disk where there is a place for it."""
    try:
        return njit(error_model="numpy", cache=True)(function)
    except RuntimeError:  # neither the package's folder nor the user's home can be written
        return njit(error_model="numpy")(function)


def _gather(axes: Any, values: Any, cell: Any, local: Any) -> Any:
    for c in range(len(cell)):
        for a in range(len(axes)):
            local[c, a] = values[cell[c], a] - values[cell[0], a]


_gather = _compiled(_gather)


def _volume_change(triangles: Any, X: Any, u: Any, x: Any, g: Any) -> Any:
    """V - V0 and, in `g`, ∂V/∂x, in sixths or so: a cell at rest X, moved by u to x."""
    g[:] = 0.0
    change = 0.0
    for t in range(len(triangles)):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            across = x[q, b] * x[r, c] - x[q, c] * x[r, b]
            g[p, a] += across
            g[q, a] += x[r, b] * x[p, c] - x[r, c] * x[p, b]
            g[r, a] += x[p, b] * x[q, c] - x[p, c] * x[q, b]
            change += u[p, a] * across
            change += X[p, a] * (u[q, b] * x[r, c] - u[q, c] * x[r, b])
            change += X[p, a] * (X[q, b] * u[r, c] - X[q, c] * u[r, b])
    return change


_volume_change = _compiled(_volume_change)


def _volume_bend(triangles: Any, x: Any, w: Any) -> Any:
    """Second derivative of V along w, in sixths or so."""
    bend = 0.0
    for t in range(len(triangles)):
        p, q, r = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        for a in range(3):
            b, c = (a + 1) % 3, (a + 2) % 3
            bend += x[p, a] * (w[q, b] * w[r, c] - w[q, c] * w[r, b])
            bend += x[q, a] * (w[r, b] * w[p, c] - w[r, c] * w[p, b])
            bend += x[r, a] * (w[p, b] * w[q, c] - w[p, c] * w[q, b])
    return 2 * bend


_volume_bend = _compiled(_volume_bend)


def _volume_force(axes: Any, displacement: Any, volumes: Any, out: Any) -> Any:
    points, cells, triangles, part, kappa, rest = volumes
    X, u, x, g = np.zeros((4, cells.shape[1] + 1, 3))
    X[-1, 2] = x[-1, 2] = 1.0  # in the plane, the normal
    energy = 0.0
    for e in range(len(cells)):
        cell = cells[e]
        _gather(axes, points, cell, X)
        _gather(axes, displacement, cell, u)
        for c in range(len(cell)):
            for a in range(len(axes)):
                x[c, a] = X[c, a] + u[c, a]
        j = part * _volume_change(triangles, X, u, x, g) / rest[e]
        energy += 0.5 * kappa[e] * rest[e] * j * j
        pressure = part * kappa[e] * j
        for c in range(len(cell)):
            for a in range(len(axes)):
                out[cell[c], a] -= pressure * g[c, a]
    return energy


_volume_force = _compiled(_volume_force)


def _volume_curvature(axes: Any, displacement: Any, way: Any, volumes: Any) -> Any:
    points, cells, triangles, part, kappa, rest = volumes
    X, u, x, g, w = np.zeros((5, cells.shape[1] + 1, 3))
    X[-1, 2] = x[-1, 2] = 1.0
    total = 0.0
    for e in range(len(cells)):
        cell = cells[e]
        _gather(axes, points, cell, X)
        _gather(axes, displacement, cell, u)
        _gather(axes, way, cell, w)
        for c in range(len(cell)):
            for a in range(len(axes)):
                x[c, a] = X[c, a] + u[c, a]
        j = part * _volume_change(triangles, X, u, x, g) / rest[e]
        change = 0.0
        for c in range(len(cell)):
            for a in range(len(axes)):
                change += part * g[c, a] * w[c, a]
        total += kappa[e] * (change * change / rest[e] + part * j * _volume_bend(triangles, x, w))
    return total


_volume_curvature = _compiled(_volume_curvature)


def _force(
    axes: Any,
    u: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    volumes: Any,
    out: Any,
) -> Any:
    out[:] = 0.0
    energy = 0.0
    if len(volumes[1]):
        energy = _volume_force(axes, u, volumes, out)
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
    axes: Any,
    u: Any,
    way: Any,
    springs: Any,
    vector: Any,
    stiffness: Any,
    rest_length: Any,
    volumes: Any,
) -> Any:
    total = 0.0
    if len(volumes[1]):
        total = _volume_curvature(axes, u, way, volumes)
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
    for step in range(steps):
        _force(axes, u, springs, vector, stiffness, rest_length, volumes, f)
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
    """Write the force (n, d) in N at a displacement into `out`; return the energy (J) stored."""
    axes = tuple(range(network.dim))
    return float(_force(axes, displacement, *_laws(network), out))


def curvature(network: Network, displacement: Array, way: Array) -> float:
    """Second derivative (N·m) of the stored energy along `way` (n, d) in m: wayᵀ K way."""
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

    v = keep·v + push·(F_internal + F_external)/m, then u += dt·v, with `keep` (n,) and `push` (n,)
    in s: every scheme with one velocity a step and viscosity. Returns the steps done, the kinetic
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


def _laws(network: Network) -> tuple[Any, Any, Any, Any, Any]:
    """Springs, and cells as one tuple; where there are none, of the same types and empty."""
    if network.shear is not None:
        raise ProblemError(
            "network: its shear springs have no compiled form, which relaxations and long motions "
            "take; ask for equilibrium, or take a volume energy"
        )
    springs = network.springs, network.vector, network.stiffness, network.rest_length
    cells = network.volumes
    if cells is None:
        none = np.zeros(0)
        empty = np.zeros((0, 3), dtype=np.intp)
        return *springs, (network.points, empty, empty, 1.0, none, none)
    triangles, part = cells.surface
    laws = network.points, cells.cells, triangles, part, cells.stiffness, cells.rest_volume
    return *springs, laws
