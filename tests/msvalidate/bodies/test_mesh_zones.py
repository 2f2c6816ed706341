"""Zones in mesh files: groups, sets and arrays of the body's own cells."""

from __future__ import annotations

import meshio
import numpy as np
import pytest

from msvalidate.bodies.mesh_file import MOST_ZONES, read_mesh
from msvalidate.problem import Box
from reference_fem import box_discretisation

BODY = box_discretisation(Box((2.0, 1.0)), (6, 2), "Q1")
LEFT, RIGHT = np.split(np.argsort(BODY.points[BODY.cells].mean(axis=1)[:, 0], kind="stable"), 2)
SPLIT = [("quad", BODY.cells[LEFT]), ("line", [[0, 1]]), ("quad", BODY.cells[RIGHT])]
"""Two parts of the body, listed apart, with a line of its side between them."""


def zones(path):
    """Name -> sorted x of the middles of a zone's cells."""
    mesh = read_mesh(path)
    assert len(mesh.cells) == len(BODY.cells)
    middle = mesh.points[mesh.cells].mean(axis=1)[:, 0]
    return {name: sorted(middle[cells].round(9).tolist()) for name, cells in mesh.zones.items()}


X = np.round(np.sort(BODY.points[BODY.cells].mean(axis=1)[:, 0]), 9).tolist()


@pytest.mark.parametrize("form", ["gmsh22", "vtu", "vtk"])
def test_groups_and_arrays_of_cells(form, tmp_path):
    tags = [np.full(6, 3), np.array([5]), np.full(6, 4)]
    points = np.column_stack([BODY.points, np.zeros(len(BODY.points))])
    if form == "gmsh22":
        path, data = tmp_path / "a.msh", {"gmsh:physical": tags, "gmsh:geometrical": tags}
        names = {"soft": np.array([3, 2]), "side": np.array([5, 1])}
        meshio.Mesh(points, SPLIT, cell_data=data, field_data=names).write(path, file_format=form)
        assert zones(path) == {"soft": X[:6], "4": X[6:]}
        return
    path = tmp_path / f"a.{form}"
    tags[0][:] = 0  # a label like any other
    many = [np.arange(6), np.array([0]), np.arange(6, 12)]
    meshio.Mesh(points, SPLIT, cell_data={"part": tags, "half": [t / 2 for t in tags]}).write(path)
    assert zones(path) == {"part:0": X[:6], "part:4": X[6:]}
    meshio.Mesh(points, SPLIT, cell_data={"id": many}).write(path)
    assert len(zones(path)) == 12


def test_an_array_that_numbers_cells_names_none(tmp_path):
    body = box_discretisation(Box((2.0, 1.0)), (20, 11), "Q1")
    count = len(body.cells)
    assert count > MOST_ZONES
    points = np.column_stack([body.points, np.zeros(len(body.points))])
    data = {"id": [np.arange(count)], "part": [np.arange(count) // 110]}
    meshio.Mesh(points, [("quad", body.cells)], cell_data=data).write(tmp_path / "a.vtu")
    assert set(read_mesh(tmp_path / "a.vtu").zones) == {"part:0", "part:1"}


def test_sets_of_abaqus(tmp_path):
    lines = ["*NODE"]
    lines += [f"{i + 1}, {x}, {y}" for i, (x, y) in enumerate(BODY.points.tolist())]
    number = 0
    for name, part in (("Soft", LEFT), ("Hard", RIGHT)):
        lines.append(f"*ELEMENT, TYPE=CPS4, ELSET={name}")
        for cell in BODY.cells[part]:
            number += 1
            lines.append(", ".join(map(str, [number, *(cell + 1)])))
    lines += ["*ELSET, ELSET=Ends", "1, 12", ""]
    path = tmp_path / "a.inp"
    path.write_text("\n".join(lines), encoding="utf-8")
    assert zones(path) == {"Soft": X[:6], "Hard": X[6:], "Ends": [X[0], X[-1]]}
