"""Compiled forces of cells that resist a change of volume; plain form: `msvalidate.volumes`.

Cells have three axes always, in the plane the normal as one more corner.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from msvalidate.kernels.compiling import compiled


def _gather(axes: Any, values: Any, cell: Any, local: Any) -> Any:
    for c in range(len(cell)):
        for a in range(len(axes)):
            local[c, a] = values[cell[c], a] - values[cell[0], a]


_gather = compiled(_gather)


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


_volume_change = compiled(_volume_change)


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


_volume_bend = compiled(_volume_bend)


def volume_force(axes: Any, displacement: Any, volumes: Any, out: Any) -> Any:
    """Add the force of all cells to `out`; return their energy."""
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


volume_force = compiled(volume_force)


def volume_curvature(axes: Any, displacement: Any, way: Any, volumes: Any) -> Any:
    """Second derivative of the energy of all cells along `way`."""
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


volume_curvature = compiled(volume_curvature)
