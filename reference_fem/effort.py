"""Predicted work and memory, of a factor and of a mesh, and a clear error if memory is short."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import breadth_first_order, connected_components

from msvalidate.problem import Index, Mask, SolverError
from msvalidate.problem.records import dataclass

MEMORY = 4.0
"""GB that the finest mesh in space may take, by default: a minute where nothing else runs."""
BYTES = {"H2": 11_100.0, "T2": 9_000.0}
"""Memory a node of the finest mesh, by element in space, nodes counted as `nodes_of_children` does.
Measured as the peak of a process over what it held before `converge`, 0.2 GB: a bracket of H2 with
668,865 nodes 7.8 GB, of 89,505 1.2 GB; a plate of bent T2 with 109,504 nodes 1.0 GB, an L of
straight ones with 105,633 0.7 GB. Half is the stiffness in blocks, a fifth slopes of shape
functions; the rest passes while it is summed."""
GB = 1e9


@dataclass(frozen=True)
class More:
    """What one more mesh takes, as predicted.

    Parameters
    ----------
    unknowns, bytes
        By the nodes that it has, the same on every machine.
    seconds
        As many times those of the last mesh.
    """

    unknowns: float
    bytes: float
    seconds: float


def one_more_mesh(element: str, dim: int, nodes: float, seconds: float) -> More:
    """What a mesh of so many nodes takes, if a node of the last one took so many seconds."""
    return More(dim * nodes, nodes * BYTES.get(element, max(BYTES.values())), seconds * nodes)


def fits_within(following: More | None, memory: float) -> bool:
    """Whether a mesh takes no more than so many GB; raise `SolverError` if these are not free."""
    if following is None:
        return True
    if following.bytes > memory * GB:
        return False
    free = free_memory()
    if following.bytes > free:
        raise SolverError(
            f"finite elements: the next mesh, of {following.unknowns:.2g} unknowns, takes "
            f"{following.bytes / GB:.1f} GB, and {free / GB:.1f} are free; free some, or allow it "
            f"less: [compare] memory = {max(0.1, np.floor(10 * free / GB) / 10):g}"
        )
    return True


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
