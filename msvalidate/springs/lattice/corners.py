"""Corners of cells, and the part of a cell's volume that belongs to each."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from msvalidate.problem import Array, Index, Shape
from msvalidate.problem.shapes import STRAIGHT
from msvalidate.springs.lattice.filled import VTK_ORDER

GAUSS = 3
"""Gauss points along each axis, exact to degree 5.

Integrals over a hexahedron and products over a flat quadrilateral have degree 3.
"""


def corners_of_cell(dim: int) -> Index:
    """Steps (2^d, d) from the low corner of a cell to every corner.

    They are in VTK order.
    """
    return STRAIGHT[dim, 2**dim].nodes.astype(np.intp)


def corner_volumes(points: Array, cells: Index) -> Array:
    """Integrate the corners' shape functions over each cell: (c, corners) in m² or m³.

    They are 0 at the others: linear on triangles and tetrahedra, and linear along each axis of
    quadrilaterals and hexahedra. Corners are in VTK's order; Gauss's places are exact.
    """
    corner, d = points[cells], points.shape[1]
    shape = STRAIGHT[d, cells.shape[1]]
    if shape.simplex:
        size = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / math.factorial(d)
        return np.asarray(np.repeat(size[:, None], d + 1, axis=1) / (d + 1))
    total = np.zeros(cells.shape)
    for weight, one, slope in _gauss_rule(shape):
        volume = np.abs(np.linalg.det(np.einsum("ka,ckd->cad", slope, corner)))
        total += weight * volume[:, None] * one
    return total


def quadrilateral_shares(corners: Array) -> Array:
    """Integrate products of the corners' shape functions over facets: (f, 4, 4) in m².

    The facets have corners (f, 4, 3) in m.

    The consistent parts of a traction that is known at the corners, the first axis fastest.
    """
    order = VTK_ORDER[2]
    total = np.zeros((len(corners), 4, 4))
    for weight, one, slope in _gauss_rule(STRAIGHT[2, 4]):
        along = np.einsum("ka,fkd->fad", slope[order, :], corners)
        area = np.linalg.norm(np.cross(along[:, 0], along[:, 1]), axis=1)
        total += weight * area[:, None, None] * np.outer(one, one)[np.ix_(order, order)]
    return total


def _gauss_rule(shape: Shape) -> list[tuple[float, Array, Array]]:
    """Weights, values (k,) and slopes (k, d) of the functions of a shape at Gauss's places."""
    at, weights = np.polynomial.legendre.leggauss(GAUSS)
    places = np.array(list(product((at + 1) / 2, repeat=shape.dim)))
    each = [math.prod(several) for several in product(weights / 2, repeat=shape.dim)]
    return list(zip(each, shape.values(places), shape.slopes(places), strict=True))
