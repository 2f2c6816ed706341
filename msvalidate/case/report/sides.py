"""Picture of a mesh with the names of its sides, from which those of supports and loads follow."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from scipy.spatial import KDTree

from msvalidate.bench.output.body_drawing import body_axes
from msvalidate.bench.output.figures import COLOURS, UPWARDS, fit_solid_axes, solid_axes
from msvalidate.case.report.figures import (
    FRONT,
    draw_surface,
    flat_facets,
    hidden,
    name_solid_axes,
    show_in_units,
    unit_normals,
    view_directions,
)
from msvalidate.problem import Array, Mesh
from msvalidate.problem.shapes import facet_middles

VIEWS = ((24, -58), (-24, 122))
"""Elevation and azimuth (degrees) of two opposite views, which show all sides of a convex body."""
AT_ONCE = 40
"""Facets whose visibility is tested at once."""
UNNAMED = "#dddddd"
LABEL: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "fontsize": 8,
    "zorder": 9,
    "parse_math": False,
    "bbox": {"boxstyle": "round,pad=0.15", "fc": "white", "ec": "black", "lw": 0.5},
}


def draw_sides(mesh: Mesh, length: str) -> Figure:
    """Draw the sides of a mesh in colours with their names, "face 10" as 10, seen from two sides.

    A name in brackets is that of a side that no view shows. Lengths are in a unit of `LENGTH`.
    """
    figure = _plane(mesh) if mesh.dim == 2 else _solid(mesh)
    show_in_units(figure, length)
    return figure


def _colour(number: int) -> str:
    return COLOURS[number % len(COLOURS)]


def _plane(mesh: Mesh) -> Figure:
    figure, axis = body_axes(mesh.points, 0.06 * float(np.ptp(mesh.points, axis=0).max()))
    sides = {"": mesh.surface, **mesh.boundaries}
    for number, (name, facets) in enumerate(sides.items(), -1):
        places = mesh.points[facets[:, [0, 2, 1]] if facets.shape[1] == 3 else facets]
        colour, width = (_colour(number), 2.5) if name else (UNNAMED, 1.0)
        axis.add_collection(LineCollection(list(places), colors=colour, linewidths=width))
        if name:
            middles = facet_middles(mesh.points[facets])
            off = np.linalg.norm(middles - middles.mean(axis=0), axis=1)
            axis.text(*middles[off.argmin()], name.removeprefix("edge "), **LABEL)
    return figure


def _solid(mesh: Mesh) -> Figure:
    x, surface = mesh.points, flat_facets(mesh.surface)
    rows = {tuple(sorted(row)): i for i, row in enumerate(surface.tolist())}
    colours, own = [UNNAMED] * len(surface), dict[str, list[int]]()
    for number, (name, facets) in enumerate(mesh.boundaries.items()):
        own[name] = [rows[tuple(sorted(each))] for each in flat_facets(facets).tolist()]
        for row in own[name]:
            colours[row] = _colour(number)
    figure, axes = solid_axes(len(VIEWS), (4.8, 4.6))
    towards = [view_directions(*view) for view in VIEWS]
    for axis, (elevation, azimuth) in zip(axes, VIEWS, strict=True):
        fit_solid_axes(axis, x[:, UPWARDS])
        name_solid_axes(axis)
        axis.view_init(elev=elevation, azim=azimuth)
        draw_surface(axis, x[surface], colours)
    for name, numbers in own.items():
        places, text = x[surface[numbers]], name.removeprefix("face ")
        others = np.delete(surface, numbers, axis=0)
        rim = x[np.intersect1d(surface[numbers], others)]
        seen = [_label_place(places, rim, x[surface], view) for view in towards]
        view = int(np.argmax([score for score, _ in seen]))
        score, at = seen[view]
        axes[view].text(*at, text if score > 0 else f"({text})", **LABEL)
    return figure


def _label_place(places: Array, rim: Array, surface: Array, view: Array) -> tuple[float, Array]:
    """Score and place (3,) of a label on facets (f, k, 3) in a view of a surface (s, k, 3) in m.

    The place is the visible facet farthest from the nodes (r, 3) of other sides. The score is the
    cosine between its normal and the viewer, 0 if no facet is visible.
    """
    middles, facing = places.mean(axis=1), unit_normals(places) @ view[2]
    off = KDTree(rim).query(middles)[0] if len(rim) else facing
    front = np.flatnonzero(facing > FRONT)
    front = front[np.argsort(-off[front], kind="stable")]
    for start in range(0, len(front), AT_ONCE):
        near = front[start : start + AT_ONCE]
        seen = near[~hidden(middles[near], surface, view)]
        if len(seen):
            return float(facing[seen[0]]), middles[seen[0]]
    return 0.0, middles[(middles @ view[2]).argmax()]
