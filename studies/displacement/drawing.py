"""Figures of the error budget, as functions of the tables."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate import kit
from msvalidate.bench.output.body_drawing import BOUNDARY_RULES

from .load_cases import BAND, CASES, body, problem
from .models import ISOTROPIC

PART_WORDS = {
    "at_rest": "not quite at rest",
    "linear_reference": "the target is linear",
    "law": "springs have another law at large strain",
    "large_spacing": "what spacing adds at large strain",
    "boundary": "boundary springs not weakened",
    "discretisation": "spacing",
    "model_form": "k2 = 2 k1 is another material",
}
"""Parts of the error budget, and how a figure calls them."""
PARTS = tuple(PART_WORDS)
"""Of the error budget, from the candidate's run to the target."""
PROBES = {
    "upper": "at a point near the upper edge",
    "inside": "at a point inside",
    "bottom": "at a point of the lower edge",
    "quarter": "at a quarter of the length",
}
SEEN = 1e-3
"""Part of the displacement below which a part of the budget is thinner than a line."""
LEVELS = (0.0, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0, np.inf)
"""Differences (%) at which colours change."""
ROOM = 0.35
"""Beside a body, where its loads are drawn (m)."""
FIELD_FINENESS = 10
"""Of the bodies whose field of differences is drawn."""


def convergence(tables: kit.Tables) -> Figure:
    """Relative L2 difference to the homogenised body against the spacing, with its order."""
    cases = tables["cases"].drop_duplicates(["case", "lattice", "weights", "k1", "cells_y"])
    figure, axes = kit.figures.new_figure(2, 2, size=(3.5, 3.3), sharey=True)
    for axis, case in zip(axes, CASES, strict=True):
        rows = cases[cases["case"] == case]
        groups = rows.groupby(["lattice", "k1", "weights"], sort=False)
        for i, ((lattice, _, weights), line) in enumerate(groups):
            k = line.iloc[0]
            name = f"{lattice}, {_model(k['k1'], k['k2'])}"
            shared = weights == "shared"
            axis.plot(
                1 / line["cells_y"],
                line["rel_l2"],
                "-" if shared else ":",
                marker=kit.figures.MARKERS[i // 2],
                color=kit.figures.COLOURS[i // 2],
                mfc=None if shared else "white",
                label=f"{name},\n{BOUNDARY_RULES[str(weights)]}",
            )
        spacing = np.array([1 / rows["cells_y"].max(), 1 / rows["cells_y"].min()])
        top = float(rows["rel_l2"].max())
        for order, style in ((1, "--"), (2, "-.")):
            axis.plot(
                spacing,
                1.5 * top * (spacing / spacing[1]) ** order,
                style,
                color="grey",
                lw=0.9,
                label=f"order {order}",
            )
        axis.set_xscale("log")
        axis.set_yscale("log")
        ticks = sorted({1 / n for n in rows[rows["lattice"] == "square"]["cells_y"]})
        axis.set_xticks(ticks, [f"1/{round(1 / t)}" for t in ticks])
        axis.set(title=case, xlabel="spacing over\nheight (1)")
    for axis in axes[::2]:
        axis.set_ylabel("difference to FEM over\nits displacement, rms (1)")
    figure.suptitle("Springs against the homogenised body, as spacings get finer")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure


def budget(tables: kit.Tables) -> Figure:
    """Signed parts of the error at one probe, along the load, stacked, for the coarsest bodies."""
    cases = tables["cases"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.6, 3.2), sharex=True, sharey=True)
    shown = {case: coarsest_rows(cases, case) for case in CASES}
    largest = pd.concat(shown.values())[list(PARTS)].abs().max()
    for axis, (case, rows) in zip(axes, shown.items(), strict=True):
        stack_parts(axis, rows, largest)
        component, probe = rows[["component", "probe"]].iloc[0]
        axis.set_title(f"{case}:\nalong {component[1]}, {PROBES[probe]}")
    for axis in axes[2:]:
        axis.set_xlabel("error, part of the target's\ndisplacement there (%)")
    for axis in axes[::2]:
        axis.set_ylabel("springs")
    figure.suptitle("What the error of springs is made of: 6 particles on a side of 1 m")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure


def coarsest_rows(cases: pd.DataFrame, case: str) -> pd.DataFrame:
    """Rows of the coarsest bodies at the last probe, along the load."""
    rows = cases[cases["case"] == case]
    rows = rows[rows["cells_y"] == rows.groupby("lattice")["cells_y"].transform("min")]
    rows = rows[rows["component"] == ("uy" if case in {"shear", "bending"} else "ux")]
    last: pd.DataFrame = rows[rows["probe"] == rows["probe"].iloc[-1]]
    return last


def stack_parts(axis: Axes, rows: pd.DataFrame, largest: pd.Series) -> None:
    """A bar for each row, its parts to the left where they are negative, and their total."""
    labels = [
        f"{r['lattice']}, {_model(r['k1'], r['k2'])},\n{BOUNDARY_RULES[r['weights']]}"
        for r in rows.to_dict("records")
    ]
    place = np.arange(len(rows))[::-1]
    right, left = np.zeros(len(rows)), np.zeros(len(rows))
    for part, colour in zip(PARTS, ("grey", *kit.figures.COLOURS), strict=True):
        value = 100 * rows[part].to_numpy()
        base = np.where(value >= 0, right, left)
        label = PART_WORDS[part] + ("" if largest[part] > SEEN else ": too small to see")
        axis.barh(place, value, left=base, color=colour, label=label, height=0.6)
        right, left = right + np.maximum(value, 0), left + np.minimum(value, 0)
    axis.errorbar(
        100 * rows["total"],
        place,
        xerr=100 * rows["reference"],
        fmt="D",
        color="black",
        ms=4,
        label="total, with the reference's own error",
    )
    axis.axvline(0, color="black", lw=0.8)
    band = 100 * BAND
    label = f"counts as agreement: {band:g} % or less"
    axis.axvspan(-band, band, color="#e6e6e6", lw=0, zorder=0, label=label)
    axis.set_yticks(place, labels, fontsize=8)
    axis.grid(visible=False, axis="y")


def field(tables: kit.Tables) -> Figure:
    """Where springs and homogenised body differ: length of the difference over the largest |u|."""
    table = tables["field"]
    lattices = list(dict.fromkeys(table["lattice"]))
    figure = Figure(figsize=(7.2, 7.4), layout="constrained")
    bar = "bending"
    blocks = [case for case in CASES if case != bar]
    layout: list[Any] = [[f"{case}, {lattice}" for case in blocks] for lattice in lattices]
    layout += [[f"{bar}, {lattice}"] * len(blocks) for lattice in lattices]
    axes = figure.subplot_mosaic(layout, height_ratios=(2, 2.2, 1.3, 1.5))
    levels = field_levels(100 * table["difference"].max())
    for (case, lattice), points in table.groupby(["case", "lattice"], sort=False):
        axis = axes[f"{case}, {lattice}"]
        mesh = Triangulation(points["x"], points["y"])
        mesh.set_mask(_slivers(mesh))
        shown = axis.tricontourf(
            mesh,
            100 * points["difference"],
            levels,
            cmap="viridis",
            norm=BoundaryNorm(levels, 256),
        )
        draw_case(axis, str(case), str(lattice), points[["x", "y"]].to_numpy())
        axis.set(title=f"{case}, {lattice}", aspect="equal")
        axis.set(xticks=range(1 + int(points["x"].max())), yticks=(0, 1))
        width, height = points[["x", "y"]].max()
        axis.set(xlim=(-ROOM, width + ROOM), ylim=(-0.1, height + ROOM))
        axis.grid(visible=False)
    for name, axis in axes.items():
        if name.startswith((blocks[0], bar)):
            axis.set_ylabel("y (m)")
        if name.endswith(lattices[-1]):
            axis.set_xlabel("x (m)")
    label = "distance of springs from the homogenised body, part of the largest displacement (%)"
    bar_axes = list(axes.values())
    scale = figure.colorbar(shown, ax=bar_axes, orientation="horizontal", aspect=50, shrink=0.9)
    scale.set_label(label)
    scale.set_ticks(levels, labels=[f"{level:g}" for level in levels])
    figure.suptitle("Where springs and the body they stand for differ")
    kit.figures.add_shared_legend(figure, bar_axes)
    return figure


def field_levels(most: float) -> list[float]:
    """Where colours change (%): the same in every panel, up to the largest difference."""
    return [*(level for level in LEVELS if level < most), next(m for m in LEVELS if m >= most)]


def draw_case(axis: Axes, case: str, lattice: str, points: kit.Array) -> None:
    """Supports at the points of a lattice that a case holds, and its loads at those it loads."""
    shape = body(lattice, case, FIELD_FINENESS)
    asked = problem(case, shape, ISOTROPIC.target)
    held, _ = kit.prescribed_displacements(asked, points)
    kit.body_drawing.draw_supports(axis, points, held, size=3.5)
    for name, force in CASES[case].loads.items():
        at = points[shape.places[name].select(points, shape.domain.tolerance)]
        kit.body_drawing.draw_loads(axis, at, np.tile(force, (len(at), 1)), length=0.9 * ROOM)


def _slivers(mesh: Triangulation) -> kit.Mask:
    """Triangles that bridge a notch of the outline: longer than the lattice's own."""
    x, y = mesh.x[mesh.triangles], mesh.y[mesh.triangles]
    side = np.hypot(x - np.roll(x, 1, axis=1), y - np.roll(y, 1, axis=1)).max(axis=1)
    return np.asarray(side > 1.5 * np.median(side))


def _model(k1: float, k2: float) -> str:
    return "k2 = 2 k1" if k2 > k1 else "isotropic"
