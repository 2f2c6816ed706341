"""Record of a judgement as JSON, small enough to commit."""

from __future__ import annotations

import json
import math
from dataclasses import is_dataclass
from typing import Any

import numpy as np

from msvalidate.simulators.bodies.bodies import BodyRow
from msvalidate.simulators.gate.rows import PASSED, STOPPED, GateRow
from msvalidate.simulators.lattice.bodies import LatticeReport
from msvalidate.simulators.probe.reading import Reading
from msvalidate.simulators.verdict.judgement import Judgement
from msvalidate.simulators.verdict.sentences import text_of

WIDE = 120
"""Characters of a line of a record, up to which what belongs together stays on one."""
DIGITS = 8
"""Number of digits of numbers, more than their accuracy."""


def record_of(found: Judgement) -> dict[str, Any]:
    """A judgement as JSON takes it; a number that there is not is null."""
    law = found.predicted
    record = {
        "asked": {"E": found.asked.E, "nu": found.asked.nu, "density": found.asked.density},
        "predicted": None if law is None else {"E": _plain(law[0]), "nu": _plain(law[1])},
        "state": found.word,
        "causes": [each.said for each in found.causes],
        "kinds": [each.kind for each in found.causes],
        "notes": [f"{each.what}: {each.why}" for each in found.notes],
        "gate": [_gate_row(row) for row in found.gate.rows],
        "probe": None if found.reading is None else probe_record(found.reading),
        "bodies": [_body(row) for row in found.bodies],
        "large": _plain(found.large),
    }
    return record if found.lattice is None else record | {"lattice": _lattice(found.lattice)}


def _lattice(lattice: LatticeReport) -> dict[str, Any]:
    """Solid, springs and bodies of a lattice; masses and steps in words and numbers alone."""
    steps, springs = lattice.steps, lattice.springs
    record = {
        **vars(lattice.mean),
        "misfit": lattice.misfit,
        "C": lattice.C,
        "springs": springs,
        "total_mass": lattice.total,
        "bodies": [
            {"load": b.load, "rest": b.rest, "factor": b.factor, **b.errors} for b in lattice.bodies
        ],
    }
    if steps is not None:
        whose = None if steps.masses is None else text_of(steps.masses.words)
        record |= {"masses": whose, "prestrain": steps.prestrain, "bound": steps.bound}
    return dict(_plain(record))


def _gate_row(row: GateRow) -> dict[str, Any]:
    """Record of one check.

    Reasons are stored only for checks that did not pass; `gate` explains all limits.
    """
    kept = {"name": row.name, "verdict": row.verdict, "value": _plain(row.value)}
    if row.verdict in {PASSED, STOPPED}:
        kept |= {"unit": row.unit, "limit": _plain(row.limit)}
    return kept if row.verdict == PASSED else kept | {"because": text_of(row.because)}


def probe_record(reading: Reading) -> dict[str, Any]:
    """A reading of the probe as JSON takes it."""
    masses, elastic = reading.masses, reading.elastic
    moduli = {name: getattr(elastic, name) for name in ("E", "nu", "E_error", "nu_error")}
    whose = None if masses is None else {"pattern": text_of(masses.words), "off": masses.off}
    return {
        **_plain(moduli),
        "because": text_of(elastic.because),
        "C": _plain(reading.C),
        "error": _plain(reading.error),
        "valid": reading.is_valid,
        "flags": {flag.name: _plain(flag.value) for flag in reading.flags},
        "mass": _plain(whose),
        "strain": reading.strain,
        "precision": reading.precision,
        "about": {key: reading.about.get(key) for key in ("simulator", "version", "law", "mass")},
    }


def _body(row: BodyRow) -> dict[str, Any]:
    own = {name: value for name, value in vars(row).items() if name not in {"on_mesh", "move"}}
    shapes = [each.said for each in row.shapes]
    return dict(_plain(own | vars(row.on_mesh) | {"shapes": shapes}))


def _plain(value: Any) -> Any:
    """As JSON takes it: records by their names, numbers with few digits, null for not finite."""
    if isinstance(value, list):
        return [_plain(each) for each in value]
    if isinstance(value, np.ndarray):
        return [_plain(each) for each in value] if value.ndim else _plain(value.item())
    if is_dataclass(value) or isinstance(value, dict):
        named = value if isinstance(value, dict) else vars(value)
        return {name: _plain(each) for name, each in named.items()}
    if not isinstance(value, float):
        return value
    if not math.isfinite(value):
        return None
    return float(np.format_float_positional(value, DIGITS, unique=False, fractional=False))


def json_of(record: object, indent: str = "") -> str:
    """A record as JSON that reads as tables do: what fits on a line is on one."""
    line = json.dumps(record, ensure_ascii=False, allow_nan=False)
    if len(indent) + len(line) <= WIDE or not isinstance(record, dict | list):
        return line
    deeper = indent + " "
    if isinstance(record, dict):
        parts = [f"{json.dumps(key)}: {json_of(each, deeper)}" for key, each in record.items()]
        return "{\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}}}"
    parts = [json_of(each, deeper) for each in record]
    return "[\n" + ",\n".join(deeper + part for part in parts) + f"\n{indent}]"
