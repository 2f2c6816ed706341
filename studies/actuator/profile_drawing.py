"""Figures of the surface profile, as functions of the tables."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit

from .bodies import HEIGHT

TITLES = {"full": "fully covered", "partial": "middle third covered"}
COMPONENTS = {"uy": "deflection uy", "ux": "displacement ux"}
DEEPEST = {"uy": (-3.2, 0.35), "ux": (-3.8, 3.8)}
"""Limits of the axes: what happens at the edges has no limit of its own."""


def profiles(tables: kit.Tables) -> Figure:
    """Both components on the upper face: springs of two lattices over finite elements."""
    surface = tables["surface"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.6, 2.8), sharex=True, sharey="row")
    for i, component in enumerate(COMPONENTS):
        for j, covered in enumerate(TITLES):
            axis = axes[2 * i + j]
            rows = surface[surface["covered"] == covered]
            coarse, fine, fem = dict.fromkeys(rows["source"])
            drawn: tuple[tuple[str, str, dict[str, Any]], ...] = (
                (fem, "-", {"color": "black", "zorder": 3}),
                (coarse, "o", {"color": kit.figures.COLOURS[0], "mfc": "none", "zorder": 2}),
                (fine, ".", {"color": kit.figures.COLOURS[1], "zorder": 2}),
            )
            for source, mark, style in drawn:
                line, label = rows[rows["source"] == source], f"springs, {source} layers"
                if source == "FEM":
                    line, label = broken(line), "FEM"
                style |= {"label": label, "ms": 4, "lw": 1.1}
                axis.plot(line["x"], line[component], mark, **style)
            for edge in rows.loc[rows["edge_distance"] < 1e-9, "x"].unique():
                axis.axvline(edge, color="grey", lw=0.8, ls=":", label="edge of the electrode")
            axis.set_ylim(*DEEPEST[component])
            if j == 0:
                axis.set_ylabel(f"{COMPONENTS[component]}\nover the uniform slab's (1)")
            if i == 0:
                axis.set_title(TITLES[covered])
            else:
                axis.set_xlabel("place along the slab, x (m)")
    figure.suptitle("The upper face of an actuator")
    kit.figures.add_shared_legend(figure, axes)
    return figure


def broken(line: pd.DataFrame) -> pd.DataFrame:
    """A line with a gap where it passes an edge of the electrode, at which it has no value."""
    step = np.median(np.diff(line["x"]))
    jump = np.flatnonzero(np.diff(line["x"]) > 1.5 * step)
    gaps = pd.DataFrame(np.nan, index=jump + 0.5, columns=line.columns)
    return pd.concat([line.reset_index(drop=True), gaps]).sort_index()


def orders(tables: kit.Tables) -> Figure:
    """Difference to finite elements against the spacing, and the edge that sinks without end."""
    figure, (falls, grows) = kit.figures.new_figure(2, size=(3.6, 4.3))
    profile, edge = tables["profile"], tables["edges"]
    for place, (covered, rows) in enumerate(profile.groupby("covered", sort=False)):
        title, style = TITLES[str(covered)], kit.figures.series_style(place)
        away, near = f"{title}, half a height and more away", f"{title}, nearer"
        falls.plot(rows["spacing"], rows["difference_away"], ls="-", label=away, **style)
        style |= {"ls": ":", "mfc": "none"}
        falls.plot(rows["spacing"], rows["difference_near"], label=near, **style)
    spacing = np.sort(profile["spacing"].unique())
    falls.plot(spacing, 0.008 * spacing, "--", color="grey", lw=0.9, label="order 1")
    falls.set(xscale="log", yscale="log", xlabel="spacing (m)")
    falls.set_ylabel("largest |springs - FEM|\nover largest |u| (1)")
    falls.set_title("away from edges springs come to FEM")
    lines = edge[["covered", "component"]].drop_duplicates().itertuples(index=False)
    for place, (slab, component) in enumerate(lines):
        rows = edge[(edge["covered"] == slab) & (edge["component"] == component)]
        h, size = HEIGHT / rows["layers"].to_numpy(), rows["at_edge"].abs().to_numpy()
        way, style = "outwards" if component == "x" else "down", kit.figures.series_style(place)
        grows.plot(h, size, ls="-", label=f"edge, {TITLES[str(slab)]}, {way}", **style)
        slope = float(rows["growth_exact"].abs().iloc[0]) / np.log(2)
        closed = size[-1] - slope * np.log(h / h[-1])
        grows.plot(h, closed, "--", color=style["color"], lw=0.8)
    grows.plot([], [], "--", color="grey", lw=0.8, label="slope of the closed form")
    grows.set(xscale="log", xlabel="spacing (m)", ylim=(0, None))
    grows.set_ylabel("displacement of the edge\nover the uniform slab's (1)")
    grows.set_title("the edge itself has no limit")
    for axis in (falls, grows):
        axis.set_xticks(spacing, [f"{h:.2g}" for h in spacing])
    figure.suptitle("Springs against finite elements as the spacing shrinks")
    kit.figures.add_shared_legend(figure, [falls, grows], columns=2)
    return figure
