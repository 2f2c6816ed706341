"""Refinement: what does it cost to have a linear solution right to the last digit?

Question   How many corrections does a linear equilibrium take, which part of its time are they, and
           is the answer right: does twice the stored energy equal the work of the load?
Candidate  `equilibrium`, "linear": a factor, and residuals summed spring by spring.
Reference  The same tangent, factor and softest motion with one solve and no correction, timed in
           turn; Clapeyron's theorem, 2 Σ k stretch² / 2 = F·u.
Expected   An ordinary body takes one correction, at most 15 % of its solution. A body 4,000 cells
           long takes a few: its factor alone is 0.8 % off.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.judging.evidence import Evidence, Observed, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import square
from msvalidate.network import Configuration, Network, internal_force
from msvalidate.problem import Array, Box, Isotropic, Problem, Support, Traction
from msvalidate.statics.equilibrium import Equilibrium
from msvalidate.tangent.inverse import Solver

from . import bodies
from .timing import QUICK_ROUNDS, ROUNDS, Act, in_turn

Linear = Callable[[Network], Equilibrium]

NODES, QUICK_NODES = 25_600, 2_500
"""Of the plate: 1e5 springs."""
LENGTH, QUICK_LENGTH = 4_000, 1_000
"""Cells along the long body, one across."""
LOAD = 1e-9
"""End load of the long body over E t: its strain is LOAD times 6 LENGTH at the most."""
TOLERANCES = (
    Tolerance(
        "corrections of an ordinary body", 0.0, "1",
        "its factor is wrong by some eps times a condition of 1e5: the first correction brings "
        "that to its square, below the rounding of doubles",
    ),
    Tolerance(
        "2 Σ energy over work - 1, plate", 1e-12, "1",
        "an identity of exact answers; stretches are differences of displacements that are rounded "
        "to 1e-16, over 160 cells, and rest lengths are rounded by as much",
    ),
    Tolerance(
        "2 Σ energy over work - 1, long body", 1e-8, "1",
        "an identity of exact answers; the rounding of rest lengths, 1e-16 of a diagonal, turns "
        "with the body and counts by the square of its length over its height, 2e-9",
    ),
)  # fmt: skip
COLUMNS = {
    "body": "plate, clamped on one side, sheared on the other; or a row of cells bent by its end",
    "points": "of the network",
    "springs": "springs of the network",
    "solution_cpu_seconds": "of a linear equilibrium: median of the rounds (s)",
    "one_solve_cpu_seconds": "of tangent, factor, softest motion and one solve (s)",
    "refinement_part_here": "of the solution's time that is neither of these (1)",
    "corrections_here": "made by the same inverse after the first solve",
    "error_here": "largest of the displacement that it states, over the largest one (1)",
}


def run(linear: Linear, setting: Setting) -> Evidence:
    """Time both ways, and hold the answers to their energy."""
    shown = {
        "plate": bodies.lattice(QUICK_NODES if setting.quick else NODES),
        "long body": long_body(QUICK_LENGTH if setting.quick else LENGTH),
    }
    rounds = QUICK_ROUNDS if setting.quick else ROUNDS
    rows, observed = [], {}
    for name, network in shown.items():
        found = linear(network)
        rows.append({"body": name, **describe_refinement(linear, network, found, rounds)})
        observed[f"2 Σ energy over work - 1, {name}"] = Observed(unbalanced_force(network, found))
    plate = linear(shown["plate"])
    observed["corrections of an ordinary body"] = Observed(float(plate.iterations - 1), 1.0)
    table = pd.DataFrame(rows)
    part = float(table["refinement_part_here"].iloc[0])
    said = (
        f"Refinement is {100 * part:.0f} % of the linear solution of a plate of "
        f"{table['springs'].iloc[0]} springs."
    )
    return Evidence(
        tables={"refinement": table},
        observed=observed,
        tolerances=TOLERANCES,
        columns=COLUMNS,
        findings=(said,),
    )


def describe_refinement(
    linear: Linear, network: Network, found: Equilibrium, rounds: int
) -> dict[str, Any]:
    """What the table says of a network."""
    acts: dict[str, Act] = {"all": partial(linear, network), "one": partial(one_solve, network)}
    laps = in_turn(acts, rounds)
    whole, alone = (float(np.median([one.cpu for one in laps[name]])) for name in acts)
    return {
        "points": len(network.points),
        "springs": len(network.springs),
        "solution_cpu_seconds": whole,
        "one_solve_cpu_seconds": alone,
        "refinement_part_here": 1 - alone / whole,
        "corrections_here": found.iterations - 1,
        "error_here": found.error,
    }


def one_solve(network: Network) -> Array:
    """Displacement (n, d) in m by the tangent's factor alone, without prescribed displacements."""
    x = network.points
    load = internal_force(network, x) + network.force
    move = np.zeros(network.points.size)
    free = ~network.held.ravel()
    found = Solver(network, "direct").regular(Configuration(network))
    move[free] = found.inverse.solve(load.ravel()[free])
    return move.reshape(x.shape)


def unbalanced_force(network: Network, found: Equilibrium) -> float:
    """Σ k stretch² over the work of the load, less 1: 0 of an unstressed network at rest."""
    unit = network.vector / np.linalg.norm(network.vector, axis=1)[:, None]
    i, j = network.springs.T
    u = found.displacement
    stretch = ((u[j] - u[i]) * unit).sum(axis=1)
    return float(network.stiffness @ stretch**2 / np.vdot(network.force, u)) - 1


def long_body(cells: int) -> Network:
    """A row of square cells, held at one end and bent at the other."""
    box = Box((float(cells), 1.0))
    problem = Problem(
        box,
        Isotropic(E=1.0, nu=1 / 3),
        (Support(box.side("left"), (0.0, 0.0)),),
        (Traction(box.side("right"), (0.0, -LOAD)),),
    )
    return lattice_network(problem, square(box, (cells, 1)))


def solve_unrefined(network: Network) -> Equilibrium:
    """A linear equilibrium that is not refined, for the negative control."""
    move = one_solve(network)
    x = network.points
    return Equilibrium(move, x + move, np.zeros_like(move), 0.0, 2, error=0.0)
