"""Emblem: the bar of the report's Figure 7 twice, as the report builds it and calibrated.

Question   Which difference from the target's outline does the choice of springs make?
Candidate  The spring network with 20 cells over the height: k2 = 2 k1 with boundary weight 1, and
           k2 = k1/2 with boundary weight 1/2.
Reference  scikit-fem's elements of the target: axial modulus of the springs, nu = 1/2 and 1/3.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.lattice import square
from msvalidate_check.text import percent

from . import load_cases
from .elastic import Bodies
from .load_cases import BAND, LENGTH
from .measuring import Block, Measurement
from .models import MODELS
from .shapes import outline_points

CASE, CELLS, STRIDE = "bending", 20, 4
"""Load case, cells over the height, and lattice lines of which one is drawn."""
BARS = {
    "k2 = 2 k1, boundary weight 1 (the report)": (MODELS[1], "equal"),
    "k2 = k1/2, boundary weight 1/2": (MODELS[0], "shared"),
}
"""Springs in words -> model and boundary rule."""
EXAGGERATED = 20
FIELDS = (("x", "y"), ("ux", "uy"), ("target_ux", "target_uy"))
"""Columns of points, displacements of the springs and of the target."""


def distance(bar: pd.DataFrame) -> float:
    """Largest distance of the outlines, relative to the target's largest displacement there."""
    points, move, target = (bar[list(names)].to_numpy() for names in FIELDS)
    ring = outline_points(points)
    away = np.linalg.norm(move - target, axis=1)[ring].max()
    return float(away / np.linalg.norm(target, axis=1)[ring].max())


RULES = (
    kit.Rule(
        "bar of calibrated springs: distance of its outline from the target's", BAND, "1",
        "the band of the load cases", layer="agreement", table="bars",
        rows={"bar": list(BARS)[-1]}, value=distance,
    ),
)  # fmt: skip


def run(measured: Mapping[Block, Measurement], bodies: Bodies) -> kit.Evidence:
    """Displacements of both bars and their targets, from what the study has solved."""
    parts = []
    for words, (model, weights) in BARS.items():
        block = Block(CASE, model, CELLS)
        springs = measured[block].moves[weights, "linear"]
        _, target = bodies[CASE, model, CELLS]
        shape = load_cases.body(model.lattice, CASE, CELLS)
        lines = np.rint(measured[block].points / shape.spacing).astype(int)
        shown = (lines % STRIDE == 0).all(axis=1)
        fields = {"x": measured[block].points[:, 0], "y": measured[block].points[:, 1]}
        for name, move in (("", springs), ("target_", target.at_points[CELLS])):
            fields |= {f"{name}ux": move[:, 0], f"{name}uy": move[:, 1]}
        parts.append(pd.DataFrame({"bar": words} | fields)[shown])
    return kit.Evidence(
        tables={"bars": pd.concat(parts, ignore_index=True)},
        tolerances=RULES,
        figures={"emblem": emblem},
        cover="emblem",
        columns=kit.columns(__file__),
    )


def emblem(tables: kit.Tables) -> Figure:
    """The bar of Figure 7 with the report's springs and with calibrated ones, over its target."""
    figure = Figure(figsize=(5.6, 3.8), layout="constrained")
    axes = figure.subplots(len(BARS), sharex=True, sharey=True)
    height = CELLS // STRIDE
    springs = square(kit.Box((LENGTH, 1.0)), (round(LENGTH) * height, height)).springs
    for axis, (words, bar) in zip(axes, tables["bars"].groupby("bar", sort=False), strict=True):
        points, move, target = (bar[list(names)].to_numpy() for names in FIELDS)
        ends = (points + EXAGGERATED * move)[springs]
        # One line with gaps: a tenth of the bytes of a path for each spring.
        x, y = np.insert(ends, 2, np.nan, axis=1).reshape(-1, 2).T
        axis.plot(x, y, color=kit.figures.COLOURS[4], lw=0.5, label="springs")
        at = (points + EXAGGERATED * target)[outline_points(points)]
        kit.body_drawing.draw_outline(
            axis, at, "outline of the elastic target (scikit-fem)", color=kit.figures.COLOURS[1]
        )
        axis.set_title(f"{words}: {percent(distance(bar))} from the target's outline")
        axis.set(aspect="equal", ylabel="y (m)")
        axis.grid(visible=False)
    axes[-1].set_xlabel(f"x (m), displacement × {EXAGGERATED}, every fourth lattice line")
    kit.figures.add_shared_legend(figure, list(axes), columns=2)
    return figure
