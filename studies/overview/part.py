"""One part, every model: what error does a spring buy, and what does it cost beside elements?

Question   A block of 1 m by 1 m in plane strain, Poisson's ratio 0.4, clamped on one side and
           sheared on the other, as a rubber mount is. How far is each spring model from elasticity,
           how does that fall with the number of springs and with the time spent, and what do
           elements do?
Candidate  The spring network's linear equilibrium.
Reference  scikit-fem: quadratic elements graded to the clamped corners, on two meshes.
Expected   Springs that are the material fall like linear elements, in the end with twice the
           exponent of the clamped corner. Springs that are another material stop at that
           material's distance, however many there are: central springs at that of a ratio of 1/3.

The couplings of an element mesh are its pairs of nodes that share an element: what springs are in a
network. Times are from the problem to the displacement: lattice or mesh, assembly, solution.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial
from itertools import combinations
from statistics import median

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.springs.constants.stiffness import isotropic_moduli
from msvalidate.springs.lattice import square
from msvalidate_check.verdict import NOT_ASKED
from reference_fem.body import nodal_forces
from reference_fem.elasticity import elastic_tensor

from . import part_drawing
from .models import BLOCK, CENTRAL, ISOTROPIC, MATERIAL, NU, SPRINGS, VOLUME, problem

ACROSS, QUICK_ACROSS = (5, 10, 20, 40, 80), (5, 10, 20)
"""Cells, or mean spacings, across the part."""
QUADRATIC, QUICK_QUADRATIC = (2, 4, 8, 16, 32), (2, 4, 8)
"""The same of quadratic elements, which have two intervals of nodes to a cell."""
GRADING = 3.0
MESH, QUICK_MESH = 32, 16
"""Elements across of the reference's finer mesh."""
REPEATS, QUICK_REPEATS = 5, 3
"""Random networks are drawn anew each time; of errors and times the median counts."""
INSIDE = 1 - 1e-9
LINEAR, QUADRATIC_ELEMENTS = ("P1 elements", "Q1 elements"), "Q2 elements"
ROUNDING = {
    "error": 1e-9,
    "error_range": 1e-9,
    "deflection_error": 1e-9,
    "reference_error": 1e-9,
    "order": 1e-5,
    "own_error": 1e-9,
    "own_ratio": 1e-9,
}
"""Of a displacement: rounding times the condition of the finest graded mesh, 1e-16 x 1e7."""
ONE_PERCENT = 0.01
TOLD = 20
WORDS = {
    "never": "no number",
    "finer": "more than tried",
    "coarser": "fewer than tried",
}
STALLED = 0.5
"""An order below it, between the two finest sizes: more springs do not bring the error down."""
Found = tuple[kit.Array, kit.Array, float, int]
"""Points (n, 2) in m, their displacement (n, 2) in m, the work of the load (J), and couplings."""
Answer = Callable[[int, int], Found]
"""Cells across, and which draw -> what was found."""


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Errors, couplings and times of each model at each size."""
    sizes = QUICK_ACROSS if setting.quick else ACROSS
    fewer = QUICK_QUADRATIC if setting.quick else QUADRATIC
    repeats = QUICK_REPEATS if setting.quick else REPEATS
    truth = reference(setting.quick)
    found = []
    for model, answer in models(candidate).items():
        for across in fewer if model == QUADRATIC_ELEMENTS else sizes:
            found.append(measure(model, answer, across, truth, repeats))
    table = pd.DataFrame(found)
    lines = table.groupby("model", sort=False)
    own = {str(each): own_solid(each.solid, setting.quick) for each in SPRINGS}
    fitted = pd.DataFrame([fit(str(model), rows, own) for model, rows in lines])
    other = reference(setting.quick, CENTRAL).work / truth.work - 1
    return kit.Evidence(
        tables={"part": table, "part_orders": fitted},
        tolerances=judge(table, fitted, other),
        figures={"part": part_drawing.draw},
        columns=kit.columns(__file__),
        findings=findings(table, fitted),
    )


@dataclass(frozen=True, eq=False)
class Reference:
    """The elastic part, on a mesh and on one with half as many cells."""

    fine: reference_fem.Solution
    coarse: reference_fem.Solution
    work: float

    def at(self, points: kit.Array) -> kit.Array:
        """Displacement (n, 2) in m."""
        return self.fine.at(points)

    def error(self, points: kit.Array) -> float:
        """How far the two meshes are from each other, over the norm."""
        fine = self.fine.at(points)
        return float(np.linalg.norm(fine - self.coarse.at(points)) / np.linalg.norm(fine))


@cache
def reference(quick: bool, material: kit.Isotropic = MATERIAL) -> Reference:
    """The elastic part, by quadratic elements graded to the corners."""
    across = QUICK_MESH if quick else MESH
    fine, coarse = (elements("Q2", n, GRADING, material) for n in (across, across // 2))
    return Reference(fine, coarse, work_of_elements(fine, material))


def elements(
    name: str, across: int, grading: float = 1.0, material: kit.Material = MATERIAL
) -> reference_fem.Solution:
    """The part by elements."""
    mesh = reference_fem.box_discretisation(BLOCK, across, name, grading=grading)
    return reference_fem.solve_problem(problem(material), mesh)


def work_of_elements(found: reference_fem.Solution, material: kit.Isotropic = MATERIAL) -> float:
    """Work of the load (J): twice the strain energy."""
    force = nodal_forces(problem(material), found.body)
    return float((force * found.displacement).sum())


def models(candidate: kit.DisplacementSolver) -> dict[str, Answer]:
    """Every model of the part, springs first."""
    found: dict[str, Answer] = {
        str(each): partial(solve_springs, candidate, each.network) for each in SPRINGS
    }
    for name in (*LINEAR, QUADRATIC_ELEMENTS):
        found[name] = partial(solve_elements, name.partition(" ")[0])
    return found


def solve_springs(
    candidate: kit.DisplacementSolver,
    build: Callable[[int, int], kit.Network],
    across: int,
    draw: int,
) -> Found:
    """Points, displacement, work of the load and springs of a network at rest."""
    network = build(across, draw)
    u = candidate(problem(), network, "linear")
    return network.points, u, float((network.force * u).sum()), len(network.springs)


def solve_elements(name: str, across: int, _draw: int) -> Found:
    """Nodes, displacement, work of the load and couplings of elements."""
    found = elements(name, across)
    return (
        found.body.points,
        found.displacement,
        work_of_elements(found),
        couplings(found.body.cells),
    )


def couplings(cells: kit.Index) -> int:
    """Pairs of nodes that share an element."""
    pairs = np.concatenate([cells[:, pair] for pair in combinations(range(cells.shape[1]), 2)])
    return len(np.unique(np.sort(pairs, axis=1), axis=0))


def measure(
    model: str, answer: Answer, across: int, truth: Reference, repeats: int
) -> dict[str, object]:
    """One row: the median of a model's draws at one size, timed."""
    errors, works, links, seconds, own = [], [], [], [], []
    for draw in range(repeats):
        started = time.perf_counter()
        points, u, work, count = answer(across, draw)
        seconds.append(time.perf_counter() - started)
        # At the corners of the loaded side the shear ends in a jump: every model has order 1 there.
        probed = points[:, 0] < INSIDE
        exact = truth.at(points[probed])
        errors.append(float(np.linalg.norm(u[probed] - exact) / np.linalg.norm(exact)))
        works.append(work)
        links.append(count)
        own.append(truth.error(points[probed]))
    return {
        "model": model,
        "across": across,
        "couplings": int(median(links)),
        "error": median(errors),
        "error_range": max(errors) - min(errors),
        "deflection_error": median(works) / truth.work - 1,
        "reference_error": max(own),
        "solve_seconds": median(seconds),
    }


def own_solid(solid: kit.Array, quick: bool) -> dict[str, float]:
    """How far an elastic part of a tensor (3, 3) in N/m is off, at points of squares; its ratio."""
    law, points = kit.Anisotropic(solid / MATERIAL.thickness), square(BLOCK, QUICK_MESH).points
    points = points[points[:, 0] < INSIDE]
    exact = reference(quick).at(points)
    apart = elements("Q2", QUICK_MESH, GRADING, law).at(points) - exact
    error = float(np.linalg.norm(apart) / np.linalg.norm(exact))
    return {"own_error": error, "own_ratio": isotropic_moduli(solid).nu}


def fit(
    model: str, rows: pd.DataFrame, own: Mapping[str, Mapping[str, float]]
) -> dict[str, object]:
    """A model's order, its own solid's error and ratio, and what 1 % takes."""
    order = kit.observed_order(1 / rows["across"], rows["error"])
    needed = reach(ONE_PERCENT, rows["across"], rows["error"], rows["couplings"])
    solid = own.get(model, dict.fromkeys(("own_error", "own_ratio"), NOT_ASKED))
    return {"model": model, "order": order, **solid, "to_one_percent": needed}


def reach(error: float, across: ArrayLike, errors: ArrayLike, costs: ArrayLike) -> float | str:
    """Cost at which an error is reached, by its line in logarithms, or why it is at no size.

    `across`, `errors` and `costs` are of rising sizes; "never" is said where an order below
    `STALLED` between the last two says that more do not help.
    """
    n, seen, paid = (np.asarray(values, float) for values in (across, errors, costs))
    if seen[0] <= error:
        return "coarser"
    if seen[-1] > error:
        return "never" if kit.observed_order(1 / n[-2:], seen[-2:]) < STALLED else "finer"
    last = int(np.argmax(seen <= error))
    part = slice(last - 1, last + 1)
    logs = np.interp(-np.log(error), -np.log(seen[part]), np.log(paid[part]))
    return float(np.exp(logs))


def extrapolate(rows: pd.DataFrame) -> float:
    """Deflection over the reference's in the limit of three sizes, each twice the one before."""
    a, b, c = 1 + rows["deflection_error"].to_numpy()[-3:]
    return float(c - (c - b) ** 2 / (c - 2 * b + a))  # Aitken: errors that fall as a power


def judge(table: pd.DataFrame, fitted: pd.DataFrame, other: float) -> tuple[kit.Tolerance, ...]:
    """What the tolerances judge, in their order; `other` is the reference's with ratio 1/3."""
    own = {str(model): rows.reset_index(drop=True) for model, rows in table.groupby("model")}
    factor = np.log(own[str(VOLUME)]["error"] / own["Q1 elements"]["error"])
    order = fitted.set_index("model")["order"]
    corner = 2 * clamped_free_exponent(elastic_tensor(MATERIAL), np.pi / 2)
    return (
        kit.Tolerance(
            "springs with volume energy over Q1 elements on the same cells: error, worst factor",
            2.5, "1",
            "both are of second order before the corner shows; bent, a row of N cells is too stiff "
            "by 1.25/N^2 of springs and by about half of that of Q1",
            layer="agreement",
            observed=kit.Observed(float(np.exp(np.abs(factor).max())), 1.0),
        ),
        kit.Tolerance(
            "springs with volume energy: deflection extrapolated, over the reference's, less 1",
            3e-3, "1",
            "errors of three sizes fall as a power; what is left of 1 % at 20 cells is a tenth or "
            "two of it, as the power still changes from 2 towards the corner's",
            observed=kit.Observed(extrapolate(own[str(VOLUME)]) - 1),
        ),
        kit.Tolerance(
            "central springs: deflection extrapolated, over that of elements of their ratio, less "
            "1",
            3e-3, "1", "as with the volume energy",
            observed=kit.Observed(extrapolate(own[str(ISOTROPIC)]) / (1 + other) - 1),
        ),
        kit.Tolerance(
            "Q2 elements: order of the displacement error less twice the exponent of the corner",
            0.25, "1",
            "the fit is over three to five sizes, and the smooth part of the error, of order 4, is "
            "up to a quarter of the whole on the coarsest",
            observed=kit.Observed(float(order[QUADRATIC_ELEMENTS]), corner),
        ),
        kit.Tolerance(
            "uncertainty of the reference over the smallest error that it judges", 0.5, "1",
            "a difference is resolved where the reference moves it by less than half",
            observed=kit.Observed(float((table["reference_error"] / table["error"]).max())),
        ),
    )  # fmt: skip


def findings(table: pd.DataFrame, fitted: pd.DataFrame) -> tuple[str, ...]:
    """What each model reaches at 20 cells across, and what 1 % takes."""
    told = table[table["across"] == TOLD].set_index("model")
    said = "; ".join(f"{model} {100 * row['error']:.2g} %" for model, row in told.iterrows())
    needed = fitted.set_index("model")["to_one_percent"]
    counts = "; ".join(
        f"{model} {value:,.0f}" if isinstance(value, float) else f"{model} {WORDS[value]}"
        for model, value in needed.items()
    )
    return (
        f"How far off a block of Poisson's ratio {NU:g} is with {TOLD} cells across: {said}.",
        f"Springs, or pairs of nodes, that an error of 1 % takes: {counts}.",
    )
