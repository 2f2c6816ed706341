"""Curve: modulus and ratio that a law answers by, over the ratio that it is asked for.

Question   What solid do two laws of Drake simulate from a ratio of 0.1 to 0.49, the shipped default
           of which is 0.49?
Candidate  The recorded readings of the probe (`make simulators`).
Reference  Each law to first order, as its source has it.
Expected   The shipped law is the solid asked for. The neo-Hookean one takes Lamé's constants as
           they stand: its ratio is that of lam - mu, below 0 for nu < 1/4. Readings of a law that
           the gate stopped are shown, and not judged.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.simulators.verdict.causes import STOPPED

from .curve_drawing import curve as drawing
from .gaps import ASKED_RATIO, fill_gaps, with_none
from .recorded import DRAFT, STATE, draft_of, looked_at, records, state_of, stops

COLUMNS = {
    "name": "of the record",
    "asked_ratio": ASKED_RATIO,
    "predicted_modulus": "over the asked, by the documented law to first order",
    "predicted_ratio": "the same for the ratio",
    "read_modulus": "over the asked, as the probe reads it",
    "read_ratio": "the same for the ratio",
    "state_of_record": STATE,
    "draft": DRAFT,
}


def run() -> kit.Evidence:
    """The table of points of all records that have them."""
    newest = looked_at()
    each = [(record, point) for record in records() for point in record.get("curve", ())]
    table = pd.DataFrame([_row(*one, newest) for one in each], columns=[*COLUMNS])
    passed = np.array([not stops(record) for record, _ in each])
    known = table["predicted_ratio"].notna() & passed
    off = (table["read_ratio"] - table["predicted_ratio"])[known].abs()
    moduli = (table["read_modulus"] - table["predicted_modulus"])[known].abs()
    missing = table["read_ratio"].isna() & known
    own = (
        kit.Tolerance(
            "curve: largest difference of the ratio as read and as predicted", 0.01, "1",
            "the program's own iteration stops at 1 % of its first residual",
            observed=kit.Observed(float(off.max())),
        ),
        kit.Tolerance(
            "curve: largest difference of the modulus as read and as predicted, over the asked",
            0.01, "1", "as the ratio",
            observed=kit.Observed(float(moduli.max())),
        ),
        kit.Tolerance(
            "curve: ratios that were not read", 0, "1", "each law is a solid at each of them",
            observed=kit.Observed(float(missing.sum())),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"curve": fill_gaps(table)},
        tolerances=own,
        columns=with_none(COLUMNS, *list(COLUMNS)[2:6]),
        findings=tuple(_findings(table)),
        figures={"curve": drawing},
    )


def _findings(table: pd.DataFrame) -> list[str]:
    """Points whose modulus is not known as well as numbers are shown, and what was stopped."""
    found = []
    for name, rows in table.groupby("name", sort=False):
        unknown = rows[rows["predicted_modulus"].notna() & rows["read_modulus"].isna()]
        stopped = "; the gate stopped it, so that none of its readings is judged" * (
            rows["state_of_record"].iloc[0].endswith(STOPPED)
        )
        if len(unknown):
            ratios = ", ".join(f"{nu:g}" for nu in unknown["asked_ratio"])
            found.append(f"{name}: no modulus is known to 0.5 % at {ratios}{stopped} (a draft).")
    return found


def _row(
    record: dict[str, Any], point: dict[str, Any], newest: dict[str, Any]
) -> dict[str, object]:
    E, law, probed = record["asked"]["E"], point["predicted"], point["probe"] or {}
    values = (
        record["name"], point["nu"], _number(law["E"]) / E, _number(law["nu"]),
        _number(probed.get("E")) / E, _number(probed.get("nu")),
        state_of(record, newest), draft_of(record),
    )  # fmt: skip
    return dict(zip(COLUMNS, values, strict=True))


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)
