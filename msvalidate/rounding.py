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


def refuse_rounded(part: float, of_load: float, network: Network, title: str) -> None:
    """Raise `SolverError` where rounding of rest lengths changes displacements by too much.

    `part` is by how much, over the largest displacement; `of_load` what of it would fall if the
    load rose.
    """
    if part <= LARGEST_PART:
        return
    grown = _times(of_load / LARGEST_PART)
    remedy = (
        f"take loads {grown} times as large, or stiffnesses that are closer together"
        if of_load > part / 2
        else "take stiffnesses that are closer together"
    )
    raise SolverError(
        f"{title}: {_rounded(network)}, which changes displacements by {part:.1g} of the largest, "
        f"more than {LARGEST_PART:g}; {remedy}"
    )


def refuse_unstable(network: Network, reference: State) -> None:
    """Raise `SolverError` for a network that is unstable at its reference points, and say why."""
    if reference.unstressed and network.volumes is None and network.shear is None:
        raise SolverError(
            f"linear equilibrium: {_rounded(network)}, under which the network is unstable at its "
            "reference points; take stiffnesses that are closer together"
        )
    raise SolverError(
        "linear equilibrium: the network is unstable at its reference points (its tangent "
        "stiffness has a negative mode); relieve its prestress or hold it better"
    )


def _rounded(network: Network) -> str:
    stress = np.finfo(float).eps / 2 * float((network.stiffness * network.rest_length).max())
    return f"rest lengths are rounded to doubles, which stresses springs by up to {stress:.1g} N"


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
