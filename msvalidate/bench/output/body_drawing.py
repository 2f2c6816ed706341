"""Bodies in figures: springs, outlines, supports and loads, drawn alike in every study."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import cycle
from typing import Any, NamedTuple

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from mpl_toolkits.mplot3d.art3d import Line3DCollection
from numpy.typing import ArrayLike

from msvalidate.bench.output.figures import (
    COLOURS,
    add_shared_legend,
    figure_style,
    fit_solid_axes,
    new_figure,
    solid_axes,
)
from msvalidate.problem import Array, Index, Mask
from msvalidate.problem.checks import finite_coordinates, positive_number
from msvalidate.springs.network import Network

AT_REST = "#8c8c8c"
SHOWN = 0.1
"""Size of the largest displacement as drawn, relative to the body."""
ARROW = 0.12
"""Length of the longest load arrow, relative to the body."""
MOST_ARROWS = 12
"""Arrows of all loads in a picture."""
FLAT = 0.3
"""Relative thickness below which a body is seen from its flattest side."""
FLATTEST = ({"elev": 20, "azim": -20}, {"elev": 20, "azim": -75}, {"elev": 60, "azim": -60})
"""Axis along which a body is shortest, as drawn -> angles (degrees) that it is seen from."""
WIDE, TALLEST = 6.2, 6.0
DEFORMED = "#3d8fc2"
ARROW_WIDTH = 0.08
"""Width of an arrow's shaft, relative to the longest arrow."""
FIXED = {
    (True, True): ("s", "held"),
    (True, False): (">", "held along x"),
    (False, True): ("^", "held along y"),
}
"""Marker and legend of a support by what it holds: along x, along y."""
BOUNDARY_RULES = {
    "shared": "boundary springs weakened",
    "equal": "all springs alike",
    "per_cell": "each cell its own springs",
}
"""Names in figures of `springs.lattice.filled.WEIGHTS`."""


class Drawing(NamedTuple):
    """Lines of a body, with their motion, supports and loads.

    Parameters
    ----------
    label
        Name in the legend.
    points, lines
        Reference positions (n, d) in m, and pairs (m, 2) of points that a line joins.
    displacement
        Displacement (n, d) in m; None if there is none to draw.
    fixed, force
        Mask (n, d) of fixed components, and external forces (n, d) in N.
    """

    label: str
    points: Array
    lines: Index
    displacement: Array | None
    fixed: Mask
    force: Array

    @property
    def size(self) -> float:
        """Largest extent (m) along an axis."""
        return float(np.ptp(self.points, axis=0).max()) or 1.0


def network_drawing(network: Network, displacement: Any = None) -> Drawing:
    """Return the drawing of a network, deformed by a displacement (n, d) in m if there is one.

    Raises `ProblemError` if the displacement does not fit the network.
    """
    if displacement is not None:
        displacement = finite_coordinates("displacement", displacement, *network.points.shape)
    lines = network.points, network.springs
    return Drawing("springs", *lines, displacement, network.fixed, network.force)


def overlay_drawings(drawings: Sequence[Drawing], magnification: float | None = None) -> Figure:
    """Draw bodies in their reference and deformed positions in one pair of axes.

    Supports and loads are those of the first. The default magnification is 1, 2 or 5 times a power
    of ten, so that the largest displacement appears as at most a tenth of the body; 1 if it is
    between a tenth of the body and all of it.

    Raises `ProblemError` if the magnification is not positive.
    """
    first = drawings[0]
    moved = any(each.displacement is not None for each in drawings)
    times = common_magnification(drawings) if magnification is None else magnification
    positive_number("magnification", times)
    places = [_moved(each, times) for each in drawings]
    title = "reference positions"
    if moved:
        most = _largest_displacement(drawings)
        title = f"displacements magnified {times:g} times, the largest is {most:.3g} m"
    on = loaded_points(first.force)
    with figure_style():
        room = 1.3 * ARROW * first.size
        figure, axis = body_axes(np.concatenate([first.points, *places]), room)
        if moved:
            draw_springs(axis, first.points, first.lines, "undeformed", AT_REST)
        for each, at, colour in zip(drawings, places, cycle(COLOURS)):
            draw_springs(axis, at, each.lines, each.label, colour)
        arrows = places[0][on], first.force[on], ARROW * first.size
        draw_supports_and_loads(axis, places[0], first.fixed, *arrows)
        axis.set_title(title, loc="left")
        add_shared_legend(figure, [axis])
    return figure


def _moved(drawing: Drawing, magnification: float) -> Array:
    """Positions (n, d) in m as drawn."""
    if drawing.displacement is None:
        return drawing.points
    return drawing.points + magnification * drawing.displacement


def common_magnification(drawings: Sequence[Drawing]) -> float:
    """Return the magnification at which all of some bodies are drawn."""
    return _magnification(SHOWN * drawings[0].size, _largest_displacement(drawings))


def _largest_displacement(drawings: Sequence[Drawing]) -> float:
    """Largest displacement (m) of some bodies."""
    moved = [u for each in drawings if (u := each.displacement) is not None]
    return max((float(np.linalg.norm(u, axis=1).max()) for u in moved), default=0.0)


def _magnification(shown: float, most: float) -> float:
    """A round number that shows a displacement (m) as one of `shown` (m), or less."""
    if most == 0 or shown <= most <= shown / SHOWN:
        return 1.0
    decade = 10.0 ** math.floor(math.log10(shown / most))
    return max(step * decade for step in (1, 2, 5) if step * decade <= shown / most)


def body_axes(points: Array, room: float = 0.0) -> tuple[Figure, Any]:
    """Figure and axes for a body with points (n, d) in m, in true proportions where they can be."""
    if points.shape[1] == 3:
        figure, axes = solid_axes(1, (6.6, 5.4))  # wide: a phone lets it scroll
        parts = fit_solid_axes(axes[0], points, room)
        if parts.min() < FLAT:
            axes[0].view_init(**FLATTEST[int(parts.argmin())])
        return figure, axes[0]
    size = np.ptp(points, axis=0) + 2 * room
    height = float(np.clip(WIDE * size[1] / size[0], 1.6, TALLEST))
    figure, (axis,) = new_figure(size=(WIDE, height + 0.9))
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xlabel="x (m)", ylabel="y (m)")
    if max(size) < 12 * min(size):
        axis.set_aspect("equal", adjustable="box")
    return figure, axis


def loaded_points(force: Array) -> Index:
    """Numbers of points with a force (n, d) in N, evenly spread, at most `MOST_ARROWS`."""
    (on,) = np.nonzero(np.linalg.norm(force, axis=1) > 1e-12 * np.abs(force).max(initial=0.0))
    return on[:: max(1, -(-len(on) // MOST_ARROWS))]


def draw_supports_and_loads(
    axis: Any, points: Array, fixed: Mask, at: Array, force: Array, length: float
) -> None:
    """Supports of points (n, d) and forces (k, d) in N at places (k, d), on axes of `body_axes`.

    The longest arrow is `length` m long.
    """
    if points.shape[1] == 2:
        draw_supports(axis, points, fixed, 4.0)
        draw_loads(axis, at, force, length)
        return
    style: dict[str, Any] = {"ms": 2.5, "mfc": "none", "color": "black", "label": "held"}
    axis.plot(*points[fixed.any(axis=1)].T, "s", **style)
    if len(at):
        arrow = length * force / np.linalg.norm(force, axis=1).max()
        start, along = (at - arrow).T, arrow.T
        axis.quiver(*start, *along, color=COLOURS[1], lw=1.2, label="load")


def draw_springs(axis: Any, at: Array, springs: Index, label: str, colour: str = DEFORMED) -> Any:
    """Draw springs (m, 2) between points (n, d) in m, and return the lines.

    They are finer where they are many.
    """
    dim = at.shape[1]
    width = min(0.8, 30 / len(at) ** (1 - 1 / dim))  # about in proportion to gaps between lines
    style: dict[str, Any] = {"color": colour, "lw": width, "label": label}
    if dim == 2:
        return axis.add_collection(LineCollection(list(at[springs]), **style))
    return axis.add_collection3d(Line3DCollection(at[springs], **style))


def draw_particles(axis: Axes, at: Array) -> None:
    """Dots at points (n, 2) in m."""
    axis.plot(*at.T, "o", color=COLOURS[0], ms=3.2, label="particles")


def draw_outline(axis: Axes, ring: Array, label: str, **style: Any) -> None:
    """Closed line round a body through points (n, 2) in m; `style` as of ``Axes.plot``."""
    axis.plot(*np.vstack([ring, ring[:1]]).T, label=label, **style)


def draw_supports(axis: Axes, at: Array, fixed: Mask, size: float = 6.0) -> None:
    """Open markers at points (n, 2) in m whose components (n, 2) are held: squares where both are.

    A triangle points along the only component that is held. `size` of markers in points.
    """
    for components, (marker, label) in FIXED.items():
        here = (fixed == components).all(axis=1)
        if here.any():
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
    axis.quiver(*at, *arrow, color="black", lw=2, arrow_length_ratio=0.35)
