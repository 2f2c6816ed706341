"""Table `summary` of a study as text, for the terminal, the page and documents."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

from msvalidate.bench.judging.columns import column_key
from msvalidate.bench.judging.evidence import Evidence
from msvalidate.bench.judging.summary import NAME, RELATIVE
from msvalidate_check.text import align_table, number_text, percent


def summary_texts(
    table: pd.DataFrame, labels: Mapping[str, str]
) -> tuple[list[str], list[list[str]], list[bool]]:
    """Heads, rows of text, and columns of numbers of a summary.

    Parameters
    ----------
    table
        The summary, its numbers as numbers or as text.
    labels
        Column, or "summary.column" -> head of the column.
    """
    names = list(map(str, table))
    keys = [column_key(NAME, name, labels) for name in names]
    heads = [labels.get(key, name) for key, name in zip(keys, names, strict=True)]
    columns = [[_text(name, value) for value in table[name]] for name in names]
    numeric = [any(is_number(value) for value in table[name]) for name in names]
    return heads, [list(row) for row in zip(*columns, strict=True)], numeric


def summary_lines(table: pd.DataFrame, evidence: Evidence) -> list[str]:
    """Lines of a summary for a terminal: its quantity, then the table."""
    quantity = str(evidence.columns[column_key(NAME, "springs", evidence.columns)])
    return [
        f"{quantity[:1].upper()}{quantity[1:]}:",
        *align_table(*summary_texts(table, evidence.labels)),
    ]


def summary_sentence(table: pd.DataFrame) -> str:
    """Sentence with the largest difference of a summary; empty without a verdict."""
    judged = table[table["difference"].map(is_number)]
    if judged.empty:
        return ""
    size = judged["difference"].astype(float).abs()
    case = judged["case"].iloc[int(size.argmax())]
    return f"The largest difference is {percent(float(size.max()))} ({case})."


def _text(name: str, value: object) -> str:
    if not is_number(value):
        return str(value)
    number = float(str(value))
    return percent(number) if name in RELATIVE else number_text(number)


def is_number(value: object) -> bool:
    """Return True if a value is a number or the text of one."""
    try:
        float(str(value))
    except ValueError:
        return False
    return True
