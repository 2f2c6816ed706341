"""Resolution: what is the smallest fault that the study notices?

Question   Which faults of the spring network make a tolerance of the finite-size question fail, and
           how small may they be?
Candidate  The network with a known fault put in.
Reference  The tolerances themselves.
Expected   Errors grow in proportion to small faults, so the smallest fault noticed is the limit of
           a tolerance over the error per fault.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd

from msvalidate.compare import worst
from msvalidate.evidence import Evidence, Tolerance
from msvalidate.network import Network
from msvalidate.problem import Array, Mask, Problem
from studies.poisson import block, finite_size
from studies.poisson.block import Candidate, Geometry

Fault = Callable[[Network, float], Network]
PROBE = 1e-4
"""Size of the fault from which the smallest noticed one is extrapolated."""
TOLERANCES = (
    Tolerance(
        "smallest fault noticed, largest over the kinds",
        1e-6,
        "1",
        "a thousand times the limits of the identities: no fault hides behind a weak lever",
    ),
)
COLUMNS = {
    "fault": "what is wrong with the network",
    "unit": "how the fault is measured",
    "smallest_noticed": "smallest fault that makes a tolerance fail (in its unit)",
    "noticed_by": "the quantity that fails first",
}
UNITS = {
    "stiffness of every spring": "relative",
    "stiffness of the diagonals": "relative",
    "one spring": "part missing",
    "boundary weight": "part of the way from shared to equal",
}


def every_spring(network: Network, size: float) -> Network:
    """All springs stiffer by the fraction `size`."""
    return network.scaled(1 + size)


def diagonals(network: Network, size: float) -> Network:
    """Diagonal springs stiffer by the fraction `size`."""
    return network.scaled(np.where(_diagonal(network), 1 + size, 1.0))


def one_spring(network: Network, size: float) -> Network:
    """The spring in the middle of the list without the part `size` of its stiffness."""
    factor = np.ones(len(network.springs))
    factor[len(factor) // 2] -= size
    return network.scaled(factor)


def boundary_weight(network: Network, size: float) -> Network:
    """Axial springs on the boundary stiffer, from shared (0) to twice that, equal (1)."""
    x = network.points[network.springs]
    on_edge = [(x[:, :, axis] == end).all(axis=1) for axis in (0, 1) for end in (0.0, block.SIDE)]
    return network.scaled(np.where(np.any(on_edge, axis=0), 1 + size, 1.0))


def _diagonal(network: Network) -> Mask:
    along = network.points[network.springs[:, 1]] - network.points[network.springs[:, 0]]
    return np.asarray((np.abs(along) > 1e-9).all(axis=1))


FAULTS: dict[str, Fault] = dict(
    zip(UNITS, (every_spring, diagonals, one_spring, boundary_weight), strict=True)
)


def spoilt(
    fault: Fault, size: float, problem: Problem, network: Network, geometry: Geometry = "linear"
) -> Array:
    """A candidate whose network has a fault."""
    return block.springs(problem, fault(network, size), geometry)


def run() -> Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame([smallest(name) for name in FAULTS])
    return Evidence(
        tables={"resolution": table},
        observed={TOLERANCES[0].quantity: worst(table["smallest_noticed"], 0.0)},
        tolerances=TOLERANCES,
        columns=COLUMNS,
    )


def smallest(name: str) -> dict[str, object]:
    """The fault's smallest size that some identity of the report's block notices, and which."""
    errors = identities(partial(spoilt, FAULTS[name], PROBE))
    quantity = max(errors, key=lambda key: errors[key])
    return {
        "fault": name,
        "unit": UNITS[name],
        "smallest_noticed": PROBE * finite_size.IDENTITY / errors[quantity],
        "noticed_by": quantity,
    }


def identities(candidate: Candidate) -> dict[str, float]:
    """Errors of the identities that hold for 5 x 5 cells of shared springs at k2 = k1/2."""
    k2 = block.K1 / 2
    ratios, modulus = finite_size.measure(candidate, (k2, "shared", 5))
    body = finite_size.body_of(k2, "shared")
    uniform = [nu for (loading, _), nu in ratios.items() if loading != "clamped"]
    return {
        "Poisson's ratio": worst(uniform, k2 / (block.K1 + k2)).error,
        "modulus": abs(modulus / ((block.K1 + k2) * (1 - body**2)) - 1),
    }
