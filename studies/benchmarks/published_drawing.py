"""Figure of `published`: meshes of springs beside print, elasticity and the framed plate."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures


def draw(tables: Tables) -> Figure:
    """How much too stiff a square of springs is, and how far from a plate framed by bars."""
    table = tables["published"]
    cells, elastic = table["cells"], table["stiffness_elastic"]
    figure, (left, right) = figures.new_figure(2, size=(3.3, 4.2))
    first, second, third = figures.COLOURS[:3]

    def above(column: str, style: str, label: str, **more: Any) -> None:
        left.loglog(cells, 100 * (table[column] / elastic - 1), style, label=label, **more)

    above("stiffness_bars", ":", "bars alone: 1/N", color="grey")
    above("stiffness_framed", "--", "elements framed by bars", color=second)
    above("stiffness_printed", "o", "springs, as printed", color="black", mfc="none", ms=8)
    above("stiffness", ".", "springs, here", color=first)
    left.axhline(1, color=third, lw=0.9, label="1 % too stiff")
    left.set_ylabel("stiffer than elasticity by (%)")
    left.set_title("too stiff by")
    off, doubt = 100 * table["from_framed"].abs(), 100 * table["framed_uncertainty"]
    right.loglog(cells, off, "o-", color=first, label="springs, from the framed plate")
    right.loglog(cells, 50 / cells**2, "--", color="grey", label="1/(2 N²)")
    right.loglog(cells, doubt, "s:", color=second, mfc="white", label="uncertainty of the plate")
    right.set_ylabel("difference (%)")
    right.set_title("from a plate framed by bars")
    below: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (-0.1, -0.24), "fontsize": 8}
    for axis in (left, right):
        axis.set_xlabel("cells along an edge, N (1)")
        axis.set_xticks(cells, [f"{n:g}" for n in cells])
        axis.minorticks_off()
        axis.legend(**below)
    figure.suptitle("A square of springs in tension, beside print and elasticity")
    return figure
