"""Springs of a case, or anybody's displacements, beside elasticity: numbers, words and a budget."""

from __future__ import annotations

import html
import math
from collections.abc import Callable
from functools import cached_property

import numpy as np
import pandas as pd
import shapely

from msvalidate.case.advise.advice import Advice
from msvalidate.case.compare.body_advice import advise_body
from msvalidate.case.compare.quantities import NotCompared, compare_quantities, difference_row
from msvalidate.case.compare.validity import Limitation, limit_rows, limitations
from msvalidate.case.file.case import Case
from msvalidate.case.file.fracture import MOST_BREAKS, Fracture
from msvalidate.case.file.units import quantity_text
from msvalidate.case.springs.large import (
    NonlinearAnswer,
    answer_in_full,
    change_in_full,
    converge_case,
    springs_law,
)
from msvalidate.case.springs.lattice_springs import (
    ROUNDING,
    Extrapolation,
    SpringAnswer,
    compared_points,
    displacements_at,
    extrapolate,
    solve_finer,
)
from msvalidate.case.springs.mesh_springs import MeshSprings, compare_on_mesh, springs_alone
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Anisotropic,
    Array,
    Box,
    Mesh,
    Problem,
    ProblemError,
    SolverError,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.progress import report_stage, report_step
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.bodies.cut_network import support_selector
from msvalidate.springs.bodies.toughness import critical_stretch
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.lattice import CutLattice, PatternLattice
from msvalidate.springs.lattice.cut import bridged_gaps
from msvalidate.springs.lattice.outline import outline
from msvalidate.springs.lattice.patterns import all_patterns
from msvalidate.springs.network import Network
from msvalidate.springs.statics.breaking import FractureResult, propagate_crack
from msvalidate.springs.statics.equilibrium import equilibrium
from msvalidate_check.verdict import AGREES, DIFFERS, Difference, agreement
from reference_fem.converged import LargeChange, Reference, converge

COARSE, OTHER_MATERIAL, NOT_TOLD = "coarse", "another material", "not told"
"""Why springs differ: their spacing, or what they are at any spacing, or either."""
STAGES = (
    *("springs", "elements", "quantities", "springs on the mesh", "time step", "budget"),
    *("coarser springs", "pictures"),
)
"""Stages of a case, as the progress reports them; springs on a mesh are of bodies that have one."""
WITHIN = 1e-3
"""Relative distance from a nearest place to its shift into the body.

Curves are drawn by straight lines.
"""


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
        for; 0 where there are none.
    limit
        What the springs close in on, without that.
    reference
        Elasticity at the points.
    homogenised
        The same of the material that the springs are, where constants were given; else None.
    differences
        A row a quantity, by its numbers alone.
    kind
        Why springs differ, "" if they do not to within rounding.
    notes
        What was not found, and why.
    gaps
        Of each lattice, `bridged_gaps`.
    on_mesh
        Springs on the body's own mesh, where it has one.
    alone
        Difference of springs alone on the edges of that mesh, NaN without them.
    missing
        Parts of the answer that an exception removed.
    """

    case: Case
    points: Array
    springs: tuple[SpringAnswer, ...]
    support: Array
    limit: Extrapolation
    reference: Reference
    homogenised: Reference | None
    differences: tuple[Difference, ...]
    kind: str
    notes: tuple[str | NotCompared, ...]
    gaps: tuple[Array, ...]
    on_mesh: MeshSprings | None = None
    alone: float = math.nan
    missing: tuple[Limitation, ...] = ()

    @cached_property
    def rows(self) -> tuple[Difference, ...]:
        """Differences whose words hold in the range of the theory."""
        return limit_rows(self.differences, self.limitations)

    def table(self) -> pd.DataFrame:
        """Return sizes, relative differences, uncertainties and verdicts, a row per quantity."""
        return pd.DataFrame([difference_row(row) for row in self.rows])

    def _repr_html_(self) -> str:
        limits = "".join(f"<p>{html.escape(each.sentence)}</p>" for each in self.limitations)
        return self.table().to_html(index=False, border=0) + limits

    @cached_property
    def limitations(self) -> tuple[Limitation, ...]:
        """Limitations of the verdict."""
        growth = self.springs[0].growth
        return limitations(self.case, self.reference, lambda: self.nonlinear, growth, self.missing)

    @cached_property
    def nonlinear(self) -> NonlinearAnswer:
        """Changes by large displacements of the target's law and of the springs'."""

        def springs_change() -> LargeChange:
            if math.isinf(self.material_off):
                raise ProblemError("what material the springs are is not known")
            law = springs_law(self.case, self.springs[0])
            return change_in_full(self.homogenised or self.reference, law)

        return answer_in_full(self.case, self.reference, springs_change)

    @property
    def material_off(self) -> float:
        """Largest relative difference by the springs' material, plus the reference's own error.

        Infinite for springs on edges at equilibrium, and for constants without a homogenised cell.
        """
        case = self.case
        if case.at_rest_on_edges or (case.constants is not None and self.homogenised is None):
            return math.inf
        off = max_length(self.own_material - self.first_order)
        return off / self.size + self.reference.error

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
    def own_material(self) -> Array:
        """The same of the material that the springs are, if it is known; else of the one asked."""
        own = self.homogenised
        return self.first_order if own is None else own.displacement.value

    @property
    def size(self) -> float:
        """Largest displacement (m) of elasticity at the points."""
        return max_length(self.reference.displacement.value)

    @property
    def relative(self) -> Array:
        """Length (p,) of springs - elasticity over the largest displacement."""
        away = self.displacement - self.reference.displacement.value
        return np.asarray(np.linalg.norm(away, axis=1) / self.size)

    @cached_property
    def advice(self) -> tuple[Advice, ...]:
        """The springs asked for, an entry a material."""
        return advise_body(self.case, self.springs[0])


def compare_case(case: Case) -> Comparison:
    """Solve a case with springs and with finite elements, and compare the results.

    The springs are solved on the lattice of the case and on finer ones, so that discretisation
    error can be told from model error. The finite elements are refined until their error estimate
    is small.

    Parameters
    ----------
    case
        Comparison task.

    Returns
    -------
    Comparison
        One ``Difference`` per quantity in ``rows``, the displacements (p, d) in m of the springs
        and of the reference at the compared points, the cause of a difference, and limitations.

    Raises
    ------
    ProblemError
        If lattice, supports, loads and material do not fit together, a compared point lies outside
        the body, or no compared point moves.
    SolverError
        If there is no trustworthy solution.

    Examples
    --------
    >>> from msvalidate import Box, Case, Isotropic, Problem, Support, Traction, compare_case
    >>> box = Box((0.4, 0.1))
    >>> roller = Support(box.side("left"), (0.0, None))
    >>> guide = Support(box.side("bottom"), (None, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> problem = Problem(box, Isotropic(E=1e5, nu=1 / 3), supports=(roller, guide), loads=(pull,))
    >>> comparison = compare_case(Case(problem, spacing=0.05, quantities=("displacement",)))
    >>> comparison.rows[0].word, comparison.rows[0].error < 1e-9
    ('agrees', True)
    """
    require_type("compare", case, Case)
    report_stage("springs", STAGES)
    answers = solve_finer(case)
    if case.fracture is not None:
        report_step("springs that break")
        growth = break_springs(case.fracture, case, answers[0])
        answers = (replace(answers[0], growth=growth), *answers[1:])
    points = compared_points(case, answers[0].lattice)
    no_finer = [each.no_finer for each in answers if each.no_finer]
    missing = [Limitation("lattice", at, detail=why) for at, why in no_finer]
    values, not_compared = displacements_at(answers, points)
    answers = answers[: len(values)]
    report_stage("elements", STAGES)
    reference = converge_case(case, points)
    if not max_length(reference.displacement.value):
        most = quantity_text(
            float(min(np.ptp(case.problem.domain.span, axis=1))) / 4, "m", case.unit
        )
        remedy = f"a smaller spacing, such as {most}" if case.problem.loads else "a load"
        raise ProblemError(f"case: nothing moves the body at the compared points; give {remedy}")
    homogenised, notes, no_material = _homogenised(case, answers[0], points)
    notes += [f"finer lattices: not compared: {not_compared}"] if not_compared else []
    support = _support(case, answers, homogenised or reference)
    limit = extrapolate(answers, [u - part for u, part in zip(values, support, strict=True)])
    report_stage("quantities", STAGES)
    rows, more = compare_quantities(case, answers[0], reference)
    missing += [*no_material, *(Limitation("quantity", detail=str(e)) for e in more if e.failed)]
    if isinstance(case.problem.domain, Mesh):
        report_stage("springs on the mesh", STAGES)
    on_mesh, why = compare_on_mesh(case, reference, len(answers[0].lattice.points))
    remarks: tuple[str | NotCompared, ...] = (*notes, *more, *([why] if why else []))
    gaps = tuple(bridged_gaps(each.lattice) for each in answers)
    kind = NOT_TOLD if len(gaps[0]) else _kind_of_error(case, limit, reference)
    off = max_length(values[0] - reference.displacement.value)
    kind = kind if off > ROUNDING * max_length(reference.displacement.value) else ""
    given = (answers, support[0], limit, reference, homogenised, rows, kind, remarks, gaps)
    alone = springs_alone(case, reference)
    return Comparison(case, points, *given, on_mesh, alone, tuple(missing))


def break_springs(rule: Fracture, case: Case, springs: SpringAnswer) -> FractureResult:
    """Springs of a case that break as its loads are raised.

    Raises what `springs.bodies.toughness.critical_stretch` and
    `springs.statics.breaking.propagate_crack` raise, or `ProblemError` if a fracture energy is
    given of anything but one lattice of one material.
    """
    stretch = rule.critical_stretch
    if rule.G_c is not None:
        make, problem = all_patterns().get(str(case.lattice)), case.problem
        if make is None or problem.zones:
            raise ProblemError(
                f"fracture: G_c of {'several materials' if make else case.lattice}; it is for one "
                "lattice of one material, so give critical_stretch"
            )
        stretch = critical_stretch(
            make(), springs.calibration or case.constants or (), rule.G_c, spacing=springs.spacing,
            thickness=problem.material.thickness, direction=rule.direction, rule=rule.rule,
        ).critical_stretch  # fmt: skip
    assert stretch is not None  # noqa: S101  one of the two is given
    return propagate_crack(springs.network, stretch, rule.raised, most_breaks=MOST_BREAKS)


def _support(case: Case, answers: tuple[SpringAnswer, ...], body: Reference) -> list[Array]:
    """Displacements (p, d) in m per lattice due to supports off lattice lines."""
    found, room = [], ROUNDING * max_length(body.displacement.value)
    for answer in answers:
        other, lattice = None, answer.lattice
        if isinstance(lattice, CutLattice):
            other = _fixed_as(case.problem, lattice, answer.network, body.finest.at, room)
        if other is None:
            found.append(np.zeros(body.points.shape))
        else:
            less = replace(answer, rest=equilibrium(other, case.geometry)).at(body.points)
            found.append(answer.at(body.points) - less)
    return found


def _fixed_as(
    problem: Problem,
    lattice: CutLattice,
    network: Network,
    motion: Callable[[Array], Array],
    room: float,
) -> Network | None:
    """The network with supports off the lattice's lines held as a motion (n, d) -> (n, d) in m.

    Such a support, as at a bolt's hole, holds all points of the cells that it runs through at its
    own value: an error of first order in the spacing (`springs.bodies.cut_network`). Beyond the
    outline the motion is taken to go on evenly: at x = 2q - y, with q the outline's place nearest
    to x and y in the body, it is 2 u(q) - u(y). None where that is nowhere other than it is by more
    than `room` (m): of boxes, whose sides lie on lines, and of solids but for walls of prisms.
    """
    domain, x, off = problem.domain, lattice.points, np.zeros(len(lattice.points), dtype=bool)
    if isinstance(domain, Box):
        return None
    for support in problem.supports:
        off |= support_selector(lattice)(support) & ~support.region.select(x, domain.tolerance)
    try:
        side = shapely.boundary(outline(domain))
    except ProblemError:  # of no prism
        return None
    step = np.zeros(x[off].shape)
    nearest = shapely.shortest_line(shapely.points(x[off, :2]), side)
    step[:, :2] = shapely.get_coordinates(nearest)[1::2] - x[off, :2]
    inside = lattice.inside[off]
    step[inside] = 0.0
    near, far = x[off] + (1 + WITHIN) * step, x[off] + 2 * step
    known = inside | (domain.contains(near) & domain.contains(far))
    u = network.displacement[off]
    at, beyond = motion(near[known]), motion(far[known])
    u[known] = at + (1 + WITHIN) / (1 - WITHIN) * (at - beyond)  # on the line through both
    moved = network.displacement.copy()
    moved[off] = np.where(network.fixed[off], u, moved[off])
    other = np.abs(moved - network.displacement).max() > room
    return replace(network, displacement=moved) if other else None


def _homogenised(
    case: Case, springs: SpringAnswer, points: Array
) -> tuple[Reference | None, list[str], list[Limitation]]:
    """Elasticity of the material that given constants make; notes and limitations if none."""
    if case.constants is None:
        return None, [], []
    if case.problem.contacts:
        return None, ["material of the springs: not sought beside an obstacle"], []
    lattice, law = springs.lattice, case.problem.material
    if not isinstance(lattice, PatternLattice):
        return None, ["material of the springs: not known for this lattice"], []
    try:
        tensor = homogenise(lattice.pattern, case.constants, springs.spacing).tensor.copy()
        d = case.problem.domain.dim
        tensor[:d, :d] += case.volume
        scale = law.thickness if d == 2 else 1.0
        other = Anisotropic(tensor / scale, law.density, law.thickness)
        problem = Problem(
            case.problem.domain, other, case.problem.supports, case.problem.loads, case.name
        )
        return converge(problem, points, case.accuracy, memory=case.memory), [], []
    except (ProblemError, SolverError) as error:
        return None, [], [Limitation("material", detail=str(error))]


def _kind_of_error(case: Case, limit: Extrapolation, reference: Reference) -> str:
    """Classify a difference as discretisation error, model error or undetermined."""
    wanted = reference.displacement.value
    size = max_length(wanted)
    left = max_length(limit.displacement - wanted) / size
    uncertainty = limit.uncertainty / size + reference.error
    word = agreement(left, uncertainty, case.band) if math.isfinite(uncertainty) else ""
    return {AGREES: COARSE, DIFFERS: OTHER_MATERIAL}.get(word, NOT_TOLD)
