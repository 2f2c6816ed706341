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


def straight_cells(corners: Array, kind: Element) -> Cells:
    """Cells with straight edges, of corners (c, k, d) in the library's order."""
    _, k, d = corners.shape
    start = np.full(d, 1 / k if kind.simplex else 0.5)
    steps = 1 if kind.simplex else NEWTON_STEPS
    return Cells(corners, corners, partial(_isoparametric, kind.first), start, kind.simplex, steps)


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


def determinant(columns: Sequence[Array]) -> Array:
    """Determinants (q,) of matrices of order 2 or 3, given by their columns (q, d)."""
    if len(columns) == 2:
        a, b = columns
        return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])
    a, b, c = columns
    return np.asarray((a * np.cross(b, c)).sum(axis=1))
