"""Rules: the rows of a table that are judged, their reference and limit."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from msvalidate.bench.judging.compare import Observed, Tolerance, observed_order
from msvalidate.problem import Array, SolverError
from msvalidate.problem.records import dataclass, field

MOST_NAMED = 6  # columns that say which row is meant


@dataclass(frozen=True)
class Quotient:
    """Row-wise quotient of two columns or numbers."""

    top: str | float
    bottom: str | float


@dataclass(frozen=True)
class Difference:
    """Row-wise difference of two columns or numbers."""

    first: str | float
    second: str | float


Term = str | float | Quotient | Difference | Callable[[pd.DataFrame], ArrayLike]
"""Column name, number, or function of the rows.

A function returns one number per row, or one.
"""


@dataclass(frozen=True, kw_only=True)
class Rule(Tolerance):
    """Tolerance of the row of a table that is farthest from its reference.

    Parameters
    ----------
    table
        Name of a table of the same evidence.
    value, reference
        What is compared, row by row.
    rows
        Column -> the value, or the tuple of values, that judged rows have in it; all are judged
        where none is given.
    by, last
        Columns whose values group the rows, and how many of each group are judged, from its end;
        0 judges all.
    power_of
        Judged is the exponent p of value ∝ power_of^p, one a group: an order where this is a
        spacing, ``Quotient(1, "cells")`` among them, a growth where it is a size.
    """

    table: str
    value: Term
    reference: Term = 0.0
    rows: Mapping[str, object] = field(default_factory=dict)
    by: tuple[str, ...] = ()
    last: int = 0
    power_of: Term | None = None

    def read(self, tables: Mapping[str, pd.DataFrame]) -> Tolerance:
        """The tolerance with what was observed: no function in it, so processes can send it."""
        plain = (self.quantity, self.limit, self.unit, self.because, self.layer)
        return Tolerance(*plain, read_rule(self, tables))


def read_rule(rule: Rule, tables: Mapping[str, pd.DataFrame]) -> Observed:
    """Observed value of the farthest row, with its reference and description.

    Raises
    ------
    ValueError
        If there is no such table, or no such column in it.
    SolverError
        If no row is selected, or a word stands where a number is judged.
    """
    if rule.table not in tables:
        raise ValueError(f"rule {rule.quantity!r}: no table {rule.table}; {_choices(tables)}")
    table = tables[rule.table]
    rows = _select(rule, table)
    groups = [rows]
    if keys := [_column(rule, rows, name) for name in rule.by]:
        groups = [group for _, group in rows.groupby(keys, sort=False)]
    groups = [group.iloc[-rule.last :] for group in groups]
    if rule.power_of is None:
        judged = pd.concat(groups)
        value = _evaluate(rule, rule.value, judged)
    else:
        judged = pd.concat([group.iloc[-1:] for group in groups])
        pairs = [[_evaluate(rule, t, g) for t in (rule.power_of, rule.value)] for g in groups]
        value = np.array([observed_order(base, power) for base, power in pairs])
    value, reference = np.broadcast_arrays(value, _evaluate(rule, rule.reference, judged))
    at = int(np.argmax(np.abs(value - reference)))  # argmax stops at the first NaN, which fails
    if len(value) != len(judged):
        return Observed(float(value[at]), float(reference[at]), len(value))
    name = _describe(rule, table, judged.iloc[at : at + 1])
    return Observed(float(value[at]), float(reference[at]), sum(map(len, groups)), name)


def _select(rule: Rule, table: pd.DataFrame) -> pd.DataFrame:
    for name, wanted in rule.rows.items():
        values = wanted if isinstance(wanted, tuple) else (wanted,)
        kept = table[_column(rule, table, name).isin(values)]
        if kept.empty:
            there = ", ".join(map(str, table[name].drop_duplicates().head(MOST_NAMED)))
            missing = f"no row of {rule.table} with {name} {wanted!r}; it has {there}"
            raise SolverError(f"rule {rule.quantity!r}: {missing}")
        table = kept
    return table


def _evaluate(rule: Rule, term: Term, rows: pd.DataFrame) -> Array:
    """Numbers (n,), a row each, or as many as a function gives; (1,) of a number."""
    if isinstance(term, Quotient):
        return _evaluate(rule, term.top, rows) / _evaluate(rule, term.bottom, rows)
    if isinstance(term, Difference):
        return _evaluate(rule, term.first, rows) - _evaluate(rule, term.second, rows)
    found = _column(rule, rows, term) if isinstance(term, str) else term
    try:
        return np.atleast_1d(np.asarray(found(rows) if callable(found) else found, dtype=float))
    except (TypeError, ValueError) as error:
        raise SolverError(f"rule {rule.quantity!r}: {term} of {rule.table}: {error}") from error


def _column(rule: Rule, table: pd.DataFrame, name: str) -> pd.Series:
    if name not in table:
        where = f"{name} in {rule.table}; {_choices(table)}"
        raise ValueError(f"rule {rule.quantity!r}: no column {where}")
    return table[name]


def _choices(known: Mapping[str, object] | pd.DataFrame) -> str:
    return f"choose from {', '.join(map(str, known))}"


def _describe(rule: Rule, table: pd.DataFrame, row: pd.DataFrame) -> str:
    """Describe a row by its key columns, or by words and whole numbers."""
    terms = (rule.value, rule.reference)
    parts = [p for t in terms for p in (vars(t).values() if hasattr(t, "__dict__") else [t])]
    used = [list(table).index(p) for p in parts if isinstance(p, str) and p in table]
    names = list(table.columns[: min(used)]) if used else list(table.select_dtypes(exclude="float"))
    values = [(name, row[name].iloc[0]) for name in names if table[name].nunique() > 1]
    shown = [f"{n} {v:g}" if isinstance(v, float) else f"{n} {v}" for n, v in values]
    return ", ".join(shown[:MOST_NAMED])
