"""Pictures of bodies with curved outlines: stress of elements, of springs, and their difference.

A table holds the nodes of a mesh of nine-node cells and the stresses there.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array, Index

COLUMNS = {
    "x": "place along x (m)",
    "y": "place along y (m)",
    "mises_fem": "von Mises' stress of finite elements at a place of the picture (Pa)",
    "mises_springs": "the same of springs, of a quartic fit to their displacements (Pa)",
}
AROUND = (0, 4, 1, 5, 2, 6, 3, 7)
"""Nodes of a nine-node cell on its sides, in their order round it."""
UNITS = ((1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"


def table(places: Array, of_elements: Array, of_springs: Array) -> pd.DataFrame:
    """Rows of a picture: places (p, 2) in m and stresses (p, 3) in Pa there."""
    return pd.DataFrame(
        {
            "x": places[:, 0],
            "y": places[:, 1],
            "mises_fem": mises(of_elements),
            "mises_springs": mises(of_springs),
        }
    )


def mises(stress: Array) -> Array:
    """Von Mises' stress (p,) of plane stresses (p, 3)."""
    x, y, shear = stress.T
    return np.asarray(np.sqrt(x**2 - x * y + y**2 + 3 * shear**2))


def triangles(cells: Index) -> Index:
    """Eight triangles round the middle of each nine-node cell."""
    ring = cells[:, AROUND]
    middle = np.broadcast_to(cells[:, 8:9], ring.shape)
    return np.stack([ring, np.roll(ring, -1, axis=1), middle], axis=2).reshape(-1, 3)


def pictures(name: str, cells: Index, tables: Tables) -> Figure:
    """Elements, springs, and springs - elements, in true proportions."""
    rows = tables[name]
    fem, springs = (rows[column].to_numpy() for column in ("mises_fem", "mises_springs"))
    mesh = Triangulation(rows["x"], rows["y"], triangles(cells))
    unit, word = next(each for each in UNITS if fem.max() >= each[0] or each[0] == 1.0)
    size = np.ptp(rows["y"]) / np.ptp(rows["x"])
    figure, axes = figures.new_figure(3, size=(3.1, 3.1 * size + 1.3), sharey=True)
    same = Normalize(0, max(fem.max(), springs.max()) / unit)
    part = 100 * (springs - fem) / fem.max()
    most = float(np.abs(part).max())
    shown: tuple[tuple[str, Array, Any, str, str], ...] = (
        ("finite elements", fem / unit, same, SEQUENTIAL, f"von Mises' stress ({word})"),
        ("springs", springs / unit, same, SEQUENTIAL, f"von Mises' stress ({word})"),
        (
            "springs - elements",
            part,
            Normalize(-most, most),
            DIVERGING,
            "difference, of the largest stress (%)",
        ),
    )
    for axis, (title, value, norm, colours, label) in zip(axes, shown, strict=True):
        drawn = axis.tripcolor(
            mesh, value, shading="gouraud", norm=norm, cmap=colours, rasterized=True
        )
        axis.set_aspect("equal")
        axis.set(title=title, xlabel="x (m)")
        axis.grid(visible=False)
        figure.colorbar(drawn, ax=axis, orientation="horizontal", label=label, shrink=0.9)
    axes[0].set_ylabel("y (m)")
    return figure


def drawing(name: str, body: str, cells: Index) -> Any:
    """`pictures` of one table, as `Evidence.figures` wants it; the caption names the body."""

    def draw_pictures(tables: Tables) -> Figure:
        return pictures(name, cells, tables)

    draw_pictures.__doc__ = f"{body}: stress of finite elements, of springs, and their difference."
    return draw_pictures
