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

import pandas as pd

from msvalidate import kit
from msvalidate.springs.network import faults

from . import block, finite_size

Fault = Callable[[kit.Network, float], kit.Network]
PROBE = 1e-4
"""Size of the fault from which the smallest noticed one is extrapolated."""
RULES = (
    kit.Rule(
        "smallest fault noticed, largest over the kinds", 1e-6, "1",
        "a thousand times the limits of the identities: no fault hides behind a weak lever",
        table="resolution", value="smallest_noticed",
    ),
)  # fmt: skip
FAULTS: dict[str, tuple[Fault, str]] = {
    "stiffness of every spring": (faults.stiffen_all, "relative"),
    "stiffness of the diagonals": (faults.stiffen_diagonals, "relative"),
    "one spring": (faults.weaken_one_spring, "part missing"),
    "boundary weight": (faults.stiffen_boundary, "part of the way from shared to equal"),
}
"""Name -> the fault, and how its size is measured."""


def apply_fault(
    fault: Fault,
    size: float,
    problem: kit.Problem,
    network: kit.Network,
    answer: kit.Answer = "linear",
) -> kit.Array:
    """A candidate whose network has a fault."""
    return kit.solve_springs(problem, fault(network, size), answer)


def run() -> kit.Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame([smallest(name) for name in FAULTS])
    return kit.Evidence(
        tables={"resolution": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def smallest(name: str) -> dict[str, object]:
    """The fault's smallest size that some identity of the report's block notices, and which."""
    errors = identities(partial(apply_fault, FAULTS[name][0], PROBE))
    quantity = max(errors, key=lambda key: errors[key])
    return {
        "fault": name,
        "unit": FAULTS[name][1],
        "smallest_noticed": PROBE * finite_size.IDENTITY / errors[quantity],
        "noticed_by": quantity,
    }


def identities(candidate: kit.DisplacementSolver) -> dict[str, float]:
    """Errors of the identities that hold for 5 x 5 cells of shared springs at k2 = k1/2."""
    k2 = block.K1 / 2
    ratios, modulus = finite_size.measure(candidate, (k2, "shared", 5))
    body = finite_size.body_of(k2, "shared")
    uniform = [nu for (loading, _), nu in ratios.items() if loading != "clamped"]
    return {
        "Poisson's ratio": kit.farthest_value(uniform, k2 / (block.K1 + k2)).error,
        "modulus": abs(modulus / ((block.K1 + k2) * (1 - body**2)) - 1),
    }
