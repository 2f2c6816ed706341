"""Strain and stress at points: gradients of the elements' own functions, in the cells there.

Gradients jump from cell to cell. At a point that several cells share, such as a node, the value is
the mean over these cells, each counted once. Inside a cell it is the cell's own: nothing is
smoothed, so that the order of convergence is that of the gradient. Stress is each cell's own before
it is a mean, so where materials meet it is between theirs: ask for it a little beside.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import csr_array

from msvalidate.problem import VOIGT, Array, Index
from reference_fem.mesh.discretisation import Discretisation


def displacement_gradient(body: Discretisation, displacement: Array, points: ArrayLike) -> Array:
    """∂u_k/∂x_l as (p, d, d) at points (p, d) of the body, of nodal values (n, d).

    Of differences within a cell.

    ∇φ = J⁻ᵀ ∂φ/∂ξ, with J = ∂x/∂ξ of the map onto the cell.

    Raises
    ------
    ProblemError
        If a point lies outside the body.
    """
    point, _, each = gradient_in_cells(body, displacement, points)
    return mean_by_point(point, each)


def gradient_in_cells(
    body: Discretisation, displacement: Array, points: ArrayLike
) -> tuple[Index, Index, Array]:
    """As `displacement_gradient`, of each pair of a point and a cell there: (q,), (q,), (q, d, d).

    Raises
    ------
    ProblemError
        If a point lies outside the body.
    """
    point, cell, local = body.incident(points)
    nodes = body.nodes_of(cell)
    _, slope = body.element.functions(local)
    along = np.einsum("kjq,kqd->qjd", slope, _relative_to_first(body.points, nodes))  # Jᵀ
    change = np.einsum("kjq,kqd->qjd", slope, _relative_to_first(displacement, nodes))
    return point, cell, np.linalg.solve(along, change).transpose(0, 2, 1)


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


def pressure_numbers(body: Discretisation, number: Index | None) -> tuple[Index, int]:
    """Number (k, c) of the pressure at each corner of each cell, and how many there are.

    Cells share it at their common corners if they are of one material; number (c,) says which.
    Pressures run by material, then by rising number of the corners.
    """
    corners = body.cell_nodes.T[: body.element.corners]
    if number is None:
        return np.searchsorted(body.vertices, corners), len(body.vertices)
    used, which = np.unique(number * len(body.points) + corners, return_inverse=True)
    return which.reshape(corners.shape), len(used)


def pressure_at(
    body: Discretisation, pressure: Array, points: ArrayLike, number: Index | None = None
) -> Array:
    """Pressure (p,) at points (p, d), of values (v,) at the corners of cells.

    It is continuous but where materials meet, given by the number (c,) of each cell's, and there
    the mean of the cells.

    Raises
    ------
    ProblemError
        If a point lies outside the body.
    """
    point, cell, local = body.incident(points)
    linear = body.element.linear
    values = np.array([linear.lbasis(local.T, i)[0] for i in range(body.element.corners)])
    known = pressure[pressure_numbers(body, number)[0][:, cell]]
    return mean_by_point(point, (values * known).sum(axis=0))


def mean_by_point(point: Index, values: Array) -> Array:
    """Means by point, which are numbered without a gap and rise, of values (q, ...)."""
    count = np.bincount(point)
    shape = len(count), len(point)
    share = csr_array((1 / count[point], (point, np.arange(len(point)))), shape)
    flat = share @ values.reshape(len(point), math.prod(values.shape[1:]))
    return np.asarray(flat.reshape(len(count), *values.shape[1:]))
