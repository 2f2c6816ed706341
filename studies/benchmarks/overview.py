"""Overview: all benchmarks on their finest meshes, in one table and one picture."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit

from . import cases
from .sheet_list import SHEETS
from .sheets import drawing

FAMILIES = {
    "FEM": "finite elements",
    "springs": "springs",
    "springs + volume energy": "springs + volume energy",
    "springs, edges": "springs on edges of a mesh",
}
"""What methods are drawn alike, by how their names begin, the longest that fits; and its words."""
ELEMENTS = {"1": "elements, linear", "2": "elements, quadratic"}
"""Last letter of an element's name -> its words."""
DECADES = (1e-6, 1e-4, 1e-2, 1.0, 100.0)
APART = 0.14
"""Of marks on one line, in lines."""
LEAST = 1e-6
"""Difference (%) at which what is smaller is drawn: rounding."""


def overview(tables: kit.Tables) -> kit.Evidence:
    """Table and picture of the finest meshes of all benchmarks, of tables that have the layout."""
    table = cases.summary(tables)
    sheets = {
        f"sheet_{name}": drawing(sheet)
        for name, sheet in SHEETS.items()
        if set(sheet.tables) & set(tables)
    }
    return kit.Evidence(
        tables={"benchmarks": table},
        columns=kit.columns(__file__),
        figures={"benchmarks": drawn, **sheets},
        rounding={"order": cases.rounding_of_orders(table)},
    )


def family(method: str) -> str:
    """Family that a method is drawn with."""
    return max((name for name in FAMILIES if method.startswith(name)), key=len)


def worst_of(table: pd.DataFrame) -> pd.DataFrame:
    """Largest difference to the limit (%) of every benchmark and method, over its quantities."""
    size = (100 * table["against_limit"].abs()).clip(lower=LEAST)
    return size.groupby([table["benchmark"], table["method"]], sort=False).max().reset_index()


def marked(method: str) -> str:
    """What a method is marked as: its family, of elements by their degree."""
    name = family(method)
    return FAMILIES[name] if name != "FEM" else ELEMENTS[method[-1]]


def drawn(tables: kit.Tables) -> Figure:
    """A line for every benchmark, a mark for every method."""
    table = worst_of(tables["benchmarks"])
    names = list(dict.fromkeys(table["benchmark"]))
    figure, (axis,) = kit.figures.new_figure(size=(5.4, 1.9 + 0.34 * len(names)))
    marks = [*ELEMENTS.values(), *list(FAMILIES.values())[1:]]
    for i, words in enumerate(marks):
        here = table[[marked(str(method)) == words for method in table["method"]]]
        # Side by side, for many are exact.
        rows = [names.index(benchmark) + APART * (i - 2) for benchmark in here["benchmark"]]
        axis.semilogx(
            here["against_limit"], rows, kit.figures.MARKERS[i],
            color=kit.figures.COLOURS[i], label=words, ms=5,
        )  # fmt: skip
    axis.axvline(LEAST, color="grey", ls=":", label="exact to rounding")
    axis.set_xticks(DECADES, [f"{decade:g}" for decade in DECADES])
    axis.set_yticks(range(len(names)), names)
    axis.set_yticks(np.arange(len(names) + 1) - 0.5, minor=True)
    axis.grid(visible=False, axis="y")
    axis.grid(visible=True, axis="y", which="minor")
    axis.tick_params(axis="y", which="both", length=0)
    axis.set(
        xlabel="largest difference to the limit (%)", ylabel="benchmark",
        ylim=(len(names) - 0.5, -0.5),
    )  # fmt: skip
    figure.suptitle("All benchmarks on their finest meshes")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
