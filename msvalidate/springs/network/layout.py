"""Order of points and springs in memory, with neighbours close to each other.

The compiled sweep (`springs.kernels.sweep`) passes over points in this order once a step and
moves them in place: a spring belongs to the earlier of its points, so that when a point moves no
later one asks where it was.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass

TOGETHER = 4
"""Springs computed side by side: of two points, two of each."""
BLOCK = 64
"""Points whose springs' forces wait for them in the first cache."""
NARROW = 2.0
"""Mean distance of a spring's points in memory that needs no reordering.

It is in layers of a cube of as many points; reordering would cost more than it saves.
"""


@dataclass(frozen=True, eq=False)
class Layout:
    """Order of points, springs of each, cells of each.

    Parameters
    ----------
    order
        (n,) the point at each place; empty where every point keeps its number.
    first
        (n + 1,) the first spring of each place, even; of every `BLOCK` places a multiple of 4.
    owner, other
        (m/2,) place that two springs belong to, and (m,) place at their other end. Springs that
        fill up have no stiffness and end at place n, where nothing is.
    stiffness, tension
        (m,) the law's two numbers of each: k (N/m) and k·L0 (N) of Hooke's.
    cells, first_cell
        (c, k) places of the corners of cells, by their first place, and (blocks + 1,) the first
        cell of each block; the cells' numbers are `cell_order`.
    span
        Largest distance between places that a spring or cell joins.
    """

    order: Index
    first: Index
    owner: Index
    other: Index
    stiffness: Array
    tension: Array
    cells: Index
    cell_order: Index
    first_cell: Index
    span: int

    def part(self, begin: int, end: int) -> Layout:
        """Layout of the positions from `begin`, the first of a block, to `end`."""
        e, stop = self.first[begin], self.first[end]
        inside = self.other[e:stop] < end
        cells = slice(self.first_cell[begin // BLOCK], self.first_cell[-(-end // BLOCK)])
        whole = (self.cells[cells] < end).all(axis=1)
        order = self.order[begin:end] if len(self.order) else np.arange(begin, end)
        before = np.concatenate(([0], np.cumsum(whole)))
        counted = self.first_cell[begin // BLOCK : -(-end // BLOCK) + 1]
        return Layout(
            order,
            self.first[begin : end + 1] - e,
            self.owner[e // 2 : stop // 2] - begin,
            np.where(inside, self.other[e:stop], end) - begin,
            np.where(inside, self.stiffness[e:stop], 0.0),
            np.where(inside, self.tension[e:stop], 0.0),
            cells=self.cells[cells][whole] - begin,
            cell_order=self.cell_order[cells][whole],
            first_cell=before[counted - counted[0]],
            span=self.span,
        )

    def slots(self, springs: Index) -> Index:
        """(m,) where springs (m, 2) of the whole network are among those of the places."""
        ends = self.place[springs]
        return _slots(ends.min(axis=1), ends.max(axis=1), self.first)

    @property
    def points(self) -> int:
        """Number of places."""
        return len(self.first) - 1

    @cached_property
    def place(self) -> Index:
        """(n,) the place of each point."""
        return _place_numbers(self.order, self.points)


def _place_numbers(order: Index, points: int) -> Index:
    """(n,) the place of each point, of an order that is empty where each keeps its number."""
    place = np.arange(points)
    if len(order):
        place[order] = np.arange(points)
    return place


def make_layout(
    points: int, dim: int, springs: Index, stiffness: Array, tension: Array, cells: Index
) -> Layout:
    """Order springs (m, 2) with two constants each, and cells (c, k)."""
    order = _choose_order(points, dim, springs)
    place = _place_numbers(order, points)
    ends = place[springs]
    low, high = ends.min(axis=1), ends.max(axis=1)
    corners = place[cells]
    lowest = corners.min(axis=1, initial=points) if len(cells) else np.zeros(0, dtype=np.intp)
    cell_order = np.argsort(lowest, kind="stable")
    reach = (corners.max(axis=1) - lowest).max() if len(cells) else 0
    blocks = np.minimum(np.arange(-(-points // BLOCK) + 1) * BLOCK, points)
    return Layout(
        order,
        *_group_springs(points, low, high, stiffness, tension),
        cells=corners[cell_order],
        cell_order=cell_order,
        first_cell=np.searchsorted(lowest[cell_order], blocks),
        span=int(max((high - low).max(), reach)),
    )


def _choose_order(points: int, dim: int, springs: Index) -> Index:
    """The ordering of [CuthillMcKee1969], reversed; empty where the network's own serves."""
    apart = np.abs(springs[:, 1] - springs[:, 0]).mean()
    if apart <= NARROW * points ** (1 - 1 / dim):
        return np.zeros(0, dtype=np.intp)
    graph = coo_array(
        (np.ones(2 * len(springs), dtype=np.int8), np.concatenate((springs, springs[:, ::-1])).T),
        shape=(points, points),
    )
    order = cuthill_mckee(graph.tocsr())
    place = _place_numbers(order, points)
    if np.abs(np.subtract(*place[springs].T)).mean() >= apart:
        return np.zeros(0, dtype=np.intp)
    return order


def cuthill_mckee(graph: csr_array) -> Index:
    """The ordering (n,) of [CuthillMcKee1969], reversed, of a symmetric graph (n, n).

    Each piece is searched in breadth from a point of fewest neighbours, those with fewer first, and
    of as many the one of lower number. SciPy's starts wherever an unstable sort, which goes by the
    processor, puts one of the points of fewest neighbours.
    """
    n = graph.shape[0]
    rank = np.argsort(np.diff(graph.indptr), kind="stable")
    ranked = graph[rank][:, rank]
    ranked.sort_indices()
    _, piece = connected_components(ranked, directed=False)
    start = np.unique(piece, return_index=True)[1]
    # One search for all pieces, from a root beside the points that leads to the first of each.
    rows = np.append(ranked.indptr, ranked.nnz + len(start))
    columns = np.append(ranked.indices, start)
    rooted = csr_array((np.ones(len(columns)), columns, rows), shape=(n + 1, n + 1))
    found = breadth_first_order(rooted, n, return_predecessors=False)[1:]
    found = found[np.argsort(piece[found], kind="stable")]
    return np.asarray(rank[found[::-1]], dtype=np.intp)


def _group_springs(
    points: int, low: Index, high: Index, k: Array, kl: Array
) -> tuple[Index, Index, Index, Array, Array]:
    """Springs by owner, each owner's filled up to pairs, each block's to fours."""
    own = np.bincount(low, minlength=points)
    room = own + own % 2
    start = np.arange(0, points, BLOCK)
    last = np.minimum(start + BLOCK, points) - 1
    room[last] += np.add.reduceat(room, start) % TOGETHER
    first = np.concatenate(([0], np.cumsum(room)))
    at = _slots(low, high, first)
    other = np.full(first[-1], points)
    stiffness, tension = np.zeros((2, first[-1]))
    other[at], stiffness[at], tension[at] = high, k, kl
    return first, np.repeat(np.arange(points), room // 2), other, stiffness, tension


def _slots(low: Index, high: Index, first: Index) -> Index:
    """Positions (m,) of springs by owner and other end.

    Owners `low` and other ends `high` are places (m,); the springs of an owner begin at its entry
    of `first` (n + 1,).
    """
    by_owner = np.lexsort((high, low))
    own = np.bincount(low, minlength=len(first) - 1)
    slots = np.empty(len(low), dtype=np.intp)
    slots[by_owner] = np.repeat(first[:-1] - (np.cumsum(own) - own), own) + np.arange(len(low))
    return slots
