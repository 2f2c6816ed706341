"""Studies side by side: the same bytes, one line each as it ends, deaths, interrupts and kills.

The studies are small ones under true names; a process that is spawned runs the script again, so
that it has them too.
"""

import json
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).parents[1]
STUDIES = """
import os
import runpy
import signal
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd

from msvalidate.bench.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.bench.judging import catalogue
from msvalidate.bench.output import baseline
from msvalidate.bench.output.figures import new_figure
from msvalidate.problem import ProblemError

baseline.CHECKOUT = Path("base")


def found(setting, **table):
    x = np.random.default_rng(setting.seed).random(9)
    table = pd.DataFrame({"x": x, "wall_seconds": time.perf_counter()} | table)

    def drawn(tables):
        figure, (axis,) = new_figure()
        axis.plot(tables["t"]["x"])
        return figure

    columns = {"x": "place (m)", "wall_seconds": "s", "threads": "those of BLAS"}
    tolerance = Tolerance("gap", 0.5, "m", "so")
    return Evidence({"t": table}, {"gap": Observed(0.1)}, (tolerance,), {"f": drawn}, columns)


def meet(name, other):
    # Neither ends before both have begun: they run side by side, or this takes forever.
    Path(f"{name}.began").touch()
    while "MEET" in os.environ and not Path(f"{other}.began").exists():
        time.sleep(0.01)


def poisson(setting):
    meet("poisson", "stability")
    time.sleep(0.3)  # ends second
    result = found(setting, threads=os.environ["OMP_NUM_THREADS"])
    Path("poisson.ended").touch()
    return result


def stability(setting):
    meet("stability", "poisson")
    return found(setting)


def cost(setting):
    assert "MEET" not in os.environ or Path("poisson.ended").exists()
    return found(setting)


def dies(setting):
    os.kill(os.getpid(), signal.SIGKILL)


def stays(setting):
    Path("stays.pid").write_text(str(os.getpid()))
    time.sleep(100)


def crashes(setting):
    raise ValueError("no such thing")


def ill_posed(setting):
    raise ProblemError("spring constants: -1; give 0 or more")


runs = {STUDIES}
catalogue.names = lambda: [*runs]
catalogue.load = lambda name: SimpleNamespace(run=runs[name], ALONE=name == "cost")
if __name__ == "__main__":
    runpy.run_module("msvalidate.study", run_name="__main__")
"""
THREE = "dict(cost=cost, poisson=poisson, stability=stability)"


def begun(folder, studies, *arguments, verb="all", **variables):
    """The program with these studies, started in a folder; its stderr is the file `log`."""
    script = folder / "script.py"
    script.write_text(STUDIES.replace("{STUDIES}", studies), encoding="utf-8")
    with (folder / "log").open("w") as log, (folder / "printed").open("w") as printed:
        return subprocess.Popen(
            [sys.executable, str(script), verb, "--out", "r", *arguments],
            cwd=folder,
            env=os.environ | {"PYTHONPATH": str(ROOT)} | variables,
            stdout=printed,
            stderr=log,
            # A shell's background job ignores interrupts, and its children with it.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),  # noqa: PLW1509
        )


def read(path):
    return path.read_text(encoding="utf-8")


def messages(folder):
    """Lines of the log, except progress."""
    return [line for line in read(folder / "log").splitlines() if not line.startswith("studies: ")]


def until(condition, what):
    """Wait for something that comes within seconds."""
    end = time.monotonic() + 60
    while not condition():
        assert time.monotonic() < end, what
        time.sleep(0.02)


def gone(pid):
    """Whether a process has ended, if nobody has asked for its exit code yet."""
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return True
    state = Path(f"/proc/{pid}/stat")
    return state.exists() and state.read_text(encoding="utf-8").rpartition(")")[2].split()[0] == "Z"


def content(folder):
    """What must not depend on the number of jobs, file by file."""
    found = {}
    for path in sorted((folder / "r").rglob("*.*")):
        name = path.relative_to(folder / "r").as_posix()
        if path.name == "t.csv":
            found[name] = pd.read_csv(path, dtype=str).drop(columns="wall_seconds").to_csv()
        elif name == "verdict.json":
            found[name] = [row | {"seconds": None} for row in json.loads(path.read_bytes())]
        elif path.name not in {"study.json", "report.html"}:  # which tell when, and how long
            found[name] = path.read_bytes()
    return found


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_any_number_of_jobs_finds_the_same(tmp_path):
    one, two = tmp_path / "1", tmp_path / "2"
    one.mkdir()
    two.mkdir()
    arguments = ("--seed", "5", "--table", "verdict", "--jobs")
    # Numbers of threads that are asked for are not taken by several jobs.
    both = [
        begun(one, THREE, *arguments, "1", OMP_NUM_THREADS="1"),
        begun(two, THREE, *arguments, "2", OMP_NUM_THREADS="3", MEET="1"),
    ]
    assert [each.wait(100) for each in both] == [0, 0], read(one / "log") + read(two / "log")
    assert content(one) == content(two)
    assert len(content(one)) == 3 * 4 + 1
    lines = messages(two)
    ended = [re.sub(r"\d+\.\d s$", "… s", line) for line in lines]
    assert ended[:-1] == [
        "stability: 1 of 1 held, … s",
        "poisson: 1 of 1 held, … s",
        "cost: 1 of 1 held, … s",
        "3 of 3 studies held, theory 3 of 3, … s",
    ]
    assert read(one / "printed") == read(two / "printed") != ""


@pytest.mark.skipif(os.name != "posix", reason="needs kill -9")
def test_a_worker_that_dies_costs_its_study_alone(tmp_path):
    studies = "dict(damping=crashes, poisson=dies, pull_in=ill_posed, stability=found)"
    program = begun(tmp_path, studies, "-v", "--jobs", "2")
    assert program.wait(100) == 3
    log = read(tmp_path / "log")
    assert "error: study poisson: crashed: its process died, killed or out of memory; run" in log
    assert "error: study damping: crashed: ValueError: no such thing" in log
    assert 'raise ValueError("no such thing")' in log, "with -v, where"
    assert "error: study pull_in: spring constants: -1; give 0 or more" in log
    assert re.search(r"^poisson: not finished, \d+\.\d s$", log, re.MULTILINE)
    assert re.search(r"^stability: 1 of 1 held, \d+\.\d s$", log, re.MULTILINE)
    rows = json.loads(read(tmp_path / "r" / "verdict.json"))
    assert [(row["study"], row["verdict"]) for row in rows] == [
        *((name, "fail") for name in ("damping", "poisson", "pull_in")),
        ("stability", "pass"),
    ]


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
@pytest.mark.parametrize(
    ("how", "jobs", "code"),
    [
        (signal.SIGKILL, 2, -9),
        pytest.param(signal.SIGKILL, 1, -9, marks=pytest.mark.slow),
        pytest.param(signal.SIGINT, 2, 130, marks=pytest.mark.slow),
    ],
)
def test_a_run_that_is_ended_has_told_how_far_it_came(how, jobs, code, tmp_path):
    """Killed, it has no time to end its workers: they end themselves."""
    program = begun(tmp_path, "dict(poisson=found, stability=stays)", "--jobs", str(jobs))
    worker = tmp_path / "stays.pid"
    until(lambda: worker.exists() and worker.stat().st_size, "the second study begins")
    until(lambda: "held" in read(tmp_path / "log"), "the first study ends")
    program.send_signal(how)
    assert program.wait(30) == code
    first, *rest = messages(tmp_path)
    assert re.fullmatch(r"poisson: 1 of 1 held, \d+\.\d s", first)
    assert len(rest) == (how == signal.SIGINT), rest
    assert "Traceback" not in "".join(rest)
    until(lambda: gone(int(read(worker))), "workers have ended")
    assert not (tmp_path / "r").exists()


@pytest.mark.skipif(os.name != "posix", reason="needs signals")
def test_check_says_of_each_study_what_the_baseline_says(tmp_path):
    """Compared as it ends: what its line says is its verdict."""
    folder = tmp_path / "base" / "quick" / "stability"
    folder.mkdir(parents=True)
    (folder / "t.csv").write_text("x\n" + "0.5\n" * 9, encoding="utf-8")
    program = begun(tmp_path, "dict(poisson=found, stability=found)", "--jobs", "2", verb="check")
    assert program.wait(100) == 4
    log = read(tmp_path / "log")
    assert "study poisson: no quick baseline, nothing compared; make one with check" in log
    assert "stability: FAIL t.csv: " in log
    assert re.search(r"^stability: FAILED, \d rows: \d held, \d missed, ", log, re.MULTILINE)
