"""Rows of a table, told by what some of its columns hold."""

from __future__ import annotations

from typing import Any

import pandas as pd


def records(table: pd.DataFrame, **values: object) -> list[dict[str, Any]]:
    """The rows whose columns hold these values, in the table's order."""
    chosen = table
    for column, value in values.items():
        chosen = chosen[chosen[column] == value]
    return [{str(key): value for key, value in row.items()} for row in chosen.to_dict("records")]


def only(table: pd.DataFrame, **values: object) -> dict[str, Any]:
    """The one row whose columns hold these values."""
    (row,) = records(table, **values)
    return row
