"""Figure of the thick plate: stress on its upper face, and what refining along the line does."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array

from . import sketches
from .shapes import INNER, OUTER, THICKNESS

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
    """The upper face coloured by σ_yy; the supports; stress and sinking by halvings and support."""
    figure, axes = figures.new_figure(2, 2, size=(3.3, 3.1))
    plan, held, stress, sinking = axes
    draw_plan(figure, plan, tables["le10_field"])
    lines = tables["le10_supports"]
    draw_supports(held, list(dict.fromkeys(lines["support"])))
    for i, (kind, rows) in enumerate(lines.groupby("support", sort=False)):
        style: dict[str, Any] = {
            "color": figures.COLOURS[i],
            "marker": figures.MARKERS[i],
            "label": str(kind),
        }
        stress.plot(rows["halvings"], rows["stress"], **style)
        sinking.plot(rows["halvings"], 1e3 * rows["sinking"], **style)
    line = lines[lines["sunk_by_theory"] > 0]
    # From the first halving on: it mends the coarse plate too.
    line = line.iloc[1:]
    theory = line["sinking"].iloc[0] + (line["halvings"] - 1) * line["sunk_by_theory"]
    sinking.plot(line["halvings"], 1e3 * theory, ":", color="grey", label="Kelvin's line force")
    published = float(tables["le10"]["accepted"].iloc[0])
    stress.axhline(published, color="grey", ls="--", lw=0.9, label="published stress")
    stress.set(title="stress at the place asked for", ylabel="σyy at (2, 0, 0.6) m (MPa)")
    sinking.set(title="sinking of the hole's side", ylabel="sinking at (2, 0, 0.3) m (mm)")
    for axis in (stress, sinking):
        axis.set_xlabel("halvings of cells along the line (1)")
        axis.set_xticks(sorted(set(lines["halvings"])))
    figure.suptitle("NAFEMS LE10, thick plate: what its support does")
    figures.add_shared_legend(figure, [stress, sinking], columns=3)
    return figure


def by_springs(tables: Tables) -> Figure:
    """Stress and sinking by springs against their spacing, beside what is accepted for them."""
    figure, (stress, sinking) = figures.new_figure(2, size=(3.3, 3.8))
    for i, (support, rows) in enumerate(tables["le10_read"].groupby("support", sort=False)):
        style: dict[str, Any] = {"color": figures.COLOURS[i], "marker": figures.MARKERS[i]}
        label = f"springs, {support}"
        stress.plot(1 / rows["layers"], rows["springs"], **style, label=label)
        if not i:  # the same whichever way springs are held
            style |= {"mfc": "none", "ls": ":"}
            label = f"elements read as springs are, {support}"
            stress.plot(1 / rows["layers"], rows["elements"], **style, label=label)
    table = tables["le10_springs"]
    for name, rows in table.groupby("quantity", sort=False):
        goal, unit = rows["limit"].iloc[0], rows["unit"].iloc[0]
        held = str(name).endswith("rim held")
        known: dict[str, Any] = {
            "color": "grey",
            "ls": "--" if held else "-.",
            "lw": 0.9,
            "label": "elements, rim held" if held else "published, line held",
        }
        if unit == "m":
            springs = rows[rows["method"].str.startswith("springs")]
            style = {"color": figures.COLOURS[0], "marker": figures.MARKERS[0]}
            label = "springs, rim held"
            sinking.plot(1 / springs["cells"], 1e3 * springs["value"], **style, label=label)
            sinking.axhline(1e3 * goal, **known)
        else:
            stress.axhline(goal, **known)
    stress.set(title="stress at the place asked for", ylabel="σyy at (2, 0, 0.6) m (MPa)")
    sinking.set(title="sinking of the hole's side", ylabel="sinking at (2, 0, 0.3) m (mm)")
    for axis in (stress, sinking):
        axis.set_xlabel("spacing over thickness (1)")
        axis.set_xlim(0, None)
    figure.suptitle("NAFEMS LE10, thick plate: springs as they grow finer")
    figures.add_shared_legend(figure, [stress, sinking], columns=2)
    return figure


def draw_supports(axis: Axes, kinds: Sequence[str]) -> None:
    """The plate cut along x, hole on the left and rim on the right, held in each way."""
    width, size = OUTER[0] - INNER[0], 0.2
    for i, kind in enumerate(kinds):
        low = -1.5 * i
        top = low + THICKNESS
        sketches.outline(axis, [(0, low), (width, low), (width, top), (0, top)])
        at = np.linspace(0, width, 6)
        sketches.forces(axis, np.column_stack([at, 0 * at + top]), (0.0, -0.25))
        sketches.note(axis, (-0.1, low + THICKNESS / 2), kind, (-4, 0), figures.COLOURS[i])
        middle = (width, low + THICKNESS / 2)
        if i == 0:
            sketches.pin(axis, middle, size)
        elif i == 1:
            sketches.clamp(axis, (width, top), (width, low), size)
        else:
            beside = np.column_stack([np.full(2, width + 0.12), (low + 0.3, low + 0.6)])
            sketches.forces(axis, beside, (0.0, 0.28))
    axis.plot(0.0, THICKNESS, "o", color="black", mfc="white", zorder=7)
    sketches.frame(axis, (-1.5, -3.3), (width + 0.4, 1.1), up="z")
    axis.set_title("supports, cut along x")


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
    sketches.mirrors(axis, INNER, OUTER)
    axis.set_aspect("equal")
    axis.grid(visible=False)
    axis.set(xlabel="x (m)", ylabel="y (m)", title="upper face, line held")
    figure.colorbar(drawn, ax=axis, label="σyy (MPa)", shrink=0.8)
