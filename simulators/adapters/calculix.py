# SPDX-License-Identifier: MIT
"""CalculiX: linear elements of its own, at rest or holding given positions (2.20 tried).

Law: *ELASTIC with *STATIC and no NLGEOM, linear elasticity with small strains: section "Linear
elastic materials" of ccx' manual, stresses 2 mu eps + lambda tr(eps) I in linel.f.

Settings: ``element`` C3D8 (default), C3D8I, C3D8R of hexahedra; tetrahedra are C3D4.
``stiffer`` times E, 1 unless a control wants it otherwise.

A motion of one step is answered by forces: every node is held where it starts, and a reaction RF
is what the world puts on the node, so the body puts -RF there. Weight and forces come as *CLOAD.

Traps: ccx reads 20 characters of a number and no more, so 13 decimals with an exponent are all it
can be given. A .dat file has seven digits, the binary .frd that `*NODE OUTPUT` makes has single
precision (6e-8), the finest that it gives of displacements. A set is printed in the order of its
making. A model without any unknown is not solved: one more tetrahedron, outside the body, has one.
On cells that are no boxes, C3D8I and C3D8R put forces on the nodes inside of an affine field.
"""

import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
from exchange import cannot, refuse_unknown, run, setting

ELEMENTS = ("C3D8", "C3D8I", "C3D8R")


def answer(request):
    """Displacement of a body at rest, or the forces of one held at `start`."""
    if request.kind not in ("tetra", "hexahedron"):
        cannot(f"cells {request.kind}: this adapter gives CalculiX tetra or hexahedron only")
    if request.task == "motion" and request.steps != 1:
        cannot(f"a motion of {request.steps} steps: this adapter asks CalculiX for statics alone")
    element = setting(request, "element", ELEMENTS) if request.kind == "hexahedron" else "C3D4"
    stiffer = setting(request, "stiffer", 1.0)
    refuse_unknown(request)
    ccx = shutil.which("ccx")
    if ccx is None:
        raise SystemExit("ccx: not found; install CalculiX (Debian: calculix-ccx)")
    moving = request.task == "motion"
    with tempfile.TemporaryDirectory() as folder:
        write_input(Path(folder, "job.inp"), request, element, stiffer)
        solve(ccx, folder)
        result = Path(folder, "job.frd").read_bytes()
    n = len(request.points)
    reaction = values(result, "FORC", n)
    about = {
        "simulator": "CalculiX",
        "version": re.findall(r"[\d.]+", printed([ccx, "-v"]))[0],
        "law": "linear",
        "settings": {"element": [element, ""], "stiffer": [stiffer, "times E"]},
        "steps": 1,
        "dt": None,
        "precision": "float32",
        "mass": "lumped",
        "forces_at": "start",
        "at_rest": {},
        "notes": "solved in float64, written in float32",
    }
    if moving:
        return about, {"force": -reaction}
    left = abs(reaction - request.load)[~request.held].max(initial=0.0)
    return {**about, "at_rest": {"residual": float(left)}}, {
        "displacement": values(result, "DISP", n)
    }


def write_input(path, request, element, stiffer):
    """The deck: nodes from 1, cells in VTK order, which is ccx' own."""
    moving, n = request.task == "motion", len(request.points)
    held = np.ones_like(request.held) if moving else request.held
    value = request.start - request.points if moving else request.value
    E = request.material.E * stiffer
    lines = ["*NODE", *rows(1, request.points), f"*ELEMENT,TYPE={element},ELSET=B"]
    lines += [f"{i},{','.join(map(str, cell + 1))}" for i, cell in enumerate(request.cells, 1)]
    if moving:
        size = np.ptp(request.points, axis=0).max()
        more = request.points.max(axis=0) + size * (1 + np.eye(4, 3))
        lines += ["*NODE", *rows(n + 1, more), "*ELEMENT,TYPE=C3D4,ELSET=B"]
        lines += [f"{len(request.cells) + 1},{n + 4},{n + 1},{n + 2},{n + 3}"]
    lines += ["*NSET,NSET=BODY,GENERATE", f"1,{n}"]
    lines += ["*MATERIAL,NAME=M", "*ELASTIC", f"{E:.13e},{request.material.nu:.13e}"]
    lines += ["*SOLID SECTION,ELSET=B,MATERIAL=M", "*STEP", "*STATIC", "*BOUNDARY"]
    lines += [f"{i + 1},{a + 1},{a + 1},{value[i, a]:.13e}" for i, a in np.argwhere(held)]
    if moving:
        lines += [f"{node},1,3" for node in (n + 1, n + 2, n + 3)]
    else:
        lines += ["*CLOAD"]
        load = request.load
        lines += [f"{i + 1},{a + 1},{load[i, a]:.13e}" for i, a in np.argwhere(load != 0)]
    lines += ["*NODE OUTPUT,NSET=BODY", "U,RF", "*END STEP"]
    path.write_text("\n".join(lines) + "\n", encoding="ascii")


def rows(first, points):
    """Lines of nodes."""
    return [f"{i},{x:.13e},{y:.13e},{z:.13e}" for i, (x, y, z) in enumerate(points, first)]


def solve(ccx, folder):
    """Run ccx with one thread, which makes it the same every time."""
    text = printed([ccx, "job"], cwd=folder, env={**os.environ, "OMP_NUM_THREADS": "1"})
    if "*ERROR" in text or not Path(folder, "job.frd").exists():
        raise SystemExit(f"ccx: {text[text.find('*ERROR') :][:300].strip()}")


def printed(command, **options):
    """What a program prints, whichever way it ends."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **options)
    return done.stdout


def values(result, name, n):
    """A vector field (n, 3) of a binary .frd, in which a record is a node and three floats."""
    start = result.index(f" -4  {name}".encode())
    start = result.index(b"\n", result.index(b" -5  ALL", start)) + 1
    record = np.dtype([("node", "<i4"), ("value", "<f4", 3)])
    read = np.frombuffer(result, record, n, start)
    order = np.argsort(read["node"], kind="stable")  # a set is printed in the order of its making
    if not np.array_equal(read["node"][order], np.arange(1, n + 1)):
        raise SystemExit(f"ccx: {name} of other nodes than asked; does each belong to a cell?")
    return read["value"][order].astype(float)


if __name__ == "__main__":
    run(answer)
