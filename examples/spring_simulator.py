"""Springs on squares, an adapter that runs: `adapter check examples/spring_simulator.py`."""

import json
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np


def springs(cells, E, thickness):
    """Ends (m, 2) and constants (N/m); each square adds half of its sides."""
    sides = cells[:, [[0, 1], [1, 2], [2, 3], [3, 0]]].reshape(-1, 2)
    diagonals = cells[:, [[0, 2], [1, 3]]].reshape(-1, 2)
    k1, k2 = 3 / 4 * E * thickness, 3 / 8 * E * thickness  # plane stress, nu = 1/3
    return np.r_[sides, diagonals], np.repeat([k1 / 2, k2], [len(sides), len(diagonals)])


def simulate(request):
    """Semi-implicit Euler: the requested motion, or a damped one to equilibrium."""
    X, law, settings = request.mesh.points, request.material, request.settings
    ends, k = springs(request.mesh.cells, law.E, law.thickness)
    a, b = ends.T
    L0, m, damping = np.linalg.norm(X[b] - X[a], axis=1), request.mass[:, None], 0.0
    x, v, dt, steps = request.start, np.zeros_like(X), request.dt, request.steps
    if request.task == "rest":
        x, dt = X + request.held * request.value, 0.6 * np.sqrt(request.mass.min() / k.max())
        slow = np.sqrt(law.E / law.density) / np.ptp(X, axis=0).max()  # rad/s, roughly
        steps, damping = settings.get("steps", 900), settings.get("damping", 1.0) * slow
    for _ in range(steps):
        d = x[b] - x[a]
        L = np.linalg.norm(d, axis=1)
        pull = (k * (1 - L0 / L))[:, None] * d
        f = request.force + m * request.gravity
        np.add.at(f, a, pull)
        np.add.at(f, b, -pull)
        v = (v + dt * f / m) / (1 + dt * damping) * ~request.held
        x = x + dt * v
    about = {"simulator": "springs", "version": "1", "law": "central springs on squares"}
    about |= {"precision": "float64", "mass": "lumped", "forces_at": "start"}
    if request.task == "motion":
        return {"position": x, "velocity": v}, about
    about["settings"] = {"steps": [steps, ""], "damping": [settings.get("damping", 1.0), ""]}
    about["at_rest"] = {"largest_speed": float(abs(v).max())}
    return {"displacement": x - X}, about


if __name__ == "__main__":
    case, out = Path(sys.argv[1]), Path(sys.argv[2])

    def table(name):
        """Numbers of a CSV file without the id."""
        return np.loadtxt(case / name, delimiter=",", skiprows=1, ndmin=2)[:, 1:]

    request = SimpleNamespace(**json.loads((case / "request.json").read_text()))
    arrays, about = {}, {"cells": ["quad"]}  # the answer to the first question, "declare"
    if request.task != "declare":
        request.mesh = SimpleNamespace(points=table("points.csv"))
        request.mesh.cells = table("cells.csv").astype(int)
        if request.mesh.cells.shape[1] != 4:
            sys.stderr.write("springs on squares alone: take --shape quad\n")
            sys.exit(77)
        mass, force, held, value = np.split(table("nodal.csv"), [1, 3, 5], axis=1)
        start = table("start.csv") if request.task == "motion" else None
        vars(request).update(mass=mass[:, 0], force=force, held=held == 1, value=value, start=start)
        request.gravity = np.array(request.gravity)
        request.material = SimpleNamespace(**request.material)
        arrays, about = simulate(request)
    np.savez(out / "result.npz", **arrays)
    (out / "result.json").write_text(json.dumps(about))
