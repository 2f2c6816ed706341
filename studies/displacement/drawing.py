"""Figures of the error budget, as functions of the tables."""

from __future__ import annotations

import numpy as np
from matplotlib.colors import PowerNorm
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Mask

from .load_cases import BAND, CASES

PARTS = ("at_rest", "geometric", "boundary", "discretisation", "model_form")
"""Of the error budget, from the candidate's run to the target."""
WORDS = {
    "at_rest": "not at rest",
    "geometric": "geometric nonlinearity",
    "boundary": "springs on the boundary",
    "discretisation": "discretisation",
    "model_form": "another material",
}
"""Of these parts in figures."""
RULES = {"shared": "half", "equal": "full"}
"""Of springs on the boundary in figures."""
MIDDLE = 0.5
"""Power of the scale of colours: small differences show beside large ones."""


def convergence(tables: Tables) -> Figure:
    """Relative L2 difference to the homogenised body against the spacing, with its order."""
    cases = tables["cases"].drop_duplicates(["case", "lattice", "weights", "k1", "cells_y"])
    figure, axes = figures.new_figure(len(CASES), 1, size=(2.7, 3.0), sharey=True)
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
                marker=figures.MARKERS[i // 2],
                color=figures.COLOURS[i // 2],
                mfc=None if shared else "white",
                label=f"{name}, {RULES[str(weights)]} springs on the boundary",
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
        axis.set(title=case, xlabel="spacing over height (1)")
    axes[0].set_ylabel("relative L2 difference to FEM (1)")
    figures.add_shared_legend(figure, axes, columns=3)
    return figure


def budget(tables: Tables) -> Figure:
    """Signed parts of the error at one probe, along the load, stacked, for the coarsest bodies."""
    cases = tables["cases"]
    figure, axes = figures.new_figure(2, 2, size=(5.2, 3.2), sharey=True)
    for axis, case in zip(axes, CASES, strict=True):
        rows = cases[(cases["case"] == case)]
        first = rows.groupby("lattice")["cells_y"].transform("min")
        rows = rows[rows["cells_y"] == first]
        rows = rows[rows["component"] == ("uy" if case in {"shear", "bending"} else "ux")]
        rows = rows[rows["probe"] == rows["probe"].iloc[-1]]
        labels = [
            f"{r.lattice}\n{_model(r.k1, r.k2)}\n{RULES[str(r.weights)]}"
            for r in rows.itertuples(index=False)
        ]
        place = np.arange(len(rows))
        up, down = np.zeros(len(rows)), np.zeros(len(rows))
        for part, colour in zip(PARTS, figures.COLOURS, strict=False):
            value = 100 * rows[part].to_numpy()
            base = np.where(value >= 0, up, down)
            axis.bar(place, value, bottom=base, color=colour, label=WORDS[part], width=0.6)
            up, down = up + np.maximum(value, 0), down + np.minimum(value, 0)
        axis.errorbar(
            place,
            100 * rows["total"],
            100 * rows["reference"],
            fmt="D",
            color="black",
            ms=4,
            label="total ± reference",
        )
        axis.axhline(0, color="black", lw=0.8)
        band = 100 * BAND
        axis.axhspan(-band, band, color="#e6e6e6", lw=0, zorder=0, label="band")
        axis.set_xticks(place, labels, fontsize=7)
        component = str(rows["component"].iloc[0])[-1]
        axis.set_title(f"{case}: displacement along {component}, {rows['probe'].iloc[0]}")
        axis.set_xlabel("lattice, constants, springs on the boundary; 6 points on a side")
    for axis in axes[::2]:
        axis.set_ylabel("part of the target's displacement (%)")
    figures.add_shared_legend(figure, axes, columns=4)
    return figure


def field(tables: Tables) -> Figure:
    """Where springs and homogenised body differ: length of the difference over the largest |u|."""
    table = tables["field"]
    lattices = list(dict.fromkeys(table["lattice"]))
    figure, axes = figures.new_figure(len(CASES), len(lattices), size=(2.7, 2.3))
    # One scale for all; the root lets differences of 1 % show beside those of 10 %.
    scale = PowerNorm(MIDDLE, 0.0, 100 * float(table["difference"].max()))
    for row, lattice in enumerate(lattices):
        for column, case in enumerate(CASES):
            axis = axes[row * len(CASES) + column]
            points = table[(table["lattice"] == lattice) & (table["case"] == case)]
            mesh = Triangulation(points["x"], points["y"])
            mesh.set_mask(_slivers(mesh))
            shown = axis.tripcolor(
                mesh,
                100 * points["difference"],
                cmap="viridis",
                shading="gouraud",
                norm=scale,
                rasterized=True,
            )
            axis.set_aspect("equal")
            axis.grid(visible=False)
            axis.set_title(f"{case}, {lattice}", fontsize=8)
            axis.set(xlabel="x (m)", ylabel="y (m)")
    bar = figure.colorbar(shown, ax=axes, orientation="horizontal", fraction=0.05, aspect=60)
    bar.set_label("difference over the largest displacement (%)")
    return figure


def _slivers(mesh: Triangulation) -> Mask:
    """Triangles that bridge a notch of the outline: longer than the lattice's own."""
    x, y = mesh.x[mesh.triangles], mesh.y[mesh.triangles]
    side = np.hypot(x - np.roll(x, 1, axis=1), y - np.roll(y, 1, axis=1)).max(axis=1)
    return np.asarray(side > 1.5 * np.median(side))


def _model(k1: float, k2: float) -> str:
    return "k2 = 2 k1" if k2 > k1 else "isotropic"
