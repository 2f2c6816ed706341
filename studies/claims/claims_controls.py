"""Negative controls of the ledger: numbers past their bounds, and results that are altered."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import pandas as pd

from msvalidate import kit

from .record import SENTENCES, TRUE, Check, Sentence

Numbers = Mapping[int, tuple[list[float], list[float]]]
"""Sentence -> its numbers as said, and under its condition."""


@dataclass(frozen=True)
class Alteration:
    """A change to one table, "study/table"."""

    table: str
    change: Callable[[pd.DataFrame], pd.DataFrame]


@dataclass(frozen=True)
class AlteredResults(kit.Results):
    """Results of which one table is changed."""

    alter: Alteration | None = None

    def table(self, study: str, name: str) -> pd.DataFrame:
        """A table, changed if it is the one."""
        table = super().table(study, name)
        if self.alter and f"{study}/{name}" == self.alter.table:
            return self.alter.change(table)
        return table


def altered(results: kit.Results, alter: Alteration | None) -> kit.Results:
    """Results with a change, if there is one."""
    if alter is None:
        return results
    return AlteredResults(results.form, results.run, results.folder, alter)


def moves(checks: Sequence[Check], numbers: Sequence[float]) -> Iterator[list[float]]:
    """Numbers reflected in their bounds so that what they decide together is another.

    Each alone where all keep to their bounds; else all that do not, at once.
    """
    pairs = list(zip(checks, numbers, strict=True))
    missed = {place for place, (check, number) in enumerate(pairs) if not check.holds(number)}
    for turned in [missed] if missed else [{place} for place in range(len(pairs))]:
        yield [
            check.moved(number) if place in turned else number
            for place, (check, number) in enumerate(pairs)
        ]


def move_past_bounds(sentences: Sequence[Sentence], found: Numbers) -> pd.DataFrame:
    """Numbers of judged sentences reflected in their bounds, and the verdict with them.

    A condition counts where the sentence is not true as said.
    """
    rows = []
    for sentence in sentences:
        said, under = found[sentence.number]
        before = sentence.decide(said, under)
        if sentence.said:
            rows += [
                moved_row(sentence, "as said", (said, other), before, sentence.decide(other, under))
                for other in moves(sentence.said, said)
            ]
        if sentence.under and before != TRUE:
            rows += [
                moved_row(sentence, "under", (under, other), before, sentence.decide(said, other))
                for other in moves(sentence.under, under)
            ]
    return pd.DataFrame(rows)


def moved_row(
    sentence: Sentence,
    part: str,
    numbers: tuple[Sequence[float], Sequence[float]],
    before: str,
    after: str,
) -> dict[str, object]:
    """Verdict of a sentence before and after some of its numbers are moved."""
    return {
        "sentence": sentence.number,
        "part": part,
        "moved": sum(old != new for old, new in zip(*numbers, strict=True)),
        "verdict": before,
        "verdict_moved": after,
        "flips": "yes" if before != after else "no",
    }


class TypedSentence(Sentence):
    """A sentence whose verdict is written down instead of computed."""

    def decide(self, said: Sequence[float], under: Sequence[float]) -> str:  # noqa: ARG002
        """The verdict that is expected, whatever the numbers."""
        return self.expected


TYPED = tuple(
    TypedSentence(**{field.name: getattr(each, field.name) for field in fields(Sentence)})
    for each in SENTENCES
)


def alteration(table: str, **columns: Any) -> dict[str, Alteration]:
    """Arguments of `run` under which columns of a table are others."""
    return {"alter": Alteration(table, lambda found: found.assign(**columns))}


def doubled(table: pd.DataFrame) -> pd.Series:
    """Twice every misfit to a curve."""
    return table["in_springs"].mask(table["figure"] == 7, table["in_springs"] * 2)


def folded(table: pd.DataFrame) -> pd.Series:
    """Folded cells in overdamped runs as well."""
    over = (table["c_over_critical"] >= 2) & (table["cells_inverted"] != "grows")
    return table["cells_inverted"].mask(over, 1.0)


FAULTS: dict[str, dict[str, Any]] = {
    "the cell's ratio in blocks of every size": alteration(
        "poisson/finite_size", nu_springs=lambda table: table["nu_cell_formula"]
    ),
    "twice every misfit to a curve": alteration(
        "displacement/statements", in_springs=doubled, in_homogenised=doubled
    ),
    "printed Verlet follows the motion": alteration("stability/misprints", difference=0.0),
    "the plane's charge at every depth": alteration(
        "electrostatics/depths", as_report_over_plane=1.0
    ),
    "every damping costs the same": alteration("damping/advice", steps=7.0, price=1.0),
    "overdamped particles pass each other": alteration("stability/passing", cells_inverted=folded),
    "the report's block as good as any": alteration(
        "displacement/cases", model_form=0.0, boundary=0.0
    ),
    "a sentence twice": {"sentences": (*SENTENCES, SENTENCES[0])},
    "verdicts written down": {"sentences": TYPED},
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""
