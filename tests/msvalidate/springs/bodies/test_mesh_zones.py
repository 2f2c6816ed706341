"""Zones in mesh files: groups, sets and arrays of the body's own cells."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Box
from msvalidate.springs.bodies.mesh_file import read_mesh
from reference_fem import box_discretisation

BODY = box_discretisation(Box((2.0, 1.0)), (6, 2), "Q1")
LEFT, RIGHT = np.split(np.argsort(BODY.points[BODY.cells].mean(axis=1)[:, 0], kind="stable"), 2)


def zones(path):
    """Name -> sorted x of the middles of a zone's cells."""
    mesh = read_mesh(path)
    assert len(mesh.cells) == len(BODY.cells)
    middle = mesh.points[mesh.cells].mean(axis=1)[:, 0]
    return {name: sorted(middle[cells].round(9).tolist()) for name, cells in mesh.zones.items()}


X = np.round(np.sort(BODY.points[BODY.cells].mean(axis=1)[:, 0]), 9).tolist()


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
