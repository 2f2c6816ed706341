"""What is kept of a judgement: numbers and words that JSON holds, small enough to commit."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np

from msvalidate.simulators.bodies.bodies import BodyRow
from msvalidate.simulators.bodies.large_strain import AtLargeStrain
from msvalidate.simulators.gate.gate import PASSED, STOPPED, GateRow
from msvalidate.simulators.probe.reading import Reading
from msvalidate.simulators.verdict.judgement import Judgement
from msvalidate.simulators.verdict.sentences import text_of

WIDE = 120
"""Characters of a line of a record, up to which what belongs together stays on one."""
DIGITS = 8
"""Of numbers: more than any of them is known to."""


def record_of(found: Judgement) -> dict[str, Any]:
    """A judgement as JSON takes it; a number that there is not is null."""
    law = found.predicted
    return {
        "asked": {"E": found.asked.E, "nu": found.asked.nu, "density": found.asked.density},
        "predicted": None if law is None else {"E": _number(law[0]), "nu": _number(law[1])},
        "state": found.state,
        "causes": [each.said for each in found.causes],
        "kinds": [each.kind for each in found.causes],
        "notes": [f"{each.what}: {each.why}" for each in found.notes],
        "gate": [_gate_row(row) for row in found.gate.rows],
        "probe": None if found.reading is None else probe_record(found.reading),
        "bodies": [_body(row) for row in found.bodies],
        "large": _large(found.large),
    }


def _gate_row(row: GateRow) -> dict[str, Any]:
    """What was tried; why its limit is what it is stands in `gate`, and here only what stops."""
    kept = {"name": row.name, "verdict": row.verdict, "value": _number(row.value)}
    if row.verdict in {PASSED, STOPPED}:
        kept |= {"unit": row.unit, "limit": _number(row.limit)}
    return kept if row.verdict == PASSED else kept | {"because": text_of(row.because)}


def _large(found: AtLargeStrain | None) -> dict[str, Any] | None:
    if found is None:
        return None
    return {name: v if isinstance(v, str) else _number(v) for name, v in vars(found).items()}


def probe_record(reading: Reading) -> dict[str, Any]:
    """A reading of the probe as JSON takes it."""
    masses = reading.masses
    return {
        "E": _number(reading.E),
        "nu": _number(reading.nu),
        "E_error": _number(reading.elastic.E_error),
        "nu_error": _number(reading.elastic.nu_error),
        "because": text_of(reading.elastic.because),
        "C": [[_number(value) for value in row] for row in reading.C],
        "error": _number(reading.error),
        "valid": reading.is_valid,
        "flags": {flag.name: _number(flag.value) for flag in reading.flags},
        "mass": None
        if masses is None
        else {"pattern": text_of(masses.words), "off": _number(masses.off)},
        "strain": reading.strain,
        "precision": reading.precision,
        "about": {key: reading.about.get(key) for key in ("simulator", "version", "law", "mass")},
    }


def _body(row: BodyRow) -> dict[str, Any]:
    factors = None
    if row.factors is not None:
        factors = {name: _number(value) for name, value in vars(row.factors).items()}
    return {
        "body": row.body,
        "case": row.case,
        "mesh": row.mesh,
        "error": _number(row.error),
        "E": _number(row.on_mesh.E),
        "nu": _number(row.on_mesh.nu),
        "left": _number(row.on_mesh.left),
        "rest": _number(row.rest),
        "factors": factors,
        "shape": "" if row.shape is None else row.shape.said,
        "even": _number(row.even),
        "finer": row.finer,
        "loaded_more": _number(row.loaded_more),
        "far_away": _number(row.far_away),
    }


def _number(value: float | None) -> float | None:
    """With few digits; None for what is not finite."""
    if value is None or not math.isfinite(value):
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
