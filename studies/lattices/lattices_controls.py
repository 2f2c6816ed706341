"""Controls: which faults does the study notice, and how small may they be?

Question   The smallest fault of each kind that a tolerance notices.
Candidate  Bodies whose network has a known fault, and solids of patterns with one.
Reference  The tolerances of `uniform` and `solids`.
Expected   Errors grow in proportion to small faults, so the smallest noticed is a limit over the
           error per fault: of identities, parts in 1e7 and below. Lattices with springs across
           sides have no identity; their faults show in their orders alone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.constants.homogenise import Homogenised, homogenise
from msvalidate.springs.lattice import Constants, Pattern
from msvalidate.springs.network import faults

from . import cases, solids, uniform
from .cases import Case, Solid

Fault = Callable[[kit.Network, float], kit.Network]
PROBE = 1e-5
"""Size of the fault from which the smallest that is noticed is extrapolated."""
BODIES: dict[str, Fault] = {
    "stiffness of every spring": faults.stiffen_all,
    "stiffness of the diagonals": faults.stiffen_diagonals,
    "one spring": faults.weaken_one_spring,
    "boundary weights": faults.stiffen_boundary,
}
SOLID = "stiffness of one direction"
UNITS = {
    "stiffness of every spring": "relative",
    "stiffness of the diagonals": "relative",
    "one spring": "part missing",
    "boundary weights": "part of the way from shared to equal",
    SOLID: "part missing",
}
ACROSS = {2: 8, 3: 2}
RULES = (
    kit.Rule(
        "smallest fault noticed, largest over the kinds", 1e-6, "1",
        "a thousand times the limit of an identity: no fault hides behind a weak lever",
        table="controls", value="smallest_noticed",
    ),
)  # fmt: skip


def apply_fault(
    fault: Fault,
    size: float,
    problem: kit.Problem,
    network: kit.Network,
    answer: kit.Answer = "linear",
) -> kit.Array:
    """A candidate whose network has a fault."""
    return kit.solve_springs(problem, fault(network, size), answer)


def soften(size: float, pattern: Pattern, k: Constants, spacing: float = 1.0) -> Homogenised:
    """The solid of a lattice without a part of the springs along the direction of the first."""
    vectors = pattern.vectors / np.linalg.norm(pattern.vectors, axis=1, keepdims=True)
    same = np.abs(vectors @ vectors[0]) > 1 - cases.STIFF
    factor = np.where(same, 1 - size, 1.0) * pattern.factor
    return homogenise(replace(pattern, factor=factor), k, spacing)


def body_with(fault: str, size: float) -> kit.DisplacementSolver:
    """The spring network with a fault of some kind and size."""
    return partial(apply_fault, BODIES[fault], size)


def solid_with(size: float) -> Solid:
    """The solid of patterns that lack a part of one direction."""
    return partial(soften, size)


def run() -> kit.Evidence:
    """State the smallest fault of each kind that is noticed."""
    rows = [
        case.head | {"fault": fault, "fault_unit": UNITS[fault], "smallest_noticed": size}
        for case in choose_faults()
        for fault, size in (
            *((fault, smallest(case, fault)) for fault in BODIES),
            (SOLID, smallest_of_solid(case)),
        )
    ]
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"controls": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(
            "Smallest faults noticed: "
            + "; ".join(
                f"{fault} {size:.1g} ({UNITS[str(fault)]})"
                for fault, size in table.groupby("fault", sort=False)["smallest_noticed"]
                .max()
                .items()
            )
            + ".",
        ),
    )


def choose_faults() -> list[Case]:
    """One lattice of the plane and one of space whose bodies are exact."""
    return [Case("square", "isotropic"), Case("cubic18", "isotropic")]


def smallest(case: Case, fault: str) -> float:
    """Smallest size of a body's fault that `uniform` notices."""
    row = uniform.measure(body_with(fault, PROBE), homogenise, (case, ACROSS[case.pattern.dim]))
    errors = [abs(float(str(row[f"{name}_error"]))) for name in ("pull", "across", "shear")]
    return PROBE * uniform.EXACT / max(errors)


def smallest_of_solid(case: Case) -> float:
    """Smallest part of a direction that `solids` misses."""
    found, _ = solids.measure(solid_with(PROBE), case)
    return PROBE * solids.CLOSED / float(str(found["closed_form_error"]))
