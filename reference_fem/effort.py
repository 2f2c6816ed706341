"""Predicted work and memory of a mesh, and a clear error if memory is short."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from msvalidate.problem import SolverError
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
    """Predicted effort of one more mesh.

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
    """Predict the effort of a mesh from the time per node of the last one."""
    return More(dim * nodes, nodes * BYTES.get(element, max(BYTES.values())), seconds * nodes)


def fits_within(following: More | None, memory: float) -> bool:
    """Return True if a mesh fits into a memory limit (GB).

    Raise `SolverError` if that much memory is not free.
    """
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
