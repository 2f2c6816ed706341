"""A part's own mesh as springs need it: cells cut on the part's own curves, then of straight sides.

Nodes lie where the file's cells have them, so that curves are met ever more closely as cells are
cut; facets and cells keep the names that supports, loads and zones have them by.
"""

from __future__ import annotations

import math
from itertools import combinations

import numpy as np

from msvalidate.problem import Boundary, CellSet, Mesh, Part, Problem, ProblemError, Traction
from msvalidate.problem.records import replace
from msvalidate.problem.shapes import facet_middles
from msvalidate.springs.lattice import EDGE_RULES, Lattice, mesh_lattice
from reference_fem.mesh.from_mesh import mesh_discretisation
from reference_fem.mesh.subdivide import subdivide


def cuts_for(mesh: Mesh, spacing: float) -> int:
    """Number of halvings of cells for edges of about a spacing (m).

    Once at least where cells have mid-sides, so that every node of the file is a point.
    """
    return max(int(mesh.kind.degree > 1), round(math.log2(mesh.mean_edge / spacing)))


def spacing_of_points(mesh: Mesh, count: int) -> float:
    """Mean edge (m) of the mesh, its cells cut, whose points are nearest to a number of them."""
    corners = len(np.unique(mesh.cells[:, : mesh.kind.corners]))
    cuts = max(int(mesh.kind.degree > 1), round(math.log2(count / corners) / mesh.dim))
    return float(mesh.mean_edge / 2**cuts)


def count_one_cell_thick(mesh: Mesh) -> int:
    """Number of quadrilaterals or hexahedra with opposite facets on the surface."""
    rings = mesh.kind.rings
    facets = np.sort(mesh.cells[:, np.array(rings)], axis=2).reshape(-1, len(rings[0]))
    _, which, count = np.unique(facets, axis=0, return_inverse=True, return_counts=True)
    outer = (count[which] == 1).reshape(-1, len(rings))
    thin = np.zeros(len(mesh.cells), dtype=bool)
    for a, b in combinations(range(len(rings)), 2):
        if not set(rings[a]) & set(rings[b]):  # of triangles and tetrahedra all facets meet
            thin |= outer[:, a] & outer[:, b]
    return int(thin.sum())


def straighten(problem: Problem, cuts: int) -> Problem:
    """A problem on its mesh with every cell cut in 2^d so many times, and sides made straight.

    Raises `ProblemError` if a straight cell would be none, or cells are too many.
    """
    mesh = problem.domain
    if not isinstance(mesh, Mesh):
        raise ProblemError(f"springs on the mesh: the body is a {mesh} and has none; give a file")
    if not cuts and mesh.kind.degree == 1:
        return problem
    body = subdivide(mesh_discretisation(mesh), cuts)
    shape = mesh.kind.straight
    used, cells = np.unique(body.cells[:, : shape.corners], return_inverse=True)
    straight = Mesh(body.points[used], cells.reshape(len(body.cells), -1), shape.name)
    number = np.full(len(body.points), -1)
    number[used] = np.arange(len(used))
    count = straight.surface.shape[1]
    facets, places = number[body.surface[:, :count]], body.points[body.surface]
    nodes = np.concatenate([places[:, :count], facet_middles(places)[:, None]], axis=1)

    def meets(part: Part) -> Part:
        """The part's facets on the new mesh; places by coordinates stay."""
        if not isinstance(part, Boundary):
            return part
        on = part.select(nodes.reshape(-1, mesh.dim), mesh.tolerance).reshape(nodes.shape[:2])
        return Boundary(part.name, straight.points[facets[on.all(axis=1)]])

    parent = np.arange(len(body.cells)) // 2 ** (mesh.dim * cuts)
    zones = {name: np.flatnonzero(np.isin(parent, own)) for name, own in mesh.zones.items()}
    straight = straight.named({}, zones)
    return replace(
        problem,
        domain=straight,
        supports=tuple(replace(s, region=meets(s.region)) for s in problem.supports),
        loads=tuple(
            replace(load, region=meets(load.region)) if isinstance(load, Traction) else load
            for load in problem.loads
        ),
        contacts=tuple(replace(c, region=meets(c.region)) for c in problem.contacts),
        zones=tuple(
            replace(zone, region=straight.zone(zone.region.name))
            if isinstance(zone.region, CellSet)
            else zone
            for zone in problem.zones
        ),
    )


def edge_lattice(problem: Problem, *, rests: bool) -> Lattice:
    """A spring on each edge of a problem's mesh: at rest, or as linear elements have them."""
    rule = EDGE_RULES[0] if rests else "cotangent"
    return mesh_lattice(problem.domain, rule, positive=rests)  # type: ignore[arg-type]
