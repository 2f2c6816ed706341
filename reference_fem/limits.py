"""Questions that elasticity gives no finite answer to, and corners that it answers slowly.

A force at a point, or a support at a point that carries one, leaves a displacement there like
log(1/r) in the plane and 1/r in space; one along a line in space like log(1/r)
[TimoshenkoGoodier1970, sections 36 and 138]. Every mesh gives a number, which grows without end.

Where four quarters of two materials meet crosswise, the displacement goes like r^λ with
λ = (4/π) arctan √(1/R) of the contrast R of their shear moduli, for the scalar problem
[Kellogg1974]: at R = 1 it is 1, at R = 10⁴ 0.013; that of plane elasticity is above it. Energy and
displacements close in like h^(2λ), behind parts of the error that die out faster, so that what is
seen on three meshes tells nothing of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import numpy as np
from scipy.sparse.csgraph import connected_components

from msvalidate.problem import Array, Index, PointForce, Problem, Region, Support
from reference_fem.elasticity import elastic_tensor
from reference_fem.materials import CellMaterials, materials_of
from reference_fem.mesh.discretisation import Discretisation

CARRIES = 1e-6
"""Smallest force at a point support, relative to all forces, that counts.

A pin that only prevents a rigid-body motion carries rounding.
"""


def acts_on_points(problem: Problem) -> bool:
    """Return True if a load or support acts at a point or 3D line."""
    forces = any(isinstance(load, PointForce) for load in problem.loads)
    return forces or any(_is_small(support) for support in problem.supports)


def has_no_limit(problem: Problem, reactions: Sequence[Array], loads: float) -> tuple[str, ...]:
    """Sentences on point forces, and on supports at points or lines that carry a force.

    Parameters
    ----------
    problem
        What is asked.
    reactions
        Force (d,) in N of each of its supports, on any mesh.
    loads
        Sum of the loads' sizes (N).
    """
    found = []
    sizes = [float(np.linalg.norm(force)) for force in reactions]
    whole = sum(sizes) + loads
    for load in problem.loads:
        if isinstance(load, PointForce) and np.any(load.force):
            found.append(
                f"a force at the point {load.region} has no finite displacement under it, and no "
                "finite energy; spread it over a side"
            )
    for support, size in zip(problem.supports, sizes, strict=True):
        if _is_small(support) and size > CARRIES * whole:
            found.append(
                f"a support at {support.region}, no side, carries a force, which would move it "
                "without end; support a side"
            )
    return tuple(found)


def _is_small(support: Support) -> bool:
    """Return True if a support is a point, or a line in 3D."""
    region = support.region
    return isinstance(region, Region) and len(region.normal_axes) > 1


def crossing_order(problem: Problem, body: Discretisation) -> float:
    """Order 2λ with which values close in where materials cross; infinite where none do."""
    law = materials_of(problem, body)
    if not isinstance(law, CellMaterials):
        return np.inf
    contrast = _largest_contrast(body, law)
    return 8 / np.pi * float(np.arctan(np.sqrt(1 / contrast))) if contrast > 1 else np.inf


def _largest_contrast(body: Discretisation, law: CellMaterials) -> float:
    """Largest ratio of moduli of materials that cross at a node, in space along an edge; or 1."""
    tensors = [elastic_tensor(each) for each in law.materials]
    # Of the shear moduli: that of λ would hide a soft zone near nu = 1/2.
    size = [float(each[-1, -1]) for each in tensors]
    # Zones of one material are one: it is what crosses.
    first = [next(i for i, a in enumerate(tensors) if np.array_equal(a, b)) for b in tensors]
    number = np.array(first)[law.number]
    corners = body.cells[:, : body.element.corners]
    found = 1.0
    for cells in _stars(corners, number, body.element.dim):
        numbers = number[cells]
        for a, b in combinations(np.unique(numbers), 2):
            ratio = max(size[a], size[b]) / min(size[a], size[b])
            if ratio > found and all(
                _pieces(corners[cells[numbers == one]], body.element.dim) > 1 for one in (a, b)
            ):
                found = ratio
    return found


def _stars(corners: Index, number: Index, dim: int) -> list[Index]:
    """Cells around each node of several materials, in space around each pair of such nodes."""
    order = np.argsort(corners.ravel(), kind="stable")
    node, start = np.unique(corners.ravel()[order], return_index=True)
    around = dict(zip(node.tolist(), np.split(order // corners.shape[1], start[1:]), strict=True))
    mixed = {n: cells for n, cells in around.items() if len(np.unique(number[cells])) > 1}
    if dim == 2:
        return list(mixed.values())
    found = []
    for n, cells in mixed.items():
        for other in np.unique(corners[cells]).tolist():
            if other > n and other in mixed:
                both = np.intersect1d(cells, mixed[other])
                if len(both) > 2 and len(np.unique(number[both])) > 1:
                    found.append(both)
    return found


def _pieces(corners: Index, dim: int) -> int:
    """Number of parts that cells (c, k) fall into which share no side."""
    shared = (corners[:, None, :, None] == corners[None, :, None, :]).sum(axis=(2, 3))
    return int(connected_components(shared >= dim, directed=False)[0])
