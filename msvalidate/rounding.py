"""Floor 1: what refinement is told of a network: whether anything acts, and how to try a factor."""

from __future__ import annotations

import numpy as np

from msvalidate.accurate import State
from msvalidate.network import Network
from msvalidate.problem import Array, Mask

ALIKE = 100.0
"""Times that stiffnesses may be apart without a word of it."""


def nothing_acts(network: Network, reference: State) -> bool:
    """Whether no load, no prescribed displacement and no prestress acts on what is free.

    `reference` is the network at its reference points.
    """
    loaded = network.force[~network.held].any() or network.displacement.any()
    return bool(not loaded and reference.unstressed)


def why(network: Network, softness: float) -> str:
    """How far apart stiffnesses are and what the softest motion meets, and what to do."""
    k = network.stiffness[network.stiffness > 0]
    apart = float(k.max() / k.min()) if len(k) else 1.0
    met = (
        f"the softest motion meets {abs(softness):.1g} of what its points meet one by one; "
        "take fewer cells along a slender body, or a load that prestress does not hide"
    )
    if apart < ALIKE:
        return met
    return (
        f"stiffnesses are {apart:.1g} times apart, and {met}, or bring stiffnesses closer together"
    )


def known(free: Mask, mode: Array) -> Array:
    """A motion (n, d) to try a factor on: of all kinds at once, a mode (n·d,) among them."""
    motion = np.where(free, np.random.default_rng(0).normal(size=free.shape), 0.0)
    own = mode.reshape(motion.shape)
    return np.asarray(motion / np.abs(motion).max() + own / np.abs(own).max())
