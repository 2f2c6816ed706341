"""Overview: all benchmarks on their finest meshes, in one table and one picture."""

from __future__ import annotations

import pandas as pd
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Evidence, Tables
from msvalidate.output import figures

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
LEAST = 1e-6
"""Difference (%) at which what is smaller is drawn: rounding."""


def overview(tables: Tables) -> Evidence:
    """Table and picture of the finest meshes of all benchmarks, of tables that have the layout."""
    table = cases.summary(tables)
    sheets = {
        f"sheet_{name}": drawing(sheet)
        for name, sheet in SHEETS.items()
        if set(sheet.tables) & set(tables)
    }
    return Evidence(
        tables={"benchmarks": table},
        observed={},
        tolerances=(),
        columns=cases.COLUMNS,
        figures={"benchmarks": drawn, **sheets},
        rounding={
            "against_accepted": 1e-8,
            "against_limit": 1e-8,
            "order": cases.rounding_of_orders(table),
        },
    )


def family(method: str) -> str:
    """Family that a method is drawn with."""
    return max((name for name in FAMILIES if method.startswith(name)), key=len)


def worst_of(table: pd.DataFrame) -> pd.DataFrame:
    """Largest difference to the limit (%) of every benchmark and method, over its quantities."""
    size = (100 * table["against_limit"].abs()).clip(lower=LEAST)
    return size.groupby([table["benchmark"], table["method"]], sort=False).max().reset_index()


def drawn(tables: Tables) -> Figure:
    """A line for every benchmark, a mark for every method."""
    table = worst_of(tables["benchmarks"])
    names = list(dict.fromkeys(table["benchmark"]))
    figure, (axis,) = figures.new_figure(size=(6.4, 1.4 + 0.32 * len(names)))
    for i, (name, words) in enumerate(FAMILIES.items()):
        here = table[[family(str(method)) == name for method in table["method"]]]
        rows = [names.index(benchmark) for benchmark in here["benchmark"]]
        axis.semilogx(
            here["against_limit"], rows, figures.MARKERS[i], color=figures.COLOURS[i], label=words,
            ms=7, mfc="none",
        )  # fmt: skip
    axis.axvline(LEAST, color="grey", ls=":", label="exact to rounding")
    axis.set_yticks(range(len(names)), names)
    axis.invert_yaxis()
    axis.set(
        xlabel="largest difference to the limit, finest mesh (%)", ylabel="benchmark",
        ylim=(len(names) - 0.5, -0.5),
    )  # fmt: skip
    figures.add_shared_legend(figure, [axis], columns=3)
    return figure
