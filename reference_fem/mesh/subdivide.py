"""Every cell of a mesh cut into cells of half its size, on the curves that its sides lie on.

Triangles and quadrilaterals become four, tetrahedra and hexahedra eight. New nodes lie where the
cell's own map takes them, so bent sides stay the file's, and a straight-sided mesh the same body.
Tetrahedra are cut as in [Bey1995], whose children are of three shapes however often they are cut.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.problem import SHAPES, Array, Index, Shape
from msvalidate.problem.checks import refuse_too_many
from reference_fem.mesh.discretisation import Discretisation, make_discretisation
from reference_fem.mesh.elements import Element

SEED = 20_240_229
"""Seed of the random numbers that identify nodes."""
SCALE = 64
"""Nodes of children lie at multiples of a quarter along each axis: weights of corners are whole."""
NO_SHARE = 1e-12
"""Value of a shape function that is rounding of zero."""
_TETRAHEDRON = (
    ((0, 0), (0, 1), (0, 2), (0, 3)),
    ((0, 1), (1, 1), (1, 2), (1, 3)),
    ((0, 2), (1, 2), (2, 2), (2, 3)),
    ((0, 3), (1, 3), (2, 3), (3, 3)),
    ((0, 1), (0, 2), (0, 3), (1, 3)),
    ((0, 1), (0, 2), (1, 2), (1, 3)),
    ((0, 2), (0, 3), (1, 3), (2, 3)),
    ((0, 2), (1, 2), (1, 3), (2, 3)),
)
"""Children by the pairs of corners whose middles are their own."""


def subdivide(body: Discretisation, times: int = 1) -> Discretisation:
    """The same body with each cell cut into 2^d, so many times.

    Raises
    ------
    ProblemError
        If the nodes are too many for the element.
    SolverError
        If memory does not suffice.
    """
    for _ in range(times):
        refuse_too_many("subdivided mesh", nodes_of_children(body), body.element.most_nodes)
        body, _ = children_of(body)
    return body


def children_of(body: Discretisation) -> tuple[Discretisation, csr_matrix]:
    """The same body with each cell cut into 2^d, and what takes values (n,) to its nodes (m, n).

    Children lie on their parent's own map, so a field of the mesh is one of the finer mesh.

    Raises
    ------
    SolverError
        If memory does not suffice.
    """
    points, cells, finer = _halve(body.points, body.cells, body.element)
    return make_discretisation(points, cells, body.element.name), finer


def nodes_of_children(body: Discretisation) -> float:
    """About how many nodes a mesh has after one more subdivision."""
    return float(len(body.points) * 2**body.dim)


def _halve(points: Array, cells: Index, kind: Element) -> tuple[Array, Index, csr_matrix]:
    """Points (m, d) in m and cells (2^d c, k) of all children, and values (n,) at the points."""
    shape = SHAPES[kind.shape]
    corners = _children(shape)
    # Straight children of the unit cell: their nodes (children, k, dim), then the cell's own map.
    local = np.einsum("kc,hcd->hkd", shape.straight.values(shape.nodes), corners)
    flat = local.reshape(-1, shape.dim)
    value = shape.values(flat)
    places = np.einsum("qk,ckd->cqd", value, points[cells])
    weights = np.rint(SCALE * shape.straight.values(flat)).astype(np.uint64)
    number = np.random.default_rng(SEED).integers(2**63, size=len(points), dtype=np.uint64)
    # Neighbours weigh the corners of their common side alike: whole sums, modulo 2^64, tell nodes.
    keys = weights @ number[cells[:, : shape.corners]].T
    _, first, which = np.unique(keys.T.ravel(), return_index=True, return_inverse=True)
    found = places.reshape(-1, points.shape[1])[first]
    parent, place = np.divmod(first, len(flat))
    value[np.abs(value) < NO_SHARE] = 0.0
    start = np.arange(len(found) + 1) * value.shape[1]
    entries = value[place].ravel(), cells[parent].ravel(), start
    finer = csr_matrix(entries, shape=(len(found), len(points)))
    finer.eliminate_zeros()
    return found, which.reshape(-1, len(shape.nodes)), finer


def _children(shape: Shape) -> Array:
    """Corners (children, corners, dim) of the children of the unit cell."""
    at = shape.straight.nodes
    if shape.simplex:
        pairs = _TETRAHEDRON if shape.dim == 3 else _triangle()
        found = np.array([[(at[a] + at[b]) / 2 for a, b in child] for child in pairs])
        edges = found[:, 1:] - found[:, :1]
        turned = np.linalg.det(edges) < 0
        found[turned] = found[turned][:, [1, 0, *range(2, len(at))]]
        return np.asarray(found)
    low = np.array(list(product((0.0, 0.5), repeat=shape.dim)))
    return np.asarray(low[:, None] + at / 2)


def _triangle() -> tuple[tuple[tuple[int, int], ...], ...]:
    return (
        ((0, 0), (0, 1), (0, 2)),
        ((0, 1), (1, 1), (1, 2)),
        ((0, 2), (1, 2), (2, 2)),
        ((1, 2), (0, 2), (0, 1)),
    )
