"""Records of the ledger: a sentence of the report, and by which numbers it is judged.

A verdict is computed from numbers and bounds, and stands nowhere as a word of its own.
"""

from __future__ import annotations

import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from msvalidate import kit

from .reading import Query, read

TRUE, WHERE, IF, FALSE = "true", "true where the source says", "false as said, true if", "false"
NOT_YET, BACKGROUND = "not judged yet", "background"
VERDICTS = (TRUE, WHERE, IF, FALSE, NOT_YET, BACKGROUND)
NONE = "none"
"""Where there is no number, and where no study's table is named."""
LEDGER = tomllib.loads((Path(__file__).parent / "ledger.toml").read_text(encoding="utf-8"))
AT_MOST, AT_LEAST = "at most", "at least"


@dataclass(frozen=True)
class Check:
    """A number that studies found, and the bound that it has to keep to."""

    query: Query
    measure: str
    unit: str
    side: str
    bound: float
    because: str

    @property
    def table(self) -> str:
        """Where the number comes from: "study/table"."""
        return str(self.query["from"])

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
class Sentence:
    """A sentence of the report.

    Parameters
    ----------
    number, place, phrase
        Its number in the ledger, where it stands, and what it says, quoted.
    expected, theory
        The verdict that theory lets expect, and why; where nothing is judged, why not.
    said
        Checks under all of which it is true as said.
    condition, under
        In words, and the checks under all of which it is true on that condition.
    stated
        Whether the source itself names the condition.
    misprint
        Whether it cannot be evaluated as printed, and so is false as said.
    """

    number: int
    place: str
    phrase: str
    expected: str
    theory: str
    said: tuple[Check, ...] = ()
    condition: str = ""
    under: tuple[Check, ...] = ()
    stated: bool = False
    misprint: bool = False

    @property
    def judged(self) -> bool:
        """Whether there is a number to judge by."""
        return bool(self.said or self.under)

    def decide(self, said: Sequence[float], under: Sequence[float]) -> str:
        """Verdict, one of `VERDICTS`, from the numbers of the two kinds of checks."""
        if not self.judged:
            return self.expected if self.expected in (NOT_YET, BACKGROUND) else NOT_YET
        if not self.misprint and holds(self.said, said):
            return TRUE
        if not self.under or not holds(self.under, under):
            return FALSE
        return WHERE if self.stated else IF

    def words(self, verdict: str) -> str:
        """A verdict with the condition that goes with it."""
        return f"{verdict} {self.condition}" if verdict == IF else verdict

    def numbers(self, results: kit.Results) -> tuple[list[float], list[float]]:
        """Of both kinds of checks; raises ProblemError, naming the sentence, if one is missing."""
        found: tuple[list[float], list[float]] = ([], [])
        for kept, checks in zip(found, (self.said, self.under), strict=True):
            for check in checks:
                try:
                    kept.append(read(results, check.query))
                except (kit.ProblemError, LookupError, ValueError) as error:
                    place = f"sentence {self.number}, from {check.table}"
                    raise kit.ProblemError(f"{place}: {error}") from error
        return found


def holds(checks: Sequence[Check], numbers: Sequence[float]) -> bool:
    """Whether every number keeps to its bound."""
    return all(check.holds(number) for check, number in zip(checks, numbers, strict=True))


def make_check(entry: Mapping[str, Any]) -> Check:
    """A check from its entry in the ledger, which names one bound."""
    (side,) = {"at_most", "at_least"} & set(entry)
    return Check(
        query=entry,
        measure=entry["measure"],
        unit=entry.get("unit", "1"),
        side=side.replace("_", " "),
        bound=float(entry[side]),
        because=entry["because"],
    )


def make_sentence(entry: Mapping[str, Any]) -> Sentence:
    """A sentence from its entry in the ledger."""
    words = {key: value for key, value in entry.items() if key not in ("said", "under", "if")}
    said, under = (tuple(map(make_check, entry.get(kind, ()))) for kind in ("said", "under"))
    return Sentence(**words, said=said, under=under, condition=entry.get("if", ""))


SENTENCES = tuple(make_sentence(entry) for entry in LEDGER["sentence"])
TOPICS: tuple[Mapping[str, Any], ...] = tuple(LEDGER["topic"])
"""The report in eight rows; see `ledger.toml`."""
