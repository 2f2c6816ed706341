"""Tables in which some numbers are not there."""

from __future__ import annotations

from collections.abc import Mapping

import pandas as pd

NONE = "none"
"""Stands in a table where there is no number."""

ASKED_RATIO = f'Poisson\'s ratio asked for; "{NONE}" where there is no number'
"""Meaning of a column of several tables, one of which has rows without."""


def fill_gaps(table: pd.DataFrame) -> pd.DataFrame:
    """The table with `NONE` where a number is missing."""
    return table.astype(object).where(table.notna(), NONE)


def with_none(columns: Mapping[str, str], *names: str) -> dict[str, str]:
    """Meanings of columns, some of which may hold `NONE`."""
    return {
        name: f'{words}; "{NONE}" where there is no number' if name in names else words
        for name, words in columns.items()
    }
