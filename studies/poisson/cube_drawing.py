"""Figures of the cube: its ratios against size, and a clamped cube as it deforms."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bench.output.body_drawing import BOUNDARY_RULES

from .cube_block import SIDE, spring_cube

MAGNIFIED = 250
"""Factor on the displacements in the picture of the cube."""
AXES = "xyz"
ENDS = {"slide": "ends slide", "traction": "traction"}
"""How cubes are loaded."""


def shape(candidate: kit.DisplacementSolver, cells: int) -> pd.DataFrame:
    """Surface points of a clamped cube of cubic 18, shared springs, and their displacements."""
    problem, network = spring_cube("cubic 18", "shared", "clamped", cells)
    move = candidate(problem, network, "linear")
    outside = ((network.points == 0) | (network.points == SIDE)).any(axis=1)
    places = (network.points + move)[outside]
    table = dict(zip(AXES, places.T, strict=True))
    return pd.DataFrame(table | {f"u{a}": u for a, u in zip(AXES, move[outside].T, strict=True)})


def ratios(tables: kit.Tables) -> Figure:
    """Ratio against size, a panel a lattice: rules by colour, loadings by marker."""
    table = tables["cube"]
    names = list(dict.fromkeys(table["lattice"]))
    figure, axes = kit.figures.new_figure(3, -(-len(names) // 3), size=(2.4, 2.5), sharey=True)
    for axis, name in zip(axes, names, strict=False):
        here = table[table["lattice"] == name]
        for rule, colour in zip(("shared", "equal", "per_cell"), kit.figures.COLOURS, strict=False):
            for loading, marker, size in (("slide", "o", 8), ("traction", "x", 5)):
                rows = here[(here["weights"] == rule) & (here["loading"] == loading)]
                label = f"{BOUNDARY_RULES[rule]}, {ENDS[loading]}"
                axis.plot(
                    rows["cells"],
                    rows["nu_springs"],
                    f"{marker}-",
                    color=colour,
                    label=label,
                    mfc="none",
                    ms=size,
                    lw=0.9,
                )
        layers = here[(here["nu_layers"] != "none") & (here["loading"] == "slide")]
        axis.plot(
            layers["cells"],
            layers["nu_layers"],
            ":",
            color="black",
            label="closed form: N + 1 layers",
        )
        bulk = here[here["weights"] == "shared"]["nu_tensor"].iloc[0]
        axis.axhline(bulk, color="grey", ls="--", lw=0.9, label="homogenised tensor")
        axis.set_title(name, fontsize=9)
        axis.set_xscale("log")
        sizes = sorted(set(table["cells"]))
        axis.set_xticks(sizes, [str(n) for n in sizes])
        axis.set_xlim(0.85, 1.15 * sizes[-1])
        axis.set_xlabel("cells per side, N (1)")
    for axis in axes[::3]:
        axis.set_ylabel("Poisson's ratio (1)")
    for axis in axes[len(names) :]:
        figure.delaxes(axis)
    figure.suptitle("Poisson's ratio of cubes of springs by size")
    kit.figures.add_shared_legend(figure, axes[: len(names)], columns=2)
    return figure


def deformed(tables: kit.Tables) -> Figure:
    """The clamped cube as it deforms, coloured by how far its points move towards its axis."""
    table = tables["cube_shape"]
    move = table[["ux", "uy", "uz"]].to_numpy()
    first = table[["x", "y", "z"]].to_numpy() - move
    away = first[:, 1:] - SIDE / 2
    inwards = -1e6 * (move[:, 1:] * away).sum(axis=1) / np.linalg.norm(away, axis=1).clip(1e-9)
    figure, (axis,) = kit.figures.solid_axes(1, (4.8, 3.8))
    norm = Normalize(0, inwards.max())
    surface = kit.figures.draw_solid(axis, first, first + MAGNIFIED * move, inwards, norm)
    figure.colorbar(surface, ax=axis, shrink=0.7, pad=0.12, label="displacement to the axis (µm)")
    right = SIDE + MAGNIFIED * move[:, 0].max()
    kit.body_drawing.draw_solid_load(
        axis, np.array([right, SIDE / 2, SIDE / 2]), np.array([0.35, 0, 0])
    )
    axis.set_title(f"Cube of springs, both ends clamped, one pulled;\ndisplacements × {MAGNIFIED}")
    return figure
