"""Targets: what was aimed at, and what this machine reached.

Question   Is each program as fast beside its peers as was asked for?
Candidate  The tables of the other questions, measured in this run.
Reference  The targets, ratios of times side by side.
Expected   Times depend on the machine: what is missed is told with what it reached, and nothing
           here is judged. A row whose size the small form leaves out, or whose peer is not
           installed, is not measured.

A measured value is the median over rounds of the ratio of two contestants of one round; least and
most are of the same rounds.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit

from . import target_list
from .target_list import Target

UNMEASURED = "not measured"
FROM = ("agreement", "kernel", "limits", "fem", "relaxation", "solvers", "large")
"""Questions whose tables are looked at."""


def run(asked: Mapping[str, Callable[[], kit.Evidence]], setting: kit.Setting) -> kit.Evidence:
    """Hold what the other questions measured beside the targets."""
    tables: dict[str, pd.DataFrame] = {}
    for answer in asked.values():
        tables |= answer().tables
    table = pd.DataFrame([row(target, tables) for target in target_list.TARGETS])
    met = table["met_here"]
    missed = "; ".join(
        f"{r.target}: {r.measured_here:.3g}, wanted {r.direction} {r.wanted:g}"
        for r in table[met == "no"].itertuples(index=False)
    )
    return kit.Evidence(
        tables={"targets": table},
        columns=kit.columns(__file__),
        findings=(
            f"Of {len(table)} targets this machine met {int((met == 'yes').sum())} and missed "
            f"{int((met == 'no').sum())}; {int(met.str.startswith(UNMEASURED).sum())} were not "
            f"measured. {f'Missed: {missed}.' if missed else ''}".strip(),
        ),
    )


def row(target: Target, tables: kit.Tables) -> dict[str, Any]:
    """One row: the target beside what was measured."""
    head = {"target": target.words, "direction": target.direction, "wanted": target.wanted}
    found = target.measure(tables)
    if isinstance(found, str):
        blank = dict.fromkeys(("measured_here", "least_here", "most_here"), UNMEASURED)
        return head | blank | {"rounds_here": 0, "met_here": f"{UNMEASURED}: {found}"}
    values = np.array(found.values, dtype=float)
    middle = float(np.median(values))
    within = middle >= target.wanted if target.direction == "at least" else middle <= target.wanted
    return head | {
        "measured_here": middle,
        "least_here": float(values.min()),
        "most_here": float(values.max()),
        "rounds_here": found.rounds,
        "met_here": "yes" if within and math.isfinite(middle) else "no",
    }
