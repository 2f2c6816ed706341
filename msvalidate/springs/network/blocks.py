"""The sparsity pattern of d × d blocks of springs and cells, and their assembly.

A spring adds its block to the diagonal ones of its two points and takes it from the two that couple
them. Where they stand depends on the springs alone: found once a network, it serves every tangent.
"""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations_with_replacement, product

import numpy as np
from scipy.sparse import bsr_array, csr_array

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass


@dataclass(frozen=True, eq=False)
class Blocks:
    """Positions of the blocks of a sparse matrix of n points and p pairs.

    Its memory is O(n + m) for m springs.

    Parameters
    ----------
    row_start, column
        (n + 1,) and (n + 2p,): rows as in `bsr_array`; every point has its diagonal block.
    diagonal
        (n,) places of the diagonal blocks.
    pair
        (m,) which pair of points a spring joins: several may join the same two.
    upper, lower
        (p,) places of the two blocks that couple a pair.
    cells
        (c, k, k) places of the blocks of k corners of cells, if there are any.
    """

    row_start: Index
    column: Index
    diagonal: Index
    pair: Index
    upper: Index
    lower: Index
    cells: Index

    def summed(self, springs: Index, dim: int, entry: Callable[[int, int], Array]) -> bsr_array:
        """Matrix (n·d, n·d) of symmetric blocks of springs.

        Component a of point i is row i·d + a.

        Parameters
        ----------
        springs
            (m, 2), those of `blocks_of`.
        dim
            Axes d.
        entry
            Entries (m,) of all springs' blocks at a row and a column: one at a time, for memory.
        """
        n, p = len(self.diagonal), len(self.upper)
        data = np.zeros((len(self.column), dim, dim))
        for a, b in combinations_with_replacement(range(dim), 2):
            value = entry(a, b)
            met = np.bincount(springs[:, 0], value, n) + np.bincount(springs[:, 1], value, n)
            coupled = -np.bincount(self.pair[: len(springs)], value, p)
            for row, column in {(a, b), (b, a)}:
                data[self.diagonal, row, column] = met
                data[self.upper, row, column] = coupled
                data[self.lower, row, column] = coupled
        return bsr_array((data, self.column, self.row_start), shape=(n * dim, n * dim))

    def add(self, data: Array, entry: Callable[[int, int], Array]) -> None:
        """Add the contributions of cells to the blocks (n + 2p, d, d).

        The function of a row and a column returns entries (c, k, k).
        """
        place = self.cells.ravel()
        for a, b in product(range(data.shape[1]), repeat=2):
            data[:, a, b] += np.bincount(place, entry(a, b).ravel(), len(data))


def blocks_of(springs: Index, points: int, cells: Index) -> Blocks:
    """Positions of the blocks of springs (m, 2) and cells (c, k)."""
    first, second = np.triu_indices(cells.shape[1], 1)
    joined = np.stack([cells[:, first].ravel(), cells[:, second].ravel()], axis=1)
    every = np.concatenate([springs, joined])
    low, high = every.min(axis=1), every.max(axis=1)
    pairs, pair = np.unique(low * points + high, return_inverse=True)
    low, high = np.divmod(pairs, points)
    own = np.arange(points)
    row, column = np.concatenate([low, high, own]), np.concatenate([high, low, own])
    # No entry twice: each keeps its number, which sorting by rows and columns carries along.
    order = csr_array((np.arange(len(row)), (row, column)), shape=(points, points))
    order.sort_indices()
    place = np.empty(len(row), dtype=order.indices.dtype)
    place[order.data] = np.arange(len(row), dtype=place.dtype)
    upper, lower, diagonal = np.split(place, [len(pairs), 2 * len(pairs)])
    of_cells: Index = np.empty((*cells.shape, cells.shape[1]), dtype=place.dtype)
    corner = np.arange(cells.shape[1])
    of_cells[:, corner, corner] = diagonal[cells]
    coupling = pair[len(springs) :].reshape(len(cells), len(first))
    turned = cells[:, first] > cells[:, second]
    of_cells[:, first, second] = np.where(turned, lower[coupling], upper[coupling])
    of_cells[:, second, first] = np.where(turned, upper[coupling], lower[coupling])
    kept = order.indptr, order.indices, diagonal, pair, upper, lower, of_cells
    for array in kept:
        array.setflags(write=False)
    return Blocks(*kept)
