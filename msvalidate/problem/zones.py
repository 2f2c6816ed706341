"""Material of each point and of each cell in a body with zones."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.spatial import KDTree

from msvalidate.problem.arrays import Array, Index, Mask
from msvalidate.problem.checks import finite_coordinates
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.mesh import Mesh
from msvalidate.problem.motions import format_point
from msvalidate.problem.region import Region
from msvalidate.problem.shapes import Shape, facet_middles, incident_pairs
from msvalidate.problem.statement import Problem
from msvalidate.problem.zone import Ball, CellSet, Zone

SAMPLES = 6
"""Sample points along each axis of a cell, to detect a ball between its corners."""
INSIDE = 1e-4
"""Relative distance from the side of a cell from which a point is inside."""
AT_ONCE = 5_000
"""Cells looked into at once: 216 places in each take 25 MB."""


def materials_at(problem: Problem, places: Array) -> Index:
    """Number (n,) of the material at places (n, d) in m, an index into `Problem.materials`.

    0 is the body's own, then the zones' in their order. Where zones meet or overlap, the last one
    that holds a place counts; each holds its own rim.
    """
    x = finite_coordinates("places", places, "n", problem.domain.dim)
    found = np.zeros(len(x), dtype=np.intp)
    for number, zone in enumerate(problem.zones, 1):
        found[zone.region.select(x, problem.domain.tolerance)] = number
    return found


def materials_of_cells(problem: Problem, places: Array, shape: Shape) -> Index:
    """Index (c,) into `Problem.materials` of the material of each cell.

    The cells have nodes (c, k, d) in m.

    Where corners of straight cells lie on a ball, its outline is the cells', which has an area or a
    volume that is less by second order in their size.

    Raises `ProblemError` if a zone holds no cell, or ends inside one: its material would be
    neither.
    """
    found = np.zeros(len(places), dtype=np.intp)
    for number, zone in enumerate(problem.zones, 1):
        inside, cut = _inside_and_cut(problem, zone, places, shape)
        if cut.any():
            at = int(np.flatnonzero(cut)[0])
            raise ProblemError(
                f"zone {zone.region}: it ends inside {cut.sum()} of {len(cut)} cells, the first at "
                f"{format_point(places[at].mean(axis=0))} m; choose cells that end where it does, "
                "or a mesh with named cells"
            )
        if not inside.any():
            raise ProblemError(f"zone {zone.region}: no cell lies in it; choose smaller cells")
        found[inside] = number
    return found


def cut_cells(problem: Problem, places: Array, shape: Shape) -> Mask:
    """Mask (c,) of the cells (c, k, d) in m that a zone ends in."""
    cut = np.zeros(len(places), dtype=bool)
    for zone in problem.zones:
        cut |= _inside_and_cut(problem, zone, places, shape)[1]
    return cut


def _inside_and_cut(problem: Problem, zone: Zone, places: Array, shape: Shape) -> tuple[Mask, Mask]:
    """Masks (c,) of the cells (c, k, d) whose middle lies in a zone, and of those it ends in."""
    region, room = zone.region, problem.domain.tolerance
    if isinstance(region, CellSet) and isinstance(problem.domain, Mesh):
        own = _numbers_in(problem.domain, places[:, : shape.corners])
        if own is not None:
            return np.isin(own, problem.domain.zones[region.name]), np.zeros(len(own), dtype=bool)
    middle = np.einsum("qk,ckd->cd", shape.values(shape.middle[None]), places)
    inside = region.select(middle, room)
    cut = np.zeros(len(places), dtype=bool)
    near = np.arange(len(places))
    if isinstance(region, CellSet):  # to find out takes long, and most cells are far from its rim
        near = _near(region.rim, places)
        cut[near] = _has_inside(places[near], facet_middles(region.rim), shape, room)
    # Amid corners on a ball a straight side has nodes inside it.
    nodes = places[near, : shape.corners] if isinstance(region, Ball) else places[near]
    each, number = np.unique(nodes.reshape(-1, nodes.shape[2]), axis=0, return_inverse=True)
    held, rim = (
        which(each, room)[number.ravel()].reshape(nodes.shape[:2])
        for which in (region.select, region.on_rim)
    )
    some_in, some_out = (held & ~rim).any(axis=1), (~held & ~rim).any(axis=1)
    cut[near] |= np.where(inside[near], some_out, some_in)
    doubtful = np.flatnonzero(~cut & ~inside)
    if isinstance(region, Region):
        cut[doubtful] = _is_entered(region, places[doubtful, : shape.corners], shape, room)
    elif isinstance(region, Ball):
        for start in range(0, len(doubtful), AT_ONCE):
            part = doubtful[start : start + AT_ONCE]
            cut[part] = _is_dented(region, places[part], shape, room)
    return inside, cut


def _near(rim: Array, places: Array) -> Index:
    """Numbers of the cells (c, k, d) that may meet facets (f, k, d): by balls round both."""
    (a, r), (b, s) = (
        (x.mean(axis=1), np.linalg.norm(np.ptp(x, axis=1), axis=1)) for x in (rim, places)
    )
    return np.flatnonzero(KDTree(a).query(b)[0] <= s + r.max())


def _has_inside(places: Array, points: Array, shape: Shape, room: float) -> Mask:
    """Mask (c,) of the cells (c, k, d) that have a point (n, d) inside, not on a side."""
    middle = places.mean(axis=1, keepdims=True)
    found = np.zeros(len(places), dtype=bool)
    less = middle + (1 - INSIDE) * (places - middle)
    found[incident_pairs(shape, less, points, INSIDE * room)[0]] = True
    return found


def _numbers_in(mesh: Mesh, corners: Array) -> Index | None:
    """Numbers (c,) of cells in a mesh by their corners (c, k, d) in m; None if one is not in it."""
    own = mesh.points[mesh.cells[:, : mesh.kind.corners]]
    if corners.shape[1:] != own.shape[1:]:
        return None
    which = KDTree(own.mean(axis=1)).query(corners.mean(axis=1))[1]
    apart = np.linalg.norm(corners[:, :, None] - own[which][:, None], axis=3)
    return which if apart.min(axis=2).max() <= mesh.tolerance else None


def _is_entered(region: Region, corners: Array, shape: Shape, room: float) -> Mask:
    """Mask (c,) of the straight cells (c, k, d), none of whose corners lies in it, that it enters.

    Two convex bodies are apart if they are along an axis, a normal of a side of one, or in space
    normal to an edge of each.
    """
    found = region.overlaps(corners.min(axis=1), corners.max(axis=1), room)
    (near,) = np.nonzero(found)
    if not len(near):
        return found
    x, unit = corners[near], np.eye(corners.shape[2])
    ring = np.array(shape.straight.rings)
    if shape.dim == 2:
        along = x[:, ring[:, 1]] - x[:, ring[:, 0]]
        normals = np.stack([along[..., 1], -along[..., 0]], axis=-1)
    else:
        first, second = x[:, ring[:, 1]] - x[:, ring[:, 0]], x[:, ring[:, 2]] - x[:, ring[:, 0]]
        pairs = np.sort(np.stack([ring, np.roll(ring, 1, axis=1)], axis=2).reshape(-1, 2), axis=1)
        ends = np.unique(pairs, axis=0)
        edge = x[:, ends[:, 1]] - x[:, ends[:, 0]]
        crossed = np.cross(edge[:, :, None], unit).reshape(len(x), -1, 3)
        normals = np.concatenate([np.cross(first, second), crossed], axis=1)
    low, high = _ends_of(region, x)
    for which in range(normals.shape[1]):
        n = normals[:, which]
        size = np.linalg.norm(n, axis=1)
        reach = np.einsum("ckd,cd->ck", x, n)
        least = np.where(n > 0, low, high) * n
        most = np.where(n > 0, high, low) * n
        apart = np.minimum(reach.max(axis=1), most.sum(axis=1)) - np.maximum(
            reach.min(axis=1), least.sum(axis=1)
        )
        found[near] &= apart > room * size
    return found


def _ends_of(region: Region, x: Array) -> tuple[Array, Array]:
    """Low and high ends (c, d) in m of a region, no further than the cells (c, k, d) reach."""
    low, high = x.min(axis=1), x.max(axis=1)
    for axis, entry in enumerate(region.extent):
        if isinstance(entry, tuple):
            low[:, axis] = np.maximum(low[:, axis], entry[0])
            high[:, axis] = np.minimum(high[:, axis], entry[1])
    return low, high


def _is_dented(ball: Ball, places: Array, shape: Shape, room: float) -> Mask:
    """Mask (c,) of cells (c, k, d), none of whose nodes lies in it, that a ball reaches into.

    By more than the arc over a chord as long as the cell, which is what a straight side on it has.
    """
    at = np.array(list(product(np.linspace(0.0, 1.0, SAMPLES), repeat=shape.dim)))
    x = np.einsum("qk,ckd->cqd", shape.values(np.unique(shape.clipped(at), axis=0)), places)
    deepest = ball.depth(x.reshape(-1, x.shape[2])).reshape(x.shape[:2]).max(axis=1)
    size = np.linalg.norm(np.ptp(places, axis=1), axis=1)
    half = np.minimum(size / 2, ball.radius)
    arc = ball.radius - np.sqrt(ball.radius**2 - half**2)
    # Of a triangle inscribed, whose corners are up to 2/√3 as far from its middle as half a side.
    return np.asarray(deepest > (arc if shape.dim == 2 else 4 / 3 * arc) + room)
