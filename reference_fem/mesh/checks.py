"""Cells as they are given: of the right kind, upright, none upon another."""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, ProblemError
from msvalidate.problem.checks import integers
from reference_fem.mesh.elements import Element
from reference_fem.mesh.maps import determinant, map_to_cell


def checked_cells(cells: ArrayLike, kind: Element, points: int) -> Index:
    """Cells (c, nodes) as whole numbers of points that are there."""
    need = f"{kind.name} needs whole numbers (c, {kind.nodes})"
    t = integers("cells", cells, "c>0", kind.nodes, need=need)
    if t.min() < 0 or t.max() >= points:
        raise ProblemError(f"cells: points {t.min()} to {t.max()}; there are 0 to {points - 1}")
    return t


def refuse_repeated(t: Index, kind: Element) -> None:
    """A quadratic cell has a point of its own for each node; linear ones are seen to be flat."""
    each = np.sort(t, axis=1)
    twice = each[:, 1:] == each[:, :-1]
    if kind.degree > 1 and twice.any():
        cell, place = np.argwhere(twice)[0]
        raise ProblemError(
            f"cells: cell {cell} names point {each[cell, place]} twice; {kind.name} lists corners, "
            "mid-sides, centre, each a point of its own"
        )


def refuse_overlap(faces: Index) -> None:
    """Neighbours run round their common face (c, faces, corners), or along an edge, oppositely."""
    each = faces.reshape(-1, faces.shape[2])
    side = "edges"
    if faces.shape[2] > 2:  # a ring starts anywhere: with its lowest number
        start = each.argmin(axis=1)[:, None]
        each = np.take_along_axis(each, (start + np.arange(each.shape[1])) % each.shape[1], axis=1)
        side = "faces"
    _, first, count = np.unique(each, axis=0, return_index=True, return_counts=True)
    if count.max() > 1:
        cell = int(first[count.argmax()]) // faces.shape[1]
        raise ProblemError(
            f"cells: cell {cell} overlaps another on one of its {side}; list it once"
        )


def refuse_crossed(corners: Array, number: Index) -> None:
    """Cells with straight edges, by their corners (c, k, d); `number` is what to call them."""
    if corners.shape[2] == 2:
        _refuse_inverted(corners, number)
    else:
        _refuse_folded(corners, number)


def _refuse_inverted(corners: Array, number: Index) -> None:
    """Corners (c, 3 or 4, 2) must turn left all the way round."""
    edge = np.roll(corners, -1, axis=1) - corners
    following = np.roll(edge, -1, axis=1)
    turn = edge[..., 0] * following[..., 1] - edge[..., 1] * following[..., 0]
    size = np.linalg.norm(edge, axis=2) * np.linalg.norm(following, axis=2)
    bad = np.flatnonzero((turn <= 1e-12 * size).any(axis=1))
    if len(bad):
        raise ProblemError(
            f"cells: cell {number[bad[0]]} is inverted, flat or not convex; list its corners "
            "counter-clockwise"
        )


def _refuse_folded(corners: Array, number: Index) -> None:
    """The map onto each cell (c, 4 or 8, 3) must nowhere turn inside out.

    A hexahedron's Jacobian is quadratic along each axis of the unit cube, so it is above zero
    wherever its 27 Bernstein coefficients are: at its corners alone would not be enough.
    """
    steps = (0.0, 0.5, 1.0) if corners.shape[1] == 8 else (0.0,)
    jacobian = np.empty((len(steps) ** 3, len(corners)))
    lengths = np.zeros((3, len(corners)))
    for i, place in enumerate(product(steps, repeat=3)):
        _, columns = map_to_cell(corners, np.array([place]))
        jacobian[i] = determinant(columns)
        lengths = np.maximum(lengths, [np.linalg.norm(side, axis=1) for side in columns])
    if len(steps) == 3:
        bernstein = np.array([[1, 0, 0], [-0.5, 2, -0.5], [0, 0, 1]])
        values = jacobian.reshape(3, 3, 3, -1)
        jacobian = np.einsum("ai,bj,ck,ijkn->abcn", *[bernstein] * 3, values).reshape(27, -1)
    bad = np.flatnonzero((jacobian <= 1e-12 * lengths.prod(axis=0)).any(axis=0))
    if len(bad):
        first = corners.shape[1] // 2 if len(steps) == 3 else 3
        raise ProblemError(
            f"cells: cell {number[bad[0]]} is inverted, flat or folded; list its corners in VTK "
            f"order, the first {first} counter-clockwise as seen from the rest"
        )
