"""Recorded: which solids do simulators simulate that people use?

Question   What did the gate, the probe and bodies at rest say of each simulator and law?
Candidate  Programs that were installed when `make simulators` was run: their records are files of
           this study, with versions, checksums of wheels and adapters, and dates.
Reference  What was asked for; what the documented law is to first order; linear elements on the
           same mesh. Controls in the same table: CalculiX, NGSolve, FElupe.
Expected   What is read is what the documented law predicts, within 1 %, or the row is "not
           explained".
"""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pandas as pd

from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.simulators.gate import STOPPED
from msvalidate.simulators.judgement import NOT_EXPLAINED

from .gaps import ASKED_RATIO, fill_gaps, with_none

DATA = Path(__file__).parent / "data"
CONTROLS = ("calculix", "ngsolve-1", "felupe-linear")
EXCLUDED = DATA / "excluded" / "excluded.json"
STIFFER = 0.01
TOLERANCES = (
    Tolerance(
        "recorded: largest error of the controls' modulus, over the asked", 1e-5, "1",
        "they solve linear elements: digits of single precision that one of them prints",
    ),
    Tolerance(
        "recorded: modulus of CalculiX asked for 1 % more, over its own, less 1", 5e-4, "1",
        "0.05 % of it is what a comparison by two records may add",
    ),
    Tolerance(
        "recorded: readings more than 1 % from their documented law and not told so", 0, "1",
        "a law that is not what its source says is a finding, and must be in the table",
    ),
)  # fmt: skip
COLUMNS = {
    "simulator": "program, version",
    "law_and_settings": "the law as its documents or source have it, and the settings",
    "asked_modulus": "Pa",
    "asked_ratio": ASKED_RATIO,
    "predicted_modulus": "over the asked, by the documented law to first order",
    "predicted_ratio": "the same for the ratio",
    "probed_modulus": "over the asked, as read",
    "probed_ratio": "the same for the ratio",
    "mass": "whose masses its nodes have, as measured; as documented where it answers by forces",
    "gate": "what stopped it; empty where nothing did",
    "rest": "largest part of a displacement that may still change, as stated",
    "pulled_error": "of the pulled block on the finer mesh, over the largest displacement (1)",
    "sheared_error": "of the sheared block",
    "pulled_not_explained": "part of it that law, mass and mesh do not explain (1)",
    "sheared_not_explained": "the same of the sheared block",
    "bent_resolution": "times the displacement of the cantilever, by linear elements on its mesh",
    "state_of_record": "agrees, differs with cause, not explained, gate, or excluded",
    "cause": "the first",
    "draft": "yes until its author has been told",
    "date": "of the record; after six months it is to be made again",
}


NUMBERS = (
    "asked_modulus", "predicted_modulus", "predicted_ratio", "probed_modulus", "probed_ratio",
    "rest", "pulled_error", "sheared_error", "pulled_not_explained", "sheared_not_explained",
    "bent_resolution",
)  # fmt: skip
"""Columns that may have gaps, beside the ratio asked for."""


def records() -> list[dict[str, Any]]:
    """What was recorded, by name."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(DATA.glob("*.json"))]
    return sorted(found, key=lambda each: (each["name"] not in CONTROLS, each["name"]))


def run() -> Evidence:
    """The table of records."""
    found = records()
    others = json.loads(EXCLUDED.read_text(encoding="utf-8"))
    rows = [*map(_row, found), *map(_excluded_row, others)]
    table = pd.DataFrame(rows, columns=[*COLUMNS])
    return Evidence(
        tables={"recorded": fill_gaps(table)},
        observed=by_quantity(TOLERANCES, _observed(found)),
        tolerances=TOLERANCES,
        findings=(_finding(found),),
        columns=with_none(COLUMNS, *NUMBERS),
    )


def _finding(found: list[dict[str, Any]]) -> str:
    """How many records are in which state."""
    states = pd.Series([record["state"] for record in found]).value_counts().sort_index()
    told = ", ".join(f"{state} {count}" for state, count in states.items())
    return f"{len(found)} records of simulators and laws: {told}. Rows marked draft are not final."


def _row(record: dict[str, Any]) -> dict[str, object]:
    asked, law, probed = record["asked"], record["predicted"] or {}, record["probe"] or {}
    settings = ", ".join(f"{name} {value}" for name, value in record["settings"].items())
    about = probed.get("about", {})
    stops = [row["name"] for row in record["gate"] if row["verdict"] == STOPPED]
    rest = [row["rest"] for row in record["bodies"] if row["rest"] is not None]
    values = (
        f"{about.get('simulator') or record['name']} {about.get('version') or ''}".strip(),
        f"{record['law'] or record['source']}{f'; {settings}' if settings else ''}",
        asked["E"],
        asked["nu"],
        _over(law.get("E"), asked["E"]),
        _number(law.get("nu")),
        _over(probed.get("E"), asked["E"]),
        _number(probed.get("nu")),
        (probed.get("mass") or {}).get("pattern", "") or record.get("masses", ""),
        "; ".join(stops),
        max(rest, default=math.nan),
        _of(record, "pulled", "error"),
        _of(record, "sheared", "error"),
        _of(record, "pulled", "apart"),
        _of(record, "sheared", "apart"),
        _of(record, "bent", "resolution"),
        record["state"],
        record["causes"][0] if record["causes"] else "",
        "yes" if record["draft"] else "no",
        record["date"],
    )
    return dict(zip(COLUMNS, values, strict=True))


def _excluded_row(other: dict[str, Any]) -> dict[str, object]:
    """What is not run, and why: no numbers."""
    row: dict[str, object] = dict.fromkeys(COLUMNS, "")
    row |= dict.fromkeys((*NUMBERS, "asked_ratio"), math.nan)
    return row | {
        "simulator": other["simulator"],
        "law_and_settings": other["law"],
        "state_of_record": f"excluded: {'permanent' if other['permanent'] else 'work to do'}",
        "cause": other["because"],
        "draft": "no",
    }


def _of(record: dict[str, Any], body: str, name: str) -> float:
    """A number of a body on its finest mesh."""
    rows = [row for row in record["bodies"] if row["body"] == body]
    if not rows:
        return math.nan
    found = rows[-1]
    return _number(found[name] if name in found else (found["factors"] or {}).get(name))


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _over(value: float | None, other: float) -> float:
    return math.nan if value is None else float(value) / other


def _observed(found: list[dict[str, Any]]) -> list[Observed]:
    named = {record["name"]: record for record in found}
    errors = [abs(_probed_modulus(named[name]) - 1) for name in CONTROLS if name in named]
    both = [_probed_modulus(named[name]) for name in ("calculix-stiffer", "calculix")]
    off = [record for record in found if _is_off(record) and record["state"] != NOT_EXPLAINED]
    return [
        Observed(max(errors)),
        Observed(both[0] / both[1] - 1, STIFFER),
        Observed(float(len(off))),
    ]


def _probed_modulus(record: dict[str, Any]) -> float:
    return _over((record["probe"] or {}).get("E"), record["asked"]["E"])


def _is_off(record: dict[str, Any]) -> bool:
    law, probed = record["predicted"], record["probe"]
    if not law or not probed or law["E"] is None or probed["E"] is None:
        return False
    off = abs(probed["E"] / law["E"] - 1), abs(probed["nu"] - law["nu"])
    return bool(max(off) > STIFFER)
