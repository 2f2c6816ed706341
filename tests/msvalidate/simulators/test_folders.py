"""Requests written and read back, and answers that are whole or refused in one line."""

from __future__ import annotations

import json
import runpy
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest

from msvalidate.case.file.case import Case
from msvalidate.problem import Box, Isotropic, Mesh, Problem, ProblemError, Support, Traction
from msvalidate.simulators.exchange.answers import read_answer
from msvalidate.simulators.exchange.export import export_case
from msvalidate.simulators.exchange.folders import write_request
from msvalidate.simulators.exchange.protocol import Answer, SimulatorError, stated_residual_motion
from tests.table import stored_rows, table

BOX = Box((0.3, 0.1, 0.1))
HOSTILE = 'x/../../"; rm -rf ~ #\\é'
ABOUT = {"simulator": "s", "version": "1", "law": "linear", "precision": "float64"}


def request(**changes):
    held = (Support(BOX.side("left"), (0.0, 0.0, 1e-3 / 3)),)
    loads = (Traction(BOX.side("right"), (1e3, 0.0, 10.0 / 3)),)
    case = Case(Problem(BOX, Isotropic(1e5 / 3, 0.3, "solid"), held, loads, HOSTILE))
    return replace(export_case(case, cells=2, settings={"law": "a", "n": [1, 0.1]}), **changes)


REST = request()
X = REST.mesh.points
MOTION = replace(REST, task="motion", start=X * (1 / 3), dt=0.1 / 3, steps=3)


ADAPTER = Path(__file__).parents[3] / "simulators" / "adapters" / "exchange.py"


@pytest.mark.parametrize("asked", [REST, MOTION])
def test_an_adapter_reads_a_request_as_it_was(tmp_path, asked):
    write_request(asked, tmp_path / "a b")
    again = runpy.run_path(str(ADAPTER))["read_request"](tmp_path / "a b")
    for name in ("task", "name", "dt", "steps", "settings"):
        assert getattr(again, name) == getattr(asked, name)
    for name in ("mass", "force", "held", "value", "gravity", "start"):
        np.testing.assert_array_equal(getattr(again, name), getattr(asked, name), strict=True)
    np.testing.assert_array_equal(again.points, asked.mesh.points, strict=True)
    np.testing.assert_array_equal(again.cells, asked.mesh.cells)
    assert all(getattr(asked.material, name) == of for name, of in vars(again.material).items())


def test_a_folder_of_other_things_is_left_alone(tmp_path):
    (tmp_path / "mine").write_text("", encoding="utf-8")
    with pytest.raises(ProblemError, match="holds what no request left there"):
        write_request(REST, tmp_path)
    with pytest.raises(ProblemError, match="settings"):
        write_request(replace(REST, settings={"a": np.nan}), tmp_path / "new")
    places = np.array([[0, 0], [2, 0], [0, 2], [1, 0], [1, 1], [0, 1]])
    quadratic = Mesh(places, np.array([range(6)]), "triangle6")
    with pytest.raises(ProblemError, match="give linear cells"):
        write_request(replace(REST, mesh=quadratic, material=Isotropic(1, 0)), tmp_path / "new")


# Answers ------------------------------------------------------------------------------------------


def left(folder, arrays=None, about=ABOUT):
    folder.mkdir(exist_ok=True)
    for old in folder.iterdir():
        old.unlink()
    if arrays is not None:
        np.savez(folder / "result.npz", **arrays)
    text = about if isinstance(about, str) else json.dumps(about)
    (folder / "result.json").write_text(text, encoding="utf-8")
    return folder


def test_an_answer_is_read_from_any_of_its_files(tmp_path):
    move = np.sqrt(X + 0.1)
    answers = [read_answer(left(tmp_path / "a", {"displacement": move}), REST)]
    order = np.random.default_rng(3).permutation(len(X))
    rows = [f"{i},{','.join(map(repr, move[i].tolist()))}" for i in order]
    text = "\n".join(["id,ux,uy,uz", *rows])
    (left(tmp_path / "a") / "result.csv").write_text(text, encoding="utf-8")
    answers.append(read_answer(tmp_path / "a", REST))
    mesh = meshio.Mesh(X, [("tetra", REST.mesh.cells)], point_data={"displacement": move})
    mesh.write(left(tmp_path / "a") / "result.vtu")
    answers.append(read_answer(tmp_path / "a", REST))
    assert all(np.array_equal(answer.displacement, move) for answer in answers)
    mesh.points = X[order]
    mesh.write(tmp_path / "a" / "result.vtu")
    with pytest.raises(SimulatorError, match="its points are not the nodes"):
        read_answer(tmp_path / "a", REST)


def test_a_third_component_of_nothing_is_left_out_in_the_plane(tmp_path):
    box = Box((0.3, 0.1))
    held = (Support(box.side("left"), (0.0, 0.0)),)
    flat = export_case(Case(Problem(box, Isotropic(1e5, 0.3), held)), cells=2)
    x = np.pad(flat.mesh.points, ((0, 0), (0, 1)))
    for out in (0.0, 1e-3):
        data = {"displacement": x + np.array([0, 0, out])}
        mesh = meshio.Mesh(x, [("triangle", flat.mesh.cells)], point_data=data)
        mesh.write(left(tmp_path / "a") / "result.vtu")
        if not out:
            assert np.array_equal(read_answer(tmp_path / "a", flat).displacement, x[:, :2])
    with pytest.raises(SimulatorError):
        read_answer(tmp_path / "a", flat)


def test_a_motion_is_answered_by_what_moved_or_by_forces(tmp_path):
    both = {"position": X + 1, "velocity": X}
    assert np.array_equal(read_answer(left(tmp_path / "a", both), MOTION).velocity, X)
    assert np.array_equal(read_answer(left(tmp_path / "a", {"force": X}), MOTION).force, X)
    with pytest.raises(SimulatorError, match="needs position and velocity or force"):
        read_answer(left(tmp_path / "a", {"position": X}), MOTION)
    header = "id,x,y,z,vx,vy,vz\n" + "\n".join(f"{i},1,2,3,4,5,6" for i in range(len(X)))
    (left(tmp_path / "a") / "result.csv").write_text(header, encoding="utf-8")
    found = read_answer(tmp_path / "a", MOTION)
    assert np.array_equal(found.position[0], [1, 2, 3])
    assert np.array_equal(found.velocity[0], [4, 5, 6])


GOOD = {"displacement": X}
REFUSED = [
    (None, ABOUT, "no result; write one of result.npz"),
    ({"displacement": X[1:]}, ABOUT, "displacement (62, 3); give (63, 3), a row a node"),
    ({"displacement": np.where(X > 0.2, np.nan, X)}, ABOUT, "did it diverge?"),
    ({"displacement": 1e250 * X}, ABOUT, "e+248 at node 1, 138 in all; did it diverge?"),
    (GOOD, ABOUT | {"at_rest": {"residual": np.nan}}, 'residual is NaN; did it diverge?'),
    (GOOD, ABOUT | {"settings": {"dt": [-np.inf, "s"]}}, 'dt is -Infinity; did it diverge?'),
    (GOOD, ABOUT | {"solves_to": 0.5}, "Expected `float` < 0.1 - at `$.solves_to`"),
    ({"displacement": np.array([None])}, ABOUT, "not whole arrays"),
    ({"u": X}, ABOUT, "result.npz holds 'nothing'; a rest needs displacement"),
    ({"displacement": np.zeros((4_000_000, 3))}, ABOUT, "bytes; the most is"),
    (GOOD, "{", "result.json: "),
    (GOOD, "[" * 100_000, "result.json: "),
    (GOOD, " " * 2_000_000, "bytes; the most is 1e+06"),
    (GOOD, {}, "missing required field `simulator`"),
    (GOOD, ABOUT | {"lawe": 1}, "unknown field `lawe`; the keys are simulator, version, law"),
    (GOOD, ABOUT | {"law": 1}, "Expected `str`, got `int` - at `$.law`"),
    (GOOD, ABOUT | {"precision": "double"}, "Invalid enum value 'double' - at `$.precision`"),
    (GOOD, ABOUT | {"settings": {"dt": 0.1}}, "Expected `array`, got `float`"),
    (GOOD, ABOUT | {"at_rest": {"speed": 0.1}}, "unknown field `speed`"),
    (GOOD, ABOUT | {"at_rest": {"residual": -1}}, ">= 0.0 - at `$.at_rest.residual`"),
    (GOOD, ABOUT | {"dt": "1"}, "at `$.dt`"),
]  # fmt: skip


@table(("arrays", "about", "words"), REFUSED)
def test_what_is_no_answer_is_refused_in_one_line(tmp_path, arrays, about, words):
    with pytest.raises(SimulatorError) as found:
        read_answer(left(tmp_path / "a", arrays, about), REST)
    assert words in str(found.value)
    assert "\n" not in str(found.value)
    assert len(str(found.value)) < 400


@table(("text", "words"), stored_rows("result_tables"))
def test_tables_that_are_no_answer(tmp_path, text, words):
    (left(tmp_path / "a") / "result.csv").write_bytes(text.encode("latin-1"))
    with pytest.raises(SimulatorError) as found:
        read_answer(tmp_path / "a", REST)
    assert words in str(found.value)


def test_half_a_file_and_two_files(tmp_path):
    folder = left(tmp_path / "a", GOOD)
    whole = (folder / "result.npz").read_bytes()
    (folder / "result.npz").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(SimulatorError, match="not whole arrays"):
        read_answer(folder, REST)
    (folder / "result.csv").write_text("", encoding="utf-8")
    with pytest.raises(SimulatorError, match=r"result.npz and result.csv; write one"):
        read_answer(folder, REST)


def test_rest_that_is_stated_in_three_ways():
    # One free node of mass m on a spring k, pulled by F: u = F/k, and ω² = k/m.
    one = replace(
        REST,
        mass=np.full(len(X), 2.0),
        force=np.zeros_like(X),
        held=np.ones(X.shape, dtype=bool),
        value=np.zeros_like(X),
        gravity=np.zeros(3),
    )
    one.held[5, 0], one.force[5, 0] = False, 3.0
    k = 8.0
    u = np.zeros_like(X)
    u[5, 0] = 3.0 / k
    stated = {
        "change_when_twice_as_long": 0.01 * 3.0 / k,
        "largest_speed": 0.01 * 3.0 / k * np.sqrt(k / 2.0),
        "residual": 0.01 * 3.0 / len(X),
    }
    for name, value in stated.items():
        answer = Answer(displacement=u, about={"at_rest": {name: value}})
        assert stated_residual_motion(one, answer) == pytest.approx(0.01), name
    assert np.isnan(stated_residual_motion(one, Answer(displacement=u, about={"at_rest": {}})))
