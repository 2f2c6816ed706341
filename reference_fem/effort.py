"""Predicted work and memory of a factor, and a clear error if memory is short."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from msvalidate.problem import Index, Mask, SolverError


def factor_envelope(links: csr_matrix, held: Mask) -> tuple[float, float]:
    """Entries of a factor within the envelope, and products to make it: Σ b and Σ b² by row.

    b is how far a row reaches to the left of the diagonal in the reversed ordering of Cuthill and
    McKee. A factor is made by nested dissection, with half as many entries in a cube of
    hexahedra and twice as many in a bar: the count is for choosing, cheap and the same on every
    machine.

    Source: [GeorgeLiu1981]; the order is that of [CuthillMcKee1969].

    Parameters
    ----------
    links
        (n, n), its entries stored where two nodes share a cell.
    held
        Components (n, d) that are held; a node with a free one counts as wholly free.
    """
    free = ~held.all(axis=1)
    graph = links[free][:, free]
    order = _breadth_first_order(graph)
    place = np.empty(len(order), dtype=np.intp)
    place[order[::-1]] = np.arange(len(order))
    first = np.minimum.reduceat(place[graph.indices], graph.indptr[:-1])
    reach = held.shape[1] * (np.maximum(place - first, 0) + 1.0)
    return held.shape[1] * float(reach.sum()), held.shape[1] * float((reach**2).sum())


def _breadth_first_order(graph: csr_matrix) -> Index:
    """Nodes (n,) of each part in breadth from one of fewest neighbours, those with fewer first.

    Ties go by number. `scipy.sparse.csgraph.reverse_cuthill_mckee` leaves its start to an unstable
    sort, and so to the processor.
    """
    by_degree = np.argsort(np.diff(graph.indptr), kind="stable")
    graph = graph[by_degree][:, by_degree]
    graph.sort_indices()
    _, part = connected_components(graph, directed=False)
    (first,) = np.nonzero(np.diff(np.maximum.accumulate(part), prepend=-1))
    # A node more, before all others: the search goes from it to the first of each part.
    indptr = np.concatenate(([0], graph.indptr + len(first)))
    indices = np.concatenate((first, graph.indices)) + 1
    size = graph.shape[0] + 1
    joined = csr_matrix((np.ones(len(indices)), indices, indptr), shape=(size, size))
    seen = breadth_first_order(joined, 0, return_predecessors=False)[1:] - 1
    return np.asarray(by_degree[seen[np.argsort(part[seen], kind="stable")]])


def free_memory() -> float:
    """Bytes that the machine says are free for a process; infinite where it does not say."""
    try:
        lines = Path("/proc/meminfo").read_text().splitlines()
    except OSError:
        return math.inf
    told = [line.split()[1] for line in lines if line.startswith("MemAvailable:")]
    return 1024.0 * int(told[0]) if told else math.inf


@contextmanager
def fits_in_memory(count: int, what: str) -> Iterator[None]:
    """Turn a lack of memory for so many of `what` into a `SolverError`."""
    try:
        yield
    except MemoryError as error:
        raise SolverError(
            f"finite elements: {count} {what} take more memory than there is; take solver "
            "'multigrid' where there is a choice, or larger cells"
        ) from error
