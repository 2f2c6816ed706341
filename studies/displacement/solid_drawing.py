"""Figures of solids: deformed bodies coloured by their difference to FEM, and errors by size."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

from .solid_bodies import CASES, DRAWN, MODELS, ElasticSolid, Moved, grid

MODEL = "cubic 18"
MAGNIFIED = {"cube, shear": 15, "cube, pressure": 20, "cantilever": 8}
"""Factor on the displacements in the pictures."""
AXES = "xyz"
COLUMNS = {
    "x": "place along x (m)",
    "y": "place along y (m)",
    "z": "place along z (m)",
    "ux": "displacement along x (m)",
    "uy": "displacement along y (m)",
    "uz": "displacement along z (m)",
    "difference": "length of springs - u_fem over the largest |u_fem|, isotropic, shared (1)",
}


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


def deformed(tables: Tables) -> Figure:
    """Deformed bodies of 8 cells through the height, coloured by springs - FEM."""
    table = tables["solid_shape"]
    figure, axes = figures.solid_axes(len(CASES), (3.7, 3.9))
    for axis, (case, factor) in zip(axes, MAGNIFIED.items(), strict=True):
        rows = table[table["case"] == case]
        points, move = (rows[list(names)].to_numpy() for names in (AXES, ("ux", "uy", "uz")))
        percent = 100 * rows["difference"].to_numpy()
        norm = Normalize(0, percent.max())
        surface = figures.draw_solid(axis, points, points + factor * move, percent, norm)
        figure.colorbar(
            surface, ax=axis, orientation="horizontal", shrink=0.8, pad=0.1,
            label="distance to FEM, of the largest displacement (%)",
        )  # fmt: skip
        axis.set_title(f"{case}, displacements x {factor}", fontsize=9)
    return figure


def convergence(tables: Tables) -> Figure:
    """Size of springs - own body against cells, the reference's uncertainty, and orders."""
    table = tables["solid"]
    figure, axes = figures.new_figure(len(CASES), size=(3.0, 3.1), sharey=True)
    for axis, case in zip(axes, CASES, strict=True):
        here = table[table["case"] == case]
        for i, (lattice, rows) in enumerate(here.groupby("lattice", sort=False)):
            colour, marker = figures.COLOURS[i], figures.MARKERS[i]
            axis.loglog(
                rows["cells_high"], 100 * rows["against_own_body"].abs(), f"{marker}-",
                color=colour, label=f"springs, {lattice}",
            )  # fmt: skip
            doubt = 100 * rows["fem_uncertainty"].iloc[0]
            axis.axhline(doubt, color=colour, ls=":", label=f"uncertainty of FEM, {lattice}")
        sizes = np.array(sorted(set(here["cells_high"])))
        first = 100 * here["against_own_body"].abs().max()
        for order, style in ((here["twice_edge_exponent"].iloc[0], "--"), (2.0, "-.")):
            label = "order 2" if order == 2 else "order 2λ of cubic 18"
            line = 1.3 * first * (sizes / sizes[0]) ** -order
            axis.loglog(sizes, line, style, color="grey", lw=0.9, label=label)
        axis.set_xticks(sizes, [str(n) for n in sizes])
        axis.set(title=case, xlabel="cells through the height (1)")
    axes[0].set_ylabel("springs - own body, loaded side (%)")
    figures.add_shared_legend(figure, axes, columns=3)
    return figure
