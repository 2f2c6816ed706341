"""Figures of solids: deformed bodies coloured by their difference to FEM, and errors by size."""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from msvalidate import kit

from .solid_bodies import CASES, DRAWN, MODELS, ElasticSolid, Moved, SolidCase, grid

MODEL = "cubic 18"
MAGNIFIED = {"cube, shear": 15, "cube, pressure": 20, "cantilever": 8}
"""Factor on the displacements in the pictures."""
ARROW = 0.6
"""Length (m) of the arrow of a load."""
AXES = "xyz"


def shapes(
    own: dict[tuple[str, str], ElasticSolid], moved: dict[tuple[str, str, int], Moved]
) -> pd.DataFrame:
    """Surface points of the isotropic bodies drawn, the springs' displacements and differences."""
    parts = []
    for case in CASES.values():
        points = grid(MODELS[MODEL], case, DRAWN).points
        move = moved[case.name, MODEL, DRAWN].at_points
        fem = own[case.name, MODEL].at_points
        away = np.linalg.norm(move - fem, axis=1) / np.linalg.norm(fem, axis=1).max()
        outside = ((points == 0) | (points == points.max(axis=0))).any(axis=1)
        table: dict[str, object] = {"case": case.name}
        table |= dict(zip(AXES, points[outside].T, strict=True))
        table |= {f"u{a}": u for a, u in zip(AXES, move[outside].T, strict=True)}
        parts.append(pd.DataFrame(table | {"difference": away[outside]}))
    return pd.concat(parts, ignore_index=True)


def deformed(tables: kit.Tables) -> Figure:
    """Deformed bodies of 8 cells through the height, coloured by springs - FEM."""
    table = tables["solid_shape"]
    figure, axes = kit.figures.solid_axes(len(CASES), (3.6, 3.2), rows=2)
    norm = Normalize(0, 100 * table["difference"].max())
    for axis, (name, factor) in zip(axes, MAGNIFIED.items(), strict=True):
        rows, case = table[table["case"] == name], CASES[name]
        # y is drawn upwards, as the names of sides have it
        points, move = (rows[list(names)].to_numpy() for names in ("xzy", ("ux", "uz", "uy")))
        moved = points + factor * move
        surface = kit.figures.draw_solid(
            axis, points, moved, 100 * rows["difference"].to_numpy(), norm
        )
        draw_traction(axis, case, points, moved)
        axis.set(ylabel="z (m)", zlabel="y (m)")
        axis.set_title(f"{name}:\n{case.clamped} held, {case.loaded} loaded, × {factor}")
    scale = figure.colorbar(surface, ax=axes, orientation="horizontal", aspect=50, shrink=0.9)
    scale.set_label("distance of springs from FEM, part of the largest displacement (%)")
    figure.suptitle("Solids of springs: arrows are loads, displacements magnified")
    return figure


def draw_traction(axis: Any, case: SolidCase, points: kit.Array, moved: kit.Array) -> None:
    """An arrow in the middle of the loaded side, which ends there where it presses."""
    along, level = {"top": (2, 1.0), "right": (0, case.length)}[case.loaded]
    start = moved[np.isclose(points[:, along], level)].mean(axis=0)
    arrow = ARROW * np.array(case.traction)[[0, 2, 1]] / np.linalg.norm(case.traction)
    pressed = arrow[along] < 0
    kit.body_drawing.draw_solid_load(axis, start - arrow * pressed, arrow)


def convergence(tables: kit.Tables) -> Figure:
    """Size of springs - own body against cells, the reference's uncertainty, and orders."""
    table = tables["solid"]
    figure, axes = kit.figures.new_figure(len(CASES), size=(2.4, 3.4), sharey=True)
    for axis, case in zip(axes, CASES, strict=True):
        here = table[table["case"] == case]
        for i, (lattice, rows) in enumerate(here.groupby("lattice", sort=False)):
            colour, marker = kit.figures.COLOURS[i], kit.figures.MARKERS[i]
            axis.loglog(
                rows["cells_high"], 100 * rows["against_own_body"].abs(), f"{marker}-",
                color=colour, label=f"springs, {lattice}",
            )  # fmt: skip
            uncertainty = 100 * rows["fem_uncertainty"].iloc[0]
            axis.axhline(uncertainty, color=colour, ls=":", label=f"uncertainty of FEM, {lattice}")
        sizes = np.array(sorted(set(here["cells_high"])))
        first = 100 * here["against_own_body"].abs().max()
        for order, style in ((here["twice_edge_exponent"].iloc[0], "--"), (2.0, "-.")):
            label = "order 2" if order == 2 else "order 2λ of cubic 18"
            line = 1.3 * first * (sizes / sizes[0]) ** -order
            axis.loglog(sizes, line, style, color="grey", lw=0.9, label=label)
        axis.set_xticks(sizes, [str(n) for n in sizes])
        axis.set(title=case, xlabel="cells through\nthe height (1)")
    axes[0].set_ylabel("springs less own body,\nloaded side (%)")
    figure.suptitle("Springs in space against the body they stand for")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
