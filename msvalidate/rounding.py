"""Floor 1: what rounding of the numbers given does to an answer, and how it is said."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.accurate import State
from msvalidate.network import Network
from msvalidate.problem import Array, Mask, SolverError

LARGEST_PART = 1e-3
"""Of the largest displacement, that rounding of rest lengths to doubles may account for."""


def nothing_acts(network: Network, reference: State) -> bool:
    """Whether no load, no prescribed displacement and no prestress acts on what is free.

    `reference` is the network at its reference points. Rest lengths that are distances, rounded to
    doubles, are no prestress here.
    """
    loaded = network.force[~network.held].any() or network.displacement.any()
    return bool(not loaded and reference.unstressed)


def refuse_rounded(part: float, network: Network, title: str) -> None:
    """Raise `SolverError` where rounding of rest lengths moves points by too much.

    `part` is what it moves them by, over the largest displacement.
    """
    if part <= LARGEST_PART:
        return
    rounded = np.finfo(float).eps / 2 * float((network.stiffness * network.rest_length).max())
    raise SolverError(
        f"{title}: rest lengths are rounded to doubles, which stresses springs by up to "
        f"{rounded:.1g} N and changes displacements by {part:.1g} of the largest, more than "
        f"{LARGEST_PART:g}; take loads {_times(part / LARGEST_PART)} times as large, or "
        "stiffnesses that are closer together"
    )


def why(network: Network, softness: float) -> str:
    """How far apart stiffnesses are and what the softest motion meets, and what to do."""
    k = network.stiffness[network.stiffness > 0]
    apart = float(k.max() / k.min()) if len(k) else 1.0
    return (
        f"stiffnesses are {apart:.1g} times apart, and the softest motion meets "
        f"{abs(softness):.1g} of what its points meet one by one; bring stiffnesses closer "
        "together, or take fewer cells along a slender body"
    )


def known(free: Mask, mode: Array) -> Array:
    """A motion (n, d) to try a factor on: of all kinds at once, a mode (n·d,) among them."""
    motion = np.where(free, np.random.default_rng(0).normal(size=free.shape), 0.0)
    own = mode.reshape(motion.shape)
    return np.asarray(motion / np.abs(motion).max() + own / np.abs(own).max())


def _times(factor: float) -> str:
    return f"{math.ceil(factor)}" if factor < 1e3 else f"{factor:.1g}"
