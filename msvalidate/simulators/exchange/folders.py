"""Requests as folders of files, for adapters: programs that know nothing of this package.

docs/simulators.md tells the files. Numbers are written so that they are read back as they were.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import numpy as np

from msvalidate.bench.output.vtu import mesh_bytes, vtu_bytes
from msvalidate.problem import AXES, ProblemError
from msvalidate.problem.checks import format_value
from msvalidate.simulators.exchange.protocol import FORMAT, Request
from msvalidate_check import exchange

REQUEST = "request.json"
"""The file that tells a folder of a request from others."""
ELEMENTS = {
    ("triangle", "plane_stress"): "CPS3",
    ("triangle", "plane_strain"): "CPE3",
    ("quad", "plane_stress"): "CPS4",
    ("quad", "plane_strain"): "CPE4",
    ("tetra", "solid"): "C3D4",
    ("hexahedron", "solid"): "C3D8",
}
"""Shape of cells and state -> name of the element in .inp files."""


def write_request(
    request: Request, folder: str | Path, more: Mapping[str, bytes] | None = None
) -> None:
    """Write a request's files into a folder, which is replaced whole.

    Parameters
    ----------
    request, folder
        What is asked, and where.
    more
        Further files: name -> content.

    Raises
    ------
    ProblemError
        If the cells are none of those that adapters are given, a setting cannot be written, or the
        folder holds anything but an earlier request.
    """
    place = Path(folder)
    refuse_foreign(place)
    exchange.replace_one(place, {**request_files(request), **(more or {})})


def refuse_foreign(folder: Path) -> None:
    """Raise `ProblemError` where a folder that would be replaced holds no request."""
    if folder.is_symlink() or (folder.exists() and not folder.is_dir()):
        raise ProblemError(f"folder {folder}: no folder of a request; name another")
    if folder.is_dir() and any(folder.iterdir()) and not (folder / REQUEST).is_file():
        raise ProblemError(f"folder {folder}: holds what no request left there; name another")


def request_files(request: Request) -> dict[str, bytes]:
    """Name -> content of every file of a request; errors as `write_request`."""
    mesh, material = request.mesh, request.material
    element = ELEMENTS.get((mesh.shape, material.state))
    if element is None:
        raise ProblemError(
            f"request: {mesh.shape} cells of state {material.state}; give linear cells: triangle "
            "or quad in the plane, tetra or hexahedron in space"
        )
    axes = AXES[: mesh.dim]
    nodal = np.column_stack([request.mass, request.force, request.held, request.value])
    names = ["mass", *(f"{what}{a}" for what in ("f", "held_", "value_") for a in axes)]
    corners = [f"n{i}" for i in range(mesh.cells.shape[1])]
    fields = {"mass": request.mass, "force": request.force}
    files = {
        REQUEST: _about(request),
        "points.csv": _table(axes, mesh.points),
        "nodal.csv": _table(names, nodal, whole=[n for n in names if n.startswith("held")]),
    }
    if not request.points_only:
        files["cells.csv"] = _table(corners, mesh.cells)
        files["mesh.vtu"] = vtu_bytes(mesh.points, {mesh.shape: mesh.cells}, fields)
        for suffix in (".msh", ".inp"):
            content = mesh_bytes(mesh.points, mesh.shape, mesh.cells, suffix, element)
            files[f"mesh{suffix}"] = content
    if request.start is not None:
        files["start.csv"] = _table(axes, request.start)
    if request.springs is not None:
        each = request.springs
        columns = np.column_stack([each.ends, each.stiffness, each.length])
        files["springs.csv"] = _table(["a", "b", "stiffness", "length"], columns, whole=["a", "b"])
    return files


def _about(request: Request) -> bytes:
    material = request.material
    content = {
        "format": FORMAT,
        "task": request.task,
        "name": request.name,
        "dimension": request.mesh.dim,
        "cells": "points" if request.points_only else request.mesh.shape,
        "nodes": len(request.mesh.points),
        "count_of_cells": 0 if request.points_only else len(request.mesh.cells),
        "material": {
            name: getattr(material, name) for name in ("E", "nu", "density", "state", "thickness")
        },
        "gravity": [float(g) for g in request.gravity],
        "dt": request.dt,
        "steps": request.steps,
        "settings": dict(request.settings),
    }
    try:
        return (json.dumps(content, indent=2, allow_nan=False) + "\n").encode()
    except (TypeError, ValueError, RecursionError) as error:
        raise ProblemError(
            f"request: settings {format_value(dict(request.settings))}: {error}; give numbers, "
            "texts and lists of them"
        ) from error


def _table(names: Sequence[str], rows: np.ndarray, whole: Iterable[str] = ()) -> bytes:
    """CSV with an id from 0; numbers by repr, which is read back exactly."""
    columns = [
        rows[:, i].astype(int) if name in whole else rows[:, i] for i, name in enumerate(names)
    ]
    texts = [map(repr, column.tolist()) for column in columns]
    lines = [",".join(["id", *names])]
    lines += [f"{i}," + ",".join(row) for i, row in enumerate(zip(*texts, strict=True))]
    return ("\n".join(lines) + "\n").encode()
