"""What a fresh process takes: the command line's answer, compilation, a large body's memory."""

from __future__ import annotations

import os
import subprocess
import sys
from typing import Any

import pandas as pd

from msvalidate.judging.sweep import Setting
from msvalidate.problem import SolverError

from . import kernel
from .timing import ROUNDS

BARE = ("-c", "pass")
ASKED = {
    "--help": ("-m", "msvalidate.study", "--help"),
    "list": ("-m", "msvalidate.study", "list"),
}
# The cache is left out: it has nothing, and keeps nothing.
COMPILED = """
import time
from contextlib import ExitStack
from msvalidate import kernels
from msvalidate.kernels.cache import KernelCache
KernelCache.load_overload = KernelCache.save_overload = lambda *given: None
from msvalidate.studies.cost import bodies, kernel
nets = {name: bodies.network(name, 100) for name in NAMES}
start = time.process_time()
for name, net in nets.items():
    for way in kernel.WAYS[name]:
        if way in kernel.OURS:
            kernel.stepping_function(kernels.Motion, way, net, 2, ExitStack())()
    kernels.Motion(net, path="general").force_and_energy(*bodies.start(net))
    kernels.curvature(net, *bodies.start(net))
print(time.process_time() - start)
"""
"""Prints the seconds of the first call of kernels without a cache, of the networks NAMES:
compilation and little more."""
FIRST_RUN = ("lattice",)
"""Networks of a first run: springs in the plane, by the path of uniform lattices and the general
one. Numba compiles a form when it is first called, so no run compiles what it does not take."""
# The kernel's own count would begin with the memory of the process that started this one.
PEAK = """
from pathlib import Path
told = Path("/proc/self/status").read_text().split("VmHWM:")[1]
print(int(told.split()[0]) / 2**20)
"""
LARGE = """
from reference_fem.elasticity import stiffness
from msvalidate.studies.cost import fem, fem_ways
given = fem.block(3, 45)
K = stiffness(given.body, given.material)
fem_ways.by("auto", given.body, K, given.held, given.force)
"""
"""Solves 2.9e5 unknowns of elements in space."""
SPRINGS = """
from msvalidate.statics.equilibrium import equilibrium
from msvalidate.studies.cost import bodies
equilibrium(bodies.cube(100_000))
"""
"""Brings 1e5 points of springs in space to rest."""
FULL = {
    "compilation, first run": (f"NAMES = {FIRST_RUN!r}\n{COMPILED}", 3),
    "compilation, every form": (f"NAMES = {tuple(kernel.WAYS)!r}\n{COMPILED}", 1),
    "3e5 unknowns, GiB": (LARGE + PEAK, 1),
    "1e5 points in space, GiB": (SPRINGS + PEAK, 1),
}
"""What only the full form measures: script and rounds."""
UNMEASURED = "not measured"
COLUMNS = {
    "what": "what takes memory, or what a fresh process does: it answers, compiles what a first "
    "run of springs in the plane takes or every form of the kernels, or solves a large body of "
    "elements or of springs",
    "round": "number of the round; contestants take turns in each",
    "value_here": "processor time beyond bare Python (s), seconds of compilation, or peak memory "
    '(GiB); "not measured" in the small form',
}


def measure(setting: Setting) -> pd.DataFrame:
    """The table `start_up`: a row for each round."""
    rows: list[dict[str, Any]] = []
    for number in range(ROUNDS):
        bare = process(BARE)[0]
        for what, command in ASKED.items():
            rows.append(_row(what, number, process(command)[0] - bare))
    for what, (script, rounds) in FULL.items():
        for number in range(rounds):
            value = UNMEASURED if setting.quick else float(process(("-c", script))[1])
            rows.append(_row(what, number, value))
    return pd.DataFrame(rows).sort_values(["what", "round"], ignore_index=True)


def _row(what: str, number: int, value: float | str) -> dict[str, Any]:
    return {"what": what, "round": number + 1, "value_here": value}


def process(arguments: tuple[str, ...]) -> tuple[float, str]:
    """Processor time (s) of a fresh Python, and the last line that it prints.

    Raises
    ------
    SolverError
        If it fails.
    """
    path = os.pathsep.join(sys.path)
    before = os.times()
    done = subprocess.run(
        [sys.executable, *arguments],
        env=os.environ | {"PYTHONPATH": path},
        capture_output=True,
        text=True,
        check=False,
    )
    after = os.times()
    if done.returncode:
        said = (done.stderr.splitlines() or ["nothing"])[-1]
        raise SolverError(f"a fresh process failed with {done.returncode}: {said}; run it by hand")
    spent = after.children_user + after.children_system
    spent -= before.children_user + before.children_system
    return spent, (done.stdout.splitlines() or [""])[-1]
