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

from msvalidate.judging.candidate import Answer, DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Tolerance
from msvalidate.network import Network, faults
from msvalidate.problem import Array, Problem

from . import block, finite_size

Fault = Callable[[Network, float], Network]
PROBE = 1e-4
"""Size of the fault from which the smallest noticed one is extrapolated."""
TOLERANCES = (
    Tolerance(
        "smallest fault noticed, largest over the kinds", 1e-6, "1",
        "a thousand times the limits of the identities: no fault hides behind a weak lever",
    ),
)  # fmt: skip
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


FAULTS: dict[str, Fault] = dict(
    zip(
        UNITS,
        (
            faults.stiffen_all,
            faults.stiffen_diagonals,
            faults.weaken_one_spring,
            faults.stiffen_boundary,
        ),
        strict=True,
    )
)


def apply_fault(
    fault: Fault, size: float, problem: Problem, network: Network, answer: Answer = "linear"
) -> Array:
    """A candidate whose network has a fault."""
    return solve_springs(problem, fault(network, size), answer)


def run() -> Evidence:
    """State the smallest fault of each kind that the study notices."""
    table = pd.DataFrame([smallest(name) for name in FAULTS])
    return Evidence(
        tables={"resolution": table},
        observed={TOLERANCES[0].quantity: farthest_value(table["smallest_noticed"], 0.0)},
        tolerances=TOLERANCES,
        columns=COLUMNS,
    )


def smallest(name: str) -> dict[str, object]:
    """The fault's smallest size that some identity of the report's block notices, and which."""
    errors = identities(partial(apply_fault, FAULTS[name], PROBE))
    quantity = max(errors, key=lambda key: errors[key])
    return {
        "fault": name,
        "unit": UNITS[name],
        "smallest_noticed": PROBE * finite_size.IDENTITY / errors[quantity],
        "noticed_by": quantity,
    }


def identities(candidate: DisplacementSolver) -> dict[str, float]:
    """Errors of the identities that hold for 5 x 5 cells of shared springs at k2 = k1/2."""
    k2 = block.K1 / 2
    ratios, modulus = finite_size.measure(candidate, (k2, "shared", 5))
    body = finite_size.body_of(k2, "shared")
    uniform = [nu for (loading, _), nu in ratios.items() if loading != "clamped"]
    return {
        "Poisson's ratio": farthest_value(uniform, k2 / (block.K1 + k2)).error,
        "modulus": abs(modulus / ((block.K1 + k2) * (1 - body**2)) - 1),
    }
