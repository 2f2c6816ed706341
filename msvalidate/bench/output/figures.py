"""Style of figures, without pyplot and without global plotting state."""

from __future__ import annotations

import contextlib
import math
import textwrap
from collections.abc import Iterator
from itertools import combinations, product
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.figure import Figure
from matplotlib.ticker import LogFormatter, LogLocator, MaxNLocator, NullLocator
from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00")
"""Told apart by colour-blind readers [OkabeIto2008]."""
FEW_DECADES = 2.5
WIDE_LABELS = 1e5
"""Numbers whose labels collide below an axis, where 50000 is followed by 100000."""
TITLE_SIZE, LETTERS_AN_INCH = 9, 14
"""Points of a title's letters, and how many of them an inch holds."""
NARROW = 2.1
"""Width (inches) of axes in which fewer labels have room."""
MARKERS = ("o", "s", "^", "D", "v", "P")
LOGARITHMIC = "log scale"
"""Said in the label of an axis that has one."""
LONG_LABEL = 22
"""Letters of a label's last line after which more goes on a line of its own."""
STYLE: dict[Any, Any] = {
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": 9,
    "figure.titlesize": 10,
    "figure.titleweight": "bold",
    "font.size": 9,
    "grid.color": "#dddddd",
    "grid.linewidth": 0.6,
    "legend.frameon": False,
    "lines.linewidth": 1.3,
    "lines.markersize": 4.5,
    "savefig.dpi": 160,
    "svg.fonttype": "none",
    "svg.hashsalt": "msvalidate",
}
"""Matplotlib settings of every figure."""


@contextlib.contextmanager
def figure_style() -> Iterator[None]:
    """Draw and save as `STYLE` says, whatever the user's own settings of the library are."""
    with mpl.rc_context():
        mpl.rcdefaults()
        mpl.rcParams.update(STYLE)
        yield


def new_figure(
    columns: int = 1, rows: int = 1, size: tuple[float, float] = (3.4, 3.0), **kwargs: Any
) -> tuple[Figure, list[Axes]]:
    """Figure and flat list of its axes, each of `size` inches; `kwargs` go to ``subplots``."""
    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **kwargs)
    return figure, list(axes.ravel())


def widen_third(figure: Figure, axes: list[Axes]) -> list[Axes]:
    """The first three of two by two axes, the third over the whole lower row."""
    *kept, unused = axes
    figure.delaxes(unused)
    grid: Any = kept[-1].get_gridspec()
    kept[-1].set_subplotspec(grid[1, :])
    return kept


def series_style(place: int) -> dict[str, Any]:
    """Colour and marker of a series by its number, the same in every figure."""
    return {"color": COLOURS[place % len(COLOURS)], "marker": MARKERS[place % len(MARKERS)]}


def draw_order(axis: Axes, numbers: ArrayLike, top: float, order: float) -> None:
    """A dotted line from `top` that falls with an order in the numbers along a logarithmic axis."""
    ends = np.array([np.min(numbers), np.max(numbers)])
    label = f"order {order:g}"
    axis.loglog(ends, top * (ends[0] / ends) ** order, ":", color="grey", label=label)


def tick_at(axis: Axes, numbers: ArrayLike) -> None:
    """Ticks along the axis at these numbers, each once, and nowhere else."""
    places = np.unique(numbers)
    axis.set_xticks(places, [str(place) for place in places])


def plain_logarithms(figure: Figure) -> None:
    """Label logarithmic axes 1e-6, and at 1, 2 and 5 where few decades show; no ticks between.

    Powers set as mathematics and a tick for every digit take a third of the time of a figure. Ticks
    and labels that a figure has chosen for itself stay. Labels of such axes say so.
    """
    for axes in figure.axes:
        for axis, (low, high) in ((axes.xaxis, axes.get_xlim()), (axes.yaxis, axes.get_ylim())):
            if axis.get_scale() != "log":
                continue
            name_logarithm(axis)
            if isinstance(axis.get_major_formatter(), LogFormatter):
                axis.set_major_formatter(
                    lambda value, _: f"{value:g}".replace("e+0", "e").replace("e-0", "e-")
                )
            if isinstance(axis.get_major_locator(), LogLocator):
                decades = abs(math.log10(high / low))
                wide = axis is axes.xaxis and max(high, low) >= WIDE_LABELS
                inches = axes.get_position().width * figure.get_figwidth()
                narrow = axis is axes.xaxis and inches < NARROW
                few = decades < (FEW_DECADES / 2 if narrow else FEW_DECADES)
                subs = ((1.0, 3.0) if wide or narrow else (1.0, 2.0, 5.0)) if few else (1.0,)
                axis.set_major_locator(LogLocator(subs=subs, numticks=12))
            axis.set_minor_locator(NullLocator())


def add_title(figure: Figure, text: str) -> None:
    """Add a title in lines as wide as the figure, unless it has one."""
    if not figure.get_suptitle() and not any(axes.get_title() for axes in figure.axes):
        wide = int(LETTERS_AN_INCH * figure.get_figwidth())
        figure.suptitle("\n".join(textwrap.wrap(text.rstrip("."), wide)), fontsize=TITLE_SIZE)


def name_logarithm(axis: Axis) -> None:
    """Add to the label of an axis, if it has one, that the axis is logarithmic."""
    label = axis.get_label_text()
    if label and LOGARITHMIC not in label:
        last = label.rpartition("\n")[2]
        gap = ",\n" if len(last) > LONG_LABEL else ", "
        axis.set_label_text(f"{label}{gap}{LOGARITHMIC}")


def add_shared_legend(figure: Figure, axes: list[Axes], columns: int = 4) -> None:
    """Add a legend below all axes, with each label once."""
    entries: dict[str, Any] = {}
    for axis in axes:
        for handle, label in zip(*axis.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    figure.legend(
        handles=list(entries.values()),
        labels=list(entries),
        loc="outside lower center",
        ncols=min(columns, len(entries)),
    )


def solid_axes(count: int, size: tuple[float, float], rows: int = 1) -> tuple[Figure, list[Any]]:
    """Figure and its axes in space, in rows, z upwards, each of `size` inches."""
    columns = -(-count // rows)
    figure = Figure(figsize=(size[0] * columns, size[1] * rows), layout="constrained")
    axes = [figure.add_subplot(rows, columns, i + 1, projection="3d") for i in range(count)]
    for axis in axes:
        axis.set_proj_type("ortho")
        axis.view_init(elev=22, azim=-58)
        axis.computed_zorder = False  # what is drawn later stands in front
        axis.set_xlabel("x (m)")
        axis.set_ylabel("y (m)")
        axis.set_zlabel("z (m)")
    return figure, axes


def draw_solid(axis: Any, points: Array, moved: Array, value: Array, norm: Any) -> Any:
    """Deformed surface of a box, its faces coloured by the mean of a value at their corners.

    True proportions; the undeformed box stands in grey lines in front. Points (n, 3) in m, those of
    a grid's surface (others do no harm), are drawn where they have moved; `norm` is matplotlib's
    ``Normalize`` of the values (n,). Returned is what a colour bar belongs to.
    """
    faces = box_faces(points)
    surface = Poly3DCollection(
        moved[faces], cmap="viridis", norm=norm, edgecolor="white", linewidth=0.25
    )
    surface.set_array(value[faces].mean(axis=1))
    low, high = points.min(axis=0), points.max(axis=0)
    corners = [np.array(corner) for corner in product(*zip(low, high, strict=True))]
    hidden = np.array([low[0], high[1], low[2]])  # the corner farthest from the viewer
    ends = [
        np.array([a, b])
        for a, b in combinations(corners, 2)
        if (a != b).sum() == 1 and (a != hidden).any() and (b != hidden).any()
    ]
    axis.add_collection3d(surface)
    axis.add_collection3d(Line3DCollection(ends, colors="#666666", linewidths=0.9))
    fit_solid_axes(axis, np.vstack([points, moved]))
    for scale in (axis.xaxis, axis.yaxis, axis.zaxis):
        scale.set_tick_params(labelsize=8, pad=0)
        scale.labelpad = 3
    return surface


def fit_solid_axes(axis: Any, points: Array, room: float = 0.0) -> Array:
    """True proportions, and few ticks, round points (n, 3) in m and `room` (m) on all sides.

    Returned are the lengths (3,) along the axes as drawn, over the longest.
    """
    low, high = points.min(axis=0) - room, points.max(axis=0) + room
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    axis.set_box_aspect(high - low, zoom=0.9)  # leaves room for labels
    parts = (high - low) / (high - low).max()
    for scale, part in zip((axis.xaxis, axis.yaxis, axis.zaxis), parts, strict=True):
        scale.set_major_locator(MaxNLocator(max(1, round(4 * part)), steps=[1, 2, 5, 10]))
    return np.asarray(parts)


def box_faces(points: Array) -> Index:
    """Corners (f, 4), in order round each, of all grid faces on the surface of a box of points."""
    faces = []
    for axis in range(3):
        across = [other for other in range(3) if other != axis]
        for end in (points[:, axis].min(), points[:, axis].max()):
            there = np.flatnonzero(np.isclose(points[:, axis], end))
            first, second = np.round(points[there][:, across], 9).T
            grid = there[np.lexsort([first, second])].reshape(len(np.unique(second)), -1)
            ring = (grid[:-1, :-1], grid[:-1, 1:], grid[1:, 1:], grid[1:, :-1])
            faces.append(np.column_stack([corner.ravel() for corner in ring]))
    return np.concatenate(faces)
