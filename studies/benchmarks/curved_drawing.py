"""Pictures of bodies with curved outlines: stress of elements, of springs, and their difference.

A table holds the nodes of a mesh of nine-node cells and the stresses there.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import Normalize
from matplotlib.figure import Figure
from matplotlib.tri import Triangulation

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures
from msvalidate.problem import Array, Index

from . import sketches

COLUMNS = {
    "x": "place along x (m)",
    "y": "place along y (m)",
    "mises_fem": "von Mises' stress of finite elements at a place of the picture (Pa)",
    "mises_springs": "the same of springs, of a quartic fit to their displacements (Pa)",
}
AROUND = (0, 4, 1, 5, 2, 6, 3, 7)
"""Nodes of a nine-node cell on its sides, in their order round it."""
UNITS = ((1e6, "MPa"), (1e3, "kPa"), (1.0, "Pa"))
ROOM = 1.2
"""Length of an axis over the body's, for arrows of loads."""
SEQUENTIAL, DIVERGING = "viridis", "RdBu_r"


@dataclass(frozen=True, eq=False)
class Body:
    """A quarter of a body with a hole: its name, cells (c, 9), half-axes of the hole, its loads."""

    name: str
    cells: Index
    inner: sketches.Place
    loads: Callable[[Axes], None]


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


def pictures(name: str, body: Body, tables: Tables) -> Figure:
    """Elements, springs, and springs - elements, in true proportions, with supports and loads."""
    rows = tables[name]
    fem, springs = (rows[column].to_numpy() for column in ("mises_fem", "mises_springs"))
    mesh = Triangulation(rows["x"], rows["y"], triangles(body.cells))
    unit, word = next(each for each in UNITS if fem.max() >= each[0] or each[0] == 1.0)
    size = np.ptp(rows["y"]) / np.ptp(rows["x"])
    figure, axes = figures.new_figure(3, size=(2.3, 2.3 * size + 1.3), sharey=True)
    same = Normalize(0, max(fem.max(), springs.max()) / unit)
    part = 100 * (springs - fem) / fem.max()
    most = float(np.abs(part).max())
    shown = (
        ("finite elements", fem / unit, same, SEQUENTIAL),
        ("springs", springs / unit, same, SEQUENTIAL),
        ("springs - elements", part, Normalize(-most, most), DIVERGING),
    )
    drawn = []
    for axis, (title, value, norm, colours) in zip(axes, shown, strict=True):
        drawn.append(
            axis.tripcolor(mesh, value, shading="gouraud", norm=norm, cmap=colours, rasterized=True)
        )
        sketches.mirrors(axis, body.inner, (rows["x"].max(), rows["y"].max()))
        body.loads(axis)
        axis.set_aspect("equal")
        axis.set(title=title, xlabel="x (m)")
        axis.set(xlim=(None, ROOM * rows["x"].max()), ylim=(None, ROOM * rows["y"].max()))
        axis.grid(visible=False)
    bar: dict[str, Any] = {"orientation": "horizontal", "aspect": 30}
    figure.colorbar(drawn[0], ax=axes[:2], label=f"von Mises stress ({word})", shrink=0.6, **bar)
    bar["aspect"] = 18
    figure.colorbar(drawn[2], ax=axes[2], label="of the largest stress (%)", shrink=0.9, **bar)
    axes[0].set_ylabel("y (m)")
    figure.suptitle(f"{body.name}: stress by elements and by springs")
    return figure


def drawing(
    name: str, body: str, cells: Index, inner: sketches.Place, loads: Callable[[Axes], None]
) -> Any:
    """`pictures` of one table, as `Evidence.figures` wants it; the caption names the body.

    `inner`: half-axes of its hole (m). `loads` draws its loads.
    """
    drawn = Body(body, cells, inner, loads)

    def draw_pictures(tables: Tables) -> Figure:
        return pictures(name, drawn, tables)

    draw_pictures.__doc__ = f"{body}: stress of finite elements, of springs, and their difference."
    return draw_pictures
