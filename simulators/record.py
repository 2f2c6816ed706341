# SPDX-License-Identifier: MIT
"""Judge the simulators that are installed, and leave what is found for the study `simulators`.

    python -m simulators.record            all that JOBS lists and that is installed
    python -m simulators.record drake      those whose name begins so
    python -m simulators.record --iterations drake    only their rest states over dt and iterations

Each is run by its adapter in its own environment (`make simulators` makes these), a new process for
every question. What comes of it is written to studies/simulators/data, a file each, with versions
and checksums of the adapter and of the pinned packages. Nothing there is typed in.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import shutil
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from msvalidate.problem import Isotropic, ProblemError, SolverError
from msvalidate.simulators.judgement import judge_simulator
from msvalidate.simulators.laws import predicted
from msvalidate.simulators.probe import probe
from msvalidate.simulators.program import Program
from msvalidate.simulators.protocol import CannotRepresent
from msvalidate.simulators.reading import Reading
from msvalidate.simulators.record import probe_record, record_of
from msvalidate_check import exchange
from simulators.jobs import JOBS, Job
from simulators.sweep import rest_states

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
DATA = ROOT / "studies" / "simulators" / "data"
E, NU, DENSITY = 1e7, 0.3, 1000.0
CURVE = (0.1, 0.2, 0.25, 0.3, 0.4, 0.45, 0.49)
LIMIT = 600.0


def main(words: list[str]) -> int:
    """Judge what was asked for; 0 if all of it was found installed."""
    parser = argparse.ArgumentParser(prog="simulators.record", description=__doc__)
    parser.add_argument("names", nargs="*", help="beginnings of names of jobs")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1, help="at once")
    parser.add_argument(
        "--iterations", action="store_true", help="only rest states over dt and iterations"
    )
    args = parser.parse_args(words)
    wanted = [
        job for job in JOBS if not args.names or any(job.name.startswith(n) for n in args.names)
    ]
    DATA.mkdir(parents=True, exist_ok=True)
    with ThreadPoolExecutor(args.jobs) as pool:
        found = list(pool.map(_add_sweeps if args.iterations else _record, wanted))
    return 0 if all(found) else 1


def _simulator(job: Job) -> Program | None:
    """The job's program; None, and a line that says so, where it is not installed."""
    python = Path(sys.executable) if not job.environment else _python(job.environment)
    if not python.exists() or (job.program and shutil.which(job.program) is None):
        print(f"{job.name}: not installed; `make simulators` makes {python}", flush=True)
        return None
    return Program(f"{python} {HERE / 'adapters' / job.adapter}", LIMIT)


def _add_sweeps(job: Job) -> bool:
    """Rest states over dt and iterations, and known issues, put into the record that there is."""
    simulator, path = _simulator(job), DATA / f"{job.name}.json"
    if simulator is None or not job.sweeps:
        return simulator is not None
    if not path.exists():
        print(f"{job.name}: no record to add to; make it without --iterations", flush=True)
        return False
    record = json.loads(path.read_text(encoding="utf-8"))
    record["iterations"] = _sweeps(simulator, job)
    record["iterations_date"] = datetime.now(UTC).date().isoformat()
    record["upstream"] = list(job.upstream)
    _write(path, record)
    print(f"{job.name}: {len(record['iterations'])} rest states", flush=True)
    return True


def _sweeps(simulator: Program, job: Job) -> list[dict[str, Any]]:
    material = Isotropic(E, NU, "solid", DENSITY)
    return [
        row for sweep in job.sweeps for row in rest_states(simulator, material, job.settings, sweep)
    ]


def _write(path: Path, record: dict[str, Any]) -> None:
    text = json.dumps(record, indent=1, ensure_ascii=False, allow_nan=False)
    exchange.replace_file(path, (text + "\n").encode)


def _record(job: Job) -> bool:
    simulator = _simulator(job)
    if simulator is None:
        return False
    began = time.perf_counter()
    material = Isotropic(E, NU, "solid", DENSITY)
    law = predicted(job.law, E, NU) if job.law else None
    expected = None if law is None or law.E is None or law.nu is None else (law.E, law.nu)
    judged = judge_simulator(
        simulator,
        material,
        job.settings,
        predicted=expected,
        converged=job.converged,
        probed=job.probed,
    )
    record = {
        "name": job.name,
        "law": job.law,
        "source": job.source,
        "settings": dict(job.settings),
        "converged": None if job.converged is None else dict(job.converged),
        "draft": job.draft,
        "upstream": list(job.upstream),
        "date": datetime.now(UTC).date().isoformat(),
        "adapter": {"file": job.adapter, "sha256": _digest(HERE / "adapters" / job.adapter)},
        "packages": _packages(job.environment),
        **record_of(judged),
    }
    if job.curve:
        known = judged.reading
        if job.weighed is not None:
            known = probe(simulator, material, settings=job.weighed)
        record["curve"] = [_point(simulator, job, nu, known) for nu in CURVE]
    if job.sweeps:
        record["iterations"] = _sweeps(simulator, job)
        record["iterations_date"] = record["date"]
    _write(DATA / f"{job.name}.json", record)
    print(f"{job.name}: {judged.state}, {time.perf_counter() - began:.0f} s", flush=True)
    for line in (*judged.causes, *judged.notes):
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


def _python(environment: str) -> Path:
    folder = os.environ.get("MSVALIDATE_ENVIRONMENTS")
    if folder:
        return Path(folder) / f"v_{environment}" / "bin" / "python"
    return ROOT / f".venv-{environment}" / "bin" / "python"


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _packages(environment: str) -> dict[str, str]:
    """Pinned packages -> checksum of the wheel, from the requirement file."""
    if not environment:
        return {}
    found = {}
    text = (HERE / "requirements" / f"{environment}.txt").read_text(encoding="utf-8")
    for line in text.replace("\\\n", " ").splitlines():
        name, _, digest = line.partition("--hash=sha256:")
        if digest:
            found[name.strip()] = digest.split()[0]
    return found


if __name__ == "__main__":
    raise SystemExit(main(sys.argv[1:]))
