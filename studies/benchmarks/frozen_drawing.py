"""Figure of the frozen cases: how far each kind of springs and elements is, on its finest mesh."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit

LINEAR = ("FEM P1", "FEM Q1", "FEM T1", "FEM H1")
QUADRATIC = ("FEM P2", "FEM Q2", "FEM T2", "FEM H2")
MODELS = {
    "elements, linear": LINEAR,
    "elements, quadratic": QUADRATIC,
    "springs": ("springs",),
    "springs, whole on the boundary": ("springs, whole on the boundary",),
    "springs on mesh edges": ("springs on mesh edges",),
}
"""Words -> models of the table."""
APART = 0.14
"""Of marks on one line, in lines."""
LEAST = 1e-4
"""Error (%) at which what is smaller is drawn."""
SHOWN = (LEAST, 0.01, 1, 100)
RATIO = 0.3


def frozen_cases(tables: kit.Tables) -> Figure:
    """A line for every case, a mark for the best mesh of every kind of model."""
    table = tables["frozen_cases"]
    drawn = table[(table["nu"] == RATIO) | (table["nu"] > 0.49)]
    names = list(dict.fromkeys(drawn["case"]))
    half = -(-len(names) // 2)
    figure, axes = kit.figures.new_figure(2, size=(3.8, 1.7 + 0.26 * half), sharex=True)
    for i, (words, models) in enumerate(MODELS.items()):
        here = drawn[drawn["model"].isin(models)]
        best = finest(here)
        lines = np.array([names.index(case) + APART * (i - 2) for case in best["case"]])
        error = (100 * best["error"]).clip(lower=LEAST)
        style = {
            "marker": kit.figures.MARKERS[i],
            "color": kit.figures.COLOURS[i],
            "ls": "",
            "ms": 5,
        }
        for axis in axes:
            axis.semilogx(error, lines, label=words, **style)
    for axis, first in zip(axes, (0, half), strict=True):
        axis.set_xticks(SHOWN, [f"{percent:g}" for percent in SHOWN])
        axis.axvline(LEAST, color="grey", ls=":", label="below a millionth")
        axis.set_yticks(range(len(names)), [name.replace("_", " ") for name in names])
        axis.set_yticks(np.arange(len(names) + 1) - 0.5, minor=True)
        axis.grid(visible=False, axis="y")
        axis.grid(visible=True, axis="y", which="minor")
        axis.tick_params(axis="y", which="both", length=0)
        axis.set_ylim(first + half - 0.5, first - 0.5)
        axis.set_xlabel("error over the\nlargest displacement (%)")
    axes[0].set_ylabel("case (nu = 0.3; rubber 0.4999)")
    figure.suptitle("Frozen cases: our springs and elements on their finest meshes")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure


def finest(rows: pd.DataFrame) -> pd.DataFrame:
    """Of every case the last row of its last mesh of each shape; of these the least error."""
    last = rows.groupby(["case", "model"], sort=False).tail(1)
    return last.loc[last.groupby("case", sort=False)["error"].idxmin()]
