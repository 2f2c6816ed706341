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
from functools import partial
from pathlib import Path
from typing import Any

import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.case.file.building import build_case
from msvalidate.case.file.reading import parse_source
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.zones import calibrate_zones
from msvalidate.springs.lattice import Lattice, fill, mesh_lattice, patterns
from msvalidate_check import ElasticCase, FieldVerdict, case_names, check, elastic_case
from msvalidate_check.case_set import case_facts

from . import frozen_drawing

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


def _of_uniform_stress(rows: pd.DataFrame) -> pd.Series:
    """Errors of the bodies of uniform stress, 0 of all others."""
    body = rows["case"].str.replace(r"_(plane_stress|plane_strain|space)$", "", regex=True)
    return rows["error"].where(body.isin(UNIFORM), 0.0)


ELEMENTS = tuple(f"FEM {shape}{order}" for shape in "PQTH" for order in (1, 2))
frozen = partial(kit.Rule, unit="1", table="frozen_cases")
RULES = (
    frozen(
        "frozen cases of uniform stress: largest error of elements, of the largest displacement",
        1e-9, rows={"model": ELEMENTS}, value=_of_uniform_stress,
        because="elements of every kind hold uniform strain: left is rounding times a condition",
    ),
    frozen(
        "frozen cases of uniform stress: largest error of lattices with shared springs", 1e-9,
        rows={"model": SHARED}, value=_of_uniform_stress,
        because="a lattice that shares its boundary springs holds uniform tension at any size",
    ),
    frozen(
        "frozen cases up to nu = 0.45: quadratic elements on the finest mesh that differ", 0,
        rows={"model": ELEMENTS[1::2], "size": tuple(f"{kind}_2" for kind in SHAPES)},
        value=lambda rows: ((rows["verdict"] == "differs") & (rows["nu"] <= LOCKING)).sum(),
        because="eight cells across and more: what they miss next to clamps is far below the band "
        "of 5 %",
    ),
    frozen(
        "frozen cases in the plane: largest error of springs at 1/32 m", BAND, layer="agreement",
        rows={"model": SHARED, "size": f"{1 / 32:g}"}, value="error",
        because="a block is 12 cells across, a beam 8: spacing costs its square, (1/8)^2 = 1.6 %, "
        "and clamps as much again",
    ),
)  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
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
    return kit.Evidence(
        tables={"frozen_cases": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={"frozen_cases": frozen_drawing.frozen_cases},
    )


def _ratios(name: str, setting: kit.Setting) -> list[float]:
    return [nu for nu in case_facts(name)["ratios"] if nu in RATIOS[setting.quick]]


def problem_of(case_file: str, nu: float) -> kit.Problem:
    """The problem that a case file asks, at a ratio of its own."""
    lines = [f"nu = {nu:g}" if line[:5] == "nu = " else line for line in case_file.splitlines()]
    return build_case(parse_source("frozen case", "\n".join(lines), Path())).problem


def _rows(
    candidate: kit.DisplacementSolver, name: str, nu: float, problem: kit.Problem
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


def _lattice(problem: kit.Problem, spacing: float) -> Lattice:
    domain = problem.domain
    assert isinstance(domain, kit.Box)  # noqa: S101
    pattern = patterns.square() if domain.dim == 2 else patterns.cubic18()
    return fill(pattern, domain, tuple(round(side / spacing) for side in domain.size))


def _mesh_rows(
    candidate: kit.DisplacementSolver, case: ElasticCase, problem: kit.Problem
) -> Iterator[dict[str, Any]]:
    """Elements on a mesh of a case, and springs on its edges."""
    kind = case.mesh.partition("_")[0]
    mesh = kit.Mesh(case.points, case.cells, SHAPES[kind])
    for element in (None, QUADRATIC[kind]):
        body = reference_fem.mesh_discretisation(mesh, element)
        model = f"FEM {body.element.name}"
        try:
            move = reference_fem.solve_problem(problem, body, allow_locked=True).at(case.points)
        except kit.ProblemError:
            continue
        yield _row(model, case.mesh, check(case, None, move, band=BAND, accuracy=ROUNDING))
    if not problem.zones:
        asked, law = replace(problem, domain=mesh), problem.material
        assert isinstance(law, kit.Isotropic)  # noqa: S101
        network = lattice_network(asked, mesh_lattice(mesh), (law.E * law.thickness,))
        yield _row(
            EDGES,
            case.mesh,
            check(case, None, candidate(asked, network, "linear"), band=BAND, accuracy=ROUNDING),
        )


def _row(model: str, size: str, verdict: FieldVerdict) -> dict[str, Any]:
    parts = {name.replace(" ", "_"): float(part) for name, part in verdict.parts.items()}
    return {
        "model": model,
        "size": size,
        "error": verdict.error,
        "error_uncertainty": verdict.uncertainty,
        **parts,
        "verdict": verdict.word,
    }
