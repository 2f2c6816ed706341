"""Figures of `instability`: eigenvalues that fall, modes on the slab, waves of infinite slabs."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit

STRETCHED = 2.0
"""Times that heights are drawn larger than lengths in the stretched pictures."""
AMPLITUDE = 1.5
"""Of the drawn modes (m)."""
TITLES = {
    "edge, flat": "electrode's edge, slab kept flat",
    "edge, followed": "electrode's edge, equilibria followed",
    "inside": "inside, ends pressed evenly",
}


def softest(tables: kit.Tables) -> Figure:
    """The lowest eigenvalue against the voltage, on each mesh and branch."""
    table = tables["softest"]
    figure, axes = kit.figures.new_figure(3, size=(2.4, 3.2), sharex=True, sharey=True)
    for axis, (branch, title) in zip(axes, TITLES.items(), strict=True):
        for place, (layers, own) in enumerate(table[table["branch"] == branch].groupby("layers")):
            style, rest = kit.figures.series_style(place), own["softest"].iloc[0]
            volts = own["voltage_over_pull_in"]
            axis.plot(volts, own["softest"] / rest, label=f"{layers} layers", **style)
            if branch == "inside":
                even = own["softest_infinite"].astype(float) / rest
                axis.plot(volts, even, "--", color=style["color"], lw=0.9)
        if branch == "inside":
            axis.plot([], [], "--", color="#444444", lw=0.9, label="infinite slab")
        axis.axvline(1.0, color="black", lw=0.8, ls=":", label="uniform pull-in")
        axis.set(xlim=(0, 1.05), ylim=(0, 1.05), title=title.replace(", ", ",\n"))
        axis.set_xlabel("voltage over pull-in's (1)")
    axes[0].set_ylabel("lowest eigenvalue\nover that at no voltage (1)")
    figure.suptitle("At which voltage a bonded slab loses its stability")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure


def modes(tables: kit.Tables) -> Figure:
    """Modes on the bonded slab, at the electrode's edge and inside."""
    table = tables["mode_shapes"]
    layers = int(table["layers"].iloc[0])
    shown = ("edge, followed", "inside")
    figure, axes = kit.figures.new_figure(1, len(shown), size=(5.6, 2.3), sharex=True, sharey=True)
    for axis, branch in zip(axes, shown, strict=True):
        _draw_slab(axis, table[table["branch"] == branch], layers)
        axis.set(aspect=STRETCHED, title=TITLES[branch], ylabel="height (m)")
        axis.tick_params(labelbottom=True)
    axes[-1].set_xlabel("place along the slab (m)")
    figure.suptitle(
        f"Softest modes of a slab of {layers} layers,\nlargest movement drawn as {AMPLITUDE:g} m, "
        f"heights {STRETCHED:g} times"
    )
    kit.figures.add_shared_legend(figure, axes[:1], columns=2)
    return figure


def _draw_slab(axis: Axes, own: pd.DataFrame, layers: int) -> None:
    """Grid lines of a slab at rest and moved by a mode.

    Points of a lattice in a box come row by row, x fastest.
    """
    place, mode = own[["x_m", "y_m"]].to_numpy(), own[["mode_x_here", "mode_y_here"]].to_numpy()
    grid = place + AMPLITUDE * mode
    numbers = np.arange(len(grid)).reshape(layers + 1, -1)
    along, up = (numbers[:, :-1], numbers[:, 1:]), (numbers[:-1], numbers[1:])
    pairs = np.concatenate([np.stack(ends, -1).reshape(-1, 2) for ends in (along, up)])
    kit.body_drawing.draw_springs(
        axis, place, pairs, "slab in equilibrium", kit.body_drawing.AT_REST
    )
    kit.body_drawing.draw_springs(axis, grid, pairs, "moved by the mode", kit.figures.COLOURS[0])
    for row, label in ((0, "electrodes"), (layers, None)):
        axis.plot(*grid[numbers[row]].T, color=kit.figures.COLOURS[1], lw=1.8, label=label)
    bonded = grid[numbers[0]]
    kit.body_drawing.draw_supports(axis, bonded, np.ones(bonded.shape, dtype=bool))
    axis.set_xlim(place[:, 0].min() - 4, place[:, 0].max() + 4)
    axis.set_ylim(-1, place[:, 1].max() + AMPLITUDE + 0.5)
    axis.grid(visible=False)


def waves(tables: kit.Tables) -> Figure:
    """Thresholds of waves of infinite slabs, and the wavelength that goes first on each mesh."""
    figure, (threshold, length) = kit.figures.new_figure(2, size=(3.3, 4.2))
    table, limits = tables["waves"], tables["waves_softest"]
    inside = tables["instability"][tables["instability"]["branch"] == "inside"]
    for place, (layers, own) in enumerate(table.groupby("layers")):
        volts, colour = own["critical_over_pull_in"], kit.figures.series_style(place)["color"]
        label = f"infinite, {layers} layers"
        threshold.semilogx(own["wavelength_over_h"], volts, color=colour, label=label)
    for place, row in enumerate(inside.to_dict("records")):
        at = row["mode_wavelength_over_h"], row["critical_over_pull_in"]
        mark, label = kit.figures.MARKERS[place], f"slab of {row['layers']} layers"
        threshold.plot(*at, mark, color="black", mfc="none", label=label)
    threshold.axhline(1.0, color="black", lw=0.8, ls=":", label="uniform pull-in")
    threshold.set_xlabel("wavelength over the height (1)")
    threshold.set_ylabel("critical voltage over pull-in's (1)")
    heights = 1 / limits["wavelength_infinite"]
    length.semilogx(limits["layers"], heights, label="infinite slab", **kit.figures.series_style(0))
    heights, style = 1 / inside["mode_wavelength_over_h"].astype(float), kit.figures.series_style(1)
    length.semilogx(inside["layers"], heights, ls="", label="slab: its mode", **style)
    length.set_xlabel("cells up the slab's height (1)")
    length.set_ylabel("height over the first wavelength (1)")
    threshold.set_title("waves on infinite slabs")
    length.set_title("the wave that goes first")
    figure.suptitle("Waves that grow below the uniform pull-in")
    kit.figures.add_shared_legend(figure, [threshold, length], 3)
    return figure
