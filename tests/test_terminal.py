"""Every command of the program: width of its lines, progress on standard error, and its log."""

import json
import time

import pytest

from msvalidate.case.report.screen import MAX_LINES
from msvalidate.cli import progress
from msvalidate.cli.arguments import COMMANDS, options_of
from msvalidate.cli.program import main
from msvalidate.linear_algebra.factor import silence_library
from msvalidate.problem.progress import report_stage, report_step
from msvalidate.simulators.exchange import program
from msvalidate_check.text import WIDTH
from tests.msvalidate.case.report.test_sweep import BEAM
from tests.test_documents import run_in_process

RUNS = {
    "study new": "own_study",
    "run": "own_study --studies . --quick --no-plots --out r",
    "check": "own_study --studies . --no-plots --out r",
    "report": "--out r",
    "list": "",
    "advise": "--E 1e6 --nu .3 --spacing 1cm --engine springs",
    "case new": "mine",
    "case run": "beam.toml --out out --no-plots",
    "case judge": "beam.toml zero.csv --out out --no-plots",
    "case export": "beam.toml exported --to json",
    "case schema": "",
    "adapter new": "toy",
    "adapter laws": "",
    "simulate": "beam.toml --with toy.py --cells 2 --out out --no-plots",
    "adapter check": "toy.py --only gate --out out --no-plots",
}
"""Command -> its words, in an order in which each finds its files."""
LOGS = {
    "run": "r.log",
    "check": "r.log",
    "case run": "out/beam.log",
    "case judge": "out/beam-zero.log",
    "case export": "exported.log",
    "simulate": "out/beam-toy.log",
    "adapter check": "out/toy-check.log",
}
"""Command that may take more than five seconds -> its log."""
DATA = {"case schema"}
"""Commands that print JSON, whose lines are not read by people."""


def test_every_command_has_narrow_lines_and_progress_apart(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(progress, "PAUSE", 0.0)
    monkeypatch.setattr(program, "run_limited", run_in_process)
    (tmp_path / "beam.toml").write_text(BEAM, encoding="utf-8")
    (tmp_path / "zero.csv").write_text("x,y,ux,uy\n1,0,0,0\n2,0,0,1e-9\n", encoding="utf-8")
    assert set(RUNS) == {name for name, command in COMMANDS.items() if "act" in command}
    for name, words in RUNS.items():
        assert main([*name.split(), *words.split()]) != 2, name
        out, err = capsys.readouterr()
        assert all(len(line) <= WIDTH for line in (out + err).splitlines()) or name in DATA, out
        if name == "case run":
            assert len(out.splitlines()) <= MAX_LINES
        if name in LOGS:
            log = (tmp_path / LOGS[name]).read_text(encoding="utf-8").splitlines()
            steps = [line[len("2026-01-01 00:00:00 ") :] for line in log]
            assert steps, name
            assert set(steps) <= set(err.splitlines())
            assert not set(steps) & set(out.splitlines())
        if name in options_of(name).get("--json", {"of": []}).get("of", [name]):
            main([*name.split(), *words.split(), "--json"])
            assert json.loads(capsys.readouterr().out), name


@pytest.mark.parametrize("shown", [True, False])
def test_a_long_step_repeats_its_line_while_a_library_is_silenced(
    shown, tmp_path, monkeypatch, capfd
):
    monkeypatch.setattr(progress, "PAUSE", 0.01)
    monkeypatch.setattr(progress, "SILENCE", 0.05)
    log = tmp_path / "runs" / "part.log"
    with progress.Progress("part", shown=shown, log=log), silence_library():
        report_stage("elements", ("springs", "elements"), ("springs", "elements"))
        report_step("mesh %d", 2)
        time.sleep(0.3)
    report_step("nobody listens")
    out, err = capfd.readouterr()
    assert out == ""
    again = "part: still on: step 2 of 2, springs, elements: mesh 2; 0 s\n"
    assert (again in err) == shown
    assert again in log.read_text(encoding="utf-8")
    assert "nobody" not in err + log.read_text(encoding="utf-8")
