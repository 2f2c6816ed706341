"""The set's own answers: elements on meshes each twice as fine, closed in on, with their errors."""

from __future__ import annotations

import tempfile
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np

from cases.make.answer import Answer
from cases.make.meshes import (
    QUADRATIC,
    coarsest_nodes,
    facets_of,
    graded_lines,
    lines,
    no_longer,
    quadratic_mesh,
)
from cases.make.statements import STRESS, Statement
from msvalidate.case.file.building import read_case
from msvalidate.linear_algebra.factor import has_cholmod
from msvalidate.problem import SHAPES, Isotropic, Mesh, Problem, Zone
from reference_fem.body import nodal_forces, solve_problem
from reference_fem.converged import Reference, converge
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation
from reference_fem.richardson import Estimate

Array = np.ndarray
MOST_NODES = {2: 120_000, 3: 100_000}
MOST_MIXED = 18_000
"""The same of elements with a pressure of their own in space, whose factors fill up."""
MIXED_FROM = 0.46
"""Ratio from which displacement and pressure are sought together: below, quadratic cells do."""
CURVED_HALVINGS = 3
"""Of a curved body's grid, before the reference begins."""
ROUNDING = 1e-9
"""Of the forces on the body, what sums of nodal forces are known to: a reaction may be 0."""
ON_CURVES = 1e-8
"""Of each value of a curved body: how far parabolas of two degrees are from an arc (α⁴/24)."""
RATIO_STEP = 1e-3
"""Half the step of the central difference by Poisson's ratio; less near 1/2."""
MOST_NODES_FOR_SLOPE = {2: 40_000, 3: 20_000}


def problem_of(
    statement: Statement, nu: float, mesh: tuple[Array, Array, str] | None = None
) -> Problem:
    """The problem that a statement's case file asks at a ratio; on a mesh of its own, if given."""
    with tempfile.TemporaryDirectory() as folder:
        if statement.sides is not None:
            own = mesh if mesh is not None else body_mesh(statement)
            write_msh(Path(folder) / "body.msh", statement, *own)
        path = Path(folder) / "case.toml"
        path.write_text(statement.case_file(nu), encoding="utf-8")
        return read_case(path).problem


def body_mesh(statement: Statement, halvings: int = 0) -> tuple[Array, Array, str]:
    """Quadratic cells of the body itself, on its curves."""
    points, cells = quadratic_mesh(statement.grid, lines(statement.grid, halvings))
    return points, cells, QUADRATIC[statement.dim]


def _curved_start(statement: Statement) -> tuple[Array, Array, str]:
    """Cells that are small beside the body's curves, and crowd where stress is singular."""
    fine = lines(statement.grid, CURVED_HALVINGS)
    columns = [
        no_longer(graded, float(np.diff(even).max())) if ends else even
        for even, graded, ends in zip(
            fine, graded_lines(statement.grid), statement.grid.sharp, strict=True
        )
    ]
    return (*quadratic_mesh(statement.grid, columns), QUADRATIC[statement.dim])


def write_msh(path: Path, statement: Statement, points: Array, cells: Array, shape: str) -> None:
    """A mesh with its named sides as a Gmsh file (2.2, text)."""
    sides = facets_of(points, cells, shape, statement.sides)
    blocks, tags = [], []
    names = {"body": np.array([1, statement.dim])}
    for number, (name, facets) in enumerate(sides.items(), 2):
        blocks.append((SHAPES[shape].facet.name, facets))
        tags.append(np.full(len(facets), number))
        names[name] = np.array([number, statement.dim - 1])
    blocks.append((shape, cells))
    tags.append(np.ones(len(cells), dtype=int))
    space = np.column_stack([points, np.zeros((len(points), 3 - points.shape[1]))])
    mesh = meshio.Mesh(
        space + 0.0,
        blocks,
        cell_data={"gmsh:physical": tags, "gmsh:geometrical": tags},
        field_data=names,
    )
    meshio.write(path, mesh, file_format="gmsh22", binary=False, float_fmt=".15g")


def first_mesh(statement: Statement, problem: Problem, *, mixed: bool) -> Discretisation:
    """The mesh that the reference starts from: lines crowd where stress is singular."""
    if statement.sides is not None:
        assert isinstance(problem.domain, Mesh)  # noqa: S101
        return mesh_discretisation(problem.domain)
    points, cells = quadratic_mesh(statement.grid, graded_lines(statement.grid, finer=mixed))
    return mesh_discretisation(Mesh(points, cells, QUADRATIC[statement.dim]))


def solve(statement: Statement, nu: float, most: int | None = None) -> tuple[Reference, Array]:
    """Elements on finer and finer meshes, and the named points."""
    curved = _curved_start(statement) if statement.sides is not None else None
    problem = problem_of(statement, nu, curved)
    points = coarsest_nodes(statement.grid)
    mixed = nu >= MIXED_FROM and statement.state != STRESS
    if most is None:
        most = MOST_MIXED if mixed and statement.dim == 3 else MOST_NODES[statement.dim]
    first = first_mesh(statement, problem, mixed=mixed)
    solver = "cholmod" if has_cholmod() and not mixed and statement.dim == 3 else "auto"
    found = converge(
        problem, points, 1e-9, most_nodes=most, first=first, mixed=mixed, solver=solver
    )
    return found, points


def slope_by_ratio(reference: Reference, nu: float) -> Array:
    """∂u/∂nu (p, d) in m by a central difference on one of the meshes."""
    problem = reference.problem
    most = MOST_NODES_FOR_SLOPE[problem.domain.dim]
    fine = [s for s in reference.solutions if len(s.body.points) <= most] or [
        reference.solutions[0]
    ]
    step = min(RATIO_STEP, (0.5 - nu) / 2)
    found = []
    for other in (nu + step, nu - step):
        moved = with_ratio(problem, other)
        mixed = fine[-1].pressure is not None
        found.append(solve_problem(moved, fine[-1].body, mixed=mixed).at(reference.points))
    return np.asarray((found[0] - found[1]) / (2 * step))


def with_ratio(problem: Problem, nu: float) -> Problem:
    """The same problem, all of its materials of another ratio."""

    def changed(law: object) -> Isotropic:
        assert isinstance(law, Isotropic)  # noqa: S101
        return replace(law, nu=nu)

    zones = tuple(Zone(zone.region, changed(zone.material)) for zone in problem.zones)
    return replace(problem, material=changed(problem.material), zones=zones)


def largest_added(each: Estimate) -> float:
    """Largest part that extrapolation added; the last mesh's uncertainty if it added none."""
    return float(np.abs(each.added).max(initial=0.0)) or float(np.max(each.uncertainty))


def answer_of(statement: Statement, nu: float) -> Answer:
    """What the elements say of a statement at one ratio."""
    reference, _ = solve(statement, nu)
    values: dict[str, Estimate] = {
        f"reaction {i + 1}": each for i, each in enumerate(reference.reactions)
    }
    values["strain energy"] = reference.energy
    values["mean stress"] = reference.mean_stress
    u = reference.displacement
    found = np.array(u.extrapolated)
    floors = _floors(reference)
    uncertainty = {
        name: max(largest_added(each), floors.get(name.split()[0], 0.0))
        for name, each in values.items()
    }
    uncertainty["displacement"] = largest_added(u)
    if statement.sides is not None:
        values["displacement"] = u
        for name in uncertainty:
            uncertainty[name] += ON_CURVES * float(np.abs(values[name].value).max())
        del values["displacement"]
    return Answer(
        found,
        -found if reference.problem.loads else np.zeros_like(found),
        slope_by_ratio(reference, nu),
        {name: np.array(each.extrapolated) for name, each in values.items()},
        uncertainty,
        float(u.order),
        len(reference.finest.body.points),
    )


def _floors(reference: Reference) -> dict[str, float]:
    """What rounding leaves of reactions (N) and of mean stresses (Pa), however small they are."""
    problem, body = reference.problem, reference.finest.body
    force = float(np.abs(nodal_forces(problem, body)).sum())
    if not force:  # supports move the body: its reactions are the size of its forces
        force = float(max(np.abs(each.value).max() for each in reference.reactions))
    longest = max(high - low for low, high in problem.domain.span)
    volume = problem.domain.volume * problem.material.thickness
    return {"reaction": ROUNDING * force, "mean": ROUNDING * force * longest / volume}
