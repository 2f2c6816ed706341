"""Fields of the known mistakes on the body of a case, at the points of a result.

The lattice or mesh behind a result is not known; only the points are. So each mistake is solved at
a few spacings, those of the case and those that the points suggest, and a candidate may lie between
two of them. Models beyond `MAX_UNKNOWNS` are left out, and reported.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial

import numpy as np
from scipy.sparse import csr_array, eye_array
from scipy.spatial import KDTree

from msvalidate.case.file.case import Case, spacing_by_cells, spacing_of
from msvalidate.case.file.part_mesh import straighten
from msvalidate.case.file.units import quantity_text
from msvalidate.case.judge.mistakes import (
    MAX_SPACINGS,
    SPRING_MISTAKES,
    CorrectSprings,
    Path,
    Solved,
    SpringMistake,
    of_records,
    solve_mistakes,
)
from msvalidate.case.springs.lattice_springs import SpringAnswer, make_network
from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import (
    Array,
    Box,
    Isotropic,
    Load,
    Mesh,
    Polygon,
    Problem,
    ProblemError,
    SolverError,
    Weight,
    prescribed_displacements,
)
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.routes import default_constants
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate.springs.statics.equilibrium import equilibrium_at
from msvalidate_check.beside import Mistake
from reference_fem.body import nodal_forces, solve_problem
from reference_fem.converged import Reference
from reference_fem.elasticity import stiffness
from reference_fem.first_mesh import grid_lines, kept_places
from reference_fem.materials import materials_of
from reference_fem.mesh.boxes import lines_discretisation
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.from_mesh import mesh_discretisation
from reference_fem.mesh.outlines import outline_discretisation

MAX_UNKNOWNS = {2: 8_000, 3: 3_000}
"""Unknowns of a model by dimension, up to which all mistakes together take a few seconds."""
FEW_NODES = 10_000
"""Nodes of a mesh on which changes of the loads are solved: these are small themselves."""
CELLS_ACROSS = (16, 12, 10, 8, 7, 6, 5, 4, 3, 2, 1)
"""Linear elements across the narrowest side that are tried, from fine to coarse."""
SHARE_OF_GRID = 0.25
"""Minimum fraction of the crossings of a grid that are points.

The lines of the grid then belong to the points.
"""
SAME_LINE = 1e-5
"""Distance relative to a side up to which two coordinates are on one line: five digits in files."""
WHOLE = 1e-3
"""Relative difference from a whole number of cells, which rounded coordinates leave."""
SLOWNESS = (16.0, 4.0, 2.0, 1.0, 0.5, 0.25, 0.0625)
"""Pseudo-times of a relaxation, in units of the slowest motion's own."""
STEPS = (1, 8)
"""Steps of a relaxation: one damps as 1/(1 + rate·time), many as exp(-rate·time)."""


@dataclass(frozen=True, eq=False)
class Catalogue:
    """Known mistakes of a case, solved when first needed.

    Parameters
    ----------
    mistakes
        For `Field.mistakes`.
    omitted
        Sentences on models that were left out, and why; complete once the mistakes are solved.
    """

    mistakes: tuple[Mistake, ...]
    omitted: list[str]


def known_mistakes(case: Case, places: Array, reference: Reference) -> Catalogue:
    """Return the known mistakes of a case, with their fields at places (p, d) in m.

    Parameters
    ----------
    case, places
        The case, and points in its body.
    reference
        Elasticity at these points.
    """
    omitted: list[str] = []
    problem, elastic = case.problem, reference.displacement.value
    if problem.contacts:
        return Catalogue((), ["Known mistakes are not solved against an obstacle."])
    if case.geometry == "nonlinear":
        return Catalogue((), ["Known mistakes are solved to first order only."])
    made = [*_element_mistakes(problem, places, elastic, omitted)]
    made += [
        Mistake("not converged", cache(partial(_relaxing, reference, steps, omitted)))
        for steps in STEPS
    ]
    for number, load in enumerate(problem.loads, 1):
        alone = cache(partial(_load_alone, reference, load))
        heavy = isinstance(load, Weight)
        whose = "weight" if heavy else "load"
        changes = {"load sign": -2.0}
        if len(problem.loads) > 1:  # without the only one nothing moves
            changes["load missing"] = -1.0
        if heavy:
            changes["doubled mass"] = 1.0
        for kind, part in changes.items():
            path = partial(_other_load, elastic, alone, number, part)
            made.append(Mistake(kind, path, key=kind.replace("load", whose)))
        if heavy and problem.domain.dim == 2:
            path = partial(_thinner, elastic, alone)
            made.append(Mistake("thickness", path, key="thickness beside weight"))
    law = problem.material
    if isinstance(law, Isotropic) and not problem.zones:
        made += _spring_mistakes(case, law, places, elastic, omitted)
    return Catalogue(tuple(made), omitted)


# Linear elements ----------------------------------------------------------------------------------


def _element_mistakes(
    problem: Problem, places: Array, elastic: Array, omitted: list[str]
) -> Iterator[Mistake]:
    """Linear elements: each family of meshes from fine to coarse, and the mesh of the points."""
    for meshes in _families(problem, places):
        yield Mistake(
            "coarse mesh", cache(partial(_element_path, problem, places, elastic, meshes, omitted))
        )


Meshes = Sequence[tuple[float, Callable[[], tuple[Problem, Discretisation]]]]
"""Pairs of a mesh size (m) and a function that makes the mesh, with the problem that fits it."""


def _families(problem: Problem, places: Array) -> Iterator[Meshes]:
    domain = problem.domain
    narrowest = min(high - low for low, high in domain.span)
    sizes = [narrowest / cells for cells in CELLS_ACROSS]
    if isinstance(domain, Box):
        grids = [(h, grid_lines(problem, h, least=1)) for h in sizes]
        own = _lines_of(places, domain)
        alone = [(max(float(np.diff(line).max()) for line in own), own)] if own else []
        for element in ("Q1", "P1") if domain.dim == 2 else ("H1", "T1"):
            for family in filter(None, (grids, alone)):
                yield [
                    (h, lambda x=lines, e=element: (problem, lines_discretisation(x, e)))  # type: ignore[misc]
                    for h, lines in family
                ]
    elif isinstance(domain, Polygon):
        through = kept_places(problem)
        yield [
            (h, lambda h=h: (problem, outline_discretisation(domain, h, through)))  # type: ignore[misc]
            for h in sizes
        ]
    elif isinstance(domain, Mesh):
        first = int(domain.kind.degree > 1)
        yield [
            (domain.mean_edge / 2**cuts, partial(_on_file_mesh, problem, cuts))
            for cuts in (first + 1, first)
        ]


def _on_file_mesh(problem: Problem, cuts: int) -> tuple[Problem, Discretisation]:
    straight = straighten(problem, cuts)
    return straight, mesh_discretisation(straight.domain)  # type: ignore[arg-type]


def _element_path(
    problem: Problem, places: Array, elastic: Array, meshes: Meshes, omitted: list[str]
) -> Path:
    """Elasticity, then linear elements from fine to coarse."""
    path: Path = [(0.0, elastic)]
    limit = MAX_UNKNOWNS[problem.domain.dim]
    for size, make in meshes:
        try:
            own, body = make()
            if body.points.size > limit:
                continue
            u = solve_problem(own, body, allow_locked=True).at(places)
        except (ProblemError, SolverError, RuntimeError):  # no such mesh, or no factor
            continue
        path.append((size, u))
    if len(path) == 1:
        omitted.append(
            f"Linear elements are not tried: no mesh with fewer than {limit:,} unknowns."
        )
    return path


def _lines_of(places: Array, box: Box) -> list[Array] | None:
    """Coordinates (m) along each axis of the grid that points are on; None if they are on none."""
    lines = []
    for x, (low, high) in zip(places.T, box.span, strict=True):
        stops = np.unique(np.r_[low, x, high])
        apart = np.r_[True, np.diff(stops) > SAME_LINE * (high - low)]
        stops = stops[apart]
        stops[-1] = high
        lines.append(stops)
    crossings = float(np.prod([len(line) for line in lines]))
    return lines if len(places) >= SHARE_OF_GRID * crossings else None


def _relaxing(reference: Reference, steps: int, omitted: list[str]) -> Path:
    """Elasticity, then the states of a relaxation that was stopped ever earlier.

    Steps of Euler's backward method from no displacement, with equal masses: as after any
    relaxation, most of what is missing is in the slowest motions.
    """
    solution, elastic = reference.solutions[0], reference.displacement.value
    body = solution.body
    if body.points.size > 2 * MAX_UNKNOWNS[body.dim]:
        sentence = f"Unfinished relaxations are not tried: {body.points.size:,} unknowns."
        omitted += [sentence] * (sentence not in omitted)
        return []
    fixed, value = (x.T.ravel() for x in prescribed_displacements(reference.problem, body.points))
    K = csr_array(stiffness(body, materials_of(reference.problem, body)))
    free = np.logical_not(fixed)
    force = nodal_forces(reference.problem, body).T.ravel() - K @ np.where(fixed, value, 0.0)
    inner = csr_array(K[free][:, free])
    moving = factorise(inner).solve(force[free])
    slowest = float(moving @ (inner @ moving) / (moving @ moving))
    at = body.interpolation(reference.points)
    path: Path = [(0.0, elastic)]
    for time in SLOWNESS:
        rate = steps * slowest / time
        factor = factorise(csr_array(inner + rate * eye_array(len(moving))))
        lag = np.zeros(len(fixed))
        lag[free] = moving
        for _ in range(steps):
            lag[free] = factor.solve(rate * lag[free])
        missing = at @ lag.reshape(body.dim, -1).T
        path.append((float(np.linalg.norm(missing) / np.linalg.norm(elastic)), elastic - missing))
    return path


def _load_alone(reference: Reference, load: Load) -> Array:
    """Displacement (p, d) in m that one load adds to elasticity."""
    problem, solution = reference.problem, reference.solutions_up_to(FEW_NODES)[-1]
    twice = replace(problem, loads=(*problem.loads, load))
    more = solve_problem(twice, solution.body, mixed=solution.pressure is not None)
    return np.asarray(more.at(reference.points) - solution.at(reference.points))


def _other_load(elastic: Array, alone: Callable[[], Array], number: int, part: float) -> Path:
    """Elasticity with a multiple of one load, of this number from 1, added."""
    return [(number, elastic + part * alone())]


def _thinner(elastic: Array, alone: Callable[[], Array]) -> Path:
    """Other forces than the weight, a fifth and five times as large."""
    weight = alone()
    return [(part, weight + part * (elastic - weight)) for part in (0.2, 5.0)]


# Springs ------------------------------------------------------------------------------------------


def _spring_mistakes(
    case: Case, law: Isotropic, places: Array, elastic: Array, omitted: list[str]
) -> Iterator[Mistake]:
    pattern = all_patterns().get(str(case.lattice))
    plain = replace(case, constants=None, volume=0.0, fracture=None)
    heavy = any(isinstance(load, Weight) for load in case.problem.loads)
    kinds = 0 if pattern is None else pattern().kinds
    records = tuple(each for each in SPRING_MISTAKES if each.applies(kinds, heavy=heavy))
    solved = cache(partial(_solve_springs, plain, law, places, records, omitted))
    yield from of_records(records, law, solved, elastic)


def _solve_springs(
    case: Case,
    law: Isotropic,
    places: Array,
    records: Sequence[SpringMistake],
    omitted: list[str],
) -> Solved:
    solved: Solved = []
    weights = [load.acceleration for load in case.problem.loads if isinstance(load, Weight)]
    gravity = np.array([np.zeros(law.dim), *weights], dtype=float).sum(axis=0)
    for spacing in _spacings(case, places, omitted):
        try:
            problem, lattice, network, made = make_network(case, spacing)
            constants = default_constants(law, lattice) if made is None else made.constants
            springs = CorrectSprings(law, gravity, lattice, network, constants, spacing)
            answer = partial(SpringAnswer, problem, spacing, lattice)
            fields: list[Array | None] = []
            for own, u in solve_mistakes(springs, records):
                rest = None if u is None else equilibrium_at(own, u, 1, linear=True)
                fields.append(None if rest is None else answer(own, rest, made, 0.0).at(places))
            solved.append((spacing, fields))
        except (ProblemError, SolverError) as error:
            shown = quantity_text(spacing, "m", case.unit)
            omitted.append(f"Mistakes with springs at {shown} are not tried: {error}.")
    return solved


def _spacings(case: Case, places: Array, omitted: list[str]) -> list[float]:
    """Spacings (m) from fine to coarse: of the points, of the case, and half and twice these."""
    dim, domain = case.problem.domain.dim, case.problem.domain
    own, limit = spacing_of(case), MAX_UNKNOWNS[domain.dim]
    suggested = _spacing_of_points(case, places)
    tried = [own, 2 * own, 4 * own, 8 * own]
    tried = tried if suggested is None else [suggested, suggested / 2, *tried]
    spacings: list[float] = []
    for spacing in tried:
        if dim * domain.volume / spacing**dim > limit:
            omitted.append(
                f"Springs at {quantity_text(spacing, 'm', case.unit)} are not tried: more than "
                f"{limit:,} unknowns."
            )
        elif all(abs(spacing / other - 1) > SAME_LINE for other in spacings):
            spacings.append(spacing)
    return sorted(spacings[: MAX_SPACINGS[dim]])


def _spacing_of_points(case: Case, places: Array) -> float | None:
    """Spacing (m) of the case's lattice that has points at the least distance of these."""
    pattern = all_patterns().get(str(case.lattice))
    if pattern is None or len(places) < 2:
        return None
    nearest = float(KDTree(places).query(places, k=2)[0][:, 1].min())
    made = pattern()
    spacing = nearest / float(np.linalg.norm(made.vectors, axis=1).min())
    cells = spacing_by_cells(replace(case, cells=1, spacing=None)) / spacing
    whole = max(1, round(cells))
    return spacing * cells / whole if abs(cells / whole - 1) < WHOLE else spacing
