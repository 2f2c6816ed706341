"""The reference: elastic bodies under the load cases by finite elements, and their uncertainty."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np

import reference_fem
from msvalidate import kit

from . import load_cases
from .load_cases import CASES, FIFTH, HIGH, LENGTH, LOW, Body
from .measuring import sizes
from .models import MODELS, Model, homogenised

ACCURACY = {"square": 1e-4, "triangular": 1e-3}
"""Largest accepted uncertainty at a probe, relative to the displacement there. A zigzag edge has a
re-entrant corner at every second point, which costs the reference its order."""
QUICK_ACCURACY = 1.5e-3
"""The same of the small form on any body: its lattices are further off by ten times as much."""
COARSEST = {"square": 5, "triangular": 1}
"""Mesh to start from: cells on a side, or level of refinement, inside and towards the corners."""
FINEST = {"square": 160, "triangular": 8}
GRADING = 2.0
"""Mesh lines crowd to corners and to the ends of loads, where stresses are singular or jump."""
TRIANGLES = {"block": 10, "bar": 5}
"""Triangle sides on 1 m of the coarsest mesh, at least, before refinement towards corners."""
FINE_INSIDE, LEFT_INSIDE = 80, 1e-5
"""Triangle sides on 1 m beyond which only corners are refined, and what more of them would change
of a probe's displacement: 8e-6 from 40 to 80, on the coarsest blocks."""


@dataclass(frozen=True)
class Question:
    """One elastic body to solve: its case, material, and the lattices' points to sample it at.

    The finenesses must name one body: see `bodies`. `accuracy`: largest accepted uncertainty.
    """

    case: str
    lattice: str
    material: kit.Material
    finenesses: tuple[int, ...]
    accuracy: float


@dataclass(frozen=True, eq=False)
class Elastic:
    """Displacement (m) of an elastic body.

    `at_probes`, `uncertainty`: (q, 2) by probe, in their order. `at_points`: fineness -> (n, 2) at
    the lattice's points. `trust`: the words of the estimate. `mesh`: nodes of the finest mesh.
    """

    at_probes: kit.Array
    uncertainty: kit.Array
    at_points: dict[int, kit.Array]
    trust: str
    mesh: int


Bodies = dict[tuple[str, Model, int], tuple[Elastic, Elastic]]
"""(case, model, fineness) -> the homogenised body and the target."""


def solve_reference(setting: kit.Setting) -> Bodies:
    """Solve every elastic body once, however many networks are compared with it."""
    asked: list[Question] = []
    wanted: dict[tuple[str, Model, int], tuple[int, int]] = {}
    for case in CASES:
        for model in MODELS:
            accuracy = QUICK_ACCURACY if setting.quick else ACCURACY[model.lattice]
            for finenesses in bodies(case, model.lattice, sizes(setting, model.lattice)):
                first = len(asked)
                asked.append(
                    Question(case, model.lattice, homogenised(model), finenesses, accuracy)
                )
                # Springs of an isotropic lattice are their target: one body serves as both.
                if model.is_target:
                    pair = (first, first)
                else:
                    asked.append(Question(case, model.lattice, model.target, finenesses, accuracy))
                    pair = (first, first + 1)
                wanted |= {(case, model, n): pair for n in finenesses}
    found = setting.sweep(solve, asked, "finite elements")
    return {key: (found[a], found[b]) for key, (a, b) in wanted.items()}


def bodies(case: str, lattice: str, finenesses: tuple[int, ...]) -> list[tuple[int, ...]]:
    """Finenesses that share a body: all of them, but a zigzag edge is a body of its own."""
    shape = load_cases.body(lattice, case, finenesses[0])
    zigzag = isinstance(shape.domain, kit.Polygon) and len(shape.domain.reentrant)
    return [(n,) for n in finenesses] if zigzag else [finenesses]


def solve(question: Question) -> Elastic:
    """Refine until the displacement at every probe is known well enough; then sample it."""
    shape = load_cases.body(question.lattice, question.case, question.finenesses[0])
    problem = load_cases.problem(question.case, shape, question.material)
    probes = np.array(list(shape.probes.values()))

    @cache
    def on_mesh(level: int) -> reference_fem.Solution:
        return reference_fem.solve_problem(problem, mesh(question.case, shape, level))

    coarsest = COARSEST[question.lattice]
    size = np.linalg.norm(on_mesh(coarsest).at(probes), axis=1, keepdims=True)
    estimate = reference_fem.refine(
        lambda level: (on_mesh(level).at(probes) / size).ravel(),
        coarsest,
        question.accuracy,
        finest=FINEST[question.lattice],
    )
    best, before = on_mesh(estimate.cells), on_mesh(estimate.cells // 2)
    # An order that three meshes suggest may be too good: count on no less than the last change, nor
    # on less than the inside of a mesh of triangles leaves.
    last = np.abs(best.at(probes) - before.at(probes))
    if question.lattice == "triangular":
        last = np.maximum(last, LEFT_INSIDE * size)
    grids = [load_cases.body(question.lattice, question.case, n) for n in question.finenesses]
    return Elastic(
        at_probes=best.at(probes),
        uncertainty=np.maximum(estimate.uncertainty.reshape(-1, 2) * size, last),
        at_points={
            n: best.at(grid.grid().points)
            for n, grid in zip(question.finenesses, grids, strict=True)
        },
        trust=", ".join(sorted(set(estimate.status))),
        mesh=len(best.body.points),
    )


def mesh(case: str, shape: Body, level: int) -> reference_fem.Discretisation:
    """Mesh of a body: cells per side of a box, or level of refinement of an outline's corners."""
    if isinstance(shape.domain, kit.Polygon):
        triangles = TRIANGLES["bar" if case == "bending" else "block"]
        most = max(1, int(FINE_INSIDE * shape.spacing))
        parts = min(level * int(np.ceil(triangles * shape.spacing)), most)
        steps = int(np.log2(level))
        return reference_fem.polygon_discretisation(
            shape.domain,
            shape.spacing / parts,
            towards=singular_places(case, shape),
            depth=2 + 2 * steps,
            rings=1 + steps,
        )
    if case == "bending":
        mid, half = LENGTH / 2, FIFTH / 2
        through: tuple[tuple[float, ...], ...] = ((mid - half, mid + half), ())
        return reference_fem.box_discretisation(
            shape.domain, (int(LENGTH) * level, level), "Q2", GRADING, through=through
        )
    # Points that are held inside the body must be nodes.
    through = ((LOW,), (LOW, HIGH)) if case == "two-sided pressure" else ((), (LOW, HIGH))
    return reference_fem.box_discretisation(shape.domain, level, "Q2", GRADING, through=through)


def singular_places(case: str, shape: Body) -> kit.Array:
    """Re-entrant corners, and where supports and loads end (p, 2)."""
    if not isinstance(shape.domain, kit.Polygon):
        raise TypeError("a box is graded towards its corners")
    asked = CASES[case]
    ends = [
        shape.places[name].corners(shape.domain.span) for name in (*asked.loads, *asked.supports)
    ]
    return np.unique(np.round(np.concatenate([shape.domain.reentrant, *ends]), 12), axis=0)
