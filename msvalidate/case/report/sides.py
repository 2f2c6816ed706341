"""Picture of a mesh with the names of its sides."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.figure import Figure
from scipy.spatial import KDTree

from msvalidate.bench.output.figures import COLOURS, fit_solid_axes, solid_axes
from msvalidate.case.report.figures import show_in_units
from msvalidate.case.report.outlines import draw_surface, flat_facets, hidden
from msvalidate.problem import Mesh

VIEWS = ((24, -58), (-24, 122))
"""Elevation and azimuth (degrees) of two opposite views.

They show all sides of a convex body."""
CANDIDATES = 100
"""Facets of a side of which one gets the label."""
UNNAMED = "#dddddd"
LABEL: dict[str, Any] = {
    "ha": "center",
    "va": "center",
    "fontsize": 8,
    "zorder": 9,
    "parse_math": False,
    "bbox": {"boxstyle": "round,pad=0.15", "fc": "white", "lw": 0.5},
}


def draw_sides(mesh: Mesh, length: str) -> Figure:
    """Draw the named sides of a 3D mesh in two views.

    Of "face 10" the label is 10. A label is on the visible facet farthest from other sides; that
    of a side that no view shows is in brackets. Lengths are in a unit of `LENGTH`.
    """
    x, surface = mesh.points, flat_facets(mesh.surface)
    rows = {frozenset(row): i for i, row in enumerate(surface.tolist())}
    colours, own = np.full(len(surface), UNNAMED), dict[str, list[int]]()
    for number, (name, facets) in enumerate(mesh.boundaries.items()):
        own[name] = [rows[frozenset(row)] for row in flat_facets(facets).tolist()]
        colours[own[name]] = COLOURS[number % len(COLOURS)]
    figure, axes = solid_axes(len(VIEWS), (4.8, 4.6))
    for axis, (elevation, azimuth) in zip(axes, VIEWS, strict=True):
        fit_solid_axes(axis, x)
        axis.view_init(elev=elevation, azim=azimuth)
        draw_surface(axis, x[surface], colours.tolist())
    for name, numbers in own.items():
        label = name.removeprefix("face ")
        others = x[np.delete(surface, numbers, axis=0)].reshape(-1, 3)
        middles = x[surface[numbers]].mean(axis=1)
        off = KDTree(others).query(middles)[0] if len(others) else middles[:, 2]
        best = middles[np.argsort(-off, kind="stable")[:: 1 + len(off) // CANDIDATES]]
        views = [(axis, best[~hidden(axis, best, x[surface])]) for axis in axes]
        axis, places = max(views, key=lambda view: len(view[1]))
        places, label = (places, label) if len(places) else (best, f"({label})")
        axis.text(*places[0], label, **LABEL)
    show_in_units(figure, length)
    return figure
