"""What repeats in a finite piece of a network, found from its points inside.

Points with the same springs around them are translations apart; the shortest translations span the
cell. At the boundary springs are missing or count in part: what repeats has all of them.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.spatial import KDTree

from msvalidate.lattice.ties import level_numbers
from msvalidate.problem import Array, Index, Mask, ProblemError

SAME = 1e-4
"""Of the shortest spring, and of the stiffest, by which places and stiffnesses are one: files of
five digits will do."""
NEAR = 30
"""Points around one that the shortest translations are looked for among."""
IRREGULAR = (
    "springs: nothing repeats between points inside, and an irregular finite piece has no tensor "
    "of its own; give a larger piece, or a periodic sample and its --period"
)


class RepeatingCell(NamedTuple):
    """What repeats: points, springs (s, 2), vectors (s, d) in m, N/m, and its area or volume.

    Each spring is there from both ends, with half of its stiffness. `inside` are the points (n,) of
    the piece with all of their springs.
    """

    points: int
    springs: Index
    vectors: Array
    stiffness: Array
    volume: float
    inside: Mask


def repeating_cell(x: Array, pairs: Index, stiffness: Array) -> RepeatingCell:
    """The cell that repeats in a piece of points (n, d) in m and springs (m, 2) of (m,) N/m.

    Raises
    ------
    ProblemError
        If nothing repeats, the piece is too small to show it, or stiffness changes inside.
    """
    n = len(x)
    start, end = np.concatenate([pairs, pairs[:, ::-1]]).T
    vectors, k = x[end] - x[start], np.tile(stiffness, 2)
    room = SAME * float(np.linalg.norm(vectors, axis=1).min())
    way = _classes(level_numbers(vectors, room))
    kind = _classes(np.column_stack([way, level_numbers(k, SAME * k.max())]))
    star, shape = _stars(start, kind, n), _stars(start, way, n)
    basis = _translations(x[star == np.bincount(star).argmax()], room)
    part = (x - x[0]) @ np.linalg.inv(basis)
    site = _classes(level_numbers((part - np.floor(part + SAME)) @ basis, room))
    sites = int(site.max()) + 1
    # Of each site, one of the points with the springs that most of its points have.
    usual = np.array([np.bincount(star[site == each]).argmax() for each in range(sites)])
    inside = star == usual[site]
    chosen = np.array([np.flatnonzero(inside & (site == each))[0] for each in range(sites)])
    own, back = np.isin(start, chosen), np.roll(np.arange(len(start)), len(pairs))
    # All springs are among those of the sites, which have them from both ends alike.
    ways, kinds = ((site[start] * sites + site[end]) * len(start) + each for each in (way, kind))
    if not (np.isin(ways, ways[own]).all() and np.isin(kinds[back[own]], kinds[own]).all()):
        raise ProblemError(IRREGULAR)
    complete, by_side = shape == shape[chosen][site], np.zeros(n, dtype=bool)
    by_side[start[~complete[end]]] = True
    if (complete & ~inside & ~by_side).any():
        raise ProblemError("springs: their stiffness changes inside; give those of one material")
    springs, size = np.column_stack([site[start], site[end]])[own], abs(np.linalg.det(basis))
    return RepeatingCell(sites, springs, vectors[own], k[own] / 2, float(size), inside)


def _classes(rows: Index) -> Index:
    """Number of each row (k, any) among those that differ."""
    return np.asarray(np.unique(rows, axis=0, return_inverse=True)[1].ravel())


def _stars(start: Index, kind: Index, count: int) -> Index:
    """Number (n,) of the set of kinds of springs that start at each point."""
    order = np.lexsort((kind, start))
    rows = np.split(kind[order], np.cumsum(np.bincount(start, minlength=count))[:-1])
    known: dict[bytes, int] = {}
    return np.array([known.setdefault(row.tobytes(), len(known)) for row in rows])


def _translations(places: Array, room: float) -> Array:
    """The shortest independent vectors (d, d) between places (p, d) that are alike."""
    distance, near = KDTree(places).query(places, k=[*range(1, min(len(places), NEAR) + 1)])
    most = int(distance[:, -1].argmin())  # the one with the most around it
    basis: list[Array] = []
    for step in places[near[most, 1:]] - places[most]:
        if np.linalg.matrix_rank(np.array([*basis, step]), tol=room) > len(basis):
            basis.append(step)
    if len(basis) < places.shape[1]:
        raise ProblemError(IRREGULAR)
    return np.array(basis)
