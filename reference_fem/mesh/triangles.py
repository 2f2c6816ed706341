"""Meshes of outlines: equilateral triangles, refined towards places of singular stress."""

from __future__ import annotations

from typing import Any

import numpy as np
import skfem
from numpy.typing import ArrayLike
from scipy.spatial import Delaunay, KDTree

from msvalidate.problem import Array, Polygon, ProblemError, Segment, format_point
from msvalidate.problem.checks import (
    finite_coordinates,
    format_value,
    length_in_metres,
    refuse_too_many,
    whole_number,
)
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import ELEMENTS, MOST_IN_PLANE, of_dimension
from reference_fem.mesh.from_mesh import with_middles

NODES_PER_TRIANGLE = 2
"""Corners and mid-sides of a large mesh of triangles for each triangle, at most."""


def polygon_discretisation(
    outline: Polygon,
    spacing: float,
    element: str = "P2",
    *,
    towards: ArrayLike | None = None,
    depth: int = 0,
    rings: int = 1,
) -> Discretisation:
    """Mesh of an outline that is a union of equilateral triangles, refined towards given places.

    Parameters
    ----------
    outline
        Its first vertex and first edge place the triangles.
    spacing
        Side (m) of the triangles to start from.
    element
        "P1" or "P2".
    towards
        (p, 2) places (m), vertices of the mesh to start from, where the stress is singular. A body
        may have none; `depth` then does nothing.
    depth
        How often triangles around them are halved, each time half as far away.
    rings
        How many triangles deep, around a place, each halving reaches.

    Raises
    ------
    ProblemError
        If an argument is out of range, triangles of this side don't make up the outline or are too
        many, a place is no vertex, or there is a depth and no place.
    """
    triangles = [name for name in of_dimension(2) if ELEMENTS[name].simplex]
    triangular = isinstance(element, str) and element in triangles
    if not isinstance(outline, Polygon) or not triangular:
        name, choice = format_value(element).strip("'"), " or ".join(triangles)
        raise ProblemError(
            f"mesh: {name} in a {format_value(outline)}; give a Polygon and {choice}"
        )
    whole_number("mesh depth", depth, 0)
    whole_number("mesh rings", rings, 1)
    if depth and towards is None:
        raise ProblemError(
            f"mesh depth: {depth} and no places to refine towards; give towards, or leave it at 0"
        )
    places = finite_coordinates("places to refine towards", () if towards is None else towards)
    mesh = _equilateral_mesh(outline, length_in_metres("mesh spacing", spacing))
    if places.size:
        if places.ndim != 2 or places.shape[1] != 2:
            raise ProblemError(f"places to refine towards: shape {places.shape}; give (p, 2)")
        _refuse_no_vertex(mesh, places, outline.tolerance)
        closest = spacing * 0.5**depth
        if closest <= 4 * outline.tolerance:
            raise ProblemError(
                f"mesh depth: {depth} puts vertices {closest:.2g} m apart, nearer than two places "
                f"are told apart ({outline.tolerance:.2g} m); take less"
            )
        mesh = _refine_around(mesh, KDTree(places), spacing, depth, rings)
    return _with_midpoints(mesh, element)


def _refine_around(mesh: Any, places: KDTree, spacing: float, depth: int, rings: int) -> Any:
    """The mesh halved around the places, `depth` times, each time half as far away."""
    for level in range(depth):
        reach = (rings - 0.5) * spacing / 2**level
        distance, _ = places.query(mesh.p.T, distance_upper_bound=reach)
        halved = np.flatnonzero(np.isfinite(distance)[mesh.t].any(axis=0))
        # Each becomes four; a neighbour or two of some are cut as well.
        name = f"mesh refined to depth {level + 1} of {depth} with {rings} rings"
        nodes = NODES_PER_TRIANGLE * (mesh.t.shape[1] + 3 * len(halved))
        refuse_too_many(name, nodes, MOST_IN_PLANE)
        mesh = mesh.refined(halved)
    return mesh


def _equilateral_mesh(outline: Polygon, side: float) -> Any:
    """Triangles of a side, in rows along the outline's first edge: a grid's Delaunay mesh."""
    start, end = outline.corners[:2]
    x, y = (end - start) / np.linalg.norm(end - start)
    turn = np.array([[x, -y], [y, x]])
    local = (outline.corners - start) @ turn / side
    (left, low), (right, high) = local.min(axis=0), local.max(axis=0)
    size = float(right - left + 6) * float((high - low) / np.sqrt(0.75) + 5)
    nodes = 2 * NODES_PER_TRIANGLE * size
    refuse_too_many(f"mesh of spacing {side:g} m", nodes, MOST_IN_PLANE)
    row = np.arange(np.floor(low / np.sqrt(0.75)) - 1, np.ceil(high / np.sqrt(0.75)) + 2)
    column = np.arange(np.floor(left) - 2, np.ceil(right) + 3)
    across, along = np.meshgrid(row, column, indexing="ij")
    grid = np.column_stack([(along + 0.5 * (across % 2)).ravel(), np.sqrt(0.75) * across.ravel()])
    cells = Delaunay(grid).simplices
    points = start + side * grid @ turn.T
    cells = cells[outline.contains(points[cells].mean(axis=1))]
    area = len(cells) * np.sqrt(0.1875) * side**2
    if abs(area - outline.volume) > 1e-9 * outline.volume:
        raise ProblemError(
            f"mesh spacing: triangles of side {side:g} m cover {area:.6g} of {outline.volume:.6g} "
            "m²; choose one that divides every edge"
        )
    used, cells = np.unique(cells, return_inverse=True)
    mesh = skfem.MeshTri(points[used].T.copy(), cells.reshape(-1, 3).T.copy())
    _refuse_other_edges(mesh, outline, side)
    return mesh


def _refuse_other_edges(mesh: Any, outline: Polygon, side: float) -> None:
    """The right area may still be another outline's: the mesh's edges must cover this one's."""
    ends = mesh.p[:, mesh.facets[:, mesh.boundary_facets()]].T
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    for i, start in enumerate(outline.vertices):
        edge = Segment(start, outline.vertices[(i + 1) % len(outline.vertices)])
        on_edge = edge.select(ends.reshape(-1, 2), outline.tolerance).reshape(-1, 2).all(axis=1)
        covered, wanted = length[on_edge].sum(), edge.measure(outline.span)
        if abs(covered - wanted) > 1e-9 * wanted:
            raise ProblemError(
                f"mesh spacing: triangles of side {side:g} m have their edges on {covered:.6g} of "
                f"{wanted:.6g} m of edge {i} of the outline, {edge}; choose one that divides it"
            )


def _refuse_no_vertex(mesh: Any, places: Array, tolerance: float) -> None:
    distance, _ = KDTree(mesh.p.T).query(places)
    far = np.flatnonzero(distance > tolerance)
    if len(far):
        raise ProblemError(
            f"places to refine towards: {format_point(places[far[0]])} is {distance[far[0]]:.3g} m "
            "from the nearest vertex of the mesh; choose vertices"
        )


def _with_midpoints(mesh: Any, element: str) -> Discretisation:
    """The mesh, its cells counter-clockwise, as points and cells with mid-sides for P2."""
    t = mesh.t.copy()
    a, b, c = (mesh.p[:, corner] for corner in t)
    clockwise = (b - a)[0] * (c - a)[1] < (b - a)[1] * (c - a)[0]
    t[1:, clockwise] = t[:0:-1, clockwise]
    return make_discretisation(*with_middles(mesh.p.T, t.T, ELEMENTS[element]), element)
