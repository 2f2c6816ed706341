"""What a solution takes: work and memory of a factor, foreseen; memory that is not there, told."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee

from msvalidate.problem import Mask, SolverError


def envelope(links: csr_matrix, held: Mask) -> tuple[float, float]:
    """Entries of a factor within the envelope, and products to make it: Σ b and Σ b² by row.

    b is how far a row reaches to the left of the diagonal in the ordering of Cuthill and McKee
    (1969), reversed. A factor is made by nested dissection, with half as many entries in a cube of
    hexahedra and twice as many in a bar: the count is for choosing, cheap and the same on every
    machine.

    Parameters
    ----------
    links
        (n, n), its entries stored where two nodes share a cell.
    held
        Components (n, d) that are held; a node with a free one counts as wholly free.
    """
    free = ~held.all(axis=1)
    graph = links[free][:, free]
    order = reverse_cuthill_mckee(graph, symmetric_mode=True)
    place = np.empty(len(order), dtype=np.intp)
    place[order] = np.arange(len(order))
    first = np.minimum.reduceat(place[graph.indices], graph.indptr[:-1])
    reach = held.shape[1] * (np.maximum(place - first, 0) + 1.0)
    return held.shape[1] * float(reach.sum()), held.shape[1] * float((reach**2).sum())


@contextmanager
def within_memory(count: int, what: str) -> Iterator[None]:
    """Turn a lack of memory for so many of `what` into a `SolverError`."""
    try:
        yield
    except MemoryError as error:
        raise SolverError(
            f"finite elements: {count} {what} take more memory than there is; take fewer cells"
        ) from error
