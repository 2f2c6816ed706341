"""Residual forces, and the scales and rounding that they are compared with."""

from __future__ import annotations

import math
from copy import copy

import numpy as np

from msvalidate.linear_algebra.norms import EPS
from msvalidate.problem import Array, SolverError
from msvalidate.springs.network import Configuration, Network


def out_of_balance_force(network: Network, displacement: Array) -> Array:
    """Out-of-balance force (n, d) in N at a displacement (n, d) in m.

    It is the sum of springs, cells and loads.
    """
    return Configuration(network, displacement).force() + network.force


def is_unloaded(network: Network) -> bool:
    """Return True without load, prescribed displacement and unbalanced prestress.

    In balance to rounding, as a form that was found under tension is.
    """
    acting = network.force[~network.fixed], network.displacement, network.rest_force[~network.fixed]
    return not any(each.any() for each in acting)


def rounded_otherwise(network: Network) -> Network:
    """Perturb the vectors and constants of a network by rounding, at random.

    The perturbation is always the same.

    What that changes in its forces is what rounding may have: of products, which corrections do not
    show, for it is the same in each of them. It is to be asked for forces only.
    """
    rng = np.random.default_rng(0)

    def shaken(values: Array) -> Array:
        return np.asarray(values * (1 + EPS * (2.0 * rng.integers(0, 2, values.shape) - 1)))

    other = copy(network)
    stiffness, vector = shaken(network.stiffness), shaken(network.vector)
    for kept in ("square", "coefficients", "axial_stiffness", "pull_at_rest", "rest_force"):
        other.__dict__.pop(kept, None)
    other.__dict__.update(
        stiffness=stiffness, vector=vector, distance=np.linalg.norm(vector, axis=1)
    )
    pull = network.pull_at_rest
    off = shaken(network.axial_stiffness) - network.axial_stiffness
    other.__dict__["pull_at_rest"] = pull + (pull != 0) * off
    if network.volumes is not None:
        own = copy(network.volumes)
        own.__dict__.pop("rest_volume", None)
        own.__dict__.update(
            stiffness=shaken(network.volumes.stiffness), corners=shaken(network.volumes.corners)
        )
        other.__dict__["volumes"] = own
    other.__dict__["rest_force"] = (network.rest_force != 0) * other.rest_force
    return other


def force_scale(at: Configuration) -> float:
    """Largest sum of force magnitudes (N) at a free point: the scale of a residual.

    Springs between points that are held take no part in any balance and do not count.

    Raises `SolverError` if the forces are beyond all numbers: any residual would be small beside
    them.
    """
    network = at.network
    with np.errstate(over="ignore", invalid="ignore"):  # refused below
        met = np.linalg.norm(network.force, axis=1) + at.force_magnitudes()
    scale = float(met[~network.fixed.all(axis=1)].max(initial=0.0))
    if not math.isfinite(scale):
        raise SolverError(
            "network: forces beyond all numbers meet at a point; choose units that give ordinary "
            "forces, or reduce the load"
        )
    return scale
