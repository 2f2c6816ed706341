"""Figure of `published`: meshes of springs beside print, elasticity and the framed plate."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures


def draw(tables: Tables) -> Figure:
    """Left: how much too stiff; right: distance from the framed plate."""
    table = tables["published"]
    cells, elastic = table["cells"], table["stiffness_elastic"]
    figure, (left, right) = figures.new_figure(2, size=(3.9, 3.2))
    first, second, third = figures.COLOURS[:3]

    def excess(column: str) -> Any:
        return 100 * (table[column] / elastic - 1)

    left.loglog(
        cells, excess("stiffness_framed"), "--", color=second, label="plate framed by bars, FEM"
    )
    left.loglog(cells, excess("stiffness"), ".", color=first, label="springs, here")
    left.loglog(
        cells,
        excess("stiffness_printed"),
        "o",
        color="black",
        mfc="none",
        markersize=8,
        label="springs, printed",
    )
    left.loglog(cells, excess("stiffness_bars"), ":", color="grey", label="bars, first effect: 1/N")
    left.axhline(1, color=third, linewidth=0.9)
    left.annotate("1 %", (1, 1), xytext=(0, 3), textcoords="offset points", color=third)
    left.set_ylabel("stiffness above elasticity's 8/3 N/m (%)")
    left.legend(fontsize=8)
    right.loglog(
        cells,
        100 * table["from_framed"].abs(),
        "o-",
        color=first,
        label="springs, from framed plate",
    )
    right.loglog(
        cells,
        100 * table["framed_uncertainty"],
        "s:",
        color=second,
        mfc="white",
        label="uncertainty of the plate",
    )
    right.loglog(cells, 50 / cells**2, "--", color="grey", label="1/(2 N²)")
    right.set_ylabel("relative difference (%)")
    right.legend(fontsize=8)
    for axis in (left, right):
        axis.set_xlabel("cells along an edge, N (1)")
        axis.set_xticks(cells, [f"{n:g}" for n in cells])
        axis.minorticks_off()
    return figure
