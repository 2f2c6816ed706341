"""Adapters answer closed forms, and refuse what is no request by one line and an exit code."""

import json
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from tests.table import table

ADAPTERS = Path(__file__).resolve().parents[2] / "simulators" / "adapters"
SINGLE = 2e-7
"""Of the largest value: CalculiX leaves float32, 6e-8, and is given 14 digits."""
E, NU = 2e6, 0.3
SIZE = np.array([0.4, 0.2, 0.3])  # m
CORNERS = np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
UNIT = np.concatenate([CORNERS, CORNERS + np.array([0, 0, 1])])
HEXES = np.array([[0, 1, 2, 3, 4, 5, 6, 7], [1, 8, 9, 2, 5, 10, 11, 6]])
POINTS = np.concatenate(
    [UNIT * SIZE / [2, 1, 1], (UNIT[[1, 2, 5, 6]] + [1, 0, 0]) * SIZE / [2, 1, 1]]
)
SIX = [[0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6]]
CELLS = {"hexahedron": HEXES, "tetra": HEXES[:, SIX].reshape(-1, 4)}


def write(folder, points, cells, *, held, force, start=None, springs=None, **changes):
    """A request folder; a table a file, ids first."""
    n, d = points.shape
    folder.mkdir(exist_ok=True)
    asked = {"format": 1, "task": "rest" if start is None else "motion", "name": "bar"}
    asked |= {"dimension": d, "cells": changes.pop("kind"), "gravity": [0.0] * d, "settings": {}}
    asked |= {"dt": None if start is None else 1e-3, "steps": 1}
    asked["material"] = {"E": E, "nu": NU, "density": 1e3, "state": "solid", "thickness": 1.0}
    (folder / "request.json").write_text(json.dumps(asked | changes), encoding="utf-8")
    parts = {"points": points, "cells": cells, "start": start, "springs": springs}
    parts["nodal"] = np.c_[np.ones(n), force, held, np.zeros((n, d))]
    for name, rows in parts.items():
        if rows is not None:
            lines = [",".join(map(repr, [i, *row])) for i, row in enumerate(rows.tolist())]
            text = "\n".join(["id" + ",value" * rows.shape[1], *lines])
            (folder / f"{name}.csv").write_text(text + "\n", encoding="utf-8")


def ask(adapter, case, out):
    command = [sys.executable, str(ADAPTERS / f"{adapter}.py"), str(case), str(out)]
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=60)


def answered(adapter, case, out):
    ask(adapter, case, out).check_returncode()
    return dict(np.load(out / "result.npz")), json.loads((out / "result.json").read_text())


@pytest.fixture
def bar(tmp_path):
    """Writes the bar on rollers, pulled along x, or at given positions."""

    def make(kind, **changes):
        force = np.zeros_like(POINTS)
        share = np.bincount(end_faces(kind).ravel(), minlength=len(POINTS))
        force[:, 0] = 1e4 * SIZE[1] * SIZE[2] * share / share.sum()
        write(
            tmp_path / "case",
            POINTS,
            CELLS[kind],
            **{"kind": kind, "held": POINTS == 0, "force": force, **changes},
        )
        return tmp_path / "case", tmp_path / "out"

    return make


def end_faces(kind):
    """Corners of equal faces that make the end of the bar."""
    faces = [cell[POINTS[cell][:, 0] == SIZE[0]] for cell in CELLS[kind]]
    return np.array([face for face in faces if len(face) == (4 if kind == "hexahedron" else 3)])


@pytest.mark.skipif(shutil.which("ccx") is None, reason="CalculiX (ccx) is not installed")
@pytest.mark.parametrize("kind", ["hexahedron", "tetra"])
def test_calculix_pulls_a_bar_and_holds_it(bar, kind):
    found, about = answered("calculix", *bar(kind))
    expected = 1e4 / E * POINTS * [1, -NU, -NU]
    assert abs(found["displacement"] - expected).max() < SINGLE * abs(expected).max()
    assert about["simulator"] == "CalculiX"
    assert about["at_rest"]["residual"] < SINGLE * 1e4 * SIZE[1] * SIZE[2]
    strain = np.array([[3, 1, -2], [1, -1, 4], [-2, 4, 2]]) / 1024
    case = bar(kind, start=POINTS + POINTS @ strain, force=0 * POINTS)
    force = answered("calculix", *case)[0]["force"]
    stress = E / (1 + NU) * (strain + NU / (1 - 2 * NU) * np.trace(strain) * np.eye(3))
    read = -force.T @ (POINTS - SIZE / 2) / SIZE.prod()
    assert abs(read - stress).max() < 10 * SINGLE * abs(stress).max()  # sums of twelve forces


def test_springs_in_a_row_stretch_by_their_constants(tmp_path):
    points = np.array([[0.0, 0], [0.2, 0], [0.5, 0]])
    held, force = np.array([[1, 1], [0, 1], [0, 1]]), np.array([[0, 0], [0, 0], [3.0, 0]])
    springs = np.array([[0, 1, 100.0, 0.2], [1, 2, 400.0, 0.3]])
    cells = np.array([[0, 1, 2]])
    shared = {"kind": "triangle", "held": held, "force": force, "springs": springs}
    for geometry in ("linear", "nonlinear"):
        case, out = tmp_path / geometry, tmp_path / f"{geometry}-out"
        write(case, points, cells, **shared, settings={"geometry": geometry})
        moved = answered("springs", case, out)[0]["displacement"]
        assert np.allclose(moved, [[0, 0], [0.03, 0], [0.0375, 0]], rtol=1e-12, atol=1e-15)
    start = points.copy()
    start[1, 0] += 0.01
    write(tmp_path / "still", points, cells, **shared, start=start)
    force = answered("springs", tmp_path / "still", tmp_path / "out")[0]["force"]
    assert np.allclose(force, [[1.0, 0], [-5.0, 0], [4.0, 0]], rtol=1e-12, atol=1e-12)


def test_what_cannot_be_asked_ends_with_its_code_and_a_line(bar, tmp_path):
    case, out = bar("tetra")
    ended = ask("springs", case, out)
    assert (ended.returncode, ended.stderr.count("\n")) == (77, 1)
    assert "springs.csv" in ended.stderr
    ended = ask("calculix", tmp_path / "nowhere", out)
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    ended = ask("calculix", *bar("tetra", settings={"elemnt": "C3D8"}))
    assert (ended.returncode, ended.stderr.count("\n")) == (2, 1)
    assert "elemnt" in ended.stderr
    assert not out.exists()


@table(
    "change, said",
    [
        ({"format": 2}, "format 2; this adapter reads 1"),
        ({"cells": "wedge"}, "'wedge'"),
        ({"material": None}, "give the folder of a request"),
        ({"dimension": 2}, "nodal.csv: give ids 0, 1, 2, ... and 7 numbers more a row"),
    ],
)
def test_exchange_refuses_by_name(bar, change, said):
    read = runpy.run_path(str(ADAPTERS / "exchange.py"))
    case, _ = bar("tetra")
    path = case / "request.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | change), encoding="utf-8")
    with pytest.raises(read["Refusal"]) as told:
        read["read_request"](case)
    assert said in str(told.value)


@table(
    "given, default, expected",
    [
        ("0.5", 1.0, 0.5),
        (3, 1.0, 3.0),
        ("12", 5, 12),
        ("false", True, False),
        ("b", ("a", "b"), "b"),
        ("1.5", 5, None),
        ("maybe", True, None),
        ("c", ("a", "b"), None),
    ],
)
def test_settings_have_the_type_of_their_default(bar, given, default, expected):
    used = runpy.run_path(str(ADAPTERS / "exchange.py"))
    request = used["read_request"](bar("tetra", settings={"it": given})[0])
    if expected is None:
        with pytest.raises(used["Refusal"], match=f"setting it: '{given}'"):
            used["setting"](request, "it", default)
    else:
        value = used["setting"](request, "it", default)
        assert (value, type(value)) == (expected, type(default if default != ("a", "b") else ""))
