"""Summary: stable steps and work of the report's four integrators in one table.

Question   Largest stable step of an oscillator, measured and in closed form, and the force
           evaluations per period for an error of 1e-3.
Candidate  The steps of the schemes.
Reference  Closed forms of the limit of each scheme.
"""

from __future__ import annotations

import pandas as pd

from msvalidate import kit

from . import common

SCHEMES = ("explicit_euler", "euler_cromer", "leapfrog", "velocity_verlet")
"""The four integrators of the report."""
DAMPING_RATIOS = (0.05, 1.0)
WANTED = 1e-3
TOLERANCE = 0.01
"""Largest relative difference of a limit: that of the rule on all limits."""
RULES = (
    kit.Rule(
        "summary: largest stable step, measured against closed form, relative", TOLERANCE, "1",
        "the resolution of the search for a limit, as in the rule on all limits",
        table="summary", value="difference",
    ),
)  # fmt: skip


def summarise(limits: pd.DataFrame, needed: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Table `summary` from the tables `limits` and `cost_needed`."""
    single = limits[limits["body"] == "oscillator"].set_index(["scheme", "damping_ratio"])
    work = needed[needed["wanted"] == WANTED].set_index("scheme")["evaluations_needed"]
    return kit.summary_tables(
        _row(
            single,
            f"{common.title(scheme)}, damping ratio {ratio:g}",
            (scheme, ratio),
            {"evaluations": round(float(work[scheme]))},
        )
        for ratio in DAMPING_RATIOS
        for scheme in SCHEMES
    )


def _row(
    limits: pd.DataFrame, words: str, key: tuple[str, float], more: dict[str, object]
) -> dict[str, object]:
    """Row of a scheme and damping ratio; without a reference if no step is stable."""
    if key not in limits.index:
        return kit.summary_row(words, 0.0, None, more=more)
    (row,) = limits[limits.index == key].to_dict("records")
    measured, predicted = row["limit_measured"], row["limit_predicted"]
    return kit.summary_row(words, measured, predicted, tolerance=TOLERANCE, more=more)
