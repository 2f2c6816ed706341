"""Floor 3: how figures look. No global plotting state: figures are made without pyplot."""

from __future__ import annotations

from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
"""Told apart by colour-blind readers (Okabe and Ito 2008, Color Universal Design)."""
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


def plain_powers(axis: Axes) -> None:
    """Label a logarithmic y axis 1e-06, not as mathematics, which takes a third of a second."""
    axis.yaxis.set_major_formatter(lambda value, _: f"{value:.0e}")


def one_two_five(axis: Axes, which: str = "x") -> None:
    """Label a logarithmic axis of few decades at 1, 2 and 5 of each, and nowhere between."""
    chosen = axis.xaxis if which == "x" else axis.yaxis
    chosen.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0), numticks=12))
    chosen.set_major_formatter(lambda value, _: f"{value:g}")
    chosen.set_minor_formatter(NullFormatter())


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
