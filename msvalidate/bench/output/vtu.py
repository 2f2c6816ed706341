"""Fields as .vtu files, which ParaView opens, and meshes for solvers. Returns bytes, not results.

The library writes files only, so each is made in a folder that is gone at the end.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping
from pathlib import Path

import meshio
import numpy as np

from msvalidate.problem import Array, Index


def vtu_bytes(
    points: Array,
    cells: Mapping[str, Index],
    fields: Mapping[str, np.ndarray],
    by_cell: Mapping[str, np.ndarray] | None = None,
) -> bytes:
    """A .vtu file's content.

    Points (n, 2) in m lie at z = 0, others are (n, 3). Cells are meshio's name of a shape -> nodes
    (c, k). Fields are name -> values (n,) or (n, d) at the points, where vectors of two components
    get a third, 0, and `by_cell` values (c,) of cells of one shape.
    """
    mesh = meshio.Mesh(
        _in_space(points),
        [(name, np.asarray(each)) for name, each in cells.items()],
        cell_data={name: [np.asarray(each)] for name, each in (by_cell or {}).items()},
        point_data={name: _in_space(np.asarray(value)) for name, value in fields.items()},
    )
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "fields.vtu"
        mesh.write(path, file_format="vtu")
        return path.read_bytes()


FORMATS = {".msh": "gmsh22", ".inp": "abaqus"}
"""Ends of names -> meshio's name of the format: text, in all digits."""


def mesh_bytes(points: Array, shape: str, cells: Index, suffix: str, element: str = "") -> bytes:
    """A mesh file's content: Gmsh's format 2.2 (".msh"), or an Abaqus deck (".inp").

    Points, shape and cells are as in `vtu_bytes`. The element, such as "C3D4", is what an .inp
    file's cells are said to be; they are the set BODY.
    """
    form = FORMATS[suffix]
    tags = np.ones(len(cells), dtype=np.int32)
    data = {name: [tags] for name in ("gmsh:physical", "gmsh:geometrical")}
    mesh = meshio.Mesh(_in_space(points), [(shape, np.asarray(cells))], cell_data=data)
    # Of the library's own names of elements some are of other formulations: reduced, or rigid.
    options = {"binary": False} if suffix == ".msh" else {"translate_cell_names": False}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"mesh{suffix}"
        mesh.write(path, file_format=form, **options)
        content = path.read_bytes()
    return content.replace(f"TYPE={shape}".encode(), f"TYPE={element}, ELSET=BODY".encode(), 1)


def _in_space(values: np.ndarray) -> np.ndarray:
    """Vectors (n, 2) with a third component, 0; all else as it is."""
    if values.ndim == 2 and values.shape[1] == 2:
        return np.column_stack([values, np.zeros(len(values))])
    return np.ascontiguousarray(values, dtype=float)
