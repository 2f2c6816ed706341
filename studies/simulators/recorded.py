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
import re
from datetime import date
from pathlib import Path
from typing import Any

import pandas as pd

from msvalidate import kit
from msvalidate.simulators.gate.rows import STOPPED
from msvalidate.simulators.verdict.causes import NOT_EXPLAINED

from . import judged
from .gaps import ASKED_RATIO, fill_gaps, with_none

DATA = Path(__file__).parent / "data"
CONTROLS = ("calculix", "ngsolve-1", "felupe-linear")
NEWEST = "newest.json"
EXCLUDED = DATA / "excluded" / "excluded.json"
STIFFER = 0.01
YEARS = 1000
"""Major versions from here on are years."""
BEHIND = 2
"""Minor releases."""
DRAFT = "yes until its author has been told; control: of a program that others are held beside"
STATE = (
    "agrees, differs with cause, not at rest, not explained, gate, excluded; stale: old, or "
    "stopped by a limit that leaves no room for what the program states to solve to"
)
COLUMNS = {
    "name": "of the record",
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
    "rest": "largest part of a displacement that may still change, as its adapter states",
    "large_strain": "largest principal strain of a body that is held against its own law (1)",
    "large_strain_apart": "from elements of the documented law there, over the displacement (1)",
    "linear_apart": "from linear elements there: how much of the law there was to be seen",
    "state_of_record": STATE,
    "cause": "the first",
    "known_upstream": "issues that its authors have, their state, and when that was looked at",
    "draft": DRAFT,
    "date": "of the record; after six months it is to be made again",
}


NUMBERS = (
    "asked_modulus", "predicted_modulus", "predicted_ratio", "probed_modulus", "probed_ratio",
    "rest", "large_strain", "large_strain_apart", "linear_apart",
)  # fmt: skip
"""Columns that may have gaps."""
BODY_COLUMNS = {"name": COLUMNS["name"]} | {
    name: judged.COLUMNS[name]
    for name in (
        "body", "case", "mesh", "error", "law_factor", "resolution_factor", "mass_factor",
        "solver_factor", "not_explained_factor", "apart",
    )
} | {"draft": DRAFT}  # fmt: skip
OLD = 183
"""Days after which a record is stale; it is too where its program is two minor releases ahead."""


def records() -> list[dict[str, Any]]:
    """What was recorded, the controls first, then by name."""
    found = [json.loads(path.read_text(encoding="utf-8")) for path in sorted(DATA.glob("*.json"))]
    judgements = [each for each in found if "state" in each]
    return sorted(judgements, key=lambda each: (each["name"] not in CONTROLS, each["name"]))


def looked_at() -> dict[str, Any]:
    """The last look at what is newest."""
    return dict(json.loads((DATA / NEWEST).read_text(encoding="utf-8")))


def run() -> kit.Evidence:
    """The tables of records and of their bodies."""
    found = records()
    newest = looked_at()
    others = json.loads(EXCLUDED.read_text(encoding="utf-8"))
    rows = [*(_row(each, newest) for each in found), *map(_excluded_row, others)]
    table = pd.DataFrame(rows, columns=[*COLUMNS])
    bodies = pd.DataFrame(
        [_body_row(each, body) for each in found for body in each["bodies"]],
        columns=[*BODY_COLUMNS],
    )
    return kit.Evidence(
        tables={"recorded": fill_gaps(table), "recorded_bodies": fill_gaps(bodies)},
        tolerances=judge(found),
        findings=(_finding(table, newest),),
        columns=with_none(COLUMNS | BODY_COLUMNS, *NUMBERS, *list(BODY_COLUMNS)[5:-1]),
    )


def _finding(table: pd.DataFrame, newest: dict[str, Any]) -> str:
    """How many records are in which state."""
    states = table["state_of_record"].value_counts().sort_index()
    told = ", ".join(f"{state} {count}" for state, count in states.items())
    return (
        f"{(table['name'] != '').sum()} records of simulators and laws: {told}. "
        "Rows marked draft are not final. "
        f"Newer versions were looked for on {newest['looked_at']}."
    )


def stops(record: dict[str, Any]) -> list[dict[str, Any]]:
    """Rows of the gate that stopped it: where there are any, none of its readings is judged."""
    return [row for row in record.get("gate", ()) if row["verdict"] == STOPPED]


def state_of(record: dict[str, Any], newest: dict[str, Any]) -> str:
    """What is shown in the column `state_of_record`."""
    return f"{'stale: ' if is_stale(record, newest) else ''}{record['state']}"


def is_stale(record: dict[str, Any], newest: dict[str, Any]) -> bool:
    """Whether a record is half a year older than the last look, or two minor releases behind.

    Of a program whose versions are years and months each month counts as one. A record whose gate
    asked less than today's says so under `stale`.
    """
    if "stale" in record:
        return True
    looked, made = (date.fromisoformat(each) for each in (newest["looked_at"], record["date"]))
    if (looked - made).days > OLD:
        return True
    pinned = dict(key.split("==") for key in record["packages"])
    for name in pinned.keys() & newest["programs"].keys():
        (old, minor), (new, newest_minor) = (
            [int(part) for part in [*re.findall(r"\d+", version), "0"][:2]]
            for version in (pinned[name], newest["programs"][name])
        )
        if old >= YEARS:  # months, then
            newest_minor, new = newest_minor + 12 * (new - old), old
        if new > old or (new == old and newest_minor - minor >= BEHIND):
            return True
    return False


def _row(record: dict[str, Any], newest: dict[str, Any]) -> dict[str, object]:
    asked, law, probed = record["asked"], record["predicted"] or {}, record["probe"] or {}
    settings = ", ".join(f"{name} {value}" for name, value in record["settings"].items())
    rest = [row["rest"] for row in record["bodies"] if row["rest"] is not None]
    large = record.get("large") or {}
    values = (
        record["name"],
        _program(record),
        f"{record['law'] or record['source']}{f'; {settings}' if settings else ''}",
        asked["E"],
        asked["nu"],
        _over(law.get("E"), asked["E"]),
        _number(law.get("nu")),
        _over(probed.get("E"), asked["E"]),
        _number(probed.get("nu")),
        (probed.get("mass") or {}).get("pattern", "") or record.get("masses", ""),
        "; ".join(row["name"] for row in stops(record)),
        max(rest, default=math.nan),
        _number(large.get("strain")),
        _number(large.get("apart")),
        _number(large.get("from_linear")),
        state_of(record, newest),
        record["causes"][0] if record["causes"] else "",
        "; ".join(record["upstream"]),
        draft_of(record),
        record["date"],
    )
    return dict(zip(COLUMNS, values, strict=True))


def _program(record: dict[str, Any]) -> str:
    """Program and version, as it told the probe; else as it was pinned."""
    about = (record["probe"] or {}).get("about", {})
    if about.get("simulator"):
        return f"{about['simulator']} {about['version']}"
    name = str(record["adapter"]["file"]).removesuffix(".py")
    pinned = dict(key.split("==") for key in record["packages"])
    return f"{name} {pinned.get(name, '')}".strip()


def draft_of(record: dict[str, Any]) -> str:
    """What is shown in the column `draft`."""
    return "yes" if record["draft"] else "control"


def _body_row(record: dict[str, Any], body: dict[str, Any]) -> dict[str, object]:
    factors = body["factors"] or {}
    values = (
        record["name"], body["body"], body["case"], body["mesh"], _number(body["error"]),
        *(_number(factors.get(each)) for each in judged.FACTORS), draft_of(record),
    )  # fmt: skip
    return dict(zip(BODY_COLUMNS, values, strict=True))


def _excluded_row(other: dict[str, Any]) -> dict[str, object]:
    """What is not run, and why: no numbers."""
    row: dict[str, object] = dict.fromkeys(COLUMNS, "")
    row |= dict.fromkeys((*NUMBERS, "asked_ratio"), math.nan)
    return row | {
        "simulator": other["simulator"],
        "law_and_settings": other["law"],
        "state_of_record": f"excluded: {'permanent' if other['permanent'] else 'work to do'}",
        "cause": other["because"],
        "draft": "",
    }


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _over(value: float | None, other: float) -> float:
    return math.nan if value is None else float(value) / other


def judge(found: list[dict[str, Any]]) -> tuple[kit.Tolerance, ...]:
    """What records of controls, and of laws that are off, say."""
    named = {record["name"]: record for record in found}
    errors = [abs(_probed_modulus(named[name]) - 1) for name in CONTROLS if name in named]
    asked_for_more = ("calculix-stiffer", "calculix")
    both = [_probed_modulus(named[name]) for name in asked_for_more]
    effective = [_pulled_modulus(named[name]) for name in asked_for_more]
    off = [record for record in found if _is_off(record) and record["state"] != NOT_EXPLAINED]
    return (
        kit.Tolerance(
            "recorded: largest error of the controls' modulus, over the asked", 1e-5, "1",
            "they solve linear elements: digits of single precision that one of them prints",
            observed=kit.Observed(max(errors)),
        ),
        kit.Tolerance(
            "recorded: modulus of CalculiX asked for 1 % more, over its own, less 1", 5e-4, "1",
            "0.05 % of it is what a comparison by two records may add",
            observed=kit.Observed(both[0] / both[1] - 1, STIFFER),
        ),
        kit.Tolerance(
            "recorded: effective modulus of its pulled block asked for 1 % more, over its own, "
            "less 1",
            5e-4, "1", "as the modulus read",
            observed=kit.Observed(effective[0] / effective[1] - 1, STIFFER),
        ),
        kit.Tolerance(
            "recorded: readings more than 1 % from their documented law and not told so", 0, "1",
            "a law that is not what its source says is a finding, and must be in the table",
            observed=kit.Observed(float(len(off))),
        ),
    )  # fmt: skip


def _probed_modulus(record: dict[str, Any]) -> float:
    return _over((record["probe"] or {}).get("E"), record["asked"]["E"])


def _pulled_modulus(record: dict[str, Any]) -> float:
    """Pa, of the finest pulled body."""
    return _number([body["E"] for body in record["bodies"] if body["body"] == "pulled"][-1])


def _is_off(record: dict[str, Any]) -> bool:
    law, probed = record["predicted"], record["probe"]
    if not law or not probed or law["E"] is None or probed["E"] is None:
        return False
    off = abs(probed["E"] / law["E"] - 1), abs(probed["nu"] - law["nu"])
    return bool(max(off) > STIFFER)
