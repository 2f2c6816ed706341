"""Springs on squares in 2D: `msvalidate adapter check examples/spring_simulator.py` tests them."""

import json
import sys
from pathlib import Path

import numpy as np

CELLS = ("quad",)  # of quad, triangle, hexahedron, tetra, or points


def springs(X, cells, E, t):
    """Ends and stiffness (N/m): each square brings half of its sides, and its diagonals."""
    sides = cells[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2)
    diagonals = cells[:, [[0, 2], [1, 3]]].reshape(-1, 2)
    k1, k2 = 3 / 4 * E * t, 3 / 8 * E * t  # plane stress of ratio 1/3
    k = np.r_[np.full(len(sides), k1 / 2), np.full(len(diagonals), k2)]
    return np.r_[sides, diagonals], k


def simulate(case, X, cells, mass, force, held, value, start):
    """Semi-implicit Euler: a motion as it is requested, or a damped one until nothing moves."""
    material, settings, g = case["material"], case["settings"], np.array(case["gravity"])
    (a, b), k = (y := springs(X, cells, material["E"], material["thickness"]))[0].T, y[1]
    L0, m = np.linalg.norm(X[b] - X[a], axis=1), mass[:, None]
    rest = case["task"] == "rest"
    dt = case["dt"] or 0.6 * np.sqrt(mass.min() / k.max())
    slow = np.sqrt(material["E"] / material["density"]) / np.ptp(X, axis=0).max()  # rad/s, about
    steps = settings.get("steps", 900) if rest else case["steps"]
    damping = settings.get("damping", 1.0)  # relative to the slowest motion
    free, loss = ~held, damping * slow if rest else 0.0
    x, v = np.where(held, X + value, X) if rest else start, np.zeros_like(X)
    for _ in range(steps):
        d = x[b] - x[a]
        L = np.linalg.norm(d, axis=1)
        pull = (k * (L - L0) / L)[:, None] * d
        f = force + m * g
        np.add.at(f, a, pull)
        np.subtract.at(f, b, pull)
        v = (v + dt * f / m) / (1 + dt * loss) * free
        x = x + dt * v
    about = {"steps": steps, "settings": {"steps": [steps, ""], "damping": [damping, ""]}}
    if not rest:
        return {"position": x, "velocity": v}, about
    return {"displacement": x - X}, about | {"at_rest": {"largest_speed": float(abs(v).max())}}


if __name__ == "__main__":
    CASE, OUT = Path(sys.argv[1]), Path(sys.argv[2])
    case = json.loads((CASE / "request.json").read_text())
    about = {"simulator": "springs", "version": "1", "law": "central springs on squares"}
    about |= {"precision": "float64", "mass": "lumped", "forces_at": "start"}
    if case["task"] == "declare":
        about |= {"cells": CELLS}
    else:
        (X, cells, nodal), d = (
            np.loadtxt(CASE / f"{name}.csv", delimiter=",", skiprows=1, ndmin=2)[:, 1:]
            for name in ("points", "cells", "nodal")
        ), case["dimension"]
        moved = CASE / "start.csv"
        start = np.loadtxt(moved, delimiter=",", skiprows=1)[:, 1:] if moved.exists() else X
        force, held, value = (nodal[:, i : i + d] for i in (1, 1 + d, 1 + 2 * d))
        arrays, more = simulate(case, X, cells.astype(int), nodal[:, 0], force, held == 1, value, start)
        np.savez(OUT / "result.npz", **arrays)
        about |= more
    (OUT / "result.json").write_text(json.dumps(about))
