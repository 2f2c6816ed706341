"""Frozen cases: what does the set that anybody may copy say of our own springs and elements?

Question   Displacements of boxes of the set: pulled, pressed and sheared uniformly; clamped; bent;
           under their own weight; twisted; of two materials; of rubber.
Candidate  Linear equilibrium of square and cubic lattices with two boundary rules, and of springs
           on the edges of the case's own mesh.
Reference  The frozen displacements, by a closed form or by elements and a second program, each with
           its uncertainty; judged by `msvalidate_check` as anybody's would be. Beside the springs
           linear and quadratic elements on the case's meshes.
Expected   Uniform stress is exact for elements of every kind and for lattices that share springs on
           their boundary. All else closes in with the mesh, but for springs on mesh edges, whose
           material the mesh decides, and for springs that count whole on the boundary.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd

import reference_fem
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.case.building import build_case
from msvalidate.case.reading import parse_source
from msvalidate.constants.zones import calibrate_zones
from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Lattice, fill, mesh_lattice, patterns
from msvalidate.problem import Box, Isotropic, Mesh, Problem, ProblemError
from msvalidate_check import ElasticCase, Verdict, case_names, check, elastic_case
from msvalidate_check.case_set import case_facts

from . import cases, frozen_drawing

UNIFORM = ("cell_pull", "cell_pressure", "block_pull", "block_pressure")
"""Bodies of uniform normal stress; under uniform shear the corners of a cube's lattice bend."""
SPACING = {2: (1 / 16, 1 / 32), 3: (1 / 16,)}
"""Sides (m) of the lattices' cells, by the number of axes: of a block 6 and 12 across, or 4."""
BAND = 0.05
ROUNDING = 2.0**-52
"""Of our own numbers, over the largest: told, as few even numbers by chance look rounded."""
LOCKING = 0.45
"""Ratio above which elements without a pressure of their own lose accuracy."""
RATIOS = {True: (0.3, 0.4999), False: (0.0, 0.3, 0.45, 0.4999)}
"""Poisson's ratios, of those that a case has: of the small form, and all."""
SHAPES = {"tri3": "triangle", "quad4": "quad", "tet4": "tetra", "hex8": "hexahedron"}
QUADRATIC = {"tri3": "P2", "quad4": "Q2", "tet4": "T2", "hex8": "H2"}
SHARED, WHOLE, EDGES = "springs", "springs, whole on the boundary", "springs on mesh edges"
TOLERANCES = (
    Tolerance(
        "frozen cases of uniform stress: largest error of elements, of the largest displacement",
        1e-9, "1", "elements of every kind hold uniform strain: left is rounding times a condition",
    ),
    Tolerance(
        "frozen cases of uniform stress: largest error of lattices with shared springs", 1e-9, "1",
        "a lattice that shares its boundary springs holds uniform tension at any size",
    ),
    Tolerance(
        "frozen cases up to nu = 0.45: quadratic elements on the finest mesh that differ", 0, "1",
        "eight cells across and more: what they miss next to clamps is far below the band of 5 %",
    ),
    Tolerance(
        "frozen cases in the plane: largest error of springs at 1/32 m", BAND, "1",
        "a block is 12 cells across, a beam 8: spacing costs its square, (1/8)^2 = 1.6 %, and "
        "clamps as much again",
        "agreement",
    ),
)  # fmt: skip
COLUMNS = {
    "case": "case of the frozen set: body and state",
    "nu": cases.COLUMNS["nu"],
    "model": "springs on a lattice or on a mesh's edges, or elements",
    "size": "side of a lattice's cell (m), or the mesh's name",
    "error": "largest difference over the largest displacement (1)",
    "doubt": "how far elasticity and rounding leave it open, over the same (1)",
    "scale": "part of the difference that a scale of elasticity is, over the same (1)",
    "rigid_motion": "part that a rigid motion is, over the same (1)",
    "shape": "what is left of the difference, over the same (1)",
    "verdict": "agrees, differs or not resolved, within 5 %",
}


def run(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Judge springs and elements by every box of the set."""
    rows = []
    for name in case_names():
        case_file = elastic_case(name, case_facts(name)["ratios"][-1]).case_file
        if "box" not in case_file.split("[material]")[0]:
            continue  # other outlines have benchmarks of their own
        for nu in _ratios(name, setting):
            problem = problem_of(case_file, nu)
            rows += [{"case": name, "nu": nu} | row for row in _rows(candidate, name, nu, problem)]
    table = pd.DataFrame(rows)
    return Evidence(
        tables={"frozen_cases": table},
        observed=by_quantity(TOLERANCES, _observed(table)),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        figures={"frozen_cases": frozen_drawing.frozen_cases},
        rounding=dict.fromkeys(("error", "doubt", "scale", "rigid_motion", "shape"), 1e-10),
    )


def _ratios(name: str, setting: Setting) -> list[float]:
    return [nu for nu in case_facts(name)["ratios"] if nu in RATIOS[setting.quick]]


def problem_of(case_file: str, nu: float) -> Problem:
    """The problem that a case file asks, at a ratio of its own."""
    lines = [f"nu = {nu:g}" if line[:5] == "nu = " else line for line in case_file.splitlines()]
    return build_case(parse_source("frozen case", "\n".join(lines), Path())).problem


def _rows(
    candidate: DisplacementSolver, name: str, nu: float, problem: Problem
) -> Iterator[dict[str, Any]]:
    for model, weights in ((SHARED, "shared"), (WHOLE, "equal")):
        for spacing in SPACING[problem.domain.dim]:
            grid = _lattice(problem, spacing)
            each = calibrate_zones(problem, grid)
            law = each if problem.zones else each[0]
            network = lattice_network(problem, grid, law, weights=weights)
            move = candidate(problem, network, "linear")
            verdict = check(
                elastic_case(name, nu), network.points, move, band=BAND, accuracy=ROUNDING
            )
            yield _row(model, f"{spacing:g}", verdict)
    for mesh in case_facts(name)["meshes"]:
        yield from _mesh_rows(candidate, elastic_case(name, nu, mesh), problem)


def _lattice(problem: Problem, spacing: float) -> Lattice:
    domain = problem.domain
    assert isinstance(domain, Box)  # noqa: S101
    pattern = patterns.square() if domain.dim == 2 else patterns.cubic18()
    return fill(pattern, domain, tuple(round(side / spacing) for side in domain.size))


def _mesh_rows(
    candidate: DisplacementSolver, case: ElasticCase, problem: Problem
) -> Iterator[dict[str, Any]]:
    """Elements on a mesh of a case, and springs on its edges."""
    kind = case.mesh.partition("_")[0]
    mesh = Mesh(case.points, case.cells, SHAPES[kind])
    for element in (None, QUADRATIC[kind]):
        body = reference_fem.mesh_discretisation(mesh, element)
        model = f"FEM {body.element.name}"
        try:
            move = reference_fem.solve_problem(problem, body, allow_locked=True).at(case.points)
        except ProblemError:
            continue
        yield _row(model, case.mesh, check(case, None, move, band=BAND, accuracy=ROUNDING))
    if not problem.zones:
        asked, law = replace(problem, domain=mesh), problem.material
        assert isinstance(law, Isotropic)  # noqa: S101
        network = lattice_network(asked, mesh_lattice(mesh), (law.E * law.thickness,))
        yield _row(
            EDGES,
            case.mesh,
            check(case, None, candidate(asked, network, "linear"), band=BAND, accuracy=ROUNDING),
        )


def _row(model: str, size: str, verdict: Verdict) -> dict[str, Any]:
    parts = {name.replace(" ", "_"): float(part) for name, part in verdict.parts.items()}
    return {
        "model": model,
        "size": size,
        "error": verdict.error,
        "doubt": verdict.doubt,
        **parts,
        "verdict": verdict.word,
    }


def _observed(table: pd.DataFrame) -> list[Observed]:
    body = table["case"].str.replace(r"_(plane_stress|plane_strain|space)$", "", regex=True)
    uniform = body.isin(UNIFORM)
    elements = table["model"].str.startswith("FEM")
    quadratic = table["model"].str.endswith("2") & elements & table["size"].str.endswith("_2")
    shared = table["model"] == SHARED
    fine = shared & (table["size"] == f"{1 / 32:g}") & ~table["case"].str.endswith("space")
    return [
        Observed(float(table["error"][uniform & elements].max())),
        Observed(float(table["error"][uniform & shared].max())),
        Observed(
            float((table["verdict"][quadratic & (table["nu"] <= LOCKING)] == "differs").sum())
        ),
        Observed(float(table["error"][fine].max())),
    ]
