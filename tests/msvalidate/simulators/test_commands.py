"""The command line of simulators: from nothing to a verdict, exit codes, nothing overwritten."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

from tests.table import stored_rows, table
from tests.test_command_line import PROGRAM, run

EXAMPLES = Path(__file__).parents[3] / "examples"


def messages(said):
    """Lines of standard error, except progress."""
    progress = re.compile("(?!.* error: ).*: (step|simul|quest|still)|loading libraries")
    return [line for line in said.splitlines() if not progress.match(line)]


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A folder with a space in its name, a case and a new adapter."""
    folder = tmp_path_factory.mktemp("my work")
    shutil.copy(EXAMPLES / "box.toml", folder)
    run("adapter", "new", "toy", cwd=folder)
    return folder


def test_a_new_adapter_says_how_to_go_on(place):
    done = run("adapter", "new", "other", cwd=place)
    assert (done.returncode, done.stdout) == (0, "")
    assert done.stderr.startswith("other.py written; it runs as it is: ")
    assert done.stderr.endswith(" adapter check other.py\n")


def test_the_template_is_judged_at_once(place):
    words = ("simulate", "box.toml", "--with", "toy.py", "--cells", "10", "--no-plots")
    done = run(*words, cwd=place)
    assert done.returncode == 0, done.stderr
    # Linear tetrahedra are too stiff.
    assert re.match(r"toy: The field is uniformly [0-9.]+ % too stiff\.\n", done.stdout)
    folder = place / "reports" / "simulators"
    verdict = json.loads((folder / "box-toy" / "verdict.json").read_text(encoding="utf-8"))
    assert verdict["verdict"] == "agrees"
    assert 0 < verdict["rest"] < 1e-6
    page = (folder / "box-toy" / "case.html").read_text(encoding="utf-8")
    for text in ("linear elasticity, toy solver of the template", "451 of 800 triangle"):
        assert text in page
    assert str(place) not in page
    kept = {path.name for path in (folder / "box-toy-run" / "out").iterdir()}
    assert kept == {"log.txt", "result.json", "result.npz"}
    again = run(*words, "-q", cwd=place)
    assert (again.returncode, again.stdout, again.stderr) == (0, "", "")


def test_a_case_is_exported_whole(place):
    words = ("case", "export", "box.toml", "for them", "--cells", "3", "--springs")
    done = run(*words, "--setting", "law=neo", "--setting", "n=[1,2]", cwd=place)
    assert done.returncode == 0, done.stderr
    assert done.stderr == "for them: mesh of 36 quad cells, 4 x 1 m, 52 nodes\n"
    written = {path.name for path in (place / "for them").iterdir()}
    assert written == {
        *("request.json", "points.csv", "cells.csv", "nodal.csv", "springs.csv"),
        *("mesh.vtu", "mesh.msh", "mesh.inp", "case.toml"),
    }
    about = json.loads((place / "for them" / "request.json").read_text(encoding="utf-8"))
    assert about["settings"] == {"law": "neo", "n": [1, 2]}
    assert run(*words, cwd=place).returncode == 0  # its own export is replaced


ENDS = {
    "soft.py": "sys.argv[0]",
    "ends_77.py": "sys.exit(print('no clamps', file=sys.stderr) or 77)",
    "ends_1.py": "sys.exit('it diverged')",
}


@table(("words", "code", "told"), stored_rows("simulator_commands"))
def test_what_goes_wrong_is_one_line_and_a_code(place, words, code, told):
    for name, body in ENDS.items():
        (place / name).write_text(f"import sys\n{body}\n", encoding="utf-8")
    done = run(*words, cwd=place)
    said = done.stdout + done.stderr
    assert (done.returncode, told in said) == (code, True), said
    assert "Traceback" not in said
    if code > 1:
        assert len(messages(done.stderr)) == 1


# Check --------------------------------------------------------------------------------------------

LAW = "mu, lam = E / (2 + 2 * nu), E * nu / ((1 + nu) * (1 - 2 * nu))"
MOVES = 'if request["task"] == "motion" and request["steps"] > 1:'
VARIANTS = {
    "lame": (LAW, f"{LAW[:-1]}) - E / (2 + 2 * nu)"),
    "deaf": ('material["E"],', "2e7,"),
    "rest": (MOVES, 'if request["task"] == "motion":'),
    "fails": ('answer["displacement"], rest', 'raise SystemExit("it diverged")\n    u, rest'),
    "hangs": ('answer["displacement"], rest', "time.sleep(60)\n    u, rest"),
}
"""Name of an adapter -> what of the template is another in it, and what stands there."""


@pytest.fixture(scope="module")
def adapters(place):
    """The template with one change each."""
    text = (place / "toy.py").read_text(encoding="utf-8")
    for name, (old, new) in VARIANTS.items():
        (place / f"{name}.py").write_text(text.replace(old, new), encoding="utf-8")
    return place


def test_the_template_has_what_its_variants_change(place):
    text = (place / "toy.py").read_text(encoding="utf-8")
    assert [name for name, (old, _) in VARIANTS.items() if text.count(old) != 1] == []


@pytest.mark.slow
@table("name, words, code, said", stored_rows("adapter_checks"))
def test_what_is_said_of_adapters(adapters, name, words, code, said):
    done = run("adapter", "check", f"{name}.py", *words, cwd=adapters)
    told = " ".join(done.stdout.split())
    assert (done.returncode, " ".join(said.split()) in told) == (code, True), done.stdout
    assert all(": question " in each for each in done.stderr.splitlines())
    assert "\nnext: " in done.stdout


@pytest.mark.slow
def test_an_adapter_is_checked_and_leaves_a_page(adapters):
    words = ("--law", "linear", "--out", "checked", "--E", "2e5")
    done = run("adapter", "check", "toy.py", *words, "--density", "900", cwd=adapters)
    assert done.returncode == 0, done.stderr
    head = "toy: the law agrees; the coarse mesh makes an error of 49 % in the bent beam\n"
    assert done.stdout.startswith(head)
    log = (adapters / "checked" / "toy-check.log").read_text(encoding="utf-8")
    numbers = list(map(int, re.findall(": question ([0-9]+)", log)))
    assert numbers == list(range(1, len(numbers) + 1))
    assert len(numbers) > 50
    assert " left, " in log
    found = json.loads((adapters / "checked/toy-check/check.json").read_text(encoding="utf-8"))
    assert found["large"]["apart"] < 1e-8
    assert found["probe"]["E"] == pytest.approx(2e5, rel=1e-6)
    folder = adapters / "checked" / "toy-check"
    page = (folder / "check.html").read_text(encoding="utf-8")
    assert page.count("<td") > 60
    assert "data:image/svg+xml" in page
    assert str(adapters) not in page


@pytest.mark.slow
def test_the_workflow_of_the_documents_notices_a_law_that_moves(adapters):
    page = (EXAMPLES.parent / "docs" / "baselines.md").read_text(encoding="utf-8")
    (line,) = re.findall(r"- run: python -m msvalidate (adapter check .*)", page)
    assert "mine.py --law neo-raw --baseline baseline --junit report.xml" in line
    command = line.replace("mine.py", "lame.py").split()
    only = ("--only", "probe")
    first = run(*command, *only, "--update", "--reason", "first", cwd=adapters)
    assert first.returncode == 0, first.stderr
    assert run(*command, *only, cwd=adapters).returncode == 0
    text = (adapters / "lame.py").read_text(encoding="utf-8")
    (adapters / "lame.py").write_text(
        text.replace('material["E"],', '1.01 * material["E"],'), encoding="utf-8"
    )
    moved = run(*command, *only, cwd=adapters)
    (adapters / "lame.py").write_text(text, encoding="utf-8")
    assert moved.returncode == 1
    assert "baseline law.csv: E, row 0: was " in moved.stderr
    suite = ET.parse(adapters / "report.xml").find("testsuite")  # noqa: S314  our own
    failed = [case.get("name") for case in suite if case.find("failure") is not None]
    assert "law.csv" in failed


@table(
    "text, words, code, said",
    stored_rows("adapters_refused"),
)
def test_adapters_that_cannot_be_checked(place, text, words, code, said):
    (place / "bad.py").write_text(text, encoding="utf-8")
    done = run("adapter", "check", "bad.py", *words, cwd=place)
    assert (done.returncode, done.stdout) == (code, "")
    assert said in done.stderr
    assert len(messages(done.stderr)) == 1


def test_a_crash_in_one_question_is_no_baseline(adapters):
    words = ("--baseline", "none", "--update", "--reason", "x", "--junit", "crash.xml")
    done = run("adapter", "check", "fails.py", "--only", "gate", *words, cwd=adapters)
    assert done.returncode == 3
    assert "baseline unchanged: fails has no result" in done.stderr
    assert not (adapters / "none").exists()
    suite = ET.parse(adapters / "crash.xml").find("testsuite")  # noqa: S314  our own
    assert suite.get("errors") == "1"


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks the system for processes")
def test_an_interrupt_ends_a_check_in_one_line(place):
    text = "import os, time; open('../../../pid', 'w').write(str(os.getpid())); time.sleep(60)"
    (place / "slow.py").write_text(text, encoding="utf-8")
    command = [*PROGRAM, "adapter", "check", "slow.py", "--out", "."]
    told = place / "pid"
    with subprocess.Popen(command, cwd=place, stderr=subprocess.PIPE, text=True) as ours:
        for _ in range(300):
            if told.exists() and told.read_text(encoding="utf-8"):
                break
            time.sleep(0.1)
        ours.send_signal(signal.SIGINT)
        _, said = ours.communicate(timeout=20)
    assert ours.returncode == 130
    assert len(messages(said)) == 1
    assert said.endswith("interrupted; results are as they were\n")
    assert ended(told.read_text(encoding="utf-8").strip())


# Side by side, and killed ------------------------------------------------------------------------

SCALED = """
import csv, json, sys, time
case, out = sys.argv[1:]
k = json.load(open(case + "/request.json"))["settings"]["k"]
time.sleep(0.2)
with open(case + "/points.csv") as points, open(out + "/result.csv", "w") as file:
    rows = [[1e-3 * k * float(x) for x in row[1:]] for row in [*csv.reader(points)][1:]]
    csv.writer(file).writerows([["ux", "uy"], *rows])
about = dict(simulator=f"scaled {k}", version="1", law="", precision="float64")
json.dump(about, open(out + "/result.json", "w"))
"""
SLEEPS = """
import os, subprocess, sys, time
child = subprocess.Popen(["sleep", "300"])
print(os.getpid(), child.pid, file=open(os.environ["PIDS"] + ".new", "w"), flush=True)
os.replace(os.environ["PIDS"] + ".new", os.environ["PIDS"])
time.sleep(300)
"""
SIMULATE = [*PROGRAM, "simulate", "box.toml", "--cells", "2", "--no-plots", "--with"]
OFTEN = [1, pytest.param(20, marks=pytest.mark.slow)]


@pytest.mark.parametrize("pairs", OFTEN)
def test_runs_at_once_each_tell_their_own_answer(place, pairs):
    (place / "scaled.py").write_text(SCALED, encoding="utf-8")
    for pair in range(pairs):
        words = {k: ["scaled.py", "--setting", f"k={k}"] for k in (2 * pair + 1, 2 * pair + 2)}
        runs = {
            k: subprocess.Popen([*SIMULATE, *more], cwd=place, stdout=subprocess.PIPE, text=True)
            for k, more in words.items()
        }
        for k, ours in runs.items():
            said, _ = ours.communicate(timeout=60)
            assert (ours.returncode, said.split(":")[0]) == (1, f"scaled {k}")
            (results,) = (place / "reports" / "simulators").glob(f"box-scaled-k-{k}-{8 * '?'}")
            verdict = json.loads((results / "verdict.json").read_text(encoding="utf-8"))
            left = results.with_name(f"{results.name}-run") / "out" / "result.json"
            told = json.loads(left.read_text(encoding="utf-8"))["simulator"]
            assert verdict["result"] == told == f"scaled {k}"


def test_settings_that_a_folder_cannot_spell_have_folders_of_their_own(place):
    (place / "scaled.py").write_text(SCALED, encoding="utf-8")
    for k in ("k=-3", "k=3", "s-1=3", "s=1-3"):
        words = ("scaled.py", "--setting", "k=1", "--setting", k, "--out", "named", "-q")
        run(*SIMULATE[len(PROGRAM) :], *words, cwd=place)
    found = {path.name.removesuffix("-run") for path in (place / "named").glob("box-scaled-k*3*/")}
    assert len(found) == 4


def ended(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").split(")")[1].split()[0] == "Z"
    except FileNotFoundError:
        return True


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks the system for processes")
@pytest.mark.parametrize("times", OFTEN)
@pytest.mark.parametrize("name", ["SIGTERM", "SIGHUP", "SIGINT", "SIGKILL"])
def test_a_simulator_ends_with_us_however_we_end(place, tmp_path, name, times):
    (place / "sleeps.py").write_text(SLEEPS, encoding="utf-8")
    for number in range(times):
        told = tmp_path / f"{number}"
        own = os.environ | {"PIDS": str(told)}
        with subprocess.Popen(
            [*SIMULATE, "sleeps.py"], cwd=place, env=own, stderr=subprocess.DEVNULL
        ) as ours:
            began = time.monotonic()
            while not told.exists():
                assert time.monotonic() - began < 30
                time.sleep(0.02)
            ours.send_signal(getattr(signal, name))
        pids, killed = told.read_text(encoding="utf-8").split(), time.monotonic()
        while not all(map(ended, pids)):
            assert time.monotonic() - killed < 2, name
            time.sleep(0.01)
    left = [path.name for path in (place / "reports" / "simulators").glob(".msvalidate-run-*")]
    assert len(left) <= 1  # of the last run alone: each clears away what a killed one left
