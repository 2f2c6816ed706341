"""Records of the ledger: a sentence of the report, and by which numbers it is judged.

A verdict is computed from numbers and bounds, and stands nowhere as a word of its own.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pandas as pd

from msvalidate.output.results import Results
from msvalidate.problem import Array, ProblemError

HOLDS, ONLY_IF, FAILS = "holds", "holds only if", "does not hold"
NOT_YET = "not judged yet"
VERDICTS = (HOLDS, ONLY_IF, FAILS, NOT_YET)
NONE = "none"
"""Where there is no number, and where no study's table is named."""
Reading = Callable[[Results], float]
Side = Literal["at most", "at least"]
AT_MOST: Side = "at most"
AT_LEAST: Side = "at least"


@dataclass(frozen=True)
class Check:
    """A number that studies found, and the bound within which a sentence holds.

    Parameters
    ----------
    study, table
        Where the number comes from.
    measure, unit
        What it says.
    read
        Takes it from the studies' results.
    side, bound
        It holds if it is at most, or at least, so much.
    because
        Why that bound.
    """

    study: str
    table: str
    measure: str
    unit: str
    read: Reading
    side: Side
    bound: float
    because: str

    def number(self, results: Results, sentence: int) -> float:
        """What is read; raises ProblemError, naming the sentence, if a table does not have it."""
        try:
            return float(self.read(results))
        except (ProblemError, LookupError, ValueError) as error:
            place = f"sentence {sentence}, from {self.study}/{self.table}"
            raise ProblemError(f"{place}: {error}") from error

    def holds(self, number: float) -> bool:
        """Whether a number is on the right side of the bound, or on it."""
        return number <= self.bound if self.side == AT_MOST else number >= self.bound

    def moved(self, number: float) -> float:
        """A number as far beyond the bound as the given one is on this side of it.

        Beyond a bound on which the number lies it is by 1, or by a thousandth of the bound.
        """
        if number != self.bound:
            return 2 * self.bound - number
        step = abs(self.bound) / 1000 or 1.0
        return self.bound + (step if self.side == AT_MOST else -step)


@dataclass(frozen=True)
class Claim:
    """A sentence of the report.

    Parameters
    ----------
    number, place, statement
        Its number in the ledger, where it stands, and what it says, in our words.
    check
        Under which it holds as it stands; None where nothing judges it yet.
    condition, conditional
        Words for a condition, and the check under which the sentence holds on it.
    expected, theory
        The verdict that theory lets expect and why, so that a moved result is noticed; of a
        sentence that is not judged, `theory` says why not.
    """

    number: int
    place: str
    statement: str
    expected: str
    theory: str
    check: Check | None = None
    condition: str = ""
    conditional: Check | None = None

    def decide(self, plain: float, under_condition: float | None) -> str:
        """Verdict from the number of the sentence as it stands, and from that of its condition."""
        if self.check is None:
            return NOT_YET
        if self.check.holds(plain):
            return HOLDS
        if self.conditional is None or under_condition is None:
            return FAILS
        if not self.conditional.holds(under_condition):
            return FAILS
        return f"{ONLY_IF} {self.condition}"


def kind(verdict: str) -> str:
    """A verdict without its condition."""
    return ONLY_IF if verdict.startswith(ONLY_IF) else verdict


def rows(results: Results, place: str, **where: Any) -> pd.DataFrame:
    """Rows of a table, named "study/table", whose columns have these values.

    Raises
    ------
    ProblemError
        If there is no such table, column or row.
    """
    study, _, name = place.partition("/")
    table = results.table(study, name)
    for column, value in where.items():
        if column not in table:
            raise ProblemError(f"{place}: no column {column}; run {study} again")
        table = table[table[column] == value]
    if table.empty:
        asked = ", ".join(f"{column} = {value}" for column, value in where.items())
        raise ProblemError(f"{place}: no row with {asked}; run {study} again")
    return table


def numbers(table: pd.DataFrame, column: str, word: str = "") -> Array:
    """A column (n,) as numbers; values that are `word` are left out.

    Raises
    ------
    ProblemError
        If there is no such column, none is left, or another word stands among them.
    """
    if column not in table:
        raise ProblemError(f"no column {column} among {', '.join(map(str, table))}")
    kept = [value for value in table[column] if not (word and value == word)]
    if not kept or any(isinstance(value, str) for value in kept):
        raise ProblemError(f"column {column}: {kept[:3]} are no numbers to judge by")
    return np.array(kept, dtype=float)


def column(results: Results, place: str, name: str, word: str = "", **where: Any) -> Array:
    """Numbers (n,) of a column in the rows of a table that have these values."""
    return numbers(rows(results, place, **where), name, word)


def value(results: Results, place: str, name: str, **where: Any) -> float:
    """The number of a column in the one row that has these values.

    Raises
    ------
    ProblemError
        If there is no such row, or several.
    """
    found = column(results, place, name, **where)
    if len(found) > 1:
        raise ProblemError(f"{place}: {len(found)} rows with {where}; one is asked for")
    return float(found[0])


def finest(results: Results, place: str, by: str, **where: Any) -> pd.DataFrame:
    """Rows of the largest number in the column `by`."""
    table = rows(results, place, **where)
    sizes = numbers(table, by)
    largest: pd.DataFrame = table[sizes == sizes.max()]
    return largest


def unjudged(number: int, place: str, statement: str, reason: str) -> Claim:
    """A sentence that no table judges, and why."""
    return Claim(number, place, statement, NOT_YET, reason)
