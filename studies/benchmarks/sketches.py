"""Marks of sketches of bodies: outlines, supports, loads, dimensions and the place asked about.

Places are (n, 2) in m.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from msvalidate import kit

BODY, EDGE = "#e8eef3", "#333333"
LOAD, SIZE = kit.figures.COLOURS[1], "#555555"
"""Colours of loads and of dimensions."""
WORDS = 8
"""Points high."""
Place = tuple[float, float]


def outline(axis: Axes, points: ArrayLike) -> None:
    """A filled body."""
    axis.fill(*np.asarray(points).T, facecolor=BODY, edgecolor=EDGE, lw=1.3, zorder=2)


def arc(half_axes: Place, ends: Place = (0.0, 90.0), count: int = 61) -> kit.Array:
    """Points (count, 2) of an ellipse about the origin between two angles in degrees."""
    angle = np.radians(np.linspace(*ends, count))
    return np.column_stack([half_axes[0] * np.cos(angle), half_axes[1] * np.sin(angle)])


def quarter(inner: Place, outer: Place) -> kit.Array:
    """Outline of a quarter between two ellipses."""
    return np.concatenate([arc(outer), arc(inner)[::-1]])


def clamp(axis: Axes, start: Place, end: Place, size: float) -> None:
    """Hatching on the left of the way from start to end: nothing moves there."""
    first, last = np.array(start), np.array(end)
    length = float(np.linalg.norm(last - first))
    along = (last - first) / length
    out = np.array([-along[1], along[0]])
    axis.plot(*np.array([first, last]).T, color=EDGE, lw=2.2, zorder=4, solid_capstyle="butt")
    for at in np.linspace(0, length, max(4, round(2 * length / size)) + 1)[1:]:
        ends = first + at * along, first + at * along + 0.6 * size * (out - along)
        axis.plot(*np.array(ends).T, color=EDGE, lw=0.8, zorder=1)


def rollers(axis: Axes, start: Place, end: Place, size: float, count: int = 4) -> None:
    """Rollers on the left of the way from start to end, which is free to slide along itself."""
    first, last = np.array(start), np.array(end)
    along = (last - first) / np.linalg.norm(last - first)
    out = np.array([-along[1], along[0]])
    centres = first + np.linspace(0.08, 0.92, count)[:, None] * (last - first) + 0.25 * size * out
    for centre in centres:
        ring = centre + 0.25 * size * arc((1.0, 1.0), (0.0, 360.0), 25)
        axis.fill(*ring.T, facecolor="white", edgecolor=EDGE, lw=0.9, zorder=3)
    wall = np.array([first, last]) + 0.5 * size * out
    axis.plot(*wall.T, color=EDGE, lw=1.1, zorder=3)


def mirrors(axis: Axes, inner: Place, outer: Place) -> None:
    """Rollers of a quarter between two ellipses on both of its straight sides."""
    size = 0.075 * outer[0]
    rollers(axis, (outer[0], 0.0), (inner[0], 0.0), size)
    rollers(axis, (0.0, inner[1]), (0.0, outer[1]), size)


def pin(axis: Axes, at: Place, size: float) -> None:
    """A support below a point that cannot move."""
    corners = np.array(at) + size * np.array([(0, 0), (-0.5, -0.85), (0.5, -0.85)])
    axis.fill(*corners.T, facecolor="white", edgecolor=EDGE, lw=1.0, zorder=4)


def forces(axis: Axes, at: ArrayLike, force: ArrayLike, *, pull: bool = False) -> None:
    """Arrows (n, 2), as long as given in m, that end at places, or start there if they pull."""
    to_scale: dict[str, Any] = {"angles": "xy", "scale_units": "xy", "scale": 1}
    at, force = np.atleast_2d(np.asarray(at, float)), np.atleast_2d(np.asarray(force, float))
    force = np.broadcast_to(force, at.shape)
    axis.quiver(
        *at.T, *force.T, **to_scale, pivot="tail" if pull else "tip", color=LOAD,
        units="inches", width=0.02, headwidth=4.5, zorder=5,
    )  # fmt: skip


def dimension(axis: Axes, start: Place, end: Place, words: str, off: Place = (0.0, 0.0)) -> None:
    """A dimension line from start to end, moved by `off` (m), with its extension lines."""
    ends = np.array([start, end], dtype=float)
    moved = ends + np.array(off)
    if any(off):
        for one, other in zip(ends, moved, strict=True):
            beyond = other + 0.12 * np.array(off)
            axis.plot(*np.array([one, beyond]).T, color=SIZE, lw=0.5, zorder=1)
    arrow = {"arrowstyle": "<->", "color": SIZE, "lw": 0.8, "shrinkA": 0, "shrinkB": 0}
    axis.annotate("", moved[0], moved[1], arrowprops=arrow, zorder=5)
    place = moved.mean(axis=0)
    background = {"facecolor": "white", "edgecolor": "none", "pad": 1.0}
    axis.text(
        place[0], place[1], words, ha="center", va="center", fontsize=WORDS, color=SIZE,
        bbox=background, zorder=6,
    )  # fmt: skip


def ask(axis: Axes, at: Place, words: str, shift: Place) -> None:
    """The place whose answer is asked for; its words moved by so many points."""
    axis.plot(*at, "o", color="black", mfc="white", ms=6, mew=1.4, zorder=7)
    note(axis, at, words, shift, colour="black")


def note(axis: Axes, at: Place, words: str, shift: Place, colour: str = LOAD) -> None:
    """Words beside a place, moved by so many points and aligned away from it."""
    across = "left" if shift[0] > 0 else "right" if shift[0] < 0 else "center"
    up = "bottom" if shift[1] > 0 else "top" if shift[1] < 0 else "center"
    axis.annotate(
        words, at, shift, textcoords="offset points", ha=across, va=up, fontsize=WORDS,
        color=colour, zorder=8,
    )  # fmt: skip


def frame(axis: Axes, low: Place, high: Place, up: str = "y") -> None:
    """Limits in m of a sketch in true proportions; dimensions replace ticks."""
    axis.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), xticks=[], yticks=[], aspect="equal")
    axis.set_xlabel("x →", fontsize=WORDS, color=SIZE, loc="left", labelpad=0)
    axis.set_ylabel(f"{up} →", fontsize=WORDS, color=SIZE, loc="bottom", labelpad=0)
    axis.grid(visible=False)
    axis.spines[:].set_visible(False)
