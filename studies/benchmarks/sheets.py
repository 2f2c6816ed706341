"""Sheets: a benchmark on one page, what is asked on top and what every method finds below."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from textwrap import fill
from typing import Any

import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure, SubFigure

from msvalidate import kit

from . import cases

WIDTH, SKETCH, PANEL, LINE = 4.8, 2.5, 2.8, 0.16
"""Inches: of the page; heights of sketch, of a panel of results, and of a line of words."""
LETTERS = 74
"""That fit in a line of words."""
MOST = 2
"""Panels of results on a page."""
SEEN = 1e-4
"""Relative difference of accepted value and limit that is worth a word."""
OWN = "our own elements"
"""Whose a value is that nobody has published."""


@dataclass(frozen=True)
class Sheet:
    """A benchmark as its page shows it; all numbers of results come from its tables.

    `tables`: whose rows are drawn. `panels`: quantity, Poisson's ratio and what is above the
    panel; the first two that are there are drawn.
    """

    title: str
    asked: str
    sketch: Callable[[Axes], None]
    facts: tuple[str, ...]
    source: str
    tables: tuple[str, ...]
    panels: tuple[tuple[str, float, str], ...]
    cells: str
    height: float = SKETCH


def draw(sheet: Sheet, tables: kit.Tables) -> Figure:
    """The sketch, what is given and accepted, and errors against cells."""
    table = pd.concat([tables[name] for name in sheet.tables if name in tables])
    panels = [(words, _rows(table, quantity, nu)) for quantity, nu, words in sheet.panels]
    panels = [(words, rows) for words, rows in panels if len(rows)][:MOST]
    said = [fill(fact, LETTERS) for fact in (*sheet.facts, *_accepted(sheet, panels))]
    lines = "\n".join(said).count("\n") + 1
    heights = [sheet.height + LINE * lines]
    heights += [PANEL + LINE * rows["method"].nunique() for _, rows in panels]
    figure = Figure(figsize=(WIDTH, sum(heights) + LINE), layout="constrained")
    top, *parts = figure.subfigures(len(heights), 1, height_ratios=heights, squeeze=False).ravel()
    sketch = top.subplots()
    sheet.sketch(sketch)
    sketch.set_title(sheet.asked)
    top.supxlabel("\n".join(said), x=0.02, ha="left", fontsize=8, linespacing=1.35)
    drawn = [_draw_results(part, *panel) for part, panel in zip(parts, panels, strict=True)]
    ends = [axis.get_ylim() for axis in drawn]
    for axis in drawn:  # one scale
        axis.set_xlabel(sheet.cells)
        axis.set_ylim(min(low for low, _ in ends), max(high for _, high in ends))
    figure.suptitle(sheet.title)
    return figure


def drawing(sheet: Sheet) -> Callable[[kit.Tables], Figure]:
    """`draw` of one sheet, as `Evidence.figures` wants it."""

    def draw_sheet(tables: kit.Tables) -> Figure:
        return draw(sheet, tables)

    draw_sheet.__doc__ = f"{sheet.title} on one page: what is asked, and what each method finds."
    return draw_sheet


def _rows(table: pd.DataFrame, quantity: str, nu: float) -> pd.DataFrame:
    return table[(table["quantity"] == quantity) & ((table["nu"] - nu).abs() < 1e-9)]


def _accepted(sheet: Sheet, panels: list[tuple[str, pd.DataFrame]]) -> tuple[str, ...]:
    """Accepted values, the limit of meshes where that is another, and the source."""
    said = []
    for words, rows in panels:
        row, unit = rows.iloc[0], rows["unit"].iloc[0]
        other = abs(row["limit"] / row["accepted"] - 1) > SEEN
        limit = f"; errors against the limit, {row['limit']:.5g} {unit}" if other else ""
        known = OWN if "this study" in row["source"] else "accepted"
        value = f"{known} {row['accepted']:.5g} {unit}"
        said.append(f"{words[0].upper()}{words[1:]}: {value}{limit}.")
    return (*said, f"Source: {sheet.source}")


def _draw_results(part: SubFigure, words: str, rows: pd.DataFrame) -> Axes:
    """Errors of all methods; the legend tells what each finds on its finest mesh."""
    axis: Axes = part.subplots()
    cases.draw(axis, rows)
    found = {
        cases.method_look(row["method"])[0]: _found(row)
        for row in cases.finest(rows).to_dict("records")
    }
    handles, labels = axis.get_legend_handles_labels()
    labels = [label + found.get(label, "") for label in labels]
    axis.set_title(words)
    axis.set_ylabel("error (%)")
    part.legend(
        handles, labels, loc="outside lower left", fontsize=8, alignment="left",
        title="Found on the finest mesh (difference to the accepted value)", title_fontsize=8,
    )  # fmt: skip
    return axis


def _found(row: dict[Any, Any]) -> str:
    """Value on the finest mesh and its difference to what is accepted."""
    return f": {row['value']:.5g} {row['unit']} ({100 * row['against_accepted']:+.2g} %)"
