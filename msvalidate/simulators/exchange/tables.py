"""Tables of numbers with a row a node, as adapters are given them and write them."""

from __future__ import annotations

import csv
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from msvalidate.case.results import refuse_wide
from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import format_value


def read_table(path: Path, columns: Sequence[str]) -> Array:
    """Numbers (n, k) in a CSV file with a header, in the order of its column `id` if it has one.

    Parameters
    ----------
    path
        The file.
    columns
        Those wanted, in this order.

    Raises
    ------
    ProblemError
        If there is no such file, a column is missing, an entry is no number, or `id` does not
        number the rows from 0. NaN, written so, is a number here.
    """
    said = f"table {format_value(path.name)}"
    try:
        with path.open(newline="", encoding="utf-8-sig") as lines:
            refuse_wide(lines)
        # As texts, whose numbers Python reads exactly: the library's own way differs by version.
        text = pd.read_csv(
            path, skipinitialspace=True, encoding="utf-8-sig", keep_default_na=False, dtype=str
        )
    except OSError as error:
        raise ProblemError(f"{said}: {error.strerror}; write it") from error
    except (csv.Error, ValueError) as error:
        why = " ".join(str(error).split())
        raise ProblemError(f"{said}: not a table: {format_value(why)}; write it again") from error
    text.columns = [str(name).strip() for name in text.columns]
    missing = [name for name in columns if name not in text.columns]
    if missing:
        there = ", ".join(map(str, text.columns))
        raise ProblemError(f"{said}: no column {missing[0]}; it has {format_value(there)}")
    found = np.empty((len(text), len(columns)))
    for place, name in enumerate(columns):
        found[:, place] = _numbers(said, name, text[name].to_list())
    if "id" in text.columns:
        return _by_id(said, _numbers(said, "id", text["id"].to_list()), found)
    return found


def _numbers(said: str, name: str, texts: list[str]) -> Array:
    found = np.empty(len(texts))
    for row, each in enumerate(texts):
        try:
            found[row] = float(each)
        except (TypeError, ValueError) as error:
            shown = format_value(each)
            raise ProblemError(
                f"{said}: {name} in row {row + 1}: {shown}; give a number"
            ) from error
    return found


def _by_id(said: str, number: Array, rows: Array) -> Array:
    order = np.argsort(number, kind="stable")
    wrong = np.flatnonzero(number[order] != np.arange(len(rows)))
    if len(wrong):
        at = wrong[0]
        raise ProblemError(
            f"{said}: id {number[order][at]:g} where {at} is due; number each row once, from 0"
        )
    return np.ascontiguousarray(rows[order])
