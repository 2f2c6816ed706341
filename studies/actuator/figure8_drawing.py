"""The report's Figure 8 (2) and (3) drawn again, and what its statements come to, from the tables.

Only how the slabs are drawn is decided here; every number stands in a table.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array

STRETCH = 3
"""How many times longer heights are drawn than lengths, where axes are stretched."""
ELECTRODE = {"top": figures.COLOURS[1], "bottom": "black"}
TITLES = {
    "full": "Figure 8 (2), fully covered",
    "partial": "Figure 8 (3), covered in the middle",
}
LABEL = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
"""Box behind a label that stands on a line."""
LINES = 11
"""Lines of equal potential, from one electrode's to the other's."""


def redrawn(tables: Tables) -> Figure:
    """Both slabs at their highest voltage: equal axes, stretched axes, charge, potential."""
    cases = list(dict.fromkeys(tables["figure8_slabs"]["covered"]))
    figure = Figure(figsize=(10.6, 9.4), layout="constrained")
    axes = figure.subplots(4, len(cases), height_ratios=(0.62, 1.65, 1.3, 1.75), sharex="col")
    slabs = tables["figure8_slabs"]  # one scale of colours for both
    ends = float(slabs["potential_bottom"].min()), float(slabs["potential_top"].max())
    for column, case in zip(axes.T, cases, strict=True):
        points, density, potential = (
            tables[name][tables[name]["covered"] == case]
            for name in ("figure8_slabs", "figure8_density", "figure8_potential")
        )
        equal, stretched, charge, around = column
        volts = points["voltage"].iloc[0]
        for axis, times in ((equal, 1), (stretched, STRETCH)):
            draw_slab(axis, points)
            axis.set_aspect(times)
        equal.set_title(f"{TITLES[case]}, {volts:.3g} V\nequal axes")
        stretched.set_title(f"stretched axes: heights × {STRETCH}")
        draw_density(charge, density)
        draw_potential(around, points, potential, ends)
        around.set_xlabel("x (m)")
    for row in axes[[0, 1, 3]]:
        row[0].set_ylabel("y (m)")
    axes[2, 0].set_ylabel("charge density (C/m²)")
    for axis in axes[2]:
        axis.set_ylim(0, max(each.get_ylim()[1] for each in axes[2]))
    figures.add_shared_legend(figure, list(axes[:3].ravel()), columns=4)
    return figure


def draw_slab(axis: Axes, points: pd.DataFrame) -> None:
    """The network's rows and columns at rest and as they are, and the electrodes on it."""
    first = points[["x", "y"]].to_numpy()
    now = first + points[["along", "up"]].to_numpy()
    for at, colour, state in ((first, "#c9c9c9", "at rest"), (now, "#66a9d4", "deformed")):
        lines = LineCollection(grid_lines(first, at), color=colour, lw=0.6)
        lines.set_label(f"springs along the axes, {state}")
        axis.add_collection(lines)
    for name, colour in ELECTRODE.items():
        axis.plot(*electrode_line(points, name).T, color=colour, lw=2.2, label=f"{name} electrode")
    axis.margins(0.02)
    axis.grid(visible=False)


def electrode_line(points: pd.DataFrame, electrode: str) -> Array:
    """Deformed places (k, 2) of an electrode's points, from left to right."""
    on = points[points["electrode"] == electrode].sort_values("x", kind="stable")
    line: Array = on[["x", "y"]].to_numpy() + on[["along", "up"]].to_numpy()
    return line


def grid_lines(first: Array, at: Array) -> list[Array]:
    """Rows and columns (p, 2) of a rectangular grid known by its first places, drawn `at`."""
    lines = []
    for axis in (0, 1):
        keys = np.round(first[:, axis], 9)
        for key in np.unique(keys):
            on = np.flatnonzero(keys == key)
            lines.append(at[on[np.argsort(first[on, 1 - axis], kind="stable")]])
    return lines


def draw_density(axis: Axes, density: pd.DataFrame) -> None:
    """Charge density of both electrodes, deformed and flat, both faces together."""
    for name, colour in ELECTRODE.items():
        rows = density[density["electrode"] == name]
        sign, label = 1, "charge density: top"
        if name == "bottom":
            sign, label = -1, "minus charge density: bottom"
        x, density_now = rows["x"], sign * rows["density"]
        axis.plot(x, sign * rows["density_flat"], ":", color=colour, lw=1)
        axis.step(x, density_now, where="mid", color=colour, lw=1.2, label=label)
    axis.plot([], [], ":", color="grey", label="charge density of flat electrodes")
    axis.set(title="charge on the electrodes, both faces together", ylim=(0, None))


def draw_potential(
    axis: Axes, points: pd.DataFrame, potential: pd.DataFrame, ends: tuple[float, float]
) -> None:
    """Lines of equal potential between two ends around the slab, its outline and its electrodes."""
    grid = potential.pivot_table(index="y", columns="x", values="potential", sort=True)
    x, y = grid.columns.to_numpy(dtype=float), grid.index.to_numpy(dtype=float)
    values = grid.to_numpy()
    levels = np.linspace(*ends, LINES)
    shown = axis.contourf(x, y, values, levels, cmap="cividis", extend="neither")
    axis.contour(x, y, values, levels, colors="white", linewidths=0.5, linestyles="solid")
    axis.figure.colorbar(shown, ax=axis, orientation="horizontal", label="potential (V)")
    first = points[["x", "y"]].to_numpy()
    now = first + points[["along", "up"]].to_numpy()
    lines = grid_lines(first, now)
    columns = len(np.unique(np.round(first[:, 0], 9)))
    for line in (lines[0], lines[columns - 1], lines[-1]):
        axis.plot(*line.T, color="black", lw=0.8)
    for name, colour in ELECTRODE.items():
        axis.plot(*electrode_line(points, name).T, color="white", lw=4)  # black stands on dark blue
        axis.plot(*electrode_line(points, name).T, color=colour, lw=2.2)
    axis.set(aspect="equal", xlim=(x.min(), x.max()), ylim=(y.min(), y.max()))
    axis.set_title("potential around the slab, equal axes")
    axis.grid(visible=False)


def ways(tables: Tables) -> Figure:
    """Marginal effect and charge against voltage, three ways, and the faces at the last of each."""
    table, faces = tables["figure8"], tables["figure8_faces"]
    figure = Figure(figsize=(10.6, 6.4), layout="constrained")
    axes = figure.subplots(2, 3, width_ratios=(1, 1, 1.35))
    sources = list(dict.fromkeys(table["way"]))
    for row, (covered, rows) in zip(axes, table.groupby("covered", sort=False), strict=True):
        for source, colour, marker in zip(sources, figures.COLOURS, figures.MARKERS, strict=False):
            line = rows[rows["way"] == source]
            style = {"color": colour, "marker": marker, "label": source}
            row[0].plot(line["voltage"], line["beside_over_middle"], **style)
            row[1].plot(line["voltage"], 100 * line["inner_charge"], **style)
            last = faces[(faces["covered"] == covered) & (faces["way"] == source)]
            last = last[last["voltage"] == last["voltage"].max()]
            row[2].plot(last["x"] + last["along"], last["up"], color=colour, lw=1.2)
            place = round((0.5 + 0.12 * (sources.index(source) - 1)) * len(last))
            row[2].annotate(
                f"{last['voltage'].iloc[0]:.3g} V",
                (last["x"].iloc[place], last["up"].iloc[place]),
                (0, -11),
                textcoords="offset points",
                color=colour,
                fontsize=8,
                ha="center",
                bbox=LABEL,
            )
        row[0].set_ylabel(f"{TITLES[str(covered)]}\n2 m inside the edge over middle (1)")
        row[0].set_yscale("log")
        row[1].set_ylabel("charge on the middle half (%)")
        row[2].set_ylabel("deflection uy (m)")
    axes[0, 0].set_title("marginal effect")
    axes[0, 1].set_title("where the charge is")
    axes[0, 2].set_title("upper face at the last voltage held, heights stretched")
    for axis, label in zip(axes[1], ("voltage (V)", "voltage (V)", "x (m)"), strict=True):
        axis.set_xlabel(label)
    figures.add_shared_legend(figure, list(axes.ravel()))
    return figure
