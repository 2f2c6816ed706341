"""Cells with their corners: steps to them, and what of a cell's area or volume belongs to each."""

from __future__ import annotations

import math
from itertools import product

import numpy as np

from msvalidate.lattice.filled import VTK_ORDER
from msvalidate.problem import Array, Index

GAUSS = 3
"""Gauss's places along each axis: exact to degree 5; a hexahedron's integrals have 3, those of
products over a flat quadrilateral 3."""


def corners_of_cell(dim: int) -> Index:
    """Steps (2^d, d) from a cell's low corner to each of its corners, in VTK's order."""
    return np.array(list(product((0, 1), repeat=dim)))[VTK_ORDER[dim], ::-1]


def corner_volumes(points: Array, cells: Index) -> Array:
    """Integrals (c, corners) in m² or m³ of the functions that are 1 at one corner of a cell.

    They are 0 at the others: linear on triangles and tetrahedra, and linear along each axis of
    quadrilaterals and hexahedra. Corners are in VTK's order; Gauss's places are exact.
    """
    corner, d = points[cells], points.shape[1]
    if cells.shape[1] == d + 1:
        size = np.abs(np.linalg.det(corner[:, 1:] - corner[:, :1])) / math.factorial(d)
        return np.asarray(np.repeat(size[:, None], d + 1, axis=1) / (d + 1))
    total = np.zeros(cells.shape)
    for weight, one, slope in _gauss_rule(d):
        volume = np.abs(np.linalg.det(np.einsum("ak,ckd->cad", slope, corner)))
        total += weight * volume[:, None] * one
    return total


def quadrilateral_shares(corners: Array) -> Array:
    """Integrals (f, 4, 4) in m² of products of the corners' functions, over facets (f, 4, 3) in m.

    The consistent parts of a traction that is known at the corners, the first axis fastest.
    """
    order = VTK_ORDER[2]
    total = np.zeros((len(corners), 4, 4))
    for weight, one, slope in _gauss_rule(2):
        along = np.einsum("ak,fkd->fad", slope[:, order], corners)
        area = np.linalg.norm(np.cross(along[:, 0], along[:, 1]), axis=1)
        total += weight * area[:, None, None] * np.outer(one, one)[np.ix_(order, order)]
    return total


def _gauss_rule(dim: int) -> list[tuple[float, Array, Array]]:
    """Weights, values (2^d,) and slopes (d, 2^d) of the corners' functions at Gauss's places."""
    up = corners_of_cell(dim)
    places, weights = np.polynomial.legendre.leggauss(GAUSS)
    found = []
    for at, weight in zip(
        product((places + 1) / 2, repeat=dim), product(weights / 2, repeat=dim), strict=True
    ):
        one = np.where(up, at, 1 - np.array(at))
        slope = [(2 * up[:, a] - 1) * np.delete(one, a, axis=1).prod(axis=1) for a in range(dim)]
        found.append((math.prod(weight), one.prod(axis=1), np.array(slope)))
    return found
