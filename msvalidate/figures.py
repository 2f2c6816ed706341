"""Floor 3: how figures look. No global plotting state: figures are made without pyplot."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter, LogLocator, NullLocator

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
"""Told apart by colour-blind readers (Okabe and Ito 2008, Color Universal Design)."""
FEW_DECADES = 2.5
MARKERS = ("o", "s", "^", "D", "v", "P")
STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "font.size": 9,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
    "savefig.dpi": 160,
    "svg.fonttype": "none",
    "svg.hashsalt": "msvalidate",
}
"""Applied by the report around each figure; part of no figure's meaning."""


def new(
    columns: int = 1, rows: int = 1, size: tuple[float, float] = (3.4, 3.0), **kwargs: Any
) -> tuple[Figure, list[Axes]]:
    """Figure and flat list of its axes, each of `size` inches; `kwargs` go to ``subplots``."""
    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **kwargs)
    return figure, list(axes.ravel())


def plain_logarithms(figure: Figure) -> None:
    """Label logarithmic axes 1e-06, and at 1, 2 and 5 where few decades show; no ticks between.

    Powers set as mathematics and a tick for every digit take a third of the time of a figure. Ticks
    and labels that a figure has chosen for itself stay.
    """
    for axes in figure.axes:
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            if axis.get_scale() != "log":
                continue
            if isinstance(axis.get_major_formatter(), LogFormatter):
                axis.set_major_formatter(lambda value, _: f"{value:g}")
            if isinstance(axis.get_major_locator(), LogLocator):
                few = abs(math.log10(high / low)) < FEW_DECADES
                subs = (1.0, 2.0, 5.0) if few else (1.0,)
                axis.set_major_locator(LogLocator(subs=subs, numticks=12))
            axis.set_minor_locator(NullLocator())


def shared_legend(figure: Figure, axes: list[Axes], columns: int = 4) -> None:
    """One legend below all axes, each label once."""
    entries: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(
        handles=list(entries.values()),
        labels=list(entries),
        loc="outside lower center",
        ncols=min(columns, len(entries)),
    )
