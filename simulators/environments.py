# SPDX-License-Identifier: MIT
"""Where simulators are installed, what of them is pinned, and where records are left."""

from __future__ import annotations

import hashlib
import os
import sys
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from msvalidate import __version__
from msvalidate.simulators.exchange.program import Program
from msvalidate.simulators.verdict.record import json_of
from msvalidate_check import exchange

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
DATA = ROOT / "studies" / "simulators" / "data"
SHARED = ("exchange.py", "moving.py")
"""Of the adapters: how folders are read, and how programs that only move are brought to rest."""
LIMIT = 600.0
"""Seconds that a simulator may take for one question."""


def python_of(environment: str) -> Path:
    """The Python of `.venv-NAME`, or of `v_NAME` in $MSVALIDATE_ENVIRONMENTS; "" is our own."""
    if not environment:
        return Path(sys.executable)
    folder = os.environ.get("MSVALIDATE_ENVIRONMENTS")
    if folder:
        return Path(folder) / f"v_{environment}" / "bin" / "python"
    return ROOT / f".venv-{environment}" / "bin" / "python"


def adapter_of(file: str, environment: str) -> Program:
    """An adapter in its environment."""
    return Program(f"{python_of(environment)} {HERE / 'adapters' / file}", LIMIT)


def pins(file: str, environment: str) -> dict[str, Any]:
    """Date, checksum of an adapter, and those of the wheels that its environment has."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "adapter": {"file": file, "sha256": _digest(file)},
        "shared": {name: _digest(name) for name in SHARED},
        "judged_by": f"msvalidate {__version__}",
        "packages": packages(environment),
    }


def _digest(file: str) -> str:
    return hashlib.sha256((HERE / "adapters" / file).read_bytes()).hexdigest()


def save(name: str, record: Any) -> None:
    """Write a record, which JSON can hold, to a file of the study's data."""
    path = DATA / name
    path.parent.mkdir(parents=True, exist_ok=True)
    exchange.replace_file(path, (json_of(record) + "\n").encode)


def packages(environment: str) -> dict[str, str]:
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
