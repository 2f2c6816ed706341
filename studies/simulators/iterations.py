"""Iterations: does a state at rest depend on the time step and on the number of iterations?

Question   How far is a block that hangs by its weight from the elements that a program's law comes
           to, at dt, dt/2, and iterations times 1, 2, 4 and more; and does it move by more than the
           program says?
Candidate  The recorded rest states (`make simulators`), of programs that the gate stops too.
Reference  Linear tetrahedra of the documented law on the same mesh with the documented masses, at
           rest by Newton's method; of the asked solid, where the law has no rest of its own.
Expected   A rest state depends on neither. What steps are solved to their end agrees with the
           elements; what few iterations leave shrinks with more of them and with shorter steps, as
           long as floats resolve what a step moves.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.simulators.gate.gate import STRAIN

from .gaps import NONE, fill_gaps, with_none
from .iterations_drawing import iterations as drawing
from .recorded import DRAFT, draft_of, records

ROUNDINGS = 100
"""Of a position, that a rest state in its floats may be off by; as many as the gate allows."""
TIMES = 4
ASKED = "linear"
"""Law of the elements beside programs whose own law has no rest."""
COLUMNS = {
    "name": "of the record",
    "law_beside": "law of the elements that it is held against",
    "iterations": "in a step, as asked for",
    "time_step": "s",
    "rest_error": "largest difference from these elements, over their largest displacement",
    "stated_rest": "part of the displacement that may still change, as its adapter says",
    "by_iterations": "largest change from the row with fewer iterations, over the same",
    "by_time_step": "largest change from the row with the next longer step, over the same",
    "draft": DRAFT,
    "seconds": "that the program took",
    "because": "why there is no state; empty where there is one",
}
GAPS = ("iterations", "rest_error", "stated_rest", "by_iterations", "by_time_step", "seconds")


def run() -> kit.Evidence:
    """The table of all recorded rest states over steps and iterations."""
    rows = [row for record in records() for row in _rows(record)]
    table = pd.DataFrame(rows, columns=[*COLUMNS, "rounding"])
    shown = fill_gaps(table[[*COLUMNS]])
    shown["iterations"] = [each if each == NONE else int(each) for each in shown["iterations"]]
    return kit.Evidence(
        tables={"iterations": shown},
        tolerances=judge(table),
        findings=tuple(_findings(table)),
        columns=with_none(COLUMNS, *GAPS),
        figures={"iterations": drawing},
    )


def _rows(record: dict[str, Any]) -> list[dict[str, object]]:
    rows = []
    for state in record.get("iterations", ()):
        single = state["precision"] == "float32"
        values = (
            f"{record['name']} {state['label']}".strip(), state["beside"],
            _number(state["iterations"]), state["dt"], _number(state["error"]),
            _number(state["rest"]), _number(state["by_iterations"]), _number(state["by_dt"]),
            draft_of(record), _number(state["seconds"]), state["because"],
            ROUNDINGS * float(np.finfo(np.float32 if single else np.float64).eps) / STRAIN,
        )  # fmt: skip
        rows.append(dict(zip([*COLUMNS, "rounding"], values, strict=True)))
    return rows


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def judge(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """Errors of rest states over iterations and steps."""
    plain = table[table["iterations"].isna()]
    nothing = table.groupby("name")["rest_error"].apply(lambda errors: errors.isna().all())
    return (
        kit.Tolerance(
            "iterations: most that four times the iterations add to an error beyond what both say",
            0.0122, "1",
            "100 roundings of float32 over a strain of 2⁻¹⁰; a program nears its own law's rest",
            observed=kit.Observed(max((_added(rows) for _, rows in _iterative(table)),
            default=math.inf)),
        ),
        kit.Tolerance(
            "iterations: most that half the step moves a state beyond what both say, no iterations",
            0.0, "1",
            "steps that are exact, or solved to their end, leave a rest that no step changes",
            observed=kit.Observed(max((_beyond(rows) for _, rows in plain.groupby("name")),
            default=math.inf)),
        ),
        kit.Tolerance(
            "iterations: largest error without iterations", 0.01, "1",
            "the band of what a documented law predicts; rest states are stated far better than "
            "that",
            observed=kit.Observed(float(plain["rest_error"].max())),
        ),
        kit.Tolerance(
            "iterations: sweeps without a number", 0, "1", "each is asked for because it runs",
            observed=kit.Observed(float(nothing.sum())),
        ),
    )  # fmt: skip


def _iterative(table: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Rows of each step of programs whose own law they are held against."""
    known = table[table["iterations"].notna() & (table["law_beside"] != ASKED)]
    return [(str(key[0]), rows) for key, rows in known.groupby(["name", "time_step"])]


def _added(rows: pd.DataFrame) -> float:
    """Most by which `TIMES` as many iterations add to an error, beyond what both say; 0 if none."""
    by_count = rows.set_index("iterations")
    errors, stated = by_count["rest_error"], by_count["stated_rest"].fillna(0.0)
    later = [(count, TIMES * count) for count in errors.index if TIMES * count in errors.index]
    added = [float(errors[b] - errors[a] - stated[a] - stated[b]) for a, b in later]
    return max([0.0, *added])


def _beyond(rows: pd.DataFrame) -> float:
    """Largest change by half the step, less what both states say and rounding; 0 if none."""
    stated = rows["stated_rest"].fillna(0.0)
    left = rows["by_time_step"] - stated - stated.shift() - rows["rounding"]
    return max(0.0, float(left.max()))


def _findings(table: pd.DataFrame) -> list[str]:
    """Of each iterative program, what it began with and came to."""
    found = []
    for name, rows in table[table["iterations"].notna()].groupby("name", sort=False):
        known = rows.dropna(subset="rest_error").sort_values(["time_step", "iterations"])
        if known.empty:
            continue
        first = known[known["time_step"] == known["time_step"].max()].iloc[0]
        last = known[known["time_step"] == known["time_step"].min()].iloc[-1]
        beside = "the asked solid" if first["law_beside"] == ASKED else "its own law"
        states = f"{_state(first)}, and by {_state(last)}"
        found.append(f"{name}: beside {beside} off by {states} (a draft).")
    return found


def _state(row: pd.Series) -> str:
    """An error and where it is."""
    return (
        f"{row['rest_error']:.2g} of the displacement at {row['iterations']:.0f} iterations "
        f"of {row['time_step']:g} s (stated {row['stated_rest']:.1g})"
    )
