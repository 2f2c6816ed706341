"""Cost: how much work is it to bring a body of each lattice to rest?

Question   Steps of viscous relaxation to a displacement error of 1e-6, and steps times springs a
           point, of the clamped body at one size.
Candidate  Leapfrog with the damping that is critical for the slowest mode, at 0.9 of its limit.
Reference  The network's own equilibrium by Newton's method. Steps by prediction: the slowest mode
           is left with (1 + s) exp(-s) after s/omega_min, in steps of 0.9 times 2/omega_max.
Expected   As predicted: what a lattice costs is its springs a point, times the ratio of its
           highest frequency to the body's lowest, which its stiffness and spacing decide. The
           highest is not quite the endless lattice's: points of edges and corners share their
           mass, and ring higher. Where no spring crosses a side the body is a sum of cells, and
           nothing in it is faster than one cell alone (Irons).
"""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pandas as pd
from scipy.linalg import eigvalsh

from msvalidate import kit
from msvalidate.bench.judging.counting import predict_steps
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Run
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.lattice import fill
from msvalidate.springs.network import tangent
from msvalidate.springs.statics.equilibrium import equilibrium

from . import cases, edges, loading
from .cases import Case, Solid

ACROSS = {2: 16, 3: 4}
"""Cells along an edge, about, by the number of axes."""
METHOD = RELAXATIONS["viscous_leapfrog"]
ERROR = 1e-6
"""Of the displacement, relative to the largest, at which steps are counted."""
AT_REST = 1e-12
"""Tolerance of a run, far below what the error needs: the error ends it."""
LOOK_EVERY = 2
RULES = (
    kit.Rule(
        "steps to rest over the prediction from frequencies, worst", 0.05, "1",
        "the prediction is of the slowest mode alone, as if it were the whole displacement; a look "
        "is taken at every second of 120 steps or more",
        table="cost", value=kit.Quotient("steps", "steps_predicted"), reference=1.0,
    ),
    kit.Rule(
        "highest frequency of a body beyond that of one cell alone, relative", 1e-9, "1",
        "energy and mass of the body are sums over cells that are alike, so no quotient of "
        "sums is beyond that of one; left is rounding",
        table="cost", value=lambda rows: np.maximum(
            0.0, rows["highest_over"] / cases.numbers("cell_over")(rows) - 1
        ).max(),
    ),
)  # fmt: skip


def run(solid: Solid, setting: kit.Setting, endless: pd.DataFrame) -> kit.Evidence:
    """Count steps to rest, and judge them; `endless` is the table `solids`."""
    table = measure_costs(solid, setting, endless)
    return kit.Evidence(
        tables={"cost": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=findings(table),
    )


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """Which lattice is the cheapest, and which the dearest, of each size of body."""
    said = []
    for cells, rows in table.groupby("cells"):
        ranked = rows.sort_values("work_of_body", kind="stable")
        least, most = ranked.iloc[0], ranked.iloc[-1]
        said.append(
            f"To rest at {cells} cells: {least['lattice']}, {least['rule']}, takes the least work, "
            f"{least['steps']} steps of {least['springs_a_point']:.0f} springs a point; "
            f"{most['lattice']}, {most['rule']}, the most, {most['steps']} of "
            f"{most['springs_a_point']:.0f}. Bodies are of unequal accuracy: this is the work at "
            "one size, not for one error."
        )
    said.append(
        "Edges and corners ring above the endless lattice, by up to "
        f"{table['highest_over'].max() - 1:.0%} on {len(table)} bodies: its frequency alone is no "
        "safe step."
    )
    return tuple(said)


def measure_costs(solid: Solid, setting: kit.Setting, endless: pd.DataFrame) -> pd.DataFrame:
    """The table `cost`."""
    fastest = endless.set_index(["lattice", "rule"])["omega2_m"]
    todo = [(case, float(fastest[case.pattern.name, case.rule])) for case in cases.stiff(solid)]
    return pd.DataFrame(setting.sweep(partial(measure, solid), todo, "steps to rest"))


def measure(solid: Solid, todo: tuple[Case, float]) -> dict[str, object]:
    """One row of the table `cost`, of a case and its endless lattice's highest m·omega²."""
    case, fastest = todo
    lattice = cases.fill_box(case, ACROSS[case.pattern.dim])
    body = cases.material(solid, case, lattice)
    size = loading.STRAIN * loading.modulus(body.C)
    problem = loading.clamped(cases.box_of(lattice), body, "shear", size)
    network = lattice_network(problem, lattice, case.constants)
    low, high = extreme_frequencies(network)
    rest = equilibrium(network, "nonlinear").displacement
    found = relax(
        network,
        METHOD,
        tolerance=AT_REST,
        watch=partial(near, rest),
        look_every=LOOK_EVERY,
        frequencies=(low, high),
    )
    pattern = case.pattern
    cell = float(np.prod(pattern.size)) * lattice.spacing**pattern.dim
    mass = body.density * cell / len(pattern.points)
    endless = math.sqrt(fastest / mass)
    springs = cases.springs_a_point(case)
    return case.head | {
        "cells": cases.cells_along(lattice),
        "points": len(lattice.points),
        "root_kappa": high / low,
        "highest_over": high / endless,
        "cell_over": "none"
        if edges.crosses(case)
        else of_one_cell(case, body, lattice.spacing) / endless,
        "steps": found.steps,
        "steps_predicted": predict_steps(high / low, ERROR),
        "springs_a_point": springs,
        "work_a_point": found.steps * springs,
        "work_of_body": found.steps * int((network.stiffness > 0).sum()),
    }


def of_one_cell(case: Case, body: kit.Anisotropic, spacing: float) -> float:
    """Highest frequency (rad/s) of a cell with nothing around it."""
    pattern = case.pattern
    box = kit.Box(tuple((spacing * np.array(pattern.size)).tolist()))
    cell = fill(pattern, box, 1)
    problem = loading.uniform(box, body, (0, 0), 0.0)
    network = lattice_network(problem, cell, case.constants)
    mass = np.repeat(network.mass, pattern.dim)
    matrix = tangent(network, network.points).toarray() / np.sqrt(np.outer(mass, mass))
    return math.sqrt(float(eigvalsh(matrix)[-1]))


def near(rest: kit.Array, run: Run) -> bool:
    """Whether a run is as near to rest as it should come."""
    return bool(abs(run.displacement - rest).max() <= ERROR * abs(rest).max())
