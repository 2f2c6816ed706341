"""The first screen of the page: what springs are good for, from the studies' own tables."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from msvalidate.judging.compare import NOT_ASKED
from msvalidate.output.baseline import baseline_folder
from msvalidate.output.stored import Stored, read_csv
from msvalidate_check.words import AGREES, DIFFERS

OVERVIEW, ROWS = "overview", "good_for"
FIGURE = "overview/part.svg"
LEDGER, SENTENCES = "claims", "ledger"
PLURAL = {
    "holds": "hold",
    "holds only": "hold only on a condition",
    "does not hold": "do not hold",
    "not judged yet": "are not judged yet",
}
"""Verdicts of the ledger -> how their count is told."""
COMMITTED = "the committed baseline"
COLUMNS = (
    *("body", "springs", "across_coarse", "error_coarse", "error_at_20", "across_fine"),
    *("error_fine", "verdict", "condition", "cells_over_linear", "study", "table"),
)
TIMES = "time_over_linear_here"
"""A column that the committed baseline does not have."""


@dataclass(frozen=True)
class Line:
    """A row of the first screen, as words."""

    body: str
    springs: str
    coarse: str
    middle: str
    fine: str
    verdict: str
    condition: str
    cost: str
    study: str
    table: str


@dataclass(frozen=True)
class Front:
    """The first screen: advice, rows, where they come from, and the count of ledger's verdicts."""

    lines: tuple[Line, ...]
    advice: str
    source: str
    sentences: str
    judged_from: str


def first_screen(studies: Sequence[Stored]) -> Front:
    """The rows that were stored, else those of the committed baseline, else none."""
    rows, source = _table(studies, OVERVIEW, ROWS, set(COLUMNS))
    ledger, judged_from = _table(studies, LEDGER, SENTENCES, {"verdict"})
    told = rows.reindex(columns=[*COLUMNS, TIMES], fill_value=NOT_ASKED)
    lines = tuple(_line(*map(str, row)) for row in told.to_numpy())
    counts = Counter(str(verdict).partition(" if ")[0] for verdict in ledger.get("verdict", []))
    said = ", ".join(f"{counts[verdict]} {word}" for verdict, word in PLURAL.items() if counts)
    return Front(lines, _advice(lines), source, said, judged_from)


def _advice(lines: Sequence[Line]) -> str:
    """The first row and those that differ, in a few words."""
    if not lines or lines[0].verdict != AGREES:
        return ""
    best = lines[0]
    avoided = dict.fromkeys(line.springs for line in lines if line.verdict == DIFFERS)
    cells = best.cost.replace(" times", " times the cells of linear elements (Q1)", 1)
    cost = f" For 1 % they take {cells}." if cells != best.cost else ""
    never = f" Do not use: {'; '.join(avoided)}." if avoided else ""
    return (
        f"For the {best.body}: {best.springs} ({best.condition}), {best.middle} off at 20 cells "
        f"across.{cost}{never}"
    )


def _table(
    studies: Sequence[Stored], study: str, name: str, needed: set[str]
) -> tuple[pd.DataFrame, str]:
    """A table as text, and in words where it comes from: of the baseline where ours is damaged."""
    why = ""
    for stored in studies:
        if stored.name != study:
            continue
        table = stored.tables.get(name, pd.DataFrame())
        if not stored.error and len(table) and needed <= set(table):
            return table, f"the run of {stored.origin.get('time', 'unknown time')}"
        why = f", as what {study} left is not whole"
    path = baseline_folder("full") / study / f"{name}.csv"
    return (read_csv(path) if path.is_file() else pd.DataFrame()), COMMITTED + why


def _line(
    body: str,
    springs: str,
    coarse: str,
    first: str,
    middle: str,
    fine: str,
    last: str,
    verdict: str,
    condition: str,
    cost: str,
    study: str,
    table: str,
    time: str,
) -> Line:
    """A row in words, from its `COLUMNS` and `TIMES`."""
    return Line(
        body=body,
        springs=springs,
        coarse=f"{percent(first)} at {coarse}",
        middle=percent(middle),
        fine=f"{percent(last)} at {fine}",
        verdict=verdict,
        condition=condition,
        cost=times(cost) + (f" ({times(time)} the time)" if _is_number(time) else ""),
        study=study,
        table=table,
    )


def percent(text: str) -> str:
    """A share in per cent with two digits."""
    return f"{100 * float(text):.2g} %" if _is_number(text) else text


def times(text: str) -> str:
    """A factor with two digits."""
    return f"{float(text):.2g} times" if _is_number(text) else text


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
