"""The ledger at a glance: a box for each sentence, by section of the report."""

from __future__ import annotations

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from msvalidate.judging.evidence import Tables
from msvalidate.output.figures import COLOURS, new_figure

from .record import FAILS, HOLDS, NOT_YET, ONLY_IF, kind

SECTIONS = {
    "1": "1 background",
    "2": "2 analysis",
    "3": "3 forces",
    "4": "4 algorithm",
    "5.1": "5.1 stiffness",
    "5.2": "5.2 lattices",
    "5.3": "5.3 viscosity",
    "5.4": "5.4 integration",
    "6": "6 simple cases",
    "7": "7 actuator",
    "8": "8 conclusion",
}
"""Section of the report -> its name."""
LOOKS = {
    HOLDS: (COLOURS[2], "yes", "holds"),
    ONLY_IF: (COLOURS[5], "if", "holds only on a condition"),
    FAILS: (COLOURS[1], "no", "does not hold"),
    NOT_YET: ("#ffffff", "–", "not judged yet"),
}
"""Verdict -> colour, word in the box, words of the legend."""


def section(place: str) -> str:
    """Section of a place, as finely as it is told apart."""
    number = place.partition(",")[0].partition(" ")[0]
    return number if number in SECTIONS else number.partition(".")[0]


def draw(tables: Tables) -> Figure:
    """Each sentence with its number and verdict, section by section."""
    ledger = tables["ledger"]
    figure, (axis,) = new_figure(size=(7.2, 4.9))
    for line, (_, sentences) in enumerate(by_section(ledger)):
        for place, (number, verdict) in enumerate(
            zip(sentences["sentence"], sentences["verdict"].map(kind), strict=True)
        ):
            draw_box(axis, place, line, int(number), str(verdict))
    longest = max(len(sentences) for _, sentences in by_section(ledger))
    names = [SECTIONS[name] for name, _ in by_section(ledger)]
    axis.set(xlim=(0, longest), ylim=(len(names), 0), yticks=[i + 0.5 for i in range(len(names))])
    axis.set(yticklabels=names, xticks=[], ylabel="section of the report")
    axis.set_xlabel("its sentences, by their number in the ledger")
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)
    axis.tick_params(length=0)
    counts = ledger["verdict"].map(kind).value_counts()
    figure.suptitle(f"The source report's {len(ledger)} checkable sentences", fontsize=9)
    figure.legend(handles=legend(counts), loc="outside lower center", ncols=2)
    return figure


def by_section(ledger: pd.DataFrame) -> list[tuple[str, pd.DataFrame]]:
    """Sections with their rows, in the report's order."""
    of = ledger["place"].map(section)
    return [(name, ledger[of == name]) for name in SECTIONS if (of == name).any()]


def draw_box(axis: Axes, place: int, line: int, number: int, verdict: str) -> None:
    """A sentence's box with its number and its verdict in a word."""
    colour, word, _ = LOOKS[verdict]
    axis.add_patch(
        Rectangle((place + 0.04, line + 0.06), 0.92, 0.88, facecolor=colour, edgecolor="#666666")
    )
    axis.text(place + 0.5, line + 0.34, str(number), ha="center", va="center", fontsize=8)
    axis.text(place + 0.5, line + 0.71, word, ha="center", va="center", fontsize=8)


def legend(counts: pd.Series) -> list[Patch]:
    """What colours and words say, with how many there are of each."""
    return [
        Patch(
            facecolor=colour, edgecolor="#666666", label=f"{word}: {said}, {counts.get(verdict, 0)}"
        )
        for verdict, (colour, word, said) in LOOKS.items()
    ]
