"""Motions that no spring resists: the verdict on one, and its name."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, format_point
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.refine import DOUBTFUL, contraction_bound

NO_STIFFNESS = 1e-24
"""Relative stiffness of a mode that is only rounding.

Rounding is a few parts in 1e16, squared; the softest mode of a cantilever of 20,000 x 1 cells still
has 1e-18.
"""


def relative_stiffness(at: Configuration, motion: Array, stiffness: Array) -> float:
    """Energy of a motion (n·d,), relative to that of its components one by one.

    It is 0 for zero motion.

    The springs that it stretches are asked: an eigenvalue of the tangent is rounded by far more.
    `stiffness` (n·d,) in N/m is what each component meets on its own, the tangent's diagonal. A
    point is judged by all of its free ones: a motion across its only spring has none of its own.
    """
    held = at.network.fixed
    way = motion.reshape(held.shape)
    own = np.where(held, 0.0, np.abs(stiffness).reshape(held.shape)).sum(axis=1)
    apart = float((way**2).sum(axis=1) @ own)
    return at.mode_energy(way) / apart if apart > 0 else 0.0


def is_certain(softness: float) -> bool:
    """Return True if the signs of a factor's pivots are those of the exact tangent."""
    return contraction_bound(softness) <= DOUBTFUL


def describe_motion(network: Network, motion: Array) -> str:
    """A sentence about a mechanism (n·d,): the point that moves most, and its place."""
    way = motion.reshape(network.points.shape)
    far = np.linalg.norm(way, axis=1)
    point = int(far.argmax())  # the first that is NaN, of a motion beyond all numbers
    along = "some direction"
    if 0 < far[point] < np.inf:
        along = format_point(np.round(way[point] / far[point], 3))
    return (
        f"equilibrium: the network is a mechanism: nothing resists point {point} at "
        f"{format_point(network.points[point])} moving along {along}; "
        "add springs or supports"
    )
