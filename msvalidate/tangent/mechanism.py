"""Motions that no spring resists: the verdict on one, and its name."""

from __future__ import annotations

import numpy as np

from msvalidate.network import Network, mode_energy
from msvalidate.problem import Array, place_name

NO_STIFFNESS = 1e-24
"""Energy of a motion, relative to what its components would cost one by one, that is rounding: a
few parts in 1e16, squared, while the softest mode of a cantilever 20,000 cells long and one high
still has 1e-18."""


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
