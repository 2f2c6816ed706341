"""`report.sweep`: combinations of a case file's values, each a row, and its journal."""

from __future__ import annotations

import multiprocessing
import re
import threading
import time
from pathlib import Path

import pytest

from msvalidate.case.report import sweep
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
    """Runs the command on the beam; exit code, and what it says."""

    def run(*words):
        code = main(["case", "run", str(beam), "--out", str(tmp_path / "out"), *words])
        return code, capsys.readouterr().err

    return run


def without_seconds(text):
    return re.sub(r"[0-9.]+$", "", text, flags=re.MULTILINE)


def test_every_combination_is_a_row_however_it_is_run(program, beam, tmp_path):
    words = ("--set", "springs.cells=2,3", "--set", "material.nu=.3,.6")
    assert program(*words)[0] == 0
    table = (tmp_path / "out/beam-sweep/sweep.csv").read_text(encoding="utf-8")
    rows = table.splitlines()
    assert len(rows) == 5
    assert rows[1].startswith("beam.toml,2,0.3,solved,")
    assert "beam.toml,3,0.6,refused" in rows[4]
    assert "nu" in rows[4]
    assert (tmp_path / "out/beam-sweep/sweep.svg").is_file()
    journal = tmp_path / "out/beam-sweep/journal.jsonl"
    lines = journal.read_text(encoding="utf-8").splitlines()
    # Killed in the middle of a line: what is known is not solved again, and the table is the same.
    journal.write_text("\n".join(lines[:2]) + "\n" + lines[2][:30], encoding="utf-8")
    again = program(*words, "--jobs", "2")[1]
    assert again.count("beam.toml springs.cells") == 2
    other = (tmp_path / "out/beam-sweep/sweep.csv").read_text(encoding="utf-8")
    assert without_seconds(other) == without_seconds(table)
    assert "beam.toml springs.cells" not in program(*words)[1]
    beam.write_text(BEAM.replace("-10]", "-20]"), encoding="utf-8")
    assert program(*words)[1].count("beam.toml springs.cells") == 4


def test_one_that_is_late_and_one_that_is_killed_are_rows(beam):
    asked = list(sweep.combinations([beam], {"springs.cells": [400, 2, 3]}))
    workers = sweep.Workers(1)

    def kill():
        time.sleep(0.3)
        multiprocessing.active_children()[0].kill()

    try:
        late = dict(sweep.run_all(iter(asked[:2]), workers, 1.0))
        workers.slots = [sweep.Workers._made()]
        workers.slots[0].submit(sweep._stamp).result()
        killer = threading.Thread(target=kill)
        killer.start()
        dead = dict(sweep.run_all(iter([asked[0], asked[2]]), workers, 60.0))
        killer.join()
    finally:
        workers.close()
    assert [row["outcome"] for row in late.values()] == [sweep.LATE, sweep.SOLVED]
    assert [row["outcome"] for row in dead.values()] == [sweep.DIED, sweep.SOLVED]


def test_words_are_values():
    found = sweep.read_values(
        ["a.b=1,2.5", 'c=["x", "y"],["x"]', "d=linear,nonlinear", "e=-.5,true"]
    )
    assert found == {
        "a.b": [1, 2.5], "c": [["x", "y"], ["x"]], "d": ["linear", "nonlinear"], "e": [-0.5, True],
    }  # fmt: skip
    for words in (["a"], ["=1"], ["a="], ["a.=1"], ["a=1", "a=2"]):
        with pytest.raises(ProblemError, match="--set"):
            sweep.read_values(words)


def test_one_clear_line(program, tmp_path):
    for words, said in (
        (("--set", "load.3.pressure=1"), "--set load.3.pressure: no such place in beam.toml"),
        (("--set", "springs.cells"), "--set springs.cells: give key=value,value"),
        (("--set", "springs.cells=2", "--jobs", "0"), "--jobs: 0"),
        (("--set", "springs.cells=2", "--limit", "-1"), "--limit: -1.0 s"),
    ):
        code, told = program(*words)
        assert code == 2
        assert said in told
        assert told.count("\n") == 1
    assert program("--set", "springs.sells=2")[0] == 0
    table = (tmp_path / "out/beam-sweep/sweep.csv").read_text(encoding="utf-8")
    assert "sells: no such key; did you mean cells?" in table
