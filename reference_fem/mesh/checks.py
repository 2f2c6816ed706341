"""Cells as they are given: of the right kind, none upon another."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Index, ProblemError
from msvalidate.problem.checks import integers
from reference_fem.mesh.elements import Element


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
