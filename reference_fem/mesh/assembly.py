"""Sums over cells: pairs of nodes are sorted once a mesh, and every integral is summed by them.

A matrix of a mesh has an entry for two nodes that share a cell, so all of them have one
`SparsityPattern`;
their entries are then rows of plain arrays, which any constant tensor combines in one product.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csc_matrix, csr_matrix

from msvalidate.problem import Array, Index, Mask
from msvalidate.problem.records import dataclass

AT_ONCE = 1000
"""Cells whose products are made at once: all slopes of H2 take 2 kB a node, copied."""


@dataclass(frozen=True, eq=False)
class SparsityPattern:
    """Pairs of nodes that share a cell, as the entries of a matrix (n, n) by rows.

    Parameters
    ----------
    columns, start
        (e,) the second node of each pair, rising in each row, and (n + 1,) where the rows begin.
    gather
        (e, c·k·k) ones: sums what cells with k nodes give to the entries, first cell first.
    mirror
        (e,) the entry of the same pair the other way round.
    """

    columns: Index
    start: Index
    gather: csr_matrix
    mirror: Index

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return len(self.start) - 1

    def matrix(self, entries: Array) -> csr_matrix:
        """The matrix (n, n) with such entries (e,)."""
        return csr_matrix((entries, self.columns, self.start), shape=(self.nodes,) * 2)

    def symmetric(
        self, d: int, products: Callable[[int, int], Array], out: Array | None = None
    ) -> Array:
        """Entries (d, d, e) of a matrix that is symmetric to the last bit.

        Parameters
        ----------
        d
            Components of a node.
        products
            What the cells bring, (c, k, k), to block [a][b]; asked for where a <= b.
        out
            (d, d, e) to write to, where it is there.
        """
        found = np.empty((d, d, len(self.columns))) if out is None else out
        for a in range(d):
            for b in range(a, d):
                found[a, b] = self.gather @ products(a, b).ravel()
                found[b, a] = found[a, b][self.mirror]
            found[a, a] = (found[a, a] + found[a, a][self.mirror]) / 2
        return found

    def component_major(self, entries: Array) -> csr_matrix:
        """The matrix (d·n, d·n) with blocks [a][b] of entries (d, d, e).

        A row of it is a row of each block of its component, one after the other.
        """
        d, size = len(entries), entries[0].size
        length, begin = np.diff(self.start), d * self.start[:-1]
        along = np.arange(len(self.columns)) - np.repeat(self.start[:-1], length)
        data = np.empty((d, size))
        columns = np.empty((d, size), dtype=self.columns.dtype)
        for b in range(d):
            place = np.repeat(begin + b * length, length) + along
            columns[:, place] = self.columns + b * self.nodes
            data[:, place] = entries[:, b]
        rows = (begin + size * np.arange(d)[:, None]).ravel()
        whole = (data.ravel(), columns.ravel(), np.append(rows, d * size))
        return csr_matrix(whole, shape=(d * self.nodes,) * 2)


def sparsity_pattern(cells: Index, nodes: int) -> SparsityPattern:
    """Pattern of cells (c, k) on so many nodes, from two sorts that count: linear in the pairs."""
    count, k = cells.size, cells.shape[1]
    whole = np.int32 if count * k < 2**31 else np.int64  # these are most of what assembly takes
    # A row for each node of each cell: its pairs, numbered as they come.
    cells, number = cells.astype(whole), np.arange(count * k, dtype=whole)
    rows = np.arange(count + 1, dtype=whole) * k
    by_second = csr_matrix(
        (number, np.repeat(cells, k, axis=0).ravel(), rows), (count, nodes)
    ).tocsc()
    first = cells.ravel()[by_second.indices]
    pairs = csc_matrix((by_second.data, first, by_second.indptr), (nodes, nodes)).tocsr()
    del number, by_second, first
    new = np.diff(pairs.indices, prepend=-1) != 0
    new[pairs.indptr[:-1]] = True
    (begin,) = new.nonzero()
    columns, start = pairs.indices[begin], np.searchsorted(begin, pairs.indptr)
    gather = csr_matrix(
        (np.ones(count * k), pairs.data, np.append(begin, count * k)), (len(begin), count * k)
    )
    entry = csr_matrix((np.arange(len(begin), dtype=whole), columns, start), (nodes, nodes))
    return SparsityPattern(columns, start, gather, entry.tocsc().data)


def gradient_products(basis: Any, shared: SparsityPattern, cells: Mask | None = None) -> Array:
    """∫ ∂φi/∂xc ∂φj/∂xd as entries (d, d, e) of a pattern, on a scalar basis of the library.

    Over all cells, or those of a mask (c,).
    """
    measure = np.asarray(basis.dx)
    if cells is not None:
        measure = np.where(cells[:, None], measure, 0.0)
    slopes = [function.grad for (function,) in basis.basis]

    def products(a: int, b: int) -> Array:
        found = np.empty((len(measure), len(slopes), len(slopes)))
        for first in range(0, len(measure), AT_ONCE):
            part = slice(first, first + AT_ONCE)
            along, other = (np.stack([each[i, part] for each in slopes], axis=1) for i in (a, b))
            weighed = along * measure[part, None]  # a weight may be negative: no root of it
            found[part] = weighed @ other.transpose(0, 2, 1)
        return found

    return shared.symmetric(len(slopes[0]), products)


def basis_gradients(basis: Any) -> tuple[Array, Array]:
    """Gradients (k, d, c, q) of a cell's functions at its points, and what these measure (c, q)."""
    found = np.array([function.grad for (function,) in basis.basis])
    return found, np.asarray(basis.dx)


def sum_to_nodes(nodes: Index, each: Array, count: int) -> Array:
    """Sums (n, d) over so many nodes of what cells bring, (d, ...), to the nodes (...) of each."""
    return np.column_stack([np.bincount(nodes.ravel(), part.ravel(), count) for part in each])
