"""Initial displacement of a body under prescribed displacements.

Moved at once, with all else left where it is, a side may go past its neighbours: the first row of
cells is then inside out, and a relaxation that starts there finds a rest that is so too. Where the
sides move by less than a part of the springs at them they are moved alone. Where they move further
all points go along, each component by the mean of the neighbours' by stiffness: the harmonic
extension, which is linear in a uniform lattice between two sides and never leaves the range of the
values prescribed.
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import coo_array, csr_array, diags_array
from scipy.sparse.linalg import cg

from msvalidate.problem import Array
from msvalidate.springs.network import Network

ALONE = 0.25
"""Largest relative change of a spring by prescribed displacements of its end alone.

The neighbours of a point then stay in front of it, even at the corner of a square.
"""
CLOSE = 1e-4
"""Residual of the mean of neighbours, relative to the first: a start is no answer."""


def impose_supports(network: Network, displacement: Array) -> Array:
    """Displacement (n, d) in m with the prescribed values imposed on a given one."""
    ahead = np.where(network.fixed, network.displacement - displacement, 0.0)
    i, j = network.springs.T
    change = ((ahead[j] - ahead[i]) ** 2).sum(axis=1)
    x = network.points + displacement
    if (change > ALONE**2 * ((x[j] - x[i]) ** 2).sum(axis=1)).any():
        ahead = _harmonic_extension(network, ahead)
    moved = displacement + ahead
    moved[network.fixed] = network.displacement[network.fixed]
    return np.asarray(moved)


def _harmonic_extension(network: Network, ahead: Array) -> Array:
    """Moves (n, d) in m of all points that are harmonic between those of the held ones."""
    n, (i, j) = len(network.points), network.springs.T
    k = np.abs(network.axial_stiffness)
    k = k / k.max(initial=0.0)
    pairs = np.concatenate([i, j]), np.concatenate([j, i])
    joined = csr_array(coo_array((np.concatenate([k, k]), pairs), shape=(n, n)))
    met = joined.sum(axis=1)
    out = np.array(ahead)
    for axis in range(network.dim):
        # Points without stiffness stay: no equation asks them to move.
        free = np.flatnonzero(~network.fixed[:, axis] & (met > 0))
        if not len(free) or not ahead[:, axis].any():
            continue
        pull = joined[free] @ ahead[:, axis]
        matrix = diags_array(met[free]) - joined[free][:, free]
        inverse = diags_array(1 / met[free])
        out[free, axis], _ = cg(matrix, pull, rtol=CLOSE, maxiter=10 * n, M=inverse)
    return out
