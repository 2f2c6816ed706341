"""The picture of one part: error against springs, and against time, of every model."""

from __future__ import annotations

from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bench.output.figures import COLOURS, MARKERS, add_shared_legend, new_figure

TITLE = "A block in plane strain, Poisson's ratio 0.4, clamped on one side and sheared on the other"
AXES = ("springs, or pairs of nodes that share an element", "seconds from problem to displacement")
ELEMENTS = {"P1 elements": ":", "Q1 elements": "--", "Q2 elements": "-"}


def draw(tables: kit.Tables) -> Figure:
    """Error of every spring model and of elements on one part, by couplings and by time."""
    table = tables["part"]
    measured = "solve_seconds" in table
    figure, axes = new_figure(2 if measured else 1, size=(4.6, 4.0))
    for place, (model, rows) in enumerate(table.groupby("model", sort=False)):
        line = ELEMENTS.get(str(model))
        style = (
            {"color": "black", "ls": line, "marker": ""}
            if line
            else {"color": COLOURS[place], "marker": MARKERS[place]}
        )
        for axis, x in zip(axes, ("couplings", "solve_seconds"), strict=False):
            axis.loglog(rows[x], 100 * rows["error"], label=str(model), **style)
    for axis, label in zip(axes, AXES, strict=False):
        axis.set(xlabel=label, ylabel="error of the displacement (%)")
        axis.axhline(1.0, color="grey", lw=0.8, ls=(0, (1, 3)))
    figure.suptitle(TITLE, fontsize=9)
    add_shared_legend(figure, axes, columns=2)
    return figure
