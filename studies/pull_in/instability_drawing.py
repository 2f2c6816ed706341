"""Figures of `instability`: eigenvalues that fall, modes on the slab, waves of infinite slabs."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

STRETCHED = 2.0
"""Times that heights are drawn larger than lengths in the stretched pictures."""
AMPLITUDE = 1.5
"""Of the drawn modes (m)."""
TITLES = {
    "edge, flat": "electrode's edge, slab kept flat",
    "edge, followed": "electrode's edge, equilibria followed",
    "inside": "inside, ends pressed evenly",
}


def softest(tables: Tables) -> Figure:
    """The lowest eigenvalue against the voltage, on each mesh and branch."""
    table = tables["softest"]
    figure, axes = figures.new_figure(3, size=(3.3, 3.3), sharey=True)
    for axis, (branch, title) in zip(axes, TITLES.items(), strict=True):
        for place, (layers, own) in enumerate(table[table["branch"] == branch].groupby("layers")):
            style, rest = figures.series_style(place), own["softest"].iloc[0]
            volts = own["voltage_over_pull_in"]
            axis.plot(volts, own["softest"] / rest, label=f"{layers} layers", **style)
            if branch == "inside":
                even = own["softest_infinite"].astype(float) / rest
                axis.plot(volts, even, "--", color=style["color"], lw=0.9)
        if branch == "inside":
            axis.plot([], [], "--", color="#444444", lw=0.9, label="infinite slab")
        axis.axvline(1.0, color="black", lw=0.8, ls=":")
        axis.set(xlim=(0, 1.05), ylim=(0, 1.05), title=title)
        axis.set_xlabel("voltage over the uniform pull-in (1)")
        axis.legend(fontsize=8, loc="lower left")
    axes[0].set_ylabel("lowest eigenvalue over that at no voltage (1)")
    return figure


def modes(tables: Tables) -> Figure:
    """Modes on the slab, with equal axes and stretched."""
    table = tables["mode_shapes"]
    layers = int(table["layers"].iloc[0])
    shown = ("edge, followed", "inside")
    figure = Figure(figsize=(7.6, 7.4), layout="constrained")
    axes = figure.subplots(4, 1, height_ratios=(1, STRETCHED, 1, STRETCHED))
    cases = [(branch, times) for branch in shown for times in (1.0, STRETCHED)]
    for axis, (branch, times) in zip(axes, cases, strict=True):
        lines = _slab(axis, table[table["branch"] == branch], layers)
        axis.set_aspect(times)
        how = "equal axes" if times == 1 else f"heights stretched {times:g} times"
        axis.set(title=f"{TITLES[branch]}; {how}", ylabel="height (m)")
    axes[-1].set_xlabel("place along the slab (m)")
    label = "mode up, over its largest component (1)"
    figure.colorbar(lines, ax=list(axes), shrink=0.5, label=label)
    figure.suptitle(f"{layers} layers, the largest movement drawn as {AMPLITUDE:g} m", fontsize=9)
    return figure


def _slab(axis: Axes, own: pd.DataFrame, layers: int) -> LineCollection:
    """Grid lines of a slab moved by a mode, coloured by how far they move up or down.

    Points of a lattice in a box come row by row, x fastest.
    """
    place, mode = own[["x_m", "y_m"]].to_numpy(), own[["mode_x_here", "mode_y_here"]].to_numpy()
    grid = place + AMPLITUDE * mode
    numbers = np.arange(len(grid)).reshape(layers + 1, -1)
    along, up = (numbers[:, :-1], numbers[:, 1:]), (numbers[:-1], numbers[1:])
    pairs = np.concatenate([np.stack(ends, -1).reshape(-1, 2) for ends in (along, up)])
    lines = LineCollection(list(grid[pairs]), cmap="cividis", linewidths=0.8)
    lines.set_array(mode[pairs, 1].mean(axis=1))
    lines.set_clim(-1, 1)
    axis.add_collection(lines)
    axis.plot(*grid[numbers[-1]].T, color="black", lw=1.1)
    axis.set_xlim(grid[:, 0].min() - 1, grid[:, 0].max() + 1)
    axis.set_ylim(-0.3, grid[:, 1].max() + 0.8)
    axis.grid(visible=False)
    return lines


def waves(tables: Tables) -> Figure:
    """Thresholds of waves of infinite slabs, and the wavelength that goes first on each mesh."""
    figure, (threshold, length) = figures.new_figure(2, size=(4.2, 4.1))
    table, limits = tables["waves"], tables["waves_softest"]
    inside = tables["instability"][tables["instability"]["branch"] == "inside"]
    for place, (layers, own) in enumerate(table.groupby("layers")):
        volts, colour = own["critical_over_pull_in"], figures.series_style(place)["color"]
        label = f"infinite, {layers} layers"
        threshold.semilogx(own["wavelength_over_h"], volts, color=colour, label=label)
    for place, row in enumerate(inside.to_dict("records")):
        at = row["mode_wavelength_over_h"], row["critical_over_pull_in"]
        mark, label = figures.MARKERS[place], f"slab of {row['layers']} layers"
        threshold.plot(*at, mark, color="black", mfc="none", label=label)
    threshold.axhline(1.0, color="black", lw=0.8, ls=":")
    threshold.set_xlabel("wavelength over the height (1)")
    threshold.set_ylabel("critical voltage over the uniform pull-in (1)")
    heights = 1 / limits["wavelength_infinite"]
    length.semilogx(limits["layers"], heights, label="infinite slab", **figures.series_style(0))
    heights, style = 1 / inside["mode_wavelength_over_h"].astype(float), figures.series_style(1)
    length.semilogx(inside["layers"], heights, ls="", label="slab: its mode", **style)
    length.set_xlabel("cells up the slab's height (1)")
    length.set_ylabel("height over the wavelength that goes first (1)")
    figures.add_shared_legend(figure, [threshold, length], 4)
    return figure
