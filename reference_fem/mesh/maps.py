"""Maps from the unit cell onto cells: affine, multilinear, or with the element's own functions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial
from itertools import product

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from reference_fem.mesh.elements import ELEMENTS, Element

Map = Callable[[Array, Array], tuple[Array, list[Array]]]
NEWTON_STEPS = 12
"""The inverse of a multilinear map from a cell's centre converges quadratically; parallelograms
take one step."""
CURVED_STEPS = 20


@dataclass(frozen=True, eq=False)
class Cells:
    """Cells, and how the unit simplex or cube is mapped onto them.

    Parameters
    ----------
    nodes
        (c, k, d) positions (m) that the map is made of.
    hull
        (c, h, d) positions (m) whose convex hull holds each cell.
    map
        Of nodes (q, k, d) and local coordinates (q, d): the places (q, d) and their derivatives.
    start
        (k, d) local coordinates of the nodes, or (d,), from which the inverse is sought.
    simplex
        Whether local coordinates run over the unit simplex.
    steps
        Of Newton's method, for the inverse.
    """

    nodes: Array
    hull: Array
    map: Map
    start: Array
    simplex: bool
    steps: int


def straight_cells(corners: Array) -> Cells:
    """Convex triangles or quadrilaterals, tetrahedra or hexahedra of corners (c, k, d).

    In VTK order; local coordinates have corner 0 at the origin.
    """
    _, k, d = corners.shape
    simplex = k == d + 1
    start = np.full(d, 1 / k if simplex else 0.5)
    return Cells(corners, corners, map_to_cell, start, simplex, 1 if simplex else NEWTON_STEPS)


def curved_cells(nodes: Array, kind: Element) -> Cells:
    """Cells of an element with nodes (c, k, d) in the library's order."""
    hull = np.einsum("ik,ckd->cid", _control(kind.name), nodes)
    start = np.asarray(kind.function.doflocs)
    return Cells(nodes, hull, partial(_isoparametric, kind), start, kind.simplex, CURVED_STEPS)


def _isoparametric(kind: Element, nodes: Array, local: Array) -> tuple[Array, list[Array]]:
    value, slope = kind.functions(local)
    place = np.einsum("kq,qkd->qd", value, nodes)
    return place, list(np.einsum("kjq,qkd->jqd", slope, nodes))


@cache
def _control(name: str) -> Array:
    """Matrix (b, nodes) from a quadratic cell's nodes to its Bernstein coefficients.

    A cell lies in their hull: of an edge from a over m to b, they are a, b and 2m - (a + b)/2.
    """
    kind = ELEMENTS[name]
    x = np.asarray(kind.function.doflocs)
    if kind.simplex:
        share = np.column_stack([1 - x.sum(axis=1), x])  # of each corner
        pairs = [tuple(np.flatnonzero(row)) for row in share[kind.corners :]]
        edges = [2 * share[:, a] * share[:, b] for a, b in pairs]
        return np.linalg.inv(np.column_stack([share**2, *edges]))
    x = np.array(list(product((0.0, 0.5, 1.0), repeat=kind.dim)))  # some elements lack middles
    power = np.round(2 * x).astype(int)
    many = np.where(power == 1, 2, 1).prod(axis=1)
    each = x[:, None] ** power * (1 - x[:, None]) ** (2 - power)
    return np.linalg.inv(many * each.prod(axis=2)) @ kind.functions(x)[0].T


def map_to_cell(corners: Array, local: Array) -> tuple[Array, list[Array]]:
    """Place (q, d) of local coordinates (q, d), and its derivative by each of them.

    Cells (q, k, d) are as in `locate`; one row of local coordinates serves them all.
    """
    x = corners.transpose(1, 0, 2)
    r, s, *t = local.T[:, :, None]
    if len(x) == local.shape[1] + 1:
        columns = [corner - x[0] for corner in x[1:]]
        return sum((u * side for u, side in zip((r, s, *t), columns, strict=True)), x[0]), columns
    if not t:
        return _bilinear(x, r, s)
    (low, sides), (high, others) = _bilinear(x[:4], r, s), _bilinear(x[4:], r, s)
    along, across = ((1 - t[0]) * a + t[0] * b for a, b in zip(sides, others, strict=True))
    return (1 - t[0]) * low + t[0] * high, [along, across, high - low]


def _bilinear(x: Array, r: Array, s: Array) -> tuple[Array, list[Array]]:
    """Place and derivatives on a quadrilateral with corners x (4, q, d)."""
    along = (1 - s) * (x[1] - x[0]) + s * (x[2] - x[3])
    across = (1 - r) * (x[3] - x[0]) + r * (x[2] - x[1])
    place = (1 - r) * (1 - s) * x[0] + r * (1 - s) * x[1] + r * s * x[2] + (1 - r) * s * x[3]
    return place, [along, across]


def determinant(columns: Sequence[Array]) -> Array:
    """Determinants (q,) of matrices of order 2 or 3, given by their columns (q, d)."""
    if len(columns) == 2:
        a, b = columns
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    a, b, c = columns
    return np.asarray((a * np.cross(b, c)).sum(axis=1))
