"""Order of the unknowns for a factor: nested dissection of a mesh by the places of its cells.

A body is cut in two halves, these in halves, and so on; the nodes that two halves share come after
all that they part [George1973]. A factor's entries then grow as n log n in the plane and n^(4/3) in
space, no ordering's less [HoffmanMartinRose1973]. The mesh knows where its cells are, so that the
cuts cost a few sorts.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index, Mask
from reference_fem.mesh.discretisation import Discretisation

SAME = 1e-7
"""Middles of cells this close, relative to twice the piece they are in, lie in one layer; cuts and
axes that differ by this part in their worth are alike, whatever coordinates are rounded to."""
WIDE = 0.4
"""Worth of a cut through the widest gap, against shares of the cells that it leaves unlike."""
SMALL = 16
"""Cells, or up to twice as many, of a piece that is cut no further."""


def elimination_order(body: Discretisation, held: Mask) -> Index:
    """Free components (f,) in the order to eliminate them, as positions among the free ones.

    Parameters
    ----------
    body
        The mesh.
    held
        Components (n, d) that are held; the free ones are counted component-major.
    """
    number = np.cumsum(~held.T.ravel()).reshape(held.T.shape) - 1
    order = node_order(body)
    return np.asarray(number.T[order][~held[order]])


def node_order(body: Discretisation) -> Index:
    """Nodes (n,) in the order of nested dissection, by cuts between cells.

    Source: [George1973].
    """
    code = _paths(body.points[body.cells[:, : body.element.corners]])
    nodes = body.cells.shape[1]
    uses = np.argsort(body.cells.ravel(), kind="stable")
    start = np.flatnonzero(np.diff(body.cells.ravel()[uses], prepend=-1))
    low = np.minimum.reduceat(code[uses // nodes], start)
    high = np.maximum.reduceat(code[uses // nodes], start)
    # A node is parted where its cells' paths part: above that, they are one piece.
    below = np.frexp((low ^ high).astype(float))[1]
    last = ((low >> below) + 1 << below) - 1
    return np.lexsort((low, below, last))


def _paths(corners: Array) -> Index:
    """Path of each cell (c, k, d) through the cuts, as the bits of a number (c,), first cut first.

    Each piece is cut across the axis along which it has most cells.
    """
    middle, size = corners.mean(axis=1), np.ptp(corners, axis=1)
    code = np.zeros(len(middle), dtype=np.intp)
    every = np.arange(len(middle))
    order = every
    for _ in range(int(len(middle) // SMALL).bit_length()):
        start = np.flatnonzero(np.diff(code[order], prepend=-1))
        count = np.diff(start, append=len(order))
        which = np.repeat(np.arange(len(start)), count)
        place = _along_the_longest(middle[order], size[order], start, count)
        turn = np.argsort(which + place, kind="stable")
        order, place = order[turn], place[turn]
        step = np.diff(place, prepend=0.0)
        step[start] = 0.0  # where a piece begins, it can be cut if nowhere else: it stays whole
        cut = _cuts(step, start, count, which)
        code *= 2
        code[order] += every >= cut[which]
    return code


def _cuts(step: Array, start: Index, count: Index, which: Index) -> Index:
    """First cell (p,) of the second half of each piece, by the steps (c,) from cell to cell.

    The halves should be alike, and the step wide: triangles cut from one square lie close, and a
    cut between them has more nodes than one between squares.
    """
    border = step > SAME
    border[start] = True
    (begin,) = border.nonzero()
    piece = which[begin]
    first = np.searchsorted(piece, np.arange(len(start)))
    widest = np.maximum.reduceat(step[begin], first)[piece]
    alike = 0.5 - np.abs(begin - start[piece] - count[piece] / 2) / count[piece]
    worth = alike + WIDE * step[begin] / np.where(widest > 0, widest, 1.0)
    (best,) = (worth >= np.maximum.reduceat(worth, first)[piece] - SAME).nonzero()
    cut = np.empty(len(start), dtype=np.intp)
    cut[piece[best]] = begin[best]
    return cut


def _along_the_longest(middle: Array, size: Array, start: Index, count: Index) -> Array:
    """Place (c,) of each cell from 0 to 1/2 in its piece, along the axis with most cells."""
    low = np.minimum.reduceat(middle, start)
    extent = np.maximum.reduceat(middle, start) - low
    cells = extent * count[:, None] / np.add.reduceat(size, start)
    axis = (cells >= cells.max(axis=1, keepdims=True) * (1 - SAME)).argmax(axis=1)
    piece = np.arange(len(start))
    low, extent = low[piece, axis], extent[piece, axis]
    scale = 0.5 / np.where(extent > 0, extent, 1.0)
    along = middle[np.arange(len(middle)), np.repeat(axis, count)]
    return np.asarray((along - np.repeat(low, count)) * np.repeat(scale, count))
