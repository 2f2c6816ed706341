"""`report.sweep`: rows of combinations, their files, keys and exit codes."""

from __future__ import annotations

import ast
import importlib
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pandas as pd
import pytest

from msvalidate.case.report import sweep
from msvalidate.cli import cases
from msvalidate.cli.program import main
from msvalidate.problem import ProblemError

ROOT = Path(__file__).resolve().parents[4]
BEAM = (
    (ROOT / "examples" / "box.toml").read_text(encoding="utf-8")
    + """
[springs]
cells = 2
[compare]
quantities = ["displacement"]
geometry = "linear"
[reference]
accuracy = 0.05
"""
)


@pytest.fixture
def beam(tmp_path):
    path = tmp_path / "beam.toml"
    path.write_text(BEAM, encoding="utf-8")
    return path


@pytest.fixture
def program(beam, tmp_path, capsys):
    """Runs the command on the beam; exit code, and its messages."""

    def run(*words, files=(beam,)):
        code = main(["case", "run", *map(str, files), "--out", str(tmp_path / "out"), *words])
        return code, capsys.readouterr().err

    return run


def without_seconds(text):
    return re.sub(r"[0-9.]+$", "", text, flags=re.MULTILINE)


def test_every_combination_is_a_row_however_it_is_run(program, beam, tmp_path):
    words = ("--set", "springs.cells=2,3", "--set", "material.nu=.3,.6")
    folder = tmp_path / "out/beam-sweep"
    assert program(*words)[0] == 2
    table = (folder / "sweep.csv").read_text(encoding="utf-8")
    rows = table.splitlines()
    assert len(rows) == 5
    assert rows[1].startswith("beam.toml,2,0.3,solved,")
    assert "beam.toml,3,0.6,refused" in rows[4]
    assert "nu" in rows[4]
    assert (folder / "sweep.svg").is_file()
    # Files that are no records are named and solved again, and the table is the same.
    damaged = sorted((folder / "rows").iterdir())
    for path, content in zip(damaged, (b"\xff", b'{"outcome": 1}', b"[" * 9999), strict=False):
        path.write_bytes(content)
    _, message = program(*words, "--jobs", "2")
    assert message.count("no record of a row") == 3
    assert all(str(path) in message for path in damaged[:3])
    assert message.count("beam.toml springs.cells") == 3
    other = (folder / "sweep.csv").read_text(encoding="utf-8")
    assert without_seconds(other) == without_seconds(table)
    assert "beam.toml springs.cells" not in program(*words)[1]
    # Other values: the count is of this sweep's combinations, and no picture is of others.
    assert "1/1 beam.toml springs.cells 4" in program("--no-plots", "--set", "springs.cells=4")[1]
    assert not (folder / "sweep.svg").exists()
    beam.write_text(BEAM.replace("-10]", "-20]"), encoding="utf-8")
    assert program(*words)[1].count("beam.toml springs.cells") == 4


MESHED = """schema = 1
[body]
mesh = "part.msh"
[material]
E = 1e7
nu = 0.3
state = "plane_stress"
[[support]]
at = { x = 0 }
"""
MESH = (
    "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n4\n"
    "1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n"
    "$Elements\n2\n1 2 2 1 1 1 2 3\n2 2 2 1 1 1 3 4\n$EndElements\n"
)
OPENED = """
import sys
from pathlib import Path
from msvalidate.case.report import sweep
from msvalidate.cli import cases
each = sweep.Combination(Path(sys.argv[1]), (), "case")
files = set()
sys.addaudithook(lambda what, args: what == "open" and files.add(str(args[0])))
assert sweep.solve(each, each.key).outcome == "refused"
names = {getattr(module, "__file__", None) for module in sys.modules.values()}
print(sorted(files | {str(name) for name in names}))
"""


def test_a_changed_byte_of_any_file_that_a_run_opens_changes_the_key(tmp_path, monkeypatch):
    """A run of a link to a case reads the mesh next to the file."""
    home, link = tmp_path / "home", tmp_path / "link"
    for folder in (home, link):
        folder.mkdir()
        (folder / "part.msh").write_text(MESH, encoding="utf-8")
    (home / "case.toml").write_text(MESHED, encoding="utf-8")
    (link / "case.toml").symlink_to(home / "case.toml")
    case = sweep.Combination(link / "case.toml", ())
    before = case.key
    (home / "part.msh").write_text(MESH.replace("3 1 1 0", "3 1 2 0"), encoding="utf-8")
    assert case.key != before

    command = [sys.executable, "-c", OPENED, str(link / "case.toml")]
    path = os.pathsep.join([str(ROOT), str(ROOT / "checker")])
    environment = {**os.environ, "PYTHONPATH": path}
    listed = subprocess.run(command, env=environment, capture_output=True, text=True, check=True)
    opened = {Path(name).resolve() for name in ast.literal_eval(listed.stdout)}
    own = sorted(each for each in opened if each.is_relative_to(home))
    assert [each.name for each in own] == ["case.toml", "part.msh"]
    sources = [
        each
        for each in opened
        for name in sweep.PACKAGES
        if each.is_relative_to(Path(importlib.import_module(name).__file__).parent)
        if each.suffix not in {".pyc", ".nbi", ".nbc"}
    ]
    assert len(sources) > 100
    assert set(sources) <= set(sweep.program_files())
    for each in own:
        before, content = case.key, each.read_bytes()
        each.write_bytes(content.replace(b"1", b"2", 1))
        assert case.key != before
        each.write_bytes(content)

    copies = [Path(shutil.copy(each, tmp_path)) for each in sources[:3]]
    monkeypatch.setattr(sweep, "program_files", lambda: copies)
    keys = set()
    for change in (None, *copies, None):
        if change:
            change.write_bytes(change.read_bytes() + b"\n")
        elif keys:
            monkeypatch.setattr(sweep, "version", lambda name: f"9 of {name}")
        sweep.program_stamp.cache_clear()
        keys.add(case.key)
    copies.insert(0, copies.pop(0).rename(tmp_path / "renamed.py"))
    sweep.program_stamp.cache_clear()
    keys.add(case.key)
    sweep.program_stamp.cache_clear()
    assert len(keys) == 6
    assert {len(key) for key in keys} == {32}


def test_keys_follow_values_labels_and_meshes_that_are_set_or_missing(tmp_path):
    (tmp_path / "case.toml").write_text(MESHED, encoding="utf-8")

    def key(values=(), label=""):
        return sweep.Combination(tmp_path / "case.toml", values, label).key

    assert key(label="case.toml") == key()
    other, keys = (("body.mesh", "other.msh"),), {key(), key(label="b"), key((("a.b", 1),))}
    keys |= {key((("a.b", 2),)), key(other)}
    (tmp_path / "part.msh").mkdir()  # another reason of refusal
    keys.add(key())
    for content in (MESH, MESH + " "):
        (tmp_path / "other.msh").write_text(content, encoding="utf-8")
        keys.add(key(other))
    assert len(keys) == 8


def test_values_are_set_in_tables_and_in_lists_from_1():
    content = {"load": [{"at": [1, 2, 3]}, {"at": [4, 5, 6]}]}
    values = (("load.2.at.1", 7), ("load.1.at.3", 8), ("a.b.c", 9))
    sweep.Combination(Path("c.toml"), values).change(content)
    assert content == {"load": [{"at": [1, 2, 8]}, {"at": [7, 5, 6]}], "a": {"b": {"c": 9}}}
    for name in ("load.0.at", "load.3.at", "load.1.at.0", "load.1.at.4", "load.x", "a.b.c.d"):
        with pytest.raises(ProblemError, match=f"--set {name}: no such place in c.toml"):
            sweep.Combination(Path("c.toml"), ((name, 1),)).change(content)


def test_a_row_is_of_the_first_quantity_and_the_first_limitation(beam, monkeypatch):
    rows = [SimpleNamespace(error=part, uncertainty=part / 10) for part in (0.5, 0.3, 0.1)]
    limitations = [SimpleNamespace(sentence=text) for text in ("first\n one", "second")]
    result = SimpleNamespace(rows=rows, limitations=limitations)
    monkeypatch.setattr(sweep, "compare_case", lambda _: result)
    monkeypatch.setattr(sweep, "overall", lambda values: "agrees" if values is rows else "")
    monkeypatch.setattr(sweep, "time", SimpleNamespace(monotonic=iter([5.0, 7.12345]).__next__))
    case = sweep.Combination(beam, (), "beam.toml")
    row = sweep.Row("solved", "agrees", 0.5, 0.05, "first one", 2.123)
    assert sweep.solve(case, case.key) == row


def test_the_picture_has_a_line_for_each_other_value():
    """Along the first key of numbers; values that all rows share are in no label."""
    rows = [
        {"file": "a", "word": word, "cells": cells, "k": number, "nu": 0.3}
        | {"outcome": "failed" if number == 9 else "solved", "difference": number / cells}
        for cells in (2, 4)
        for number in range(10, 0, -1)
        for word in "xy"[: 1 + (number == 10)]
    ]
    names = ("word", "cells", "k", "nu")
    figure = sweep.draw_sweep(pd.DataFrame(rows), names)
    (axis,) = figure.axes
    labels = ["word x, k 10", "word y, k 10", *(f"word x, k {k}" for k in (8, 7, 6, 5, 4, 3))]
    assert [line.get_label() for line in axis.lines] == labels
    for line, number in zip(axis.lines, (10, 10, 8, 7, 6, 5, 4, 3), strict=True):
        assert line.get_xydata().tolist() == [[2, 50 * number], [4, 25 * number]]
    assert (axis.get_xlabel(), axis.get_yscale()) == ("cells", "log")
    assert [text.get_text() for text in figure.legends[0].texts] == labels
    # Without a key of numbers, along the rows; without other values, without a legend.
    table = pd.DataFrame(rows[:1] * 3).assign(cells=["a", "b", "b"])
    figure = sweep.draw_sweep(table.assign(cells="a"), ("cells",))
    (axis,) = figure.axes
    assert axis.lines[0].get_xdata().tolist() == [1, 2, 3]
    assert (axis.get_xlabel(), figure.legends) == ("combination", [])
    assert [
        len(line.get_xdata()) for line in sweep.draw_sweep(table, ("cells",)).axes[0].lines
    ] == [
        1,
        2,
    ]


def test_one_that_changes_while_it_is_swept_is_no_row_of_the_old_file(beam):
    case = sweep.Combination(beam, (), "beam.toml")
    row = sweep.solve(case, "of another file")
    assert row.outcome == sweep.DIED
    assert "differs from that of the sweep's start; sweep again, on a cluster with" in row.message


@pytest.mark.parametrize("worst", ["solved", "refused", "failed", "too long", "died"])
def test_exit_code_is_that_of_the_worst_row(program, tmp_path, monkeypatch, worst):
    """Rows in their files; the table of codes is that of docs/command-line.md."""
    monkeypatch.setattr(sweep, "finished_row", lambda row: row)
    rows = [sweep.Row("solved", "agrees"), sweep.Row(worst)]
    monkeypatch.setattr(cases, "run_all", lambda _, todo, *__: zip(todo, rows, strict=False))
    codes = {"solved": 1, "refused": 2, "failed": 3, "too long": 3, "died": 3}
    words = ("--no-plots", "--set", "springs.cells=2,3")
    assert program(*words)[0] == codes[worst]
    assert program("--no-plots", "--set", "springs.cells=2")[0] == 0
    assert len(list((tmp_path / "out/beam-sweep/rows").iterdir())) == 2


def test_rows_over_lists_have_a_table_and_a_picture(program, tmp_path):
    words = ("--set", "load.1.traction=[0.0, -10.0],[0.0, -20.0]")
    assert program(*words)[0] == 1
    assert {"sweep.csv", "sweep.png"} <= {
        path.name for path in (tmp_path / "out/beam-sweep").iterdir()
    }


def test_a_folder_of_others_is_left_alone(program, tmp_path):
    words, folder = ("--set", "springs.cells=2"), tmp_path / "out/beam-sweep"
    folder.mkdir(parents=True)
    (folder / "sweep.csv").write_text("mine", encoding="utf-8")
    code, message = program(*words)
    assert (code, message.count("\n")) == (2, 1)
    assert "holds 'sweep.csv', which no case left there" in message
    assert [path.read_text() for path in folder.iterdir()] == ["mine"]
    (folder / "sweep.csv").unlink()
    assert program(*words)[0] == 1
    other = tmp_path / "other.csv"
    other.write_text("mine", encoding="utf-8")
    (folder / "sweep.csv").unlink()
    (folder / "sweep.csv").symlink_to(other)
    assert program(*words)[0] == 2
    assert other.read_text(encoding="utf-8") == "mine"


def test_files_of_one_name_have_labels(program, tmp_path):
    files = [tmp_path / "d1" / "b.toml", tmp_path / "d2" / "b.toml"]
    for file in files:
        file.parent.mkdir()
        file.write_text(BEAM, encoding="utf-8")
    assert program("--no-plots", "--set", "springs.cells=2", files=files)[0] == 1
    rows = (tmp_path / "out/sweep/sweep.csv").read_text(encoding="utf-8").splitlines()[1:]
    assert [row.split(",")[0] for row in rows] == ["d1/b.toml", "d2/b.toml"]
    assert program("--set", "springs.cells=2", files=[files[0]] * 2)[0] == 2


def test_words_are_values():
    result = sweep.read_values(
        ["a.b=1,2.5", 'c=["x", "y"],["x"]', "d=linear,nonlinear", "e=-.5,true", "f=8,x,.5"]
    )
    assert result == {
        "a.b": [1, 2.5], "c": [["x", "y"], ["x"]], "d": ["linear", "nonlinear"], "e": [-0.5, True],
        "f": [8, "x", 0.5],
    }  # fmt: skip
    for words in (["a"], ["=1"], ["a="], ["a.=1"], ["a=1", "a=2"], ["a=2,2"]):
        with pytest.raises(ProblemError, match="--set"):
            sweep.read_values(words)


def test_one_clear_line(program, tmp_path):
    for words, part in (
        (("--set", "load.3.pressure=1"), "--set load.3.pressure: no such place in beam.toml"),
        (("--set", "springs.cells"), "--set 'springs.cells': give key=value,value"),
        (("--set", "springs\n.cells"), r"--set 'springs\n.cells': give key=value,value"),
        (("--set", "springs.cells=2", "--limit", "-1"), "--limit: -1.0 s"),
    ):
        code, message = program(*words)
        assert code == 2
        assert part in message
        assert message.count("\n") == 1
    assert program("--set", "springs.sells=2")[0] == 2
    table = (tmp_path / "out/beam-sweep/sweep.csv").read_text(encoding="utf-8")
    assert "sells: no such key; did you mean cells?" in table
