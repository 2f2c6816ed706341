"""Figure of the thick plate: stress on its upper face, and what refining along the line does."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array

from .shapes import INNER

PLACE = (INNER[0], 0.0)
COLUMNS = {
    "x": "place along x (m)",
    "y": "place along y (m)",
    "sigma_yy": "σyy of finite elements on the upper face (MPa)",
}


def table(places: Array, stress: Array) -> pd.DataFrame:
    """Rows of the picture: places (p, 3) in m on the upper face and σ_yy (p,) in MPa there."""
    return pd.DataFrame({"x": places[:, 0], "y": places[:, 1], "sigma_yy": stress})


def plate(tables: Tables) -> Figure:
    """The upper face coloured by σ_yy; stress and sinking by halvings and support."""
    figure, (plan, stress, sinking) = figures.new_figure(3, size=(3.5, 3.6))
    draw_plan(figure, plan, tables["le10_field"])
    for i, (kind, rows) in enumerate(tables["le10_supports"].groupby("support", sort=False)):
        style: dict[str, Any] = {
            "color": figures.COLOURS[i],
            "marker": figures.MARKERS[i],
            "label": str(kind),
        }
        stress.plot(rows["halvings"], rows["stress"], **style)
        sinking.plot(rows["halvings"], 1e3 * rows["sinking"], **style)
    lines = tables["le10_supports"]
    line = lines[lines["sunk_by_theory"] > 0]
    # From the first halving on: it mends the coarse plate too.
    line = line.iloc[1:]
    theory = line["sinking"].iloc[0] + (line["halvings"] - 1) * line["sunk_by_theory"]
    sinking.plot(line["halvings"], 1e3 * theory, ":", color="grey", label="Kelvin's line force")
    published = float(tables["le10"]["accepted"].iloc[0])
    stress.axhline(published, color="grey", ls="--", lw=0.9, label="published")
    stress.set_ylabel("σyy at (2, 0, 0.6) m (MPa)")
    sinking.set_ylabel("sinking of the hole's side (mm)")
    for axis in (stress, sinking):
        axis.set_xlabel("halvings of the cells along the line (1)")
        axis.set_xticks(sorted(set(lines["halvings"])))
        axis.legend(fontsize=7)
    return figure


def by_springs(tables: Tables) -> Figure:
    """Stress and sinking by springs against their spacing, beside what is accepted for them."""
    figure, (stress, sinking) = figures.new_figure(2, size=(4.0, 3.4))
    for i, (support, rows) in enumerate(tables["le10_read"].groupby("support", sort=False)):
        style: dict[str, Any] = {"color": figures.COLOURS[i], "marker": figures.MARKERS[i]}
        label = f"springs, {support}"
        stress.plot(1 / rows["layers"], rows["springs"], **style, label=label)
        if not i:  # the same whichever way springs are held
            style |= {"mfc": "none", "ls": ":"}
            label = f"elements read as springs are, {support}"
            stress.plot(1 / rows["layers"], rows["elements"], **style, label=label)
    table = tables["le10_springs"]
    for i, (name, rows) in enumerate(table.groupby("quantity", sort=False)):
        goal, unit = rows["limit"].iloc[0], rows["unit"].iloc[0]
        if unit == "m":
            goal, axis, words = 1e3 * goal, sinking, "elements, rim held"
            springs = rows[rows["method"].str.startswith("springs")]
            style = {"color": figures.COLOURS[0], "marker": figures.MARKERS[0]}
            label = "springs, rim held"
            axis.plot(1 / springs["cells"], 1e3 * springs["value"], **style, label=label)
        else:
            axis = stress
            words = "elements, rim held" if str(name).endswith("rim held") else "published"
        axis.axhline(goal, color="grey", ls=("--", "-.")[i // 2], lw=0.9, label=words)
    stress.set_ylabel("σyy at (2, 0, 0.6) m (MPa)")
    sinking.set_ylabel("sinking of the hole's side (mm)")
    for axis in (stress, sinking):
        axis.set_xlabel("spacing over thickness (1)")
        axis.set_xlim(0, None)
        axis.legend(fontsize=7)
    return figure


def draw_plan(figure: Figure, axis: Axes, rows: pd.DataFrame) -> None:
    """The upper face from above; triangles across the hole are left out."""
    mesh = Triangulation(rows["x"], rows["y"])
    x, y = (rows[name].to_numpy()[mesh.triangles].mean(axis=1) for name in "xy")
    mesh.set_mask((x / INNER[0]) ** 2 + (y / INNER[1]) ** 2 < 1)
    most = float(np.abs(rows["sigma_yy"]).max())
    drawn = axis.tripcolor(
        mesh, rows["sigma_yy"], shading="gouraud", cmap="RdBu_r", vmin=-most, vmax=most,
        rasterized=True,
    )  # fmt: skip
    axis.plot(*PLACE, "o", color="black", mfc="none", clip_on=False)
    axis.annotate("asked for", PLACE, (-6, 6), textcoords="offset points", ha="right", fontsize=8)
    axis.set_aspect("equal")
    axis.grid(visible=False)
    axis.set(xlabel="x (m)", ylabel="y (m)")
    figure.colorbar(drawn, ax=axis, orientation="horizontal", label="σyy, upper face (MPa)")
