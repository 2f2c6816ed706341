"""Springs on squares, an adapter that runs: `adapter check examples/spring_simulator.py`."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np

CELLS = ("quad",)


def springs(cells, E, thickness):
    """Ends (m, 2) and constants (N/m): each square brings half of its sides, and its diagonals."""
    sides = cells[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2)
    diagonals = cells[:, [[0, 2], [1, 3]]].reshape(-1, 2)
    k1, k2 = 3 / 4 * E * thickness, 3 / 8 * E * thickness  # plane stress, nu = 1/3
    return np.r_[sides, diagonals], np.repeat([k1 / 2, k2], [len(sides), len(diagonals)])


def simulate(task, X, cells, mass, force, fixed, value, start, material, gravity, dt, steps, own):
    """Semi-implicit Euler: the requested motion, or a damped one to equilibrium."""
    ends, k = springs(cells, material.E, material.thickness)
    a, b = ends.T
    L0, m, damping = np.linalg.norm(X[b] - X[a], axis=1), mass[:, None], 0.0
    x, v = start, np.zeros_like(X)
    if task == "rest":
        x, dt, steps = X + fixed * value, 0.6 * np.sqrt(mass.min() / k.max()), own.get("steps", 900)
        slow = np.sqrt(material.E / material.density) / np.ptp(X, axis=0).max()  # rad/s, roughly
        damping = own.get("damping", 1.0) * slow
    for _ in range(steps):
        d = x[b] - x[a]
        L = np.linalg.norm(d, axis=1)
        pull = (k * (1 - L0 / L))[:, None] * d
        f = force + m * gravity
        np.add.at(f, a, pull)
        np.add.at(f, b, -pull)
        v = (v + dt * f / m) / (1 + dt * damping) * ~fixed
        x = x + dt * v
    about = {"simulator": "springs", "version": "1", "law": "central springs on squares"}
    about |= {"precision": "float64", "mass": "lumped", "forces_at": "start"}
    if task == "motion":
        return {"position": x, "velocity": v}, about
    about["settings"] = {"steps": [steps, ""], "damping": [own.get("damping", 1.0), "slowest"]}
    about["at_rest"] = {"largest_speed": float(abs(v).max())}
    return {"displacement": x - X}, about


if __name__ == "__main__":
    CASE, OUT = Path(sys.argv[1]), Path(sys.argv[2])
    asked = json.loads((CASE / "request.json").read_text())
    if asked["task"] == "declare":
        sys.exit((OUT / "result.json").write_text(json.dumps({"cells": CELLS})) and 0)

    def table(name):
        """Numbers of a CSV file without the id."""
        return np.loadtxt(CASE / name, delimiter=",", skiprows=1, ndmin=2)[:, 1:]

    mass, force, fixed, value = np.split(table("nodal.csv"), [1, 3, 5], axis=1)
    start = table("start.csv") if asked["task"] == "motion" else None
    arrays, about = simulate(
        asked["task"], table("points.csv"), table("cells.csv").astype(int), mass[:, 0], force,
        fixed == 1, value, start, SimpleNamespace(**asked["material"]),
        np.array(asked["gravity"]), asked["dt"], asked["steps"], asked["settings"],
    )  # fmt: skip
    np.savez(OUT / "result.npz", **arrays)
    (OUT / "result.json").write_text(json.dumps(about))
