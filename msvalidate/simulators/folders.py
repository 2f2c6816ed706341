"""Requests as folders of files, for adapters: programs that know nothing of this package.

docs/simulators.md tells the files. Numbers are written so that they are read back as they were.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from msvalidate.output.vtu import mesh_bytes, vtu_bytes
from msvalidate.problem import AXES, Array, Isotropic, Mesh, ProblemError
from msvalidate.problem.checks import format_value, require_one_of
from msvalidate.simulators.answers import read_answer
from msvalidate.simulators.protocol import FORMAT, Request, Springs
from msvalidate.simulators.tables import read_table
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
        "cells.csv": _table(corners, mesh.cells),
        "nodal.csv": _table(names, nodal, whole=[n for n in names if n.startswith("held")]),
        "mesh.vtu": vtu_bytes(mesh.points, {mesh.shape: mesh.cells}, fields),
    }
    for suffix in (".msh", ".inp"):
        files[f"mesh{suffix}"] = mesh_bytes(mesh.points, mesh.shape, mesh.cells, suffix, element)
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
        "cells": request.mesh.shape,
        "nodes": len(request.mesh.points),
        "count_of_cells": len(request.mesh.cells),
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


def read_request(folder: str | Path) -> Request:
    """The request that a folder holds, as it was written: the inverse of `write_request`.

    Raises
    ------
    ProblemError
        If a file is missing, or is no such file.
    """
    place = Path(folder)
    about = _read_about(place / REQUEST)
    try:
        axes = list(AXES[: about["dimension"]])
        points = read_table(place / "points.csv", axes)
        corners = read_table(place / "cells.csv", None)
        groups = [f"{what}{a}" for what in ("f", "held_", "value_") for a in axes]
        nodal = read_table(place / "nodal.csv", ["mass", *groups])
        force, held, value = np.split(nodal[:, 1:], 3, axis=1)
        start = read_table(place / "start.csv", axes) if about["task"] == "motion" else None
        return Request(
            task=about["task"],
            mesh=Mesh(points, corners.astype(np.intp), about["cells"]),
            material=Isotropic(**about["material"]),
            mass=np.ascontiguousarray(nodal[:, 0]),
            gravity=np.array(about["gravity"], dtype=float),
            force=np.ascontiguousarray(force),
            held=held.astype(bool),
            value=np.ascontiguousarray(value),
            start=start,
            dt=about["dt"],
            steps=about["steps"],
            settings=about["settings"],
            springs=_read_springs(place),
            name=about["name"],
        )
    except (KeyError, TypeError) as error:
        raise ProblemError(f"request {place}: {REQUEST} lacks {error}; export it again") from error


def _read_about(path: Path) -> dict[str, Any]:
    try:
        about = json.loads(path.read_text(encoding="utf-8"))
        require_one_of("format", str(about["format"]), (str(FORMAT),))
    except OSError as error:
        raise ProblemError(f"request {path}: {error.strerror}; name a folder of one") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise ProblemError(f"request {path}: no request ({error}); export it again") from error
    return dict(about)


def _read_springs(place: Path) -> Springs | None:
    path = place / "springs.csv"
    if not path.exists():
        return None
    found: Array = read_table(path, ["a", "b", "stiffness", "length"])
    return Springs(found[:, :2].astype(np.intp), found[:, 2].copy(), found[:, 3].copy())


__all__ = ["read_answer", "read_request", "refuse_foreign", "request_files", "write_request"]
