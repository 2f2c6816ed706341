"""Springs of a case, or anybody's displacements, beside elasticity: numbers, words and a budget."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cached_property

import numpy as np

from msvalidate.case.advice import Advice
from msvalidate.case.body_advice import advise_body
from msvalidate.case.case import Case
from msvalidate.case.fracture import break_springs
from msvalidate.case.large import converge_case
from msvalidate.case.mesh_springs import MeshSprings, compare_on_mesh
from msvalidate.case.quantities import NotCompared, Row, compare_quantities
from msvalidate.case.springs import (
    ROUNDING,
    SpringAnswer,
    SpringLimit,
    compared_points,
    displacements_at,
    limit_of,
    solve_finer,
)
from msvalidate.case.supports import held_as
from msvalidate.constants.homogenise import homogenise
from msvalidate.lattice import CutLattice, Lattice, PatternLattice
from msvalidate.lattice.cut import bridged_gaps
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Anisotropic,
    Array,
    Mesh,
    Problem,
    ProblemError,
    SolverError,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.statics.equilibrium import equilibrium
from msvalidate_check.words import AGREES, DIFFERS, agreement
from reference_fem.converged import Reference, converge

COARSE, OTHER_MATERIAL, NOT_TOLD = "coarse", "another material", "not told"
"""Why springs differ: their spacing, or what they are at any spacing, or either."""


@dataclass(frozen=True, eq=False)
class Comparison:
    """A case's springs beside elasticity.

    Parameters
    ----------
    case
        What was asked.
    points
        (p, d) in m, where displacements are compared.
    springs
        On the lattice asked for, then on finer ones.
    support
        (p, d) in m: what supports that no line of the lattice runs along add to the springs asked
        for; 0 where there are none (`supports.held_as`).
    limit
        What the springs close in on, without that.
    reference
        Elasticity at the points.
    homogenised
        The same of the material that the springs are, where constants were given; else None.
    rows
        A row a quantity.
    kind
        Why springs differ, "" where they do not.
    notes
        What was not found, and why.
    on_mesh
        Springs on the body's own mesh, where it has one.
    """

    case: Case
    points: Array
    springs: tuple[SpringAnswer, ...]
    support: Array
    limit: SpringLimit
    reference: Reference
    homogenised: Reference | None
    rows: tuple[Row, ...]
    kind: str
    notes: tuple[str | NotCompared, ...]
    on_mesh: MeshSprings | None = None

    @property
    def displacement(self) -> Array:
        """Displacement (p, d) in m of the springs asked for, at the points."""
        return self.springs[0].at(self.points)

    @property
    def first_order(self) -> Array:
        """Displacement (p, d) in m of elasticity to first order, at the points."""
        large = self.reference.large
        return self.reference.displacement.value - (0.0 if large is None else large[0])

    @property
    def size(self) -> float:
        """Largest displacement (m) of elasticity at the points."""
        return max_length(self.reference.displacement.value)

    @property
    def relative(self) -> Array:
        """Length (p,) of springs - elasticity over the largest displacement."""
        away = self.displacement - self.reference.displacement.value
        return np.asarray(np.linalg.norm(away, axis=1) / (self.size or 1.0))

    @cached_property
    def advice(self) -> tuple[Advice, ...]:
        """The springs asked for, an entry a material."""
        return advise_body(self.case, self.springs[0])


def compare_case(case: Case, progress: Callable[[str], None] = lambda _: None) -> Comparison:
    """Solve a case with springs and with elements and compare them.

    Parameters
    ----------
    case
        What is asked.
    progress
        Told what is being done.

    Raises
    ------
    ProblemError
        If lattice, supports, loads and material do not go together, or a point lies outside.
    SolverError
        If there is no trustworthy answer.
    """
    require_type("compare", case, Case)
    progress("springs")
    answers = solve_finer(case)
    if case.fracture is not None:
        progress("springs that break")
        one, constants = answers[0], answers[0].calibration or case.constants or ()
        of = one.network, case.problem, str(case.lattice), constants, one.spacing
        answers = (replace(one, growth=break_springs(case.fracture, *of)), *answers[1:])
    points = compared_points(case, answers[0].lattice)
    values = displacements_at(answers, points)
    answers = answers[: len(values)]
    progress("elements")
    reference = converge_case(case, points)
    if not max_length(reference.displacement.value):
        raise ProblemError("case: nothing moves the body at these points; give a load")
    homogenised, notes = _homogenised(case, answers[0], points)
    support = _support(case, answers, homogenised or reference)
    limit = limit_of(answers, [u - part for u, part in zip(values, support, strict=True)])
    rows, more = compare_quantities(case, answers[0], reference, progress)
    if isinstance(case.problem.domain, Mesh):
        progress("springs on the mesh")
    on_mesh, why = compare_on_mesh(case, reference, len(answers[0].lattice.points))
    remarks: tuple[str | NotCompared, ...] = (*notes, *more, *([why] if why else []))
    bridged = say_bridged(answers[0].lattice)
    kind = NOT_TOLD if bridged else _kind_of_error(case, limit, reference)
    given = (answers, support[0], limit, reference, homogenised, rows, kind, remarks)
    return Comparison(case, points, *given, on_mesh)


def _support(case: Case, answers: tuple[SpringAnswer, ...], body: Reference) -> list[Array]:
    """What supports off the lattice's lines add to displacements (p, d) in m of each lattice."""
    found, room = [], ROUNDING * max_length(body.displacement.value)
    for answer in answers:
        other, lattice = None, answer.lattice
        if isinstance(lattice, CutLattice):
            other = held_as(case.problem, lattice, answer.network, body.finest.at, room)
        if other is None:
            found.append(np.zeros(body.points.shape))
        else:
            less = replace(answer, rest=equilibrium(other, case.geometry)).at(body.points)
            found.append(answer.at(body.points) - less)
    return found


def _homogenised(
    case: Case, springs: SpringAnswer, points: Array
) -> tuple[Reference | None, list[str]]:
    """Elasticity of the material that given constants make, and why there is none."""
    if case.constants is None:
        return None, []
    if case.problem.contacts:
        return None, ["material of the springs: not sought beside an obstacle"]
    lattice, law = springs.lattice, case.problem.material
    if not isinstance(lattice, PatternLattice):
        return None, ["material of the springs: not known for this lattice"]
    try:
        tensor = homogenise(lattice.pattern, case.constants, springs.spacing).tensor.copy()
        d = case.problem.domain.dim
        tensor[:d, :d] += case.volume
        scale = law.thickness if d == 2 else 1.0
        other = Anisotropic(tensor / scale, law.density, law.thickness)
        problem = Problem(
            case.problem.domain, other, case.problem.supports, case.problem.loads, case.name
        )
        return converge(problem, points, case.accuracy, memory=case.memory), []
    except (ProblemError, SolverError) as error:
        return None, [f"material of the springs: not found: {error}"]


def say_bridged(lattice: Lattice) -> str:
    """A sentence where springs join what the body does not, "" elsewhere."""
    found = bridged_gaps(lattice) if isinstance(lattice, CutLattice) else np.empty((0, 2))
    if not len(found):
        return ""
    x, y = found[0]
    return (
        "Springs bridge a gap of the body that is narrower than their cells, "
        f"the first of {len(found)} at ({x:.4g}, {y:.4g}) m: take a smaller spacing."
    )


def _kind_of_error(case: Case, limit: SpringLimit, reference: Reference) -> str:
    """Whether springs would agree on finer lattices, never, or one cannot tell."""
    wanted = reference.displacement.value
    size = max_length(wanted)
    if not size:
        return ""
    left = max_length(limit.displacement - wanted) / size
    uncertainty = limit.uncertainty / size + reference.error
    word = agreement(left, uncertainty, case.band) if math.isfinite(uncertainty) else ""
    return {AGREES: COARSE, DIFFERS: OTHER_MATERIAL}.get(word, NOT_TOLD)
