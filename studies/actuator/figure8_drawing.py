"""The report's Figure 8 (2) and (3) drawn again, and what its statements come to, from the tables.

Only how the slabs are drawn is decided here; every number stands in a table.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.contour import ContourSet
from matplotlib.figure import Figure

from msvalidate import kit

STRETCH = 3
"""How many times longer heights are drawn than lengths, where axes are stretched."""
ELECTRODE = {"top": kit.figures.COLOURS[1], "bottom": "black"}
ON = {"top": "top electrode", "bottom": "bottom electrode; the slab is held there"}
TITLES = {
    "full": "(2), fully covered",
    "partial": "(3), covered in the middle",
}
WAYS = (
    "deflection 2 m inside\nthe edge over middle (1)",
    "charge on the\nmiddle half (%)",
    "deflection uy (m)",
)
"""What the rows of the figure of all ways show."""
LINES = 11
"""Lines of equal potential, from the lowest electrode's to the highest's of all slabs."""


def redrawn(tables: kit.Tables) -> Figure:
    """Figure 8's slabs at their highest voltage: equal and stretched axes, charge, potential."""
    cases = list(dict.fromkeys(tables["figure8_slabs"]["covered"]))
    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    axes = figure.subplots(
        4, len(cases), height_ratios=(0.62, 1.5, 1.6, 1.4), sharex="col", sharey="row"
    )
    slabs = tables["figure8_slabs"]
    ends = slabs["potential_bottom"].min(), slabs["potential_top"].max()
    levels = np.linspace(*ends, LINES)
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
        equal.set_title(f"{TITLES[case]}, {volts:.3g} V:\nequal axes")
        stretched.set_title(f"the same, heights × {STRETCH}")
        draw_density(charge, density)
        shown = draw_potential(around, points, potential, levels)
        around.set_xlabel("x (m)")
    for row in axes[[0, 1, 3]]:
        row[0].set_ylabel("y (m)")
    axes[2, 0].set_ylim(0, None)
    axes[2, 0].set_ylabel("charge density\n(C/m²)")
    scale = figure.colorbar(shown, ax=axes, orientation="horizontal", aspect=50, shrink=0.9)
    scale.set_label("potential (V)")
    figure.suptitle("The report's Figure 8 (2) and (3) drawn again")
    kit.figures.add_shared_legend(figure, list(axes[:3].ravel()), columns=2)
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
        axis.plot(*electrode_line(points, name).T, color=colour, lw=2.2, label=ON[name])
    axis.margins(0.02)
    axis.grid(visible=False)


def electrode_line(points: pd.DataFrame, electrode: str) -> kit.Array:
    """Deformed places (k, 2) of an electrode's points, from left to right."""
    on = points[points["electrode"] == electrode].sort_values("x", kind="stable")
    line: kit.Array = on[["x", "y"]].to_numpy() + on[["along", "up"]].to_numpy()
    return line


def grid_lines(first: kit.Array, at: kit.Array) -> list[kit.Array]:
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
    axis.set(title="charge, both faces together")


def draw_potential(
    axis: Axes, points: pd.DataFrame, potential: pd.DataFrame, levels: kit.Array
) -> ContourSet:
    """Lines of equal potential around the slab, its outline and its electrodes."""
    grid = potential.pivot_table(index="y", columns="x", values="potential", sort=True)
    x, y = grid.columns.to_numpy(dtype=float), grid.index.to_numpy(dtype=float)
    values = grid.to_numpy()
    shown = axis.contourf(x, y, values, levels, cmap="cividis", extend="neither")
    axis.contour(x, y, values, levels, colors="white", linewidths=0.5, linestyles="solid")
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
    axis.set_title("potential around the slab")
    axis.grid(visible=False)
    return shown


def ways(tables: kit.Tables) -> Figure:
    """Marginal effect and charge against voltage, three ways, and the faces at the last of each."""
    table, faces = tables["figure8"], tables["figure8_faces"]
    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    axes = figure.subplots(3, 2, sharey="row")
    sources = list(dict.fromkeys(table["way"]))
    for column, (covered, rows) in zip(axes.T, table.groupby("covered", sort=False), strict=True):
        margin, charge, face = column
        for place, source in enumerate(sources):
            style = kit.figures.series_style(place)
            line = rows[rows["way"] == source]
            margin.plot(line["voltage"], line["beside_over_middle"], label=source, **style)
            charge.plot(line["voltage"], 100 * line["inner_charge"], **style)
            last = faces[(faces["covered"] == covered) & (faces["way"] == source)]
            last = last[last["voltage"] == last["voltage"].max()]
            volts = f"{last['voltage'].iloc[0]:.3g} V"
            face.plot(last["x"] + last["along"], last["up"], color=style["color"], label=volts)
        margin.set_title(f"{TITLES[str(covered)]}:\nmarginal effect")
        margin.set(yscale="log", xlabel="voltage (V)")
        charge.set(title="where the charge is", xlabel="voltage (V)")
        face.set(title="upper face at the last voltage held", xlabel="x (m)")
        face.legend(loc="lower center", title="last voltage")
    for axis, label in zip(axes[:, 0], WAYS, strict=True):
        axis.set_ylabel(label)
    figure.suptitle("The report's Figure 8 in numbers, by its own way and others")
    kit.figures.add_shared_legend(figure, list(axes[0]))
    return figure
