"""Controls: which faults does the study notice, by which quantity, and how small may they be?

Question   Every fault that it must notice, on either lattice; and the smallest one of each kind.
Candidate  The spring network with one known fault.
Reference  The study's own identities and its observed order.
Expected   Identities notice parts in 1e8. An order needs two sizes and no exact answer, and sees
           tenths of a percent: a softer network first shows *smaller* errors and too high an order.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.network import faults

from . import identities, load_cases, orders
from .elastic import Bodies
from .models import ISOTROPIC, homogenised
from .orders import SMOOTH, SMOOTH_ERROR

Fault = Callable[[kit.Problem, kit.Network, float], kit.Network]


def _of_network(fault: Callable[[kit.Network, float], kit.Network]) -> Fault:
    return lambda _, network, size: fault(network, size)


KINDS: dict[str, Fault] = {
    "stiffness of every spring": _of_network(faults.stiffen_all),
    "one spring": _of_network(faults.weaken_one_spring),
    "boundary weights": _of_network(faults.stiffen_boundary),
    "traction": faults.lump_tractions,
}
UNITS = {
    "stiffness of every spring": "relative",
    "one spring": "part missing",
    "boundary weights": "part of the way from shared to equal",
    "traction": "part of the way from consistent to equal forces",
}
ASKED = {
    "every spring 1 % stiffer": ("stiffness of every spring", 0.01),
    "every spring 0.1 % softer": ("stiffness of every spring", -0.001),
    "every spring 0.2 % softer": ("stiffness of every spring", -0.002),
    "one spring missing": ("one spring", 1.0),
    "wrong boundary weights": ("boundary weights", 1.0),
    "traction lumped equally": ("traction", 1.0),
}
"""What the study must notice: name -> kind of fault and its size."""
CASE = "shear"
"""Loads a whole side: of the middle fifth on 6 x 6 particles, lumped forces are the consistent."""
PROBE = 1e-6
"""Size of the fault from which the smallest that an identity notices is extrapolated."""
STEPS = tuple(m * 10.0**-e for e in range(4, 0, -1) for m in (1, 2, 5))
"""Sizes tried on the order, which does not grow in proportion to the fault."""
FINENESSES = (10, 20)
IDENTITY = 1e-9


def _unnoticed(rows: pd.DataFrame) -> int:
    """Faults that no quantity of a lattice notices."""
    return int((~(rows["noticed"] == "yes").groupby([rows["fault"], rows["lattice"]]).any()).sum())


RULES = (
    kit.Rule(
        "faults that the study must notice and does not", 0.0, "1",
        "a study that cannot fail proves nothing", table="controls", value=_unnoticed,
    ),
)  # fmt: skip
Measure = Callable[[kit.DisplacementSolver], float]


def apply_fault(
    kind: str,
    size: float,
    problem: kit.Problem,
    network: kit.Network,
    answer: kit.Answer = "linear",
) -> kit.Array:
    """A candidate whose network has a fault."""
    return kit.solve_springs(problem, KINDS[kind](problem, network, size), answer)


def candidate_with(kind: str, size: float) -> kit.DisplacementSolver:
    """The spring network with a fault of some kind and size."""
    return partial(apply_fault, kind, size)


def run(bodies: Bodies) -> kit.Evidence:
    """Try every fault on every quantity."""
    quantities: list[tuple[str, str, Measure, float]] = [
        ("square", "order, two-sided pressure", partial(order_error, bodies), SMOOTH_ERROR),
        ("square", "pure bending", bending_error, IDENTITY),
        ("square", "uniform tension", partial(identities.uniform_tension, cells=5), IDENTITY),
        ("triangular", "P1 identity", p1_error, IDENTITY),
    ]
    rows = []
    for fault, (kind, size) in ASKED.items():
        for lattice, quantity, measure, limit in quantities:
            error = measure(candidate_with(kind, size))
            row: dict[str, object] = {"fault": fault, "kind": kind, "fault_unit": UNITS[kind]}
            row |= {"size": size, "lattice": lattice, "quantity": quantity, "error": error}
            row |= {"limit": limit, "noticed": "yes" if error > limit else "no"}
            rows.append(row | {"smallest_noticed": smallest(kind, np.sign(size), measure, limit)})
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"controls": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def smallest(kind: str, sign: float, measure: Measure, limit: float) -> float | str:
    """Smallest size of a fault that a quantity notices."""
    if limit == IDENTITY:
        rounding = measure(kit.solve_springs)
        grown = measure(candidate_with(kind, sign * PROBE)) - rounding
        size = PROBE * limit / grown if grown > rounding else np.inf
        return float(size) if size <= 1 else "none"
    for size in STEPS:
        if measure(candidate_with(kind, sign * size)) > limit:
            return size
    return "none"


def order_error(bodies: Bodies, candidate: kit.DisplacementSolver) -> float:
    """Largest distance of the two-sided case's observed orders from what they should be."""
    case = "two-sided pressure"
    errors = []
    for n in FINENESSES:
        shape = load_cases.body("square", case, n)
        problem = load_cases.problem(case, shape, homogenised(ISOTROPIC))
        network = lattice_network(problem, shape.grid(), ISOTROPIC.constants)
        move = candidate(problem, network, "linear")
        at = shape.at_probes(network.points)
        errors.append((move[at] - bodies[case, ISOTROPIC, n][0].at_probes).ravel())
    found = [
        orders.order(a, b, FINENESSES[1] / FINENESSES[0]) for a, b in zip(*errors, strict=True)
    ]
    # Errors that change sign or hardly fall show no order: it counts as 0.
    return max(abs((0.0 if isinstance(o, str) else o) - SMOOTH) for o in found)


def bending_error(candidate: kit.DisplacementSolver) -> float:
    """Error of EI_eff/EI of a beam four cells high."""
    nu = ISOTROPIC.target.nu
    exact = 1 + (2 - nu) / (1 + nu) / 4**2
    return abs(identities.bending_stiffness(candidate, 4) - exact)


def p1_error(candidate: kit.DisplacementSolver) -> float:
    """Difference of a sheared triangular network to P1 elements."""
    return identities.against_p1(candidate, CASE)[1]


def finding(table: pd.DataFrame) -> str:
    """How fine the study's net is."""
    sizes = pd.to_numeric(table["smallest_noticed"], errors="coerce")
    best = sizes.groupby(table["kind"]).min()
    return "Smallest faults noticed: " + "; ".join(
        f"{kind} {size:.1g} ({UNITS[str(kind)]})" for kind, size in best.items()
    )
