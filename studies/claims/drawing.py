"""The ledger at a glance: a box for each sentence, by section of the report."""

from __future__ import annotations

from collections import Counter

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from msvalidate.judging.evidence import Tables
from msvalidate.output.figures import COLOURS, new_figure

from .record import BACKGROUND, FALSE, IF, NOT_YET, TRUE, WHERE

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
    TRUE: (COLOURS[2], "yes"),
    WHERE: (COLOURS[4], "there"),
    IF: (COLOURS[5], "if"),
    FALSE: (COLOURS[1], "no"),
    NOT_YET: ("#ffffff", "–"),
    BACKGROUND: ("#e8e8e8", ""),
}
"""Verdict -> colour, and word in the box."""


def section(place: str) -> str:
    """Section of a place, as finely as `SECTIONS` divides them."""
    number = place.partition(",")[0].partition(" ")[0]
    return number if number in SECTIONS else number.partition(".")[0]


def draw(tables: Tables) -> Figure:
    """Each sentence with its number and verdict, section by section."""
    ledger = tables["ledger"]
    figure, (axis,) = new_figure(size=(7.2, 4.9))
    lines: dict[str, list[tuple[int, str]]] = {name: [] for name in SECTIONS}
    for number, place, words in ledger[["sentence", "place", "verdict"]].to_numpy():
        verdict = IF if words.startswith(IF) else words
        lines[section(place)].append((int(number), verdict))
    for line, boxes in enumerate(lines.values()):
        for place, (number, verdict) in enumerate(boxes):
            draw_box(axis, place, line, number, verdict)
    axis.set(xlim=(0, max(map(len, lines.values()))), ylim=(len(lines), 0), xticks=[])
    axis.set_yticks([line + 0.5 for line in range(len(lines))], SECTIONS.values())
    axis.set(ylabel="section of the report", xlabel="its sentences, by their number in the ledger")
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)
    axis.tick_params(length=0)
    counts = Counter(verdict for boxes in lines.values() for _, verdict in boxes)
    figure.suptitle(f"The source report's {len(ledger)} sentences", fontsize=9)
    handles = [
        Patch(facecolor=colour, edgecolor="#666666", label=f"{verdict}: {counts[verdict]}")
        for verdict, (colour, _) in LOOKS.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure


def draw_box(axis: Axes, place: int, line: int, number: int, verdict: str) -> None:
    """A sentence's box with its number and its verdict in a word."""
    colour, word = LOOKS[verdict]
    axis.add_patch(
        Rectangle((place + 0.04, line + 0.06), 0.92, 0.88, facecolor=colour, edgecolor="#666666")
    )
    axis.text(place + 0.5, line + 0.34, str(number), ha="center", va="center", fontsize=8)
    axis.text(place + 0.5, line + 0.71, word, ha="center", va="center", fontsize=8)
