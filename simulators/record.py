# SPDX-License-Identifier: MIT
"""Judge the simulators that are installed, and leave what is found for the study `simulators`.

    python -m simulators.record            all that JOBS lists and that is installed
    python -m simulators.record drake      those whose name begins so; `held` is the study's `held`
    python -m simulators.record --iterations drake    only their rest states over dt and iterations

Each is run by its adapter in its own environment (`make simulators` makes these), a new process for
every question. What comes of it is written to studies/simulators/data, a file each, with versions
and checksums of the adapter and of the pinned packages. Nothing there is typed in.
"""

from __future__ import annotations

import argparse
import json
import os
import shutil
import sys
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from typing import Any

from msvalidate.problem import Isotropic, ProblemError, SolverError
from msvalidate.simulators.bodies.laws import predicted
from msvalidate.simulators.bodies.tetrahedra import linear_elements
from msvalidate.simulators.exchange.program import Program
from msvalidate.simulators.exchange.protocol import CannotRepresent
from msvalidate.simulators.probe.probe import probe
from msvalidate.simulators.probe.reading import Reading
from msvalidate.simulators.verdict.judgement import judge_simulator
from msvalidate.simulators.verdict.record import probe_record, record_of
from simulators.environments import DATA, adapter_of, pins, python_of, save
from simulators.held import record_elements, record_springs
from simulators.jobs import EXCLUDED, JOBS, Job
from simulators.one_cell import one_cell
from simulators.sweep import rest_states

E, NU, DENSITY = 1e7, 0.3, 1000.0
CURVE = (0.1, 0.2, 0.25, 0.3, 0.4, 0.45, 0.49)
HELD: dict[str, tuple[str, Callable[[], None]]] = {
    "held-elements": ("ngsolve", record_elements),
    "held-springs": ("lammps", record_springs),
}
"""Name -> environment, and what it is held by."""


def main(words: list[str]) -> int:
    """Judge what was asked for; 0 if all of it was found installed."""
    parser = argparse.ArgumentParser(prog="simulators.record", description=__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of names of jobs")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at once")
    parser.add_argument(
        "--iterations", action="store_true", help="only rest states over dt and iterations"
    )
    args = parser.parse_args(words)
    wanted = [job for job in JOBS if _is_asked(job.name, args.names)]
    held = [name for name in HELD if _is_asked(name, args.names)]
    save("excluded/excluded.json", [asdict(each) for each in EXCLUDED])
    with ThreadPoolExecutor(args.jobs) as pool:
        found = (
            [*pool.map(_add_sweeps, wanted)]
            if args.iterations
            else [*pool.map(_record, wanted), *pool.map(_hold, held)]
        )
    return 0 if all(found) else 1


def _is_asked(name: str, beginnings: list[str]) -> bool:
    return not beginnings or any(name.startswith(each) for each in beginnings)


def _is_installed(name: str, environment: str, program: str = "") -> bool:
    python = python_of(environment)
    if python.exists() and (not program or shutil.which(program) is not None):
        return True
    print(f"{name}: not installed; `make simulators` makes {python}", flush=True)
    return False


def _hold(name: str) -> bool:
    environment, act = HELD[name]
    if _is_installed(name, environment):
        act()
        print(f"{name}: done", flush=True)
        return True
    return False


def _add_sweeps(job: Job) -> bool:
    """Rest states over dt and iterations, and known issues, put into the record that there is."""
    path = DATA / f"{job.name}.json"
    if not _is_installed(job.name, job.environment, job.program):
        return False
    if not job.sweeps:
        return True
    if not path.exists():
        print(f"{job.name}: no record to add to; make it without --iterations", flush=True)
        return False
    record = json.loads(path.read_text(encoding="utf-8"))
    record["iterations"] = _sweeps(adapter_of(job.adapter, job.environment), job)
    record["iterations_by"] = pins(job.adapter, job.environment)
    record["upstream"] = list(job.upstream)
    save(path.name, record)
    print(f"{job.name}: {len(record['iterations'])} rest states", flush=True)
    return True


def _sweeps(simulator: Program, job: Job) -> list[dict[str, Any]]:
    material = Isotropic(E, NU, "solid", DENSITY)
    return [
        row for sweep in job.sweeps for row in rest_states(simulator, material, job.settings, sweep)
    ]


def _record(job: Job) -> bool:
    if not _is_installed(job.name, job.environment, job.program):
        return False
    began = time.perf_counter()
    simulator = adapter_of(job.adapter, job.environment)
    material = Isotropic(E, NU, "solid", DENSITY)
    judged = judge_simulator(
        simulator,
        material,
        job.settings,
        law=job.law,
        converged=job.converged,
        probed=job.probed,
        elements=one_cell if job.one_cell else linear_elements,
    )
    record = {
        "name": job.name,
        "law": job.law,
        "source": job.source,
        "settings": dict(job.settings),
        "converged": None if job.converged is None else dict(job.converged),
        "draft": job.draft,
        "upstream": list(job.upstream),
        "masses": job.masses,
        **pins(job.adapter, job.environment),
        **record_of(judged),
    }
    if job.sweeps:
        record["iterations"] = _sweeps(simulator, job)
    if job.curve:
        known = judged.reading
        if job.weighed is not None:
            known = probe(simulator, material, settings=job.weighed)
        record["curve"] = [_point(simulator, job, nu, known) for nu in CURVE]
    save(f"{job.name}.json", record)
    print(f"{job.name}: {record['state']}, {time.perf_counter() - began:.0f} s", flush=True)
    for line in (*record["causes"], *record["notes"]):
        print(f"  {line}", flush=True)
    return True


def _point(simulator: Program, job: Job, nu: float, known: Reading | None) -> dict[str, Any]:
    """One ratio of the curve: what the probe reads beside what the law says."""
    law = predicted(job.law, E, nu)
    point: dict[str, Any] = {"nu": nu, "predicted": {"E": law.E, "nu": law.nu}}
    try:
        reading = probe(
            simulator,
            Isotropic(E, nu, "solid", DENSITY),
            settings={**job.settings, **job.probed},
            masses=None if known is None else known.masses,
        )
    except (CannotRepresent, SolverError, ProblemError) as error:
        return point | {"probe": None, "because": str(error)}
    return point | {"probe": probe_record(reading)}


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
