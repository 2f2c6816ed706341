"""What large displacements change of the elastic bodies: of their own law, and of the springs'."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

import reference_fem
from msvalidate import kit
from msvalidate.case.springs.large import elements_in_full, lattice_law
from msvalidate.springs.lattice.patterns import all_patterns
from reference_fem.large_strain import st_venant_kirchhoff

from . import elastic, load_cases
from .load_cases import CASES, THICKNESS, Body
from .measuring import sizes
from .models import MODELS, Model, homogenised

BLOCK, BAR = 10, 5
"""Cells on 1 m of the coarser of two meshes of quadratic elements. Triangles are no smaller at
corners: where these are pressed there would soon be no equilibrium."""
LEFT = 1 / 3
"""Of the change between the two meshes, what the finer leaves at order 2."""
NOTCHES = 40
"""Fineness of the zigzag body that stands for finer ones: of what shear changes, the most of all
cases, 2e-3, 1e-3 and 4e-4 of the displacement went from 5 to 10, 20 and 40."""


@dataclass(frozen=True, eq=False)
class Large:
    """What displacements (q, 2) at probes change by, over the target's length there (1).

    `springs`: of the lattice's law at finite strain, homogenised; `target`: of the target's, St
    Venant and Kirchhoff's. `uncertainty`: (q, 2) of either.
    """

    springs: kit.Array
    target: kit.Array
    uncertainty: kit.Array


Bodies = dict[tuple[str, Model, int], Large]
"""(case, model, fineness) -> what changes."""


def solve(setting: kit.Setting) -> Bodies:
    """Every body of the study, each once."""
    alike = {
        (case, model, n): (case, model, min(body[0], NOTCHES))
        for case in CASES
        for model in MODELS
        for body in elastic.bodies(case, model.lattice, sizes(setting, model.lattice))
        for n in body
    }
    asked = list(dict.fromkeys(alike.values()))
    found = dict(zip(asked, setting.sweep(change, asked, "large displacements"), strict=True))
    return {key: found[own] for key, own in alike.items()}


def change(asked: tuple[str, Model, int]) -> Large:
    """What large displacements change of one body."""
    case, model, fineness = asked
    shape = load_cases.body(model.lattice, case, fineness)
    probes, pattern = np.array(list(shape.probes.values())), all_patterns()[model.lattice]()
    springs = lattice_law(pattern, model.constants, shape.spacing, THICKNESS)
    if isinstance(shape.domain, kit.Polygon) and case != "bending":
        springs = replace(springs, vectors=springs.vectors[:, ::-1])  # blocks have rows along y
    found = []
    meshes = [mesh(case, shape, times) for times in (1, 2)]
    for material, law in (
        (homogenised(model), lambda _: springs),
        (model.target, st_venant_kirchhoff),
    ):
        problem = load_cases.problem(case, shape, material)
        linear = [reference_fem.solve_problem(problem, each) for each in meshes]
        found.append([elements_in_full(problem, each, probes, law) for each in linear])
    (coarse, own), (before, target) = found
    off = LEFT * np.maximum(np.abs(own - coarse), np.abs(target - before))
    size = np.linalg.norm(linear[-1].at(probes), axis=1, keepdims=True)
    return Large(own / size, target / size, off / size)


def mesh(case: str, shape: Body, times: int) -> reference_fem.Discretisation:
    """Mesh of a body, that many times as fine as the coarser one."""
    cells = BAR if case == "bending" else BLOCK
    if isinstance(shape.domain, kit.Polygon):
        parts = times * max(1, round(cells * shape.spacing))
        return reference_fem.polygon_discretisation(shape.domain, shape.spacing / parts)
    return elastic.mesh(case, shape, times * cells)
