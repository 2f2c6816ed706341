"""Adapters of all kinds in processes of their own: whatever they do, an answer or one line."""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np
import pytest

from msvalidate.case.file.case import Case
from msvalidate.problem import Box, Isotropic, Problem, ProblemError, Support, Traction
from msvalidate.simulators.exchange.export import export_case
from msvalidate.simulators.exchange.program import Program, label_of, words_of
from msvalidate.simulators.exchange.protocol import CannotRepresent, SimulatorError
from msvalidate.simulators.exchange.template import adapter_template
from msvalidate.springs.bodies.process import STORED
from reference_fem import box_discretisation, solve_problem
from tests.table import table

BOX = Box((1.0, 1.0, 1.0))
PROBLEM = Problem(
    BOX,
    Isotropic(1e5, 0.3, "solid"),
    (Support(BOX.side("left"), (0.0, 0.0, 1e-3)),),
    (Traction(BOX.side("right"), (1e3, 0.0, 100.0)),),
    "cube",
)
REQUEST = export_case(Case(PROBLEM), cells=3)

HEAD = """\
import json, os, sys, time
import numpy as np
case, out = sys.argv[1:]
n = json.load(open(case + "/request.json"))["nodes"]
u = np.zeros((n, 3))
def leave(name="result.npz", **more):
    np.savez(out + "/" + name, displacement=u)
    about = dict(simulator="s", version="1", law="l", precision="float64", **more)
    json.dump(about, open(out + "/result.json", "w"))
"""


def adapter(folder, body, name="own adapter.py"):
    path = folder / name
    path.write_text(HEAD + body, encoding="utf-8")
    return f"'{path}'"


def test_the_template_is_elasticity_as_it_is(tmp_path):
    path = tmp_path / "mine.py"
    path.write_text(adapter_template("mine"), encoding="utf-8")
    answer = Program(str(path))(REQUEST)
    body = box_discretisation(BOX, 3, "T1")
    own = solve_problem(PROBLEM, body, allow_locked=True).at(REQUEST.mesh.points)
    assert np.abs(answer.displacement - own).max() <= 1e-9 * np.abs(own).max()
    assert answer.about["simulator"] == "mine"
    assert len(adapter_template("mine").splitlines()) <= 95


BAD = [
    ("time.sleep(100)", SimulatorError, "not done after 1 s"),
    ("raise ValueError('dt too\\nlarge')", SimulatorError, "exit code 1: large"),
    ("sys.exit(3)", SimulatorError, "exit code 3: no word on stderr"),
    ("os.kill(os.getpid(), 11)", SimulatorError, "ended by the system (Segmentation fault)"),
    ("print('no tets\\n', file=sys.stderr); sys.exit(77)", CannotRepresent, "no tets"),
    ("sys.exit(77)", CannotRepresent, "it does not say why"),
    ("u[3, 1] = np.nan; leave()", SimulatorError, "displacement nan at node 3"),
    ("leave(); os.truncate(out + '/result.npz', 200)", SimulatorError, "not whole arrays"),
    ("leave('other.npz')", SimulatorError, "no result; write one of"),
    ("leave(); os.remove(out + '/result.json')", SimulatorError, "no result.json"),
    ("leave('a.npz'); os.mkfifo(out + '/result.npz')", SimulatorError, "no result"),
    ("sys.stderr.write('a\\x1b[31mb\\n'); sys.exit(1)", SimulatorError, "code 1: a\ufffd[31mb"),
]  # fmt: skip


@table(("body", "kind", "words"), BAD)
def test_what_goes_wrong_is_one_line(tmp_path, body, kind, words):
    command = adapter(tmp_path, body)
    limit = 1.0 if "sleep" in body else 60.0
    with pytest.raises(kind) as found:
        Program(command, limit)(REQUEST)
    assert words in str(found.value)
    assert "\n" not in str(found.value)


def alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").split(")")[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


CHILD = "import subprocess; p = subprocess.Popen(['sleep', '300']); print(p.pid, flush=True)\n"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks the system for processes")
@pytest.mark.parametrize("ending", ["time.sleep(300)", "leave()"])
def test_children_end_with_their_adapter(tmp_path, ending):
    keep, began = tmp_path / "kept", time.monotonic()
    program = Program(adapter(tmp_path, CHILD + ending), 2.0, keep)
    if "sleep" in ending:
        with pytest.raises(SimulatorError, match="not done"):
            program(REQUEST)
    else:
        program(REQUEST)
    pid = int((keep / "out" / "log.txt").read_text(encoding="utf-8").split()[1])
    assert not alive(pid)
    assert time.monotonic() - began < 20


def test_100_megabytes_of_words_are_read_and_not_kept(tmp_path):
    body = "for _ in range(1600): os.write(1, b'x' * 65536)\nprint('last'); leave()"
    answer = Program(adapter(tmp_path, body), 60.0, tmp_path / "kept")(REQUEST)
    assert answer.displacement.shape == REQUEST.mesh.points.shape
    log = (tmp_path / "kept" / "out" / "log.txt").read_bytes()
    assert len(log) < 4 * STORED
    assert b"bytes left out" in log
    assert b"last" in log


def test_what_is_kept_is_the_latest_call_and_no_other_peoples_files(tmp_path):
    keep = tmp_path / "kept here"
    good = adapter(tmp_path, "assert os.getcwd() == os.path.realpath(out); leave()")
    Program(good, keep=keep)(REQUEST)
    with pytest.raises(SimulatorError):
        Program(adapter(tmp_path, "sys.exit(1)", "bad.py"), keep=keep)(REQUEST)
    assert sorted(path.name for path in (keep / "out").iterdir()) == ["log.txt"]
    (tmp_path / "own" / "out").mkdir(parents=True)
    (tmp_path / "own" / "out" / "thesis").write_text("", encoding="utf-8")
    with pytest.raises(ProblemError, match="what no adapter left there"):
        Program(good, keep=tmp_path / "own")(REQUEST)
    assert (tmp_path / "own" / "out" / "thesis").exists()
    (keep / "notes").write_text("", encoding="utf-8")
    with pytest.raises(ProblemError, match="what no adapter left there"):
        Program(good, keep=keep)(REQUEST)
    assert (keep / "notes").exists()


COMMANDS = [
    ("", "no program; give a command"),
    ("   ", "no program; give a command"),
    ("'a", "No closing quotation; close it"),
    ("no_such_program_here", "no such program"),
    ("a\0b", "no program"),
    ("/", "no such program"),
]


@table(("command", "words"), COMMANDS)
def test_commands_that_are_none(command, words):
    with pytest.raises(ProblemError) as found:
        Program(command)
    assert words in str(found.value)


def test_a_command_is_no_shells(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    adapter(tmp_path, "assert len(sys.argv) == 3; leave()", "$(touch x); y.py")
    words = words_of("'./$(touch x); y.py' a;b")
    assert words == [sys.executable, str(tmp_path / "$(touch x); y.py"), "a;b"]
    Program("'$(touch x); y.py'")(REQUEST)
    assert [path.name for path in tmp_path.iterdir()] == ["$(touch x); y.py"]
    assert label_of("'$(touch x); y.py' a") == "$(touch x); y"
