"""Sketches of the benchmarks' bodies, in m, from the numbers of their questions."""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes

from . import cantilever, cook, ellipse, hole, ring, three_point
from . import sketches as mark
from .shapes import INNER, OUTER, THICKNESS

MEGA = 1e6
TWICE = 2.0
"""How much larger the section of LE10 is drawn than its plan."""


def draw_cook(axis: Axes) -> None:
    """The panel, clamped on the left and pushed up on the right."""
    corners = np.array(cook.PANEL.vertices)
    (_, low), (right, bottom), (_, top), (_, high) = corners
    mark.outline(axis, corners)
    mark.clamp(axis, (0.0, low), (0.0, high), 4.0)
    at = np.linspace(bottom, top, 4)[1:]
    beside = np.column_stack([np.full(3, right + 2.0), at])
    mark.forces(axis, beside, (0.0, 0.28 * (top - bottom)))
    mark.note(axis, (right + 2.0, top), "F = 1 N upwards,\nspread evenly", (2, 4))
    mark.ask(axis, tuple(cook.PROBE[0]), "uy here", (-8, 0))
    mark.dimension(axis, (0.0, low), (right, low), f"{right:g} m", (0.0, -6.0))
    mark.dimension(axis, (0.0, low), (0.0, high), f"{high:g} m", (-9.0, 0.0))
    mark.dimension(axis, (right, bottom), (right, top), f"{cook.EDGE:g} m", (10.0, 0.0))
    mark.frame(axis, (-16.0, -9.0), (78.0, 70.0))


def draw_cantilever(axis: Axes) -> None:
    """The beam, its left end given the exact displacement, its right end the exact shear."""
    length, depth = cantilever.LENGTH, cantilever.DEPTH
    mark.outline(axis, [(0, 0), (length, 0), (length, depth), (0, depth)])
    mark.clamp(axis, (0.0, 0.0), (0.0, depth), 2.0)
    height = np.linspace(0.0, depth, 41)
    parabola = np.column_stack([length + 4 * (1 - (2 * height / depth - 1) ** 2), height])
    axis.plot(*parabola.T, color=mark.LOAD, lw=1.2)
    mark.forces(axis, [(length + 2.0, 0.2 * depth)], (0.0, -0.6 * depth))
    mark.note(axis, (length, depth), f"P = {cantilever.LOAD:g} N,\na parabola", (-6, 4))
    mark.note(axis, (0.0, depth), "exact displacement", (0, 8), mark.EDGE)
    mark.ask(axis, cantilever.END, "deflection here", (-8, 0))
    mark.dimension(axis, (0.0, 0.0), (length, 0.0), f"{length:g} m", (0.0, -4.5))
    mark.dimension(axis, (0.0, 0.0), (0.0, depth), f"{depth:g} m", (-5.0, 0.0))
    mark.frame(axis, (-7.0, -5.5), (length + 6.0, depth + 6.0))


def draw_three_point(axis: Axes) -> None:
    """Both beams, one above the other."""
    for kind, level in zip(three_point.KINDS, (3.4, 0.0), strict=True):
        _draw_beam(axis, kind, level)
    length, height = three_point.LENGTH, three_point.HEIGHT
    mark.dimension(axis, (0.0, 0.0), (length, 0.0), f"{length:g} m", (0.0, -0.8))
    mark.dimension(axis, (length, 0.0), (length, height), f"{height:g} m", (0.9, 0.0))
    mark.frame(axis, (-1.0, -1.1), (length + 1.4, 5.3))


def _draw_beam(axis: Axes, kind: str, level: float) -> None:
    length, height = three_point.LENGTH, three_point.HEIGHT
    top, middle = level + height, length / 2
    mark.outline(axis, [(0, level), (length, level), (length, top), (0, top)])
    over = middle + three_point.LOADED * np.linspace(-0.5, 0.5, 5)
    mark.forces(axis, np.column_stack([over, 0 * over + top]), (0.0, -0.7))
    words = f"P = {three_point.LOAD:g} N over {three_point.LOADED:g} m"
    mark.note(axis, (middle + three_point.LOADED / 2, top + 0.4), words, (6, 0))
    mark.note(axis, (0.0, top + 0.4), kind, (1, 0), "black")
    mark.ask(axis, (middle, level + height / 2), "deflection here", (8, 0))
    if kind == "clamped":
        mark.clamp(axis, (0.0, level), (0.0, top), 0.5)
        mark.clamp(axis, (length, top), (length, level), 0.5)
        return
    shear = np.column_stack([np.repeat([-0.25, length + 0.25], 2), level + np.array([0.5, 1] * 2)])
    mark.forces(axis, shear, (0.0, 0.45))
    for end, side in ((0.0, -1), (length, 1)):
        mark.note(axis, (end, level), "P/2 spread", (4 * side, -3))


def draw_membrane(axis: Axes) -> None:
    """Quarter of the elliptic membrane of LE1, pulled on its rim."""
    _draw_ellipses(axis)
    ellipse.mark_loads(axis)
    mark.note(axis, (2.5, 2.4), f"{ellipse.PRESSURE / MEGA:g} MPa outwards", (4, 4))
    mark.ask(axis, (INNER[0], 0.0), "σyy here", (-8, 8))
    mark.frame(axis, (-1.2, -0.9), (4.0, 3.2))


def draw_plate(axis: Axes) -> None:
    """Quarter of the thick plate of LE10 from above, and cut along x."""
    _draw_ellipses(axis)
    axis.plot(*mark.arc(OUTER).T, color=mark.EDGE, lw=3, zorder=3)
    mark.note(axis, (2.45, 2.0), "rim: ux = uy = 0,\nuz = 0 on its middle line", (8, 8), mark.EDGE)
    mark.note(axis, (0.0, OUTER[1]), "from above", (2, 8), mark.SIZE)
    mark.ask(axis, (INNER[0], 0.0), "", (0, 0))
    left, low = 5.0, 0.2
    right, top = left + TWICE * (OUTER[0] - INNER[0]), low + TWICE * THICKNESS
    mark.outline(axis, [(left, low), (right, low), (right, top), (left, top)])
    at = np.linspace(left, right, 7)[1:]
    mark.forces(axis, np.column_stack([at, 0 * at + top]), (0.0, -0.4))
    mark.note(axis, (0.5 * (left + right), top + 0.4), "1 MPa", (0, 3))
    mark.note(
        axis, (0.5 * (left + right), low), "cut along x, z up, twice as large", (0, -8), mark.SIZE
    )
    mark.pin(axis, (right, 0.5 * (low + top)), 0.3)
    mark.ask(axis, (left, top), "σyy here", (-2, 10))
    mark.dimension(axis, (left, low), (left, top), f"{THICKNESS:g} m", (-0.5, 0.0))
    mark.frame(axis, (-1.2, -0.8), (right + 0.3, OUTER[1] + 0.45))


def _draw_ellipses(axis: Axes) -> None:
    """Outline, mirrors and dimensions that LE1 and LE10 share."""
    mark.outline(axis, mark.quarter(INNER, OUTER))
    mark.mirrors(axis, INNER, OUTER)
    mark.dimension(axis, (0.0, 0.0), (INNER[0], 0.0), f"{INNER[0]:g} m", (0.0, -0.35))
    mark.dimension(axis, (0.0, 0.0), (OUTER[0], 0.0), f"{OUTER[0]:g} m", (0.0, -0.72))
    mark.dimension(axis, (0.0, 0.0), (0.0, INNER[1]), f"{INNER[1]:g} m", (-0.4, 0.0))
    mark.dimension(axis, (0.0, 0.0), (0.0, OUTER[1]), f"{OUTER[1]:g} m", (-0.95, 0.0))


def draw_hole(axis: Axes) -> None:
    """Quarter of the piece of the endless plate, with the plate's tractions on its rim."""
    radius, rim = hole.RADIUS, hole.RIM
    mark.outline(axis, mark.quarter((radius, radius), (rim, rim)))
    _measure(axis, radius, rim)
    hole.mark_loads(axis)
    mark.note(axis, (2.8, 3.4), "tractions of the endless\nplate, 1 Pa along y\nfar away", (14, 6))
    mark.ask(axis, (radius, 0.0), "σyy here", (3, 9))
    mark.ask(axis, (0.0, radius), "σxx here", (9, 3))
    mark.frame(axis, (-0.6, -1.1), (5.6, 4.8))


def draw_ring(axis: Axes) -> None:
    """Quarter of the ring under pressure on its inside."""
    mark.outline(axis, mark.quarter((ring.INSIDE,) * 2, (ring.OUTSIDE,) * 2))
    _measure(axis, ring.INSIDE, ring.OUTSIDE)
    ring.mark_loads(axis)
    mark.note(axis, (0.0, 0.0), f"p = {ring.PRESSURE / 1e3:g} kPa", (4, 3))
    mark.ask(axis, (ring.INSIDE, 0.0), "ur, σθθ", (7, 8))
    mark.frame(axis, (-0.4, -0.6), (2.4, 2.1))


def _measure(axis: Axes, inside: float, outside: float) -> None:
    """Mirrors and dimensions of a quarter between two circles."""
    mark.mirrors(axis, (inside, inside), (outside, outside))
    mark.dimension(axis, (0.0, 0.0), (inside, 0.0), f"{inside:g} m", (0.0, -0.11 * outside))
    mark.dimension(axis, (0.0, 0.0), (outside, 0.0), f"{outside:g} m", (0.0, -0.22 * outside))
