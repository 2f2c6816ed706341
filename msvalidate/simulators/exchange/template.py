"""The commented adapter that `adapter new` writes: it runs as it is, on a toy solver."""

from __future__ import annotations

TEMPLATE = '''\
"""Adapter NAME: run as `python NAME.py CASE_DIR OUT_DIR`. Replace what is marked HERE by yours.

As it is, linear elasticity by conjugate gradients; `msvalidate adapter check NAME.py` judges it.
"""
import json, sys, time  # noqa: E401
from pathlib import Path

import numpy as np

CASE, OUT = Path(sys.argv[1]), Path(sys.argv[2])


def cannot(reason):
    """Exit code 77 and a last line on stderr: not a failure, but nothing that it can represent."""
    sys.exit(print(reason, file=sys.stderr) or 77)


def table(name):
    """Numbers of a CSV file, a row a node, without the id."""
    return np.loadtxt(CASE / name, delimiter=",", skiprows=1, ndmin=2)[:, 1:]


# 1. What is asked, in SI units: m, kg, s, N, Pa. Leave it; what is not for you, do not use.
request = json.loads((CASE / "request.json").read_text())
d, material = request["dimension"], request["material"]
X, cells, nodal = table("points.csv"), table("cells.csv").astype(int), table("nodal.csv")
mass = nodal[:, 0]  # lumped; use it where your program lets you set masses
force = nodal[:, 1 : 1 + d] + mass[:, None] * request["gravity"]
held, value = nodal[:, 1 + d : 1 + 2 * d] == 1, nodal[:, 1 + 2 * d :]
settings = request["settings"]  # from --set NAME=VALUE: law, iterations, dt ... as you like

# 2. HERE: your program in place of this part: rest, motion or both. Say what it cannot represent.
if request["cells"] not in ("triangle", "tetra"):
    cannot(f"cells {request['cells']}; triangles and tetrahedra only")
if request["task"] == "motion" and request["steps"] > 1:
    cannot("a motion: it is static, and tells the forces at the start of one step alone")
E, nu, thickness = material["E"], material["nu"], material["thickness"]
if nu == 0.5:
    cannot("ratio 1/2: its stiffness is infinite")
mu, lam = E / (2 + 2 * nu), E * nu / ((1 + nu) * (1 - 2 * nu))
if material["state"] == "plane_stress":
    lam = E * nu / (1 - nu**2)
edges = np.swapaxes(X[cells[:, 1:]] - X[cells[:, :1]], 1, 2)
slope = np.linalg.inv(edges)  # of the shape functions of corners 1 to d; corner 0 has the rest
slope = np.concatenate([-slope.sum(axis=1, keepdims=True), slope], axis=1)
volume = np.linalg.det(edges) / (2 if d == 2 else 6) * thickness


def inner(u):
    """Forces (n, d) in N that hold the body at displacements u (n, d)."""
    H = np.einsum("cka,ckb->cab", u[cells], slope)
    stress = mu * (H + np.swapaxes(H, 1, 2)) + lam * np.trace(H, 0, 1, 2)[:, None, None] * np.eye(d)
    out = np.zeros_like(X)
    np.add.at(out, cells, np.einsum("cab,ckb,c->cka", stress, slope, volume))
    return out


began, answer, steps, rest = time.perf_counter(), {}, 0, {}
if request["task"] == "motion":
    # HERE, motion: from start.csv, at no velocity, `steps` steps of `dt` under `gravity` alone: no
    # supports, forces, damping, contact. "position" and "velocity" (n, d), or of a static program
    answer["force"] = -inner(table("start.csv") - X)
else:
    # HERE, rest: under `force`, with `value` where `held`, until nothing moves; `rest` says so.
    u = np.where(held, value, 0.0)
    r = np.where(held, 0.0, force - inner(u))
    p, first = r, np.abs(r).max()
    while np.abs(r).max() > 1e-12 * first and steps < settings.get("iterations", 10000):
        Kp = np.where(held, 0.0, inner(p))
        a, before = (r * r).sum() / (p * Kp).sum(), (r * r).sum()
        u, r, steps = u + a * p, r - a * Kp, steps + 1
        p = r + (r * r).sum() / before * p
    left = float(np.abs(np.where(held, 0.0, force - inner(u))).max())
    answer["displacement"], rest = u, {"residual": left}

# 3. The answer: arrays in the order of points.csv, and HERE what is true of your program.
np.savez(OUT / "result.npz", **answer)
about = {
    "simulator": "NAME",
    "version": "0",
    "law": "linear elasticity, toy solver of the template",
    "precision": "float64",  # or "float32"
    "settings": {"iterations": [settings.get("iterations", 10000), "at most"]},  # [value, unit]
    "steps": steps,  # that it took; "dt" (s) where it moves in time
    "mass": "lumped",  # or "consistent", or "one point"
    "forces_at": "start",  # of a step, where forces act that change velocities; implicit: "end"
    "at_rest": rest,  # or {"largest_speed": m/s}, {"change_when_twice_as_long": m}, {} if unknown
    "seconds": time.perf_counter() - began,
}
(OUT / "result.json").write_text(json.dumps(about, indent=2))
'''


def adapter_template(name: str) -> str:
    """Text of an adapter of a name, which is letters, digits, - and _ alone."""
    return TEMPLATE.replace("NAME=VALUE", "\0").replace("NAME", name).replace("\0", "NAME=VALUE")
