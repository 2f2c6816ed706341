"""The figure of `models`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit

from .model_cases import MODELS, Model

EDGE_SHOWN = 0.8
"""Over half the width: from where the figure shows the force along."""
TOTALS = {
    "charge_over_plane": "charge",
    "squeeze_over_plane": "squeeze",
    "margin_along_over_plane": "along half the top",
}
"""Columns that the figure sets side by side, and their names there."""


def label(model: Model) -> str:
    """A model's name in a legend."""
    if model.name == "report's":
        return f"report's, depth {model.depth:g} d"
    if model.name == "in air":
        return f"in air, ratio {model.ratio:g}"
    return f"plane, {model.forces_by}"


KEYS = ["model", "depth_over_gap", "forces_by", "permittivity_ratio"]
STYLES: dict[str, dict[str, Any]] = {
    label(model): {"color": colour, "ls": style}
    for model, colour, style in zip(
        MODELS,
        ("black", "#888888", *kit.figures.COLOURS[:6]),
        ("-", ":", "-", "-", "-", "--", "--", "--"),
        strict=True,
    )
}


def draw(tables: kit.Tables) -> Figure:
    """Squeeze along the electrode, force along it near its edge, and totals."""
    figure, axes = kit.figures.new_figure(2, 2, size=(3.6, 3.4))
    down, outward, totals = kit.figures.widen_third(figure, axes)
    lines = tables["along_electrode"]
    for key, rows in lines.groupby(KEYS, sort=False):
        model = Model(*key)  # type: ignore[arg-type]
        name = label(model)
        down.semilogy(rows["place"], rows["squeeze"], **STYLES[name], label=name)
        if model.name != "report's":
            half = rows[rows["place"] > EDGE_SHOWN]
            outward.plot(half["place"], half["along_here"], marker=".", **STYLES[name], label=name)
    down.set(title="along the electrode", ylabel="squeeze over\n½ε(V/d)² (1)", ylim=(0.5, 40))
    outward.set_title("near the edge, plane and in air")
    outward.set_ylabel("outward force over εV²/4d (1)")
    for axis in (down, outward):
        axis.set_xlabel("place over half the width (1)")
    draw_totals(totals, tables["models"])
    figure.suptitle("Models of charges side by side: facing strips")
    kit.figures.add_shared_legend(figure, [down, outward], columns=2)
    return figure


def draw_totals(axis: Axes, table: pd.DataFrame) -> None:
    """A row for each model."""
    names = [label(Model(*key)) for key in table[KEYS].itertuples(index=False)]
    places = np.arange(len(names))[::-1]
    for i, (column, name) in enumerate(TOTALS.items()):
        style = kit.figures.series_style(i)
        axis.semilogx(table[column], places + 0.12 * (1 - i), ls="", label=name, **style)
    axis.set_yticks(places, names, fontsize=8)
    axis.set(xlabel="total over the\nplane model's (1)", title="totals")
    axis.legend(fontsize=8, loc="lower right")
