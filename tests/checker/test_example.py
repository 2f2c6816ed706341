"""The project that others copy runs in an environment with NumPy, pytest and the wheel alone."""

from __future__ import annotations

import itertools
import math
import os
import runpy
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

CHECKER = Path(__file__).resolve().parents[2] / "checker"


def kuhn(d):
    """The unit square in 2 triangles, or cube in 6 tetrahedra: points (n, d) in m, cells."""
    points = np.array(list(itertools.product((0.0, 1.0), repeat=d)))
    steps = 2 ** np.arange(d)
    walks = [np.cumsum([0, *order]) for order in itertools.permutations(steps)]
    return points, np.array(walks)


@pytest.mark.parametrize(
    ("state", "E_seen", "nu_seen"),
    [
        ("plane_stress", 2.0, 0.3),
        ("plane_strain", 2.0 / (1 - 0.3**2), 0.3 / (1 - 0.3)),
        ("space", 2.0, 0.3),
    ],
)
def test_its_solver_stretches_a_block_as_the_closed_form_says(state, E_seen, nu_seen):
    solve = runpy.run_path(str(CHECKER / "example" / "my_solver.py"))["solve"]
    points, cells = kuhn(3 if state == "space" else 2)
    d, thickness = points.shape[1], 1.0 if state == "space" else 0.5
    force = np.zeros_like(points)
    for cell in cells:  # a traction of 1 Pa on x = 1 m
        face = [point for point in cell if points[point, 0] == 1.0]
        if len(face) == d:
            force[face, 0] += thickness / math.factorial(d - 1) / d
    u = solve(points, cells, 2.0, 0.3, state, thickness, force, points == 0, 0.0)
    strain = np.array([1.0, *[-nu_seen] * (d - 1)]) / E_seen
    np.testing.assert_allclose(u, points * strain, atol=1e-14)


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
