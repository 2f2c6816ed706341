"""Elimination: entries and products of a factor, counted from the pattern of its matrix alone.

No number is computed, so the counts are the same on every machine, and those of any program that
eliminates the nodes in the same order. What is counted is a Cholesky factor: a column of c entries
takes c² products, half of them if symmetry is used, as is usual ([GeorgeLiu1981], section 2.2.2).
Programs that keep both triangles have twice the entries.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate import kit


class Counts(NamedTuple):
    """Entries of a factor, and products to make it."""

    entries: float
    products: float


def count_factor(links: csr_matrix, order: kit.Index, components: int) -> Counts:
    """Counts of a sparse factor.

    Source: [Liu1990], [GeorgeLiu1981].

    Parameters
    ----------
    links
        (n, n), an entry stored where two nodes share a cell, the diagonal too.
    order
        (n,) nodes as they are eliminated, each with all of its components.
    components
        Unknowns of a node.
    """
    below = nodes_below(links, order)
    # Within a node the first component still meets the others, the last only itself.
    columns = components * below[:, None] + np.arange(components, 0, -1.0)
    return _sums(columns)


def count_full(unknowns: int) -> Counts:
    """Counts of a full matrix's factor.

    Source: [GeorgeLiu1981].
    """
    return _sums(np.arange(unknowns, 0, -1.0))


def _sums(columns: kit.Array) -> Counts:
    return Counts(float(columns.sum()), float((columns**2).sum()))


def nodes_below(links: csr_matrix, order: kit.Index) -> kit.Index:
    """Nodes (n,) below the diagonal in each column of the factor.

    A column has what its own row of the matrix has, and what the columns have whose first node
    below the diagonal it is: its children in the elimination tree [Liu1990].
    """
    links = links[order][:, order].tocsr()
    size = len(order)
    below = np.zeros(size, dtype=np.intp)
    left: list[list[kit.Index]] = [[] for _ in range(size)]  # by children, to be taken up
    for node in range(size):
        own = links.indices[links.indptr[node] : links.indptr[node + 1]]
        column = np.unique(np.concatenate([own, *left[node]]))
        left[node] = []
        column = column[column > node]
        below[node] = len(column)
        if len(column):
            left[column[0]].append(column)
    return below
