"""Networks with a known fault, for negative controls: a study must notice each of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from msvalidate.problem import Problem, ProblemError, Traction, measure_of
from msvalidate.problem.checks import finite_number, require_type
from msvalidate.springs.network import Network


def stiffen_all(network: Network, size: float) -> Network:
    """All springs stiffer by the fraction `size`."""
    _check_network(network, size)
    return network.scaled(1 + size)


def stiffen_diagonals(network: Network, size: float) -> Network:
    """Springs that run along no axis stiffer by the fraction `size`."""
    _check_network(network, size)
    along = np.diff(network.points[network.springs], axis=1)[:, 0]
    slanted = (np.abs(along) > 1e-9 * network.rest_length[:, None]).sum(axis=1) > 1
    return network.scaled(np.where(slanted, 1 + size, 1.0))


def weaken_one_spring(network: Network, size: float) -> Network:
    """The spring in the middle of the list without the part `size` of its stiffness."""
    _check_network(network, size)
    factor = np.ones(len(network.springs))
    factor[len(factor) // 2] -= size
    return network.scaled(factor)


def stiffen_boundary(network: Network, size: float) -> Network:
    """Springs with cells missing beside them stiffer, from shared (0) to equal (1).

    They are known by their stiffness: half that of the stiffest spring of their length, on the
    edges of a solid a quarter. So it says nothing of lattices whose lengths are all different.
    """
    _check_network(network, size)
    _, alike = np.unique(
        np.round(network.rest_length / network.rest_length.max(), 9), return_inverse=True
    )
    strongest = np.zeros(alike.max() + 1)
    np.maximum.at(strongest, alike, network.stiffness)
    part = network.stiffness < 0.75 * strongest[alike]
    missing = np.ones(len(part))
    missing[part] += size * (strongest[alike[part]] / network.stiffness[part] - 1)
    return network.scaled(missing)


def lump_tractions(problem: Problem, network: Network, size: float) -> Network:
    """Network with nodal forces of tractions between consistent (0) and equal ones (1).

    A network is returned unchanged if any load is not a traction, or is one that varies.
    """
    require_type("problem", problem, Problem)
    _check_network(network, size)
    force = np.zeros_like(network.force)
    for load in problem.loads:
        if not isinstance(load, Traction) or callable(load.traction):
            return network
        loaded = load.region.select(network.points, problem.domain.tolerance)
        if not loaded.any():
            raise ProblemError(
                f"traction on {load.region}: no point of the network lies there; give the "
                "problem's own network"
            )
        total = measure_of(load.region, problem.domain) * problem.material.thickness
        force[loaded] += total * np.array(load.traction) / loaded.sum()
    return replace(network, force=network.force + size * (force - network.force))


def _check_network(network: Network, size: float) -> None:
    """Raise `ProblemError` unless a fault has a network and a finite size."""
    require_type("network", network, Network)
    finite_number("size of the fault", size)
