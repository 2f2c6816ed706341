"""Tables of numbers with a row a node, as adapters are given them and write them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from msvalidate.problem import Array, ProblemError
from msvalidate.problem.checks import format_value


def read_table(path: Path, columns: Sequence[str] | None) -> Array:
    """Numbers (n, k) in a CSV file with a header, in the order of its column `id` if it has one.

    Parameters
    ----------
    path
        The file.
    columns
        Those wanted, in this order; None takes all but `id`.

    Raises
    ------
    ProblemError
        If there is no such file, a column is missing, an entry is no number, or `id` does not
        number the rows from 0. NaN, written so, is a number here.
    """
    said = f"table {format_value(path.name)}"
    try:
        text = pd.read_csv(
            path,
            skipinitialspace=True,
            float_precision="round_trip",
            encoding="utf-8-sig",
            keep_default_na=False,
            na_values=["nan", "NaN", "-nan"],
        )
    except OSError as error:
        raise ProblemError(f"{said}: {error.strerror}; write it") from error
    except (ValueError, pd.errors.ParserError, pd.errors.EmptyDataError) as error:
        why = " ".join(str(error).split())
        raise ProblemError(f"{said}: not a table: {format_value(why)}; write it again") from error
    text.columns = [str(name).strip() for name in text.columns]
    wanted = [name for name in text.columns if name != "id"] if columns is None else [*columns]
    missing = [name for name in wanted if name not in text.columns]
    if missing:
        there = ", ".join(map(str, text.columns))
        raise ProblemError(f"{said}: no column {missing[0]}; it has {format_value(there)}")
    for name in ["id", *wanted] if "id" in text.columns else wanted:
        if text[name].dtype.kind not in "iuf":
            bad = pd.to_numeric(text[name], errors="coerce").isna().to_numpy().argmax()
            shown = format_value(text[name].iloc[bad])
            raise ProblemError(f"{said}: {name} in row {bad + 1}: {shown}; give a number")
    found = text[wanted].to_numpy(dtype=float)
    if "id" in text.columns:
        found = _by_id(said, text["id"].to_numpy(dtype=float), found)
    return np.ascontiguousarray(found)


def _by_id(said: str, number: Array, rows: Array) -> Array:
    order = np.argsort(number, kind="stable")
    wrong = np.flatnonzero(number[order] != np.arange(len(rows)))
    if len(wrong):
        at = wrong[0]
        raise ProblemError(
            f"{said}: id {number[order][at]:g} where {at} is due; number each row once, from 0"
        )
    return np.asarray(rows[order])
