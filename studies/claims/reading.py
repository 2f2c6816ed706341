"""Numbers of the ledger, read from studies' tables as `ledger.toml` says."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit

Query = Mapping[str, Any]
COMBINE = {"over": np.divide, "less": np.subtract}
"""What is done with a second number, column, or the same column of other rows, in this order."""
TAKES: Mapping[str, Callable[[kit.Array], Any]] = {
    "only": lambda values: values,
    "max": np.max,
    "min": np.min,
    "farthest": lambda values: np.abs(values).max(),
    "nearest": lambda values: np.abs(values).min(),
    "factor": lambda values: np.maximum(values, 1 / values).max(),
    "count": np.size,
}
"""How one number comes of many; beside these "share" of rows, and "growth" from size to size."""


def read(results: kit.Results, query: Query) -> float:
    """The number (in its unit) that a query asks for.

    Raises
    ------
    ProblemError
        If there is no such table, column or row, or not one number.
    """
    where = query.get("where", {})
    table = select(results, query, where)
    take = query.get("take", "only")
    if take == "share":
        return share(list(table[query["column"]]), query)
    values = numbers(table, query)
    for word, combine in COMBINE.items():
        if word in query:
            values = combine(values, second(results, query, table, query[word]))
    if take == "growth":
        means = pd.Series(values).groupby(table[query["by"]].to_numpy(dtype=float)).mean()
        values, take = np.array([means.iloc[-1] / means.iloc[0]]), "only"
    found = np.ravel(TAKES[take](values)) * query.get("times", 1)
    if found.size != 1 or not np.isfinite(found).all():
        raise kit.ProblemError(f"{query['from']}: {found.size} numbers with {dict(where)}, not one")
    return float(found[0])


def select(results: kit.Results, query: Query, where: Mapping[str, Any]) -> pd.DataFrame:
    """Rows of a table in which columns have some values, of the last size."""
    study, _, name = query["from"].partition("/")
    table = results.table(study, name)
    tests = (("between", within), ("without", unlike))
    conditions = [(alike, *each) for each in where.items()]
    conditions += [(test, *each) for word, test in tests for each in query.get(word, {}).items()]
    for test, column, value in conditions:
        require(table, column, query)
        table = table[[test(each, value) for each in table[column]]]
    for column in np.atleast_1d(query.get("last", [])):
        require(table, column, query)
        table = table[table[column] == table[column].max()]
    if table.empty:
        raise kit.ProblemError(f"{query['from']}: no row with {dict(where)}; run {study} again")
    return table


def last_sizes(results: kit.Results, query: Query) -> str:
    """The sizes to which a query is limited, in words."""
    table = select(results, query, query.get("where", {}))
    sizes = (f"{name} = {table[name].iloc[0]:g}" for name in np.atleast_1d(query.get("last", [])))
    return ", ".join(sizes)


def require(table: pd.DataFrame, column: str, query: Query) -> None:
    """Raise ProblemError if a table lacks a column."""
    if column not in table:
        raise kit.ProblemError(
            f"{query['from']}: no column {column} among {', '.join(map(str, table))}"
        )


def alike(found: Any, value: Any) -> bool:
    """Whether a cell is a value or one of several; numbers to a millionth."""
    if isinstance(value, list):
        return any(alike(found, each) for each in value)
    if isinstance(found, str) or isinstance(value, str):
        return str(found) == str(value)
    return bool(np.isclose(found, value, rtol=1e-6, atol=0))


def unlike(found: Any, value: Any) -> bool:
    """Whether a cell is another value."""
    return not alike(found, value)


def within(found: Any, ends: Any) -> bool:
    """Whether a number lies between two, or on one of them."""
    return bool(ends[0] <= found <= ends[1])


def numbers(table: pd.DataFrame, query: Query) -> kit.Array:
    """A column's numbers (n,), those of several one after another or their sum; no word to skip."""
    found = []
    for column in np.atleast_1d(query["column"]):
        require(table, column, query)
        found.append([value for value in table[column] if value != query.get("skip")])
    if not found[0] or any(isinstance(value, str) for values in found for value in values):
        raise kit.ProblemError(f"{query['from']}: {found[0][:3]} are no numbers to judge by")
    every = np.array(found, dtype=float)
    return every.sum(axis=0) if "sum" in query else every.ravel()


def second(
    results: kit.Results, query: Query, table: pd.DataFrame, other: Any
) -> float | kit.Array:
    """What a column is divided by, or less: a number, a column, or the same column elsewhere."""
    if isinstance(other, str):
        return numbers(table, {**query, "column": other})
    if isinstance(other, Mapping):
        return numbers(select(results, query, {**query.get("where", {}), **other}), query)
    return float(other)


def share(column: Sequence[Any], query: Query) -> float:
    """Part of the cells that are a word, or a number and no less than the `least`."""
    kept = [value for value in column if value != query.get("skip")]
    if "equal" in query:
        return float(np.mean([value == query["equal"] for value in kept]))
    return float(np.mean(np.array(kept, dtype=float) >= query["least"]))
