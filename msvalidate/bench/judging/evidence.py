"""Evidence of a study and its verdict, independent of any solver."""

from __future__ import annotations

import difflib
from collections.abc import Callable, Iterable, Mapping
from typing import TypeVar

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bench.judging.columns import Column, column_key, common_columns
from msvalidate.bench.judging.compare import Observed, Tolerance
from msvalidate.bench.judging.rules import Rule
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import format_value, require_type
from msvalidate.problem.records import dataclass, field
from msvalidate_check.verdict import AGREES, NOT_AT_REST, NOT_RESOLVED

T = TypeVar("T")
Tables = Mapping[str, pd.DataFrame]
HELD, OPEN = ("pass", AGREES), (NOT_RESOLVED, NOT_AT_REST)
"""Verdicts of passed rows, and of rows that are not resolved.

Any other verdict is a failure.
"""
UNGATED = ("_seconds", "_per_second", "_bytes", "_here")
"""Endings of columns that depend on the machine and are not compared with the baseline."""


@dataclass(frozen=True, eq=False)
class Evidence:
    """Result of a study: tables, observed values, tolerances, figures and findings.

    Parameters
    ----------
    tables
        Name -> table; a table has rows, and no number in it is missing.
    figures, drawn
        Name -> function that draws the figure from the tables; and tables that only figures need,
        which are neither written nor compared.
    observed, tolerances
        Every observed quantity has a tolerance and the reverse. A rule reads its own off a table,
        and is a plain tolerance from then on; another may carry it.
    columns
        Column -> what it means and its unit, as text or `Column`, for every column of every table
        but those of `common_columns`; "table.column" holds for one table alone. Kept are
        those that the tables have, as text.
    rounding
        Column -> as `Column.rounding`, which enters it.
    labels
        Column -> as `Column.label`, which enters it.
    cover
        Name of the figure that the page shows first, a picture of a body; "" for the first figure.
    findings
        Sentences that say what was found; numbers in them come from the tables.

    Raises
    ------
    SolverError
        If a table is empty or holds a number that is not finite: that is a failure, not a result.
    """

    tables: Tables
    observed: Mapping[str, Observed] = field(default_factory=dict)
    tolerances: tuple[Tolerance, ...] = ()
    figures: Mapping[str, Callable[[Tables], Figure]] = field(default_factory=dict)
    columns: Mapping[str, str | Column] = field(default_factory=dict)
    findings: tuple[str, ...] = ()
    rounding: Mapping[str, float] = field(default_factory=dict)
    labels: Mapping[str, str] = field(default_factory=dict)
    drawn: Tables = field(default_factory=dict)
    cover: str = ""

    def __post_init__(self) -> None:
        known = {**common_columns(), **self.columns}
        used = {
            column_key(name, str(column), known)
            for name, table in self.tables.items()
            for column in table
        }
        meanings = {column: str(known[column]) for column in known if column in used}
        rounding = {
            name: entry.rounding
            for name, entry in known.items()
            if name in used and isinstance(entry, Column) and entry.rounding
        } | dict(self.rounding)
        for name, table in self.tables.items():
            if table.empty:
                raise SolverError(f"table {name}: no rows; nothing was compared")
            for column in table:
                bad = np.flatnonzero([_is_missing(value) for value in table[column]])
                if len(bad):
                    raise SolverError(
                        f"table {name}: {column} is {table[column].iloc[bad[0]]} in row {bad[0]}"
                    )
            keys = {str(column): column_key(name, str(column), known) for column in table}
            unexplained = [column for column, key in keys.items() if key not in meanings]
            if unexplained:
                raise ValueError(f"table {name}: columns without a meaning: {unexplained}")
            for column in table:
                meaning = meanings[keys[str(column)]]
                undeclared = _words_among_numbers(table[column]) - _words(meaning)
                if undeclared:
                    raise ValueError(
                        f"table {name}: {column} holds {sorted(undeclared)} among numbers, which "
                        "its meaning does not name"
                    )
        tolerances = tuple(
            tolerance.read(self.tables) if isinstance(tolerance, Rule) else tolerance
            for tolerance in self.tolerances
        )
        quantities = [tolerance.quantity for tolerance in tolerances]
        seen = {t.quantity: t.observed for t in tolerances if t.observed is not None}
        observed = {**self.observed, **seen}
        labels = {
            name: entry.label
            for name, entry in known.items()
            if name in used and isinstance(entry, Column) and entry.label
        } | dict(self.labels)
        object.__setattr__(self, "labels", labels)
        own = (("columns", meanings), ("rounding", rounding), ("tolerances", tolerances))
        for name, value in (*own, ("observed", observed)):
            object.__setattr__(self, name, value)
        unjudged = set(quantities) ^ set(observed)
        if unjudged or len(set(quantities)) < len(quantities):
            raise ValueError(
                f"observed without a tolerance, the reverse, or twice: {sorted(unjudged)}"
            )


def merge(*parts: Evidence) -> Evidence:
    """Combine the evidence of a study's questions.

    Raises
    ------
    ValueError
        If two parts use one name for a table, figure or quantity.
    """
    tables: dict[str, pd.DataFrame] = {}
    drawn: dict[str, pd.DataFrame] = {}
    figures: dict[str, Callable[[Tables], Figure]] = {}
    observed: dict[str, Observed] = {}
    columns: dict[str, str] = {}
    rounding: dict[str, float] = {}
    labels: dict[str, str] = {}
    for part in parts:
        labels |= part.labels
        rounding |= {c: max(size, rounding.get(c, 0.0)) for c, size in part.rounding.items()}
        _join(tables, part.tables)
        _join(drawn, part.drawn)
        _join(figures, part.figures)
        _join(observed, part.observed)
        for column, meaning in part.columns.items():
            if columns.setdefault(column, str(meaning)) != meaning:
                raise ValueError(f"column {column} means two things: {meaning!r} is one of them")
    return Evidence(
        tables=tables,
        observed=observed,
        tolerances=tuple(t for part in parts for t in part.tolerances),
        figures=figures,
        columns=columns,
        findings=tuple(f for part in parts for f in part.findings),
        rounding=rounding,
        labels=labels,
        drawn=drawn,
        cover=next((part.cover for part in parts if part.cover), ""),
    )


def gather_evidence(
    study: Mapping[str, Callable[[], Evidence]], questions: Iterable[str] | None = None
) -> Evidence:
    """Evidence of a study from its selected questions, by default all.

    Raises
    ------
    ProblemError
        If none is asked, or one that is none of the study's.
    """
    if questions is None:
        return merge(*(answer() for answer in study.values()))
    # A text is a row of letters to Python; a reader means one question.
    if isinstance(questions, str) or not isinstance(questions, Iterable):
        raise ProblemError(
            f"questions: {format_value(questions)}; choose from {', '.join(study)}, in a tuple"
        )
    asked = list(questions)
    unknown = [name for name in asked if name not in study]
    if unknown or not asked:
        near = difflib.get_close_matches(str(unknown[0]), study, n=1) if unknown else []
        hint = f"did you mean {near[0]!r}? " if near else ""
        given = format_value(unknown[0]) if unknown else "none"
        raise ProblemError(f"questions: {given}; {hint}choose from {', '.join(study)}")
    return merge(*(answer() for name, answer in study.items() if name in asked))


def judge(evidence: Evidence) -> pd.DataFrame:
    """Compare every observed quantity of a study with its tolerance.

    Parameters
    ----------
    evidence
        Tables, observed values and tolerances that a study returns.

    Returns
    -------
    pandas.DataFrame
        One row per tolerance, with the observed value, reference, error and limit in the unit of
        the quantity, and "pass" or "fail" in the column ``verdict``. A value that is not finite
        fails.

    Raises
    ------
    ProblemError
        If the argument is no `kit.Evidence`.

    Examples
    --------
    >>> import pandas as pd
    >>> from msvalidate import judge, kit
    >>> measured = kit.Observed(1.02, reference=1.0)
    >>> reason = "the ruler has marks every 10 mm"
    >>> length = kit.Tolerance("length", limit=0.01, unit="m", because=reason, observed=measured)
    >>> table = pd.DataFrame({"length_m": [1.02]})
    >>> columns = {"length_m": "measured length in m"}
    >>> evidence = kit.Evidence(tables={"lengths": table}, tolerances=(length,), columns=columns)
    >>> judge(evidence)["verdict"].tolist()
    ['fail']
    """
    require_type("evidence", evidence, Evidence)
    rows = [judge_one(each, evidence.observed[each.quantity]) for each in evidence.tolerances]
    return pd.DataFrame(rows) if rows else nothing_judged()


def nothing_judged() -> pd.DataFrame:
    """Verdict without rows."""
    return pd.DataFrame([judge_one(Tolerance("", 0.0, "1", "none"), Observed(0.0))]).iloc[:0]


def judge_one(tolerance: Tolerance, observed: Observed) -> dict[str, object]:
    """Row of a verdict: layer, quantity, unit, observed, reference, error, limit, verdict, because.

    Beside them, of how many `rows` of a table this is the farthest, and `at` which of them.

    A value that is not finite fails.
    """
    within = np.isfinite(observed.error) and observed.error <= tolerance.limit
    return {
        "layer": tolerance.layer,
        "quantity": tolerance.quantity,
        "unit": tolerance.unit,
        "observed": float(observed.value),
        "reference": float(observed.reference),
        "error": float(observed.error),
        "limit": float(tolerance.limit),
        "verdict": "pass" if within else "fail",
        "because": tolerance.because,
        "rows": observed.rows,
        "at": observed.at,
    }


def all_passed(verdict: pd.DataFrame) -> bool:
    """Return True if rows of a verdict passed and none failed; see `HELD`."""
    if verdict.empty:
        return False
    return bool(verdict["verdict"].isin(HELD).any()) and not is_missed(verdict).any()


def is_missed(verdict: pd.DataFrame) -> pd.Series:
    """Mask of the failed rows of a verdict."""
    return ~verdict["verdict"].isin((*HELD, *OPEN))


def _is_missing(value: object) -> bool:
    """Not a finite number where one is expected. A declared word is a value."""
    return value is None or (isinstance(value, float | np.floating) and not np.isfinite(value))


def _words_among_numbers(values: pd.Series) -> set[str]:
    """Words of a column that holds numbers as well."""
    words = {value for value in values if isinstance(value, str)}
    return words if words and any(not isinstance(value, str) for value in values) else set()


def _words(meaning: str) -> set[str]:
    """Words that a column's meaning declares, in double quotes."""
    return set(meaning.split('"')[1::2])


def _join(whole: dict[str, T], piece: Mapping[str, T]) -> None:
    twice = set(whole) & set(piece)
    if twice:
        raise ValueError(f"two questions of one study both name {sorted(twice)}")
    whole |= piece
