"""Changes of displacements at large strain, of elements and of springs."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from msvalidate.case.file.case import Case
from msvalidate.case.springs.lattice_springs import SpringAnswer
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Array,
    Material,
    Problem,
    ProblemError,
    SolverError,
    prescribed_displacements,
)
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import ALIKE
from msvalidate.springs.constants.zones import calibrate_zones
from msvalidate.springs.lattice import Constants, Pattern, PatternLattice
from reference_fem.body import Solution, nodal_forces
from reference_fem.contact import converge_contact
from reference_fem.converged import LargeChange, Reference, converge
from reference_fem.large_strain.by_cell import laws_of, neo_hookean, st_venant_kirchhoff
from reference_fem.large_strain.equilibrium import deform
from reference_fem.large_strain.hyperelastic import Fibres, Law, NeoHookean
from reference_fem.large_strain.solid import Solid
from reference_fem.mesh.discretisation import Discretisation

LawOf = Callable[[Material], Law]
BY_NAME: dict[str, LawOf] = {
    "st-venant-kirchhoff": st_venant_kirchhoff,
    "neo-hookean": neo_hookean,
}
LARGE_NODES = 5_000
"""Nodes of the finest mesh on which large displacements are sought."""


def converge_case(case: Case, points: Array, first: Discretisation | None = None) -> Reference:
    """Elasticity of a case at points (p, d) in m, to first order or in full, as it asks.

    `first` is the first mesh, if it is made already. Raises what `converge` raises and, of a case
    that is nonlinear, `change_in_full`.
    """
    if case.problem.contacts:
        return converge_contact(case.problem, points, case.accuracy)
    found = converge(case.problem, points, case.accuracy, memory=case.memory, first=first)
    if case.geometry == "linear":
        return found
    return replace(found, large=change_in_full(found, BY_NAME[case.law]))


@dataclass(frozen=True, eq=False)
class NonlinearAnswer:
    """Change by large displacements of the target's law and of the springs', as far as they exist.

    Parameters
    ----------
    target, springs
        None if there is none, or if the springs' was not requested.
    why
        Reason why the first of them is None.
    failure
        The error of an equilibrium that was sought and is missing; None if none is missing.
    """

    target: LargeChange | None = None
    springs: LargeChange | None = None
    why: str = ""
    failure: SolverError | None = None


def answer_in_full(
    case: Case, reference: Reference, springs_change: Callable[[], LargeChange] | None = None
) -> NonlinearAnswer:
    """Equilibria in full that a reference to first order is compared with; none is raised."""
    target, own = reference.large, None
    try:
        if target is None:
            target = change_in_full(reference, BY_NAME[case.law])
        own = springs_change() if springs_change else None
    except ProblemError as error:
        return NonlinearAnswer(target, why=str(error))
    except SolverError as error:
        return NonlinearAnswer(target, why=str(error), failure=error)
    return NonlinearAnswer(target, own)


def change_in_full(reference: Reference, law: LawOf) -> LargeChange:
    """Compute the change by large displacements at a reference's points.

    On the finest of its meshes, up to `LARGE_NODES`, that has an equilibrium: at corners that are
    pressed a finer one may have none. It may be off by what the next coarser one has other. Raises
    what `elements_in_full` raises of the coarsest mesh.
    """
    found: list[Array] = []
    no_finer: SolverError | None = None
    for solution in reversed(reference.solutions_up_to(LARGE_NODES)):
        nodes = f"{len(solution.body.points):,}"
        report_step("large displacements, mesh of %s nodes", nodes)
        try:
            found.append(elements_in_full(reference.problem, solution, reference.points, law))
        except SolverError as error:
            if solution is reference.solutions[0] and not found:
                raise
            no_finer = no_finer or error
            continue
        if len(found) == 2:
            return LargeChange(found[0], max_length(found[0] - found[1]), no_finer)
    return LargeChange(found[0], math.inf, no_finer)


def elements_in_full(problem: Problem, linear: Solution, points: Array, law: LawOf) -> Array:
    """Change of elasticity's displacement (p, d) in m due to large displacements.

    Parameters
    ----------
    problem, linear
        What is asked, with loads that keep size and direction as the springs' do, and its solution
        to first order on a mesh.
    points
        (p, d) in m, in the body.
    law
        Material -> law at finite strain, whose tangent at rest is the material's.

    Raises
    ------
    ProblemError
        If the law is none for the material, there is an obstacle, or displacement and pressure were
        sought together.
    SolverError
        If no equilibrium is found.
    """
    if problem.contacts:
        raise ProblemError("large displacements: against obstacles none are sought")
    if linear.pressure is not None:
        raise ProblemError(
            "large displacements: of nearly incompressible bodies none are sought; take nu below "
            "0.45, or geometry 'linear'"
        )
    body = linear.body
    held, moved = prescribed_displacements(problem, body.points)
    solid = Solid(body, laws_of(problem, body, law), held, problem.material.thickness)
    full = deform(solid, moved, nodal_forces(problem, body))
    return np.asarray(full.at(points) - linear.at(points))


def springs_law(case: Case, springs: SpringAnswer) -> LawOf:
    """The law that the springs of a case are at finite strain, of each of its materials.

    Raises `ProblemError` if it is not known for the lattice.
    """
    lattice, problem = springs.lattice, case.problem
    if case.route == "neo-Hookean":  # what the network itself is made of, per thickness
        t, each = problem.material.thickness, calibrate_zones(problem, lattice, route=case.route)
        laws: list[Law] = [
            NeoHookean(one.pressure / t, one.volume / t, problem.domain.dim) for one in each
        ]
    elif not isinstance(lattice, PatternLattice):
        raise ProblemError("the law of these springs is not known")
    else:
        pattern, a = lattice.pattern, springs.spacing
        constants = [(case.constants, case.volume)]
        if case.constants is None:
            each = calibrate_zones(problem, pattern, spacing=a, route=case.route)
            constants = [(one.constants, one.volume) for one in each]
        t = problem.material.thickness
        laws = [lattice_law(pattern, k, a, t, volume) for k, volume in constants if k is not None]
    number = {material: i for i, material in enumerate(problem.materials)}
    return lambda material: laws[number.get(material, 0)]


def lattice_law(
    pattern: Pattern, k: Constants, spacing: float, thickness: float, volume: float = 0.0
) -> Fibres:
    """An endless lattice of linear springs at finite strain, whose points follow as a whole.

    Parameters
    ----------
    pattern, k, spacing
        What repeats, its constants (N/m) a kind, and the length (m) of its unit.
    thickness
        In m, 1 of a solid.
    volume
        κ of cells: N/m in the plane, Pa in space.

    Raises
    ------
    ProblemError
        If points move inside a cell where it is strained, so that it is no such law.
    """
    solid = homogenise(pattern, k, spacing)
    if np.abs(solid.affine - solid.tensor).max() > ALIKE * np.abs(solid.affine).max():
        raise ProblemError(f"points of {pattern.name} move inside its cells: no law is known")
    cell = math.prod(pattern.size) * spacing ** len(pattern.size) * thickness
    return Fibres(spacing * pattern.vectors, pattern.stiffness(k), cell, volume / thickness)
