"""Floor 1: motions that no spring resists: the verdict on one, and its name."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, diags_array

from msvalidate.linear import Factor, factorised, softest_mode
from msvalidate.network import Network, mode_energy
from msvalidate.problem import Array, SolverError, place_name

NO_STIFFNESS = 1e-24
"""Energy of a motion, relative to what its components would cost one by one, that is rounding: a
few parts in 1e16, squared, while the softest mode of a cantilever 20,000 cells long and one high
still has 1e-18."""


STIFFENED = 2.0**-48
"""Part of its diagonal added to a matrix that rounding has made singular: it has a factor then."""


class Regular(NamedTuple):
    """A factor of a tangent's free part.

    Parameters
    ----------
    factor, diagonal
        Of the free part, and its diagonal (f,) in N/m.
    softness, mode
        Of the motion (n·d,) that the tangent resists least.
    """

    factor: Factor
    diagonal: Array
    softness: float
    mode: Array


def regular(network: Network, position: Array, K: csr_array) -> Regular:
    """Factor of the free part K of the tangent at `position` (n, d) in m.

    The motion that the tangent resists least is judged by the springs that it stretches.

    Raises
    ------
    SolverError
        If some motion meets no stiffness.
    """
    stiffness, mode = np.zeros(network.points.size), np.zeros(network.points.size)
    free = ~network.held.ravel()
    stiffness[free] = diagonal = K.diagonal()
    if not diagonal.all():
        mode[free] = softest_mode(K)
        raise SolverError(named(network, mode))
    try:
        factor = factorised(K)
    except SolverError:  # no memory
        raise
    except RuntimeError:  # by a mechanism, or by rounding alone
        factor = factorised(csr_array(K + diags_array(STIFFENED * np.abs(diagonal))))
    mode[free] = softest_mode(K, factor, np.abs(diagonal))
    soft = softness(network, position, mode, stiffness)
    if not abs(soft) > NO_STIFFNESS:
        raise SolverError(named(network, mode))
    return Regular(factor, diagonal, soft, mode)


def is_loose(network: Network, position: Array, motion: Array, stiffness: Array) -> bool:
    """Whether a motion (n·d,) in m from `position` (n, d) in m meets no stiffness.

    The springs that it stretches are asked: an eigenvalue of the tangent is rounded by far more.
    `stiffness` (n·d,) in N/m is what each component meets on its own, the tangent's diagonal. A
    point is judged by all of its free ones: a motion across its only spring has none of its own.
    """
    return not abs(softness(network, position, motion, stiffness)) > NO_STIFFNESS


def softness(network: Network, position: Array, motion: Array, stiffness: Array) -> float:
    """Energy of a motion over what its components would cost one by one, as in `is_loose`.

    0 where that is nothing.
    """
    way = motion.reshape(position.shape)
    own = np.where(network.held, 0.0, np.abs(stiffness).reshape(position.shape)).sum(axis=1)
    apart = float((way**2).sum(axis=1) @ own)
    return mode_energy(network, position, way) / apart if apart > 0 else 0.0


def named(network: Network, motion: Array) -> str:
    """What to say of a motion (n·d,) that nothing resists: the point that moves most, and where."""
    way = motion.reshape(network.points.shape)
    point = int(np.linalg.norm(way, axis=1).argmax())
    along = np.round(way[point] / np.linalg.norm(way[point]), 3)
    return (
        f"equilibrium: the network is a mechanism: nothing resists point {point} at "
        f"{place_name(network.points[point])} moving along {place_name(along)}; "
        "add springs or supports"
    )
