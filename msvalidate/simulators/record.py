"""What is kept of a judgement: numbers and words that JSON holds, small enough to commit."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from msvalidate.simulators.judgement import BodyRow, Judgement
from msvalidate.simulators.reading import Reading

DIGITS = 8
"""Of numbers: more than any of them is known to."""


def record_of(found: Judgement) -> dict[str, Any]:
    """A judgement as JSON takes it; a number that there is not is null."""
    law = found.predicted
    return {
        "asked": {"E": found.asked.E, "nu": found.asked.nu, "density": found.asked.density},
        "predicted": None if law is None else {"E": _number(law[0]), "nu": _number(law[1])},
        "state": found.state,
        "causes": list(found.causes),
        "notes": list(found.notes),
        "gate": [
            {
                "name": row.name,
                "value": _number(row.value),
                "unit": row.unit,
                "limit": _number(row.limit),
                "verdict": row.verdict,
                "because": row.because,
            }
            for row in found.gate.rows
        ],
        "probe": None if found.reading is None else probe_record(found.reading),
        "bodies": [_body(row) for row in found.bodies],
    }


def probe_record(reading: Reading) -> dict[str, Any]:
    """A reading of the probe as JSON takes it."""
    masses = reading.masses
    return {
        "E": _number(reading.E),
        "nu": _number(reading.nu),
        "E_error": _number(reading.elastic.E_error),
        "nu_error": _number(reading.elastic.nu_error),
        "because": reading.elastic.because,
        "C": [[_number(value) for value in row] for row in reading.C],
        "error": _number(reading.error),
        "valid": reading.is_valid,
        "flags": {flag.name: [_number(flag.value), flag.limit] for flag in reading.flags},
        "mass": None if masses is None else {"pattern": masses.pattern, "off": _number(masses.off)},
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
        "shape": row.shape,
    }


def _number(value: float | None) -> float | None:
    """With few digits; None for what is not finite."""
    if value is None or not math.isfinite(value):
        return None
    return float(np.format_float_positional(value, DIGITS, unique=False, fractional=False))
