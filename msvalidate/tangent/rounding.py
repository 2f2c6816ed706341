"""What refinement needs of a network: whether it is loaded, and a motion to test a factor with."""

from __future__ import annotations

import numpy as np

from msvalidate.network import Network
from msvalidate.network.accurate import State
from msvalidate.problem import Array, Mask

TOLD = 1e-14
"""Part that a softest motion meets, of what its points do, from which a factor's corrections fall:
several times what they leave of it."""
ALIKE = 100.0
"""Times that stiffnesses may be apart without a word of it."""


def is_unloaded(network: Network, reference: State) -> bool:
    """Whether no load, no prescribed displacement and no prestress acts on what is free.

    `reference` is the network at its reference points.
    """
    loaded = network.force[~network.held].any() or network.displacement.any()
    return bool(not loaded and reference.unstressed)


def explain_rounding(network: Network, softness: float) -> str:
    """How far apart stiffnesses are and what the softest motion meets, and what to do."""
    k = network.stiffness[network.stiffness > 0]
    apart = float(k.max() / k.min()) if len(k) else 1.0
    # What the softest motion of a slender body meets falls as the fourth power of its cells.
    share = min((abs(softness) / TOLD) ** 0.25, 1.0)
    fewer = f"take {share:.1g} of the cells along a slender body, or " if share < 1 else "take "
    met = (
        f"the softest motion meets {abs(softness):.1g} of what its points meet one by one; "
        f"{fewer}a load that prestress does not hide"
    )
    if apart < ALIKE:
        return met
    return (
        f"stiffnesses are {apart:.1g} times apart, and {met}, or bring stiffnesses closer together"
    )


def trial_motion(free: Mask, mode: Array) -> Array:
    """A motion (n, d) to try a factor on: of all kinds at once, a mode (n·d,) among them."""
    motion = np.where(free, np.random.default_rng(0).normal(size=free.shape), 0.0)
    own = mode.reshape(motion.shape)
    return np.asarray(motion / np.abs(motion).max() + own / np.abs(own).max())
