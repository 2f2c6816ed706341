"""Bodies in figures: springs, outlines, supports and loads, drawn alike in every study."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from numpy.typing import ArrayLike

from msvalidate.output.figures import COLOURS
from msvalidate.problem import Array, Index, Mask

AT_REST = "#d4d4d4"
DEFORMED = "#66a9d4"
ARROW_WIDTH = 0.08
"""Of an arrow's shaft over the length of the longest."""
HELD = {(True, True): "s", (True, False): ">", (False, True): "^"}
"""Marker of a support by what it holds: along x, along y."""
BOUNDARY_RULES = {
    "shared": "boundary springs weakened",
    "equal": "all springs alike",
    "per_cell": "each cell its own springs",
}
"""Names in figures of `lattice.filled.WEIGHTS`."""
HOW = {(True, True): "held", (True, False): "held along x", (False, True): "held along y"}


def draw_springs(axis: Axes, at: Array, springs: Index, label: str, colour: str = DEFORMED) -> None:
    """Lines between points (n, 2) in m that springs (m, 2) join."""
    axis.add_collection(LineCollection(list(at[springs]), color=colour, lw=0.8, label=label))


def draw_particles(axis: Axes, at: Array) -> None:
    """Dots at points (n, 2) in m."""
    axis.plot(*at.T, "o", color=COLOURS[0], ms=3.2, label="particles")


def draw_outline(axis: Axes, ring: Array, label: str, **style: Any) -> None:
    """Closed line round a body through points (n, 2) in m; `style` as of ``Axes.plot``."""
    axis.plot(*np.vstack([ring, ring[:1]]).T, label=label, **style)


def draw_supports(axis: Axes, at: Array, held: Mask, size: float = 6.0) -> None:
    """Open markers at points (n, 2) in m whose components (n, 2) are held: squares where both are.

    A triangle points along the only component that is held. `size` of markers in points.
    """
    for (along_x, along_y), marker in HELD.items():
        here = (held == (along_x, along_y)).all(axis=1)
        if here.any():
            label = HOW[along_x, along_y]
            style: dict[str, Any] = {"color": "black", "ms": size, "mfc": "none", "mew": 1}
            axis.plot(*at[here].T, marker, label=label, zorder=3, **style)


def draw_loads(
    axis: Axes, at: Array, load: ArrayLike, length: float = 0.2, label: str = "load"
) -> None:
    """Arrows that end at points (n, 2), for forces (n, 2) in N; the longest is `length` m long.

    No force at all draws nothing.
    """
    load = np.asarray(load, dtype=float)
    size = np.linalg.norm(load, axis=1)
    on = size > 0
    if not on.any():
        return
    arrow = length * load[on] / size.max()
    to_scale: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "units": "xy", "scale": 1}
    width = ARROW_WIDTH * length
    axis.quiver(*at[on].T, *arrow.T, **to_scale, pivot="tip", width=width, zorder=3)
    axis.plot([], [], ls="", marker=r"$\rightarrow$", ms=11, color="black", label=label)


def draw_solid_load(axis: Any, at: Array, arrow: Array) -> None:
    """Arrow (3,) in m that starts at a point (3,) in m, on axes of `figures.solid_axes`."""
    upwards = [0, 2, 1]
    axis.quiver(*at[upwards], *arrow[upwards], color="black", lw=2, arrow_length_ratio=0.35)
