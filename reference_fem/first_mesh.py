"""The mesh that `converge` starts from: coarse quadratic cells whose sides end where loads do."""

from __future__ import annotations

from itertools import pairwise
from math import prod

import numpy as np

from msvalidate.problem import Array, Box, Polygon, Problem, Region, Segment
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS
from reference_fem.mesh.from_mesh import mesh_discretisation, with_middles
from reference_fem.mesh.outlines import outline_discretisation

MOST_NODES = {2: 150_000, 3: 60_000}
"""Nodes by the number of axes: of the finest mesh in the plane, by default, some 5 s; in space, of
one that is solved by itself where multigrid over all gives up, of a third that is solved though two
are enough, and of the second of plates, whose cells are made longer than thick where it had more.
"""
MOST_MIXED = 12_000
"""The same of mixed elements in space, whose factor fills up: 30,000 nodes take minutes. And of the
second mesh of plates, whose thin cells take a factor too."""
ACROSS = 3
"""Cells of the first mesh across the narrowest side of a box or an outline."""
MOST_ALONG = 200
"""Cells of the first mesh along any side: those of slender bodies are longer than wide."""


def first_mesh(problem: Problem) -> Discretisation:
    """The coarsest mesh of a problem's domain: quadratic cells whose sides end where loads do."""
    domain = problem.domain
    if isinstance(domain, Polygon):
        sides = [high - low for low, high in domain.span]
        h = max(min(sides) / ACROSS, max(sides) / MOST_ALONG)
        linear = outline_discretisation(domain, h, kept_places(problem))
        return make_discretisation(*with_middles(linear.points, linear.cells, ELEMENTS["P2"]), "P2")
    if isinstance(domain, Box):
        h = max(min(domain.size) / ACROSS, max(domain.size) / MOST_ALONG)
        lines = grid_lines(problem, h)
        if _nodes_of_second(lines) > MOST_NODES[domain.dim]:  # of a plate: no error were known
            while _nodes_of_second(lines) > MOST_MIXED and h < max(domain.size):
                h *= 1.25
                lines = grid_lines(problem, h)
        return lines_discretisation(lines, "Q2" if domain.dim == 2 else "H2")
    own = mesh_discretisation(domain)
    if own.element.degree > 1:
        return own
    return mesh_discretisation(domain, own.element.raised[0])


def kept_places(problem: Problem) -> Array:
    """Places (k, d) in m that must be nodes: ends of parts and zones, point forces."""
    span = problem.domain.span
    parts = [
        *problem.supports,
        *problem.contacts,
        *(load for load in problem.loads if hasattr(load, "region")),
    ]
    found = [
        part.region.corners(span) for part in parts if isinstance(part.region, Region | Segment)
    ]
    found += [
        zone.region.corners(span) for zone in problem.zones if isinstance(zone.region, Region)
    ]
    return np.concatenate(found) if found else np.empty((0, len(span)))


def grid_lines(problem: Problem, h: float, least: int = 2) -> list[Array]:
    """Coordinates (m) of lines along each axis, about h apart, through where parts of sides end.

    Where none ends, an axis has the `least` number of cells or more.
    """
    domain = problem.domain
    found = []
    for x, (low, high) in zip(kept_places(problem).T, domain.span, strict=True):
        stops = np.unique(np.concatenate([x[(x > low) & (x < high)], [low, high]]))
        apart = np.concatenate([[True], np.diff(stops) > domain.tolerance])
        stops = np.append(stops[apart][:-1], high) if apart.sum() > 1 else np.array([low, high])
        parts = []
        for a, b in pairwise(stops):
            many = max(least if len(stops) == 2 else 1, round((b - a) / h))
            parts.append(a + (b - a) * np.arange(many) / many)
        found.append(np.append(np.concatenate(parts), high))
    return found


def _nodes_of_second(lines: list[Array]) -> int:
    """About how many nodes the second mesh between lines along each axis has."""
    return prod(4 * len(line) - 2 for line in lines)
