"""Figures of the question about shapes, as functions of the tables: the report's, drawn again."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure

from msvalidate import kit

from .claims import CLAIMS, CURVES, SOURCES
from .load_cases import CASES


def figures_4_to_7(tables: kit.Tables) -> Figure:
    """Figures 4 to 7 at k2 = 2 k1 redrawn: 6 x 6 particles over the outlines of elastic bodies."""
    figure = Figure(figsize=(7.6, 6.8), layout="constrained")
    bar = "bending"
    blocks = [case for case in CASES if case != bar]
    layout: list[Any] = [blocks, [bar] * len(blocks)]
    axes = figure.subplot_mosaic(layout, height_ratios=(1.3, 1))
    _, orange, green, *_ = kit.figures.COLOURS
    for case, axis in axes.items():
        scale = CASES[case].magnification
        points, pairs, edge = (
            table[table["case"] == case]
            for table in (tables["deformed"], tables["deformed_springs"], tables["outline"])
        )
        rest = points[["x", "y"]].to_numpy()
        now = rest + scale * points[["ux", "uy"]].to_numpy()
        springs = pairs[["start", "end"]].to_numpy()
        kit.body_drawing.draw_springs(
            axis, rest, springs, "springs, at rest", kit.body_drawing.AT_REST
        )
        kit.body_drawing.draw_springs(axis, now, springs, "springs, deformed")
        kit.body_drawing.draw_particles(axis, now)
        for source, colour, line in zip(SOURCES[1:], (orange, green), ("-", "--"), strict=True):
            ring = edge[edge["source"] == source]
            at = ring[["x", "y"]].to_numpy() + scale * ring[["ux", "uy"]].to_numpy()
            kit.body_drawing.draw_outline(axis, at, f"{source} (FEM)", ls=line, color=colour)
        words = points["held_components"].str
        held = np.column_stack([words.contains("ux"), words.contains("uy")])
        kit.body_drawing.draw_supports(axis, now, held)
        kit.body_drawing.draw_loads(axis, now, points[["load_x", "load_y"]])
        axis.set(aspect="equal", xlabel="x (m)", ylabel="y (m)")
        gap_in_title = ", " if case == bar else "\n"
        axis.set_title(f"Figure {CASES[case].figure}: {case}{gap_in_title}displacement × {scale}")
        axis.grid(visible=False)
        if case != bar:
            axis.set(xlim=(-0.2, 1.15), ylim=(-0.1, 1.33), xticks=(0, 0.5, 1))
    figure.suptitle("The report's load cases: springs, k2 = 2 k1, over elastic bodies")
    kit.figures.add_shared_legend(figure, list(axes.values()), columns=3)
    return figure


def bent_line(tables: kit.Tables) -> Figure:
    """Deflection of the bar's lowest row at k2 = 2 k1, and by how much four curves miss it."""
    figure, (axis, missed) = kit.figures.new_figure(columns=2, size=(3.6, 4.2))
    lines = dict(list(tables["bent_line"].groupby("source")))
    springs = lines[SOURCES[0]]
    x, deflection = springs["x"], 1e3 * springs["uy"]
    height = deflection.abs().max()
    blue, *solids = kit.figures.COLOURS[:3]
    for source, colour, style in zip(SOURCES[1:], solids, ("-", "--"), strict=True):
        axis.plot(x, 1e3 * lines[source]["uy"], style, color=colour, label=f"{source} (FEM)")
    curves = zip(CURVES, CLAIMS["bending"], (*kit.figures.COLOURS[3:], "#444444"), strict=True)
    for (curve, claim, colour), marker in zip(curves, "^vDs", strict=True):
        fit = 1e3 * springs[curve]
        label = f"fit: {claim.statement.partition(': ')[2]}"
        axis.plot(x, fit, color=colour, lw=1, label=label)
        by = 100 * (deflection - fit) / height
        missed.plot(x, by, marker, ls="-", color=colour, lw=1, ms=3.5)
    axis.plot(x, deflection, "o", color=blue, mfc="white", ms=4, label="springs")
    axis.set(xlabel="x (m)", ylabel="deflection uy (mm)", title="Lowest row of the bar")
    missed.set(
        xlabel="x (m)", ylabel="springs less fit (% of largest)", title="Misfit of the springs"
    )
    figure.suptitle("How the bar of Figure 7 bends, k2 = 2 k1")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
