"""The project that others copy runs in an environment with NumPy, pytest and the wheel alone."""

from __future__ import annotations

import os
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

CHECKER = Path(__file__).resolve().parents[2] / "checker"


def finish(command, folder, **more):
    return subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, timeout=600, **more
    )


@pytest.fixture
def project(tmp_path):
    """A copy of the example, with the wheel where its workflow looks for it."""
    copy = tmp_path / "project"
    shutil.copytree(CHECKER / "example", copy)
    options = ["--quiet", "--no-deps", "--wheel-dir", copy / "wheels", CHECKER]
    built = finish([sys.executable, "-m", "pip", "wheel", *options], tmp_path)
    if built.returncode and "No matching distribution found for hatchling" in built.stderr:
        pytest.skip("no wheel can be built here: hatchling cannot be had")
    assert built.returncode == 0, built.stderr
    return copy


@pytest.mark.slow
def test_the_example_runs_in_a_bare_environment(project, tmp_path):
    """By the very commands of its workflow."""
    bare, began = tmp_path / "bare", time.perf_counter()
    assert finish([sys.executable, "-m", "venv", bare], tmp_path).returncode == 0
    ours = ("PYTHON", "PYTEST", "VIRTUAL")
    kept = {name: value for name, value in os.environ.items() if not name.startswith(ours)}
    bare_first = kept | {"PATH": f"{bare / 'bin'}{os.pathsep}{kept['PATH']}"}
    workflow = (project / "workflow.yml").read_text(encoding="utf-8").splitlines()
    install, test = [line.partition("run: ")[2] for line in workflow if "- run: " in line]
    done = finish(["bash", "-c", install], project, env=bare_first)
    if "No matching distribution" in done.stderr:
        pytest.skip(f"no packages can be installed here: {done.stderr.splitlines()[-1]}")
    assert done.returncode == 0, done.stderr
    installed, began = time.perf_counter() - began, time.perf_counter()
    done = finish(["bash", "-c", test], project, env=bare_first)
    seconds = time.perf_counter() - began
    assert done.returncode == 0, done.stdout
    listed = finish(shlex.split("python -m pip list --format=freeze"), project, env=bare_first)
    names = {line.partition("==")[0] for line in listed.stdout.split()}
    assert {"numpy", "pytest", "msvalidate-check"} <= names
    assert not {"scipy", "pandas", "numba", "scikit-fem", "msvalidate"} & names
    (wheel,) = (project / "wheels").glob("*.whl")
    kilobytes = wheel.stat().st_size / 1e3
    assert kilobytes < 1000
    size = sum(path.stat().st_size for path in bare.rglob("*") if path.is_file()) / 1e6
    sys.stdout.write(
        f"\nwheel {kilobytes:.0f} kB; environment {size:.0f} MB, made in {installed:.0f} s; "
        f"tests {seconds:.1f} s: {done.stdout.splitlines()[-1]}\n"
    )
