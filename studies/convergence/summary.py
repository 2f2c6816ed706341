"""Summary: a sheared plate brought to equilibrium by three relaxations and by elements.

Question   Steps and seconds to within 1 % of the equilibrium, and its difference from elasticity.
Candidate  The table of relaxations, on a square lattice with k2 = k1/2 and boundary weight 1/2.
Reference  scikit-fem's Q2 elements, refined until their own error is known.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from statistics import median

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging import counting
from msvalidate.springs.dynamics.run import Method

from . import bodies, times

BODY, CELLS = "plate", 32
ONE_PERCENT = 0.01
"""Distance from the equilibrium, relative to the largest displacement, at which steps are counted;
also the largest difference from elasticity that counts as agreement."""
METHODS = {"algorithm1": "Algorithm 1", "fire": "FIRE", "newton": "Newton"}
"""Relaxations of the summary -> words."""
MICROMETRES = 1e6


def summarise(
    candidate: Mapping[str, Method], truth: tuple[kit.Array, float], points: kit.Array, repeats: int
) -> dict[str, pd.DataFrame]:
    """Table `summary`: rows of springs by relaxation, then of linear elements.

    Parameters
    ----------
    candidate
        Name -> relaxation.
    truth, points
        Elastic displacement (q, 2) in m at the points (q, 2) in m, and its relative uncertainty.
    repeats
        Runs whose median time is taken.
    """
    move, uncertainty = truth
    at = int(np.linalg.norm(move, axis=1).argmax())
    nodes = bodies.network(BODY, CELLS).points
    nearest = int(np.linalg.norm(nodes - points[at], axis=1).argmin())
    springs = bodies.rest_displacement(BODY, CELLS)[nearest]
    mesh = reference_fem.box_discretisation(bodies.box(BODY), bodies.cells(BODY, CELLS), "Q1")
    elements = reference_fem.solve_problem(bodies.problem(BODY), mesh).at(points[at : at + 1])[0]
    row = partial(_row, move[at], uncertainty)
    rows = [
        row(words, springs, *_cost(candidate[name], repeats)) for name, words in METHODS.items()
    ]
    solve = partial(times.time_solution, BODY, CELLS, "Q1", "auto")
    seconds = median(sum(solve()) for _ in range(repeats))
    return kit.summary_tables([*rows, row("scikit-fem, Q1", elements, 1, seconds)])


def _cost(method: Method, repeats: int) -> tuple[int, float]:
    """Steps of a relaxation to within 1 % of the equilibrium, and its seconds with the set-up."""
    network, reference = bodies.network(BODY, CELLS), bodies.rest_displacement(BODY, CELLS)
    known = bodies.frequencies(BODY, CELLS)
    reached = counting.count_steps(
        method, network, known, lambda u: bodies.relative_error(u, reference), (ONE_PERCENT,)
    )
    if ONE_PERCENT not in reached:
        raise kit.SolverError(f"{method.name}: not within 1 % of the equilibrium of the {BODY}")
    steps, _ = reached[ONE_PERCENT]
    cost = {"body": BODY, "cells_y": CELLS, "method": method.name, "steps": steps}
    row = times.time_relaxation({method.name: method}, repeats, cost)
    return steps, float(row["setup_seconds"]) + float(row["wall_seconds"])  # type: ignore[arg-type]


def _row(
    truth: kit.Array, uncertainty: float, words: str, move: kit.Array, steps: int, seconds: float
) -> dict[str, object]:
    springs, reference = (MICROMETRES * float(np.linalg.norm(u)) for u in (move, truth))
    return kit.summary_row(
        words, springs, reference, uncertainty=uncertainty, tolerance=ONE_PERCENT,
        more={"steps": steps, "time_seconds": seconds},
    )  # fmt: skip
