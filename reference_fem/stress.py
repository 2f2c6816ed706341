"""Strain and stress at points: gradients of the elements' own functions, in the cells there.

Gradients jump from cell to cell. At a point that several cells share, such as a node, the value is
the mean over these cells, each counted once. Inside a cell it is the cell's own: nothing is
smoothed, so that the order of convergence is that of the gradient.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from msvalidate.problem import VOIGT, Array, Index
from reference_fem.mesh.discretisation import Discretisation


def displacement_gradient(
    body: Discretisation, displacement: Array, points: ArrayLike, rest: Array | None = None
) -> Array:
    """∂u_k/∂x_l as (p, d, d) at points (p, d) of the body, of nodal values (n, d).

    Of differences within a cell, and of the digits `rest` (n, d) that the values lack, if given.

    ∇φ = J⁻ᵀ ∂φ/∂ξ, with J = ∂x/∂ξ of the map onto the cell.

    Raises
    ------
    ProblemError
        If a point lies outside the body.
    """
    point, cell, local = body.incident(points)
    nodes = body.nodes_of(cell)
    _, slope = body.element.functions(local)
    along = np.einsum("kjq,kqd->qjd", slope, _relative_to_first(body.points, nodes))  # Jᵀ
    moved = _relative_to_first(displacement, nodes)
    if rest is not None:
        moved += _relative_to_first(rest, nodes)
    change = np.einsum("kjq,kqd->qjd", slope, moved)
    each = np.linalg.solve(along, change).transpose(0, 2, 1)
    return _mean_by_point(point, each)


def _relative_to_first(values: Array, nodes: Index) -> Array:
    """Values (k, q, d) at the nodes of cells (k, q), less those at the first of each."""
    each = values[nodes]
    return np.asarray(each - each[0])


def engineering_strain(gradient: Array) -> Array:
    """Strain (p, 3 or 6) of displacement gradients (p, d, d), its shears doubled.

    In Voigt's order: xx, yy, xy or xx, yy, zz, yz, xz, xy.

    Source: [TimoshenkoGoodier1970], article 5.
    """
    rows = [
        gradient[:, a, a] if a == b else gradient[:, a, b] + gradient[:, b, a]
        for a, b in VOIGT[gradient.shape[1]]
    ]
    return np.stack(rows, axis=1)


def pressure_at(body: Discretisation, pressure: Array, points: ArrayLike) -> Array:
    """Pressure (p,) at points (p, d), of values (v,) at the corners of cells: it is continuous.

    Raises
    ------
    ProblemError
        If a point lies outside the body.
    """
    point, cell, local = body.incident(points)
    corners = body.nodes_of(cell)[: body.element.corners]
    linear = body.element.linear
    values = np.array([linear.lbasis(local.T, i)[0] for i in range(len(corners))])
    known = pressure[np.searchsorted(body.vertices, corners)]
    return _mean_by_point(point, (values * known).sum(axis=0))


def _mean_by_point(point: Index, values: Array) -> Array:
    """Means by point, which are numbered without a gap and rise, of values (q, ...)."""
    count = np.bincount(point)
    shape = len(count), len(point)
    share = csr_array((1 / count[point], (point, np.arange(len(point)))), shape)
    flat = share @ values.reshape(len(point), math.prod(values.shape[1:]))
    return np.asarray(flat.reshape(len(count), *values.shape[1:]))
