"""Summary of a study: one short table that compares springs with a reference.

The table `summary` stands first in the terminal and on the page of a study. Its columns are the
same in all studies, and `columns.toml` of a study may change their labels.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping

import pandas as pd

from msvalidate_check.verdict import agreement

NAME = "summary"
MAX_ROWS = 10
"""Maximum number of rows: a reader surveys no more at a glance."""
TOLERANCE = 0.05
"""Largest relative difference that counts as agreement: a spring model in use replaces a material
whose constants are known to some per cent."""
RELATIVE = ("difference", "tolerance")
"""Columns that are shown as percentages."""
NONE = "none"
"""Entry of a row without a reference or without a number."""


def summary_row(
    case: str,
    springs: float,
    reference: float | None,
    *,
    scale: float | None = None,
    uncertainty: float = 0.0,
    tolerance: float = TOLERANCE,
    more: Mapping[str, object] | None = None,
) -> dict[str, object]:
    """Row of a summary: both values, their relative difference and its verdict.

    Parameters
    ----------
    case
        Body, load and springs of the row, in words.
    springs, reference
        Values of the springs and of the reference in one unit. A row without a reference has no
        difference and no verdict.
    scale
        Size that the difference is relative to, by default that of the reference. A positive
        difference means that the springs give the larger value.
    uncertainty
        Error of the reference, relative to the scale.
    tolerance
        Largest relative difference that counts as agreement.
    more
        Further columns, placed before the verdict.
    """
    row: dict[str, object] = {"case": case, "springs": springs}
    if reference is None:
        row |= {"reference": NONE, "difference": NONE, "tolerance": NONE}
        return row | dict(more or {}) | {"verdict": NONE}
    size = abs(reference) if scale is None else scale
    difference = (springs - reference) / math.copysign(size, reference) if size else math.inf
    row |= {"reference": reference, "difference": difference, "tolerance": tolerance}
    verdict = agreement(difference, uncertainty, tolerance)
    return row | dict(more or {}) | {"verdict": verdict}


def summary_tables(rows: Iterable[Mapping[str, object]]) -> dict[str, pd.DataFrame]:
    """Return the table `summary` under its name, for `Evidence.tables`.

    Raises
    ------
    ValueError
        If there are more than `MAX_ROWS` rows.
    """
    table = pd.DataFrame(list(rows))
    if len(table) > MAX_ROWS:
        raise ValueError(f"table {NAME}: {len(table)} rows; give at most {MAX_ROWS}")
    return {NAME: table}
