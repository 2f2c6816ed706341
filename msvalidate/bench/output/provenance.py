"""Provenance of results: versions, commit, machine, seed, command and time.

Names no host, no user and no path.
"""

from __future__ import annotations

import contextlib
import os
import platform
import subprocess
from collections.abc import Sequence
from datetime import datetime
from importlib.metadata import version
from pathlib import Path

from msvalidate import __version__

LIBRARIES = ("numpy", "scipy", "scikit-fem", "numba", "pandas", "matplotlib")


def collect_provenance(
    command: Sequence[str], seed: int, started: datetime, seconds: float, *, form: str
) -> dict[str, str]:
    """Label -> value, in the order in which a report shows them.

    Of a command in words, the seed of its random numbers, when the study began and how long it
    alone took (s), and its form, "quick" or "full".
    """
    libraries = ", ".join(f"{name} {version(name)}" for name in LIBRARIES)
    return {
        "msvalidate": f"{__version__}, commit {current_commit()}",
        "Python": f"{platform.python_implementation()} {platform.python_version()}",
        "libraries": libraries,
        "processor": f"{processor_name()}, {available_cores()} cores available",
        "system": f"{platform.system()} {platform.machine()}",
        "seed": str(seed),
        "form": form,
        "command": " ".join(command),
        "time": f"{started:%Y-%m-%d %H:%M} UTC, took {seconds:.1f} s",
    }


def current_commit() -> str:
    """Commit of the checkout that this package runs from; "unknown" for an installed wheel."""
    root = Path(__file__).resolve().parents[3]
    if not (root / ".git").exists():
        return "unknown (not a checkout)"
    describe = ["git", "-C", str(root), "describe", "--always", "--abbrev=12", "--exclude=*"]
    try:
        done = subprocess.run(
            [*describe, "--dirty= with uncommitted changes"],
            capture_output=True,
            text=True,
            check=True,
        )
    except (OSError, subprocess.CalledProcessError):
        return "unknown (git did not answer)"
    return done.stdout.strip()


def processor_name() -> str:
    """Model name of the processor."""
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()


def available_cores() -> int:
    """Cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1
