# SPDX-License-Identifier: MIT
"""Which simulators are judged, with which laws and settings, and which are not, and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgspec

from simulators.sweep import Sweep


@dataclass(frozen=True)
class Job:
    """A simulator with one law.

    Parameters
    ----------
    name
        Of the file of results.
    adapter
        File in adapters/.
    environment
        `.venv-NAME` that it runs in; "" for our own.
    law
        Of `msvalidate.simulators.bodies.laws`, as its documents or source have it; "" if none.
    source
        Where that stands.
    settings, probed
        Of the simulator, and of the probe's steps beside.
    weighed
        Settings with which masses are measured, where those of the law are too loose for that.
    converged
        Settings at which its bodies are at rest, where those above do not bring them so far: what
        is between the two is the cause "solver".
    curve
        Whether the probe alone is asked at all of `CURVE` too.
    draft
        Whether its author has still to be told.
    upstream
        Known issues, their state and when that was looked at; copies of the web may be older.
    sweeps
        Rest states at several dt and iterations.
    one_cell
        Whether it puts a body into one trilinear cell, by design.
    masses
        Whose its nodes have, as documented, where the probe measures none: it answers by forces.
    """

    name: str
    adapter: str
    source: str
    environment: str = ""
    law: str = ""
    settings: Mapping[str, Any] = field(default_factory=dict)
    probed: Mapping[str, Any] = field(default_factory=dict)
    curve: bool = False
    weighed: Mapping[str, Any] | None = None
    draft: bool = True
    upstream: tuple[str, ...] = ()
    converged: Mapping[str, Any] | None = None
    sweeps: tuple[Sweep, ...] = ()
    program: str = ""
    masses: str = ""
    one_cell: bool = False


@dataclass(frozen=True)
class Excluded:
    """What is not run.

    Parameters
    ----------
    simulator, law
        What it is; law or settings, "" for all of it.
    permanent
        Whether it stays so; else work is to do.
    because
        Why.
    """

    simulator: str
    law: str
    permanent: bool
    because: str


@dataclass(frozen=True)
class _File:
    job: tuple[Job, ...]
    excluded: tuple[Excluded, ...]


_FILE = msgspec.toml.decode(Path(__file__).with_suffix(".toml").read_bytes(), type=_File)
JOBS, EXCLUDED = _FILE.job, _FILE.excluded
"""What is run, and what is not, and why; in the study's table beside what is."""
