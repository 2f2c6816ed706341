"""Tables as a page shows them: their first rows, numbers with six digits."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

import pandas as pd

from msvalidate.bench.judging.columns import column_key
from msvalidate.problem.records import dataclass

ROWS_SHOWN = 12
"""Longer tables are shown by their first rows; the CSV has them all."""
WHOLE = ("good_for", "topics", "ledger")
"""Tables of which every row is shown."""
TABLES_FIRST = ("good_for", "summary", "cases")
"""Tables that a reader wants first: above the others, and open."""
MANY_COLUMNS = 10
"""Tables with more columns are printed on pages that lie on their side."""
LONG = 28
"""Characters beyond which a cell is prose, which needs some width to be readable."""
_NUMBER = re.compile(r"[+-]?(?P<digits>\d+\.?\d*|\.\d+)(?P<power>[eE][+-]?\d+)?")


@dataclass(frozen=True)
class Column:
    """Name, meaning and head of a column, and how its cells are set."""

    name: str
    meaning: str
    kind: str
    label: str


@dataclass(frozen=True)
class Table:
    """The first rows of a table."""

    name: str
    columns: tuple[Column, ...]
    rows: tuple[tuple[str, ...], ...]
    length: int
    open: bool

    @property
    def wide(self) -> bool:
        """Return True if a table needs a landscape page in print."""
        return len(self.columns) > MANY_COLUMNS


def table_excerpt(
    name: str, content: pd.DataFrame, meanings: Mapping[str, str], labels: Mapping[str, str]
) -> Table:
    """The first rows of a table, its numbers with six digits."""

    def of(column: object, known: Mapping[str, str], default: str) -> str:
        return known.get(column_key(name, str(column), known), default)

    texts = {column: [str(value) for value in content[column]] for column in content}
    shown = len(content) if name in WHOLE else ROWS_SHOWN
    kept = [format_column(values)[:shown] for values in texts.values()]
    return Table(
        name=name,
        columns=tuple(
            Column(
                str(column),
                of(column, meanings, ""),
                column_kind(values),
                of(column, labels, str(column)),
            )
            for column, values in texts.items()
        ),
        rows=tuple(zip(*kept, strict=True)),
        length=len(content),
        open=name in TABLES_FIRST,
    )


def column_kind(values: Sequence[str]) -> str:
    """Classify a column as "number", "word" or "prose".

    A number among words makes it a column of numbers.
    """
    if any(_NUMBER.fullmatch(value) for value in values):
        return "number"
    return "prose" if any(len(value) > LONG for value in values) else "word"


def format_column(values: Sequence[str]) -> list[str]:
    """A column's values with six digits.

    If no value has more, they are left as they are: digits such as those of 0.2000 are meant.
    """
    if not any(_has_many_digits(value) for value in values):
        return list(values)
    return [format_number(float(value)) if _is_decimal(value) else value for value in values]


def format_number(value: float) -> str:
    """A number with six digits; zero has no sign."""
    return f"{value + 0.0:.6g}"


def _is_decimal(value: str) -> bool:
    """Return True for a number that is not written as an integer.

    All digits of integers are significant.
    """
    found = _NUMBER.fullmatch(value)
    return bool(found) and not value.lstrip("+-").isdigit()


def _has_many_digits(value: str) -> bool:
    """Return True for a decimal number with more than six digits."""
    found = _NUMBER.fullmatch(value)
    if found is None or not _is_decimal(value):
        return False
    return len(found["digits"].replace(".", "").lstrip("0")) > 6
