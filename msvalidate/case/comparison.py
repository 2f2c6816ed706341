"""Springs of a case, or anybody's displacements, beside elasticity: numbers, words and a budget."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import suppress
from functools import cached_property

import numpy as np

from msvalidate.bodies.cut_network import support_selector
from msvalidate.case.advice import Advice
from msvalidate.case.body_advice import advise_body
from msvalidate.case.case import Case, compared_points
from msvalidate.case.fracture import break_springs
from msvalidate.case.large import converge_case
from msvalidate.case.mesh_springs import MeshSprings, compare_on_mesh
from msvalidate.case.springs import (
    ROUNDING,
    SpringAnswer,
    SpringLimit,
    displacements_at,
    limit_of,
    solve_finer,
)
from msvalidate.case.supports import held_as
from msvalidate.constants.homogenise import homogenise
from msvalidate.judging.compare import NOT_ASKED
from msvalidate.lattice import CutLattice, Lattice, PatternLattice
from msvalidate.lattice.gaps import bridged_gaps
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import (
    Anisotropic,
    Array,
    Mask,
    Mesh,
    Problem,
    ProblemError,
    SolverError,
    Support,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, replace
from msvalidate.statics.equilibrium import equilibrium
from msvalidate.statics.stress import fitted_stress
from msvalidate_check.words import AGREES, DIFFERS, agreement
from reference_fem.body import nodal_forces
from reference_fem.converged import Reference, converge
from reference_fem.elasticity import elastic_tensor
from reference_fem.limits import CARRIES

COARSE, OTHER_MATERIAL, NOT_TOLD = "coarse", "another material", "not told"
"""Why springs differ: their spacing, or what they are at any spacing, or either."""
KNOWN_STRESS, LEAST_KNOWN = 0.5, 0.5
"""Of the band, what elasticity's stress may be off at points that count; of all, how many must."""
UNSTRAINED = 1e-14
"""Strain energy, over that of a strain as large as displacement over length, that is rounding."""
STRESS_BAND = 2.0
"""Of the band, what stress at points may differ by: it is of two displacements' difference over a
cell, each of which may use up the band."""
STRESSED_POINTS = 400
"""Points, about, at which stresses are compared: each is looked for in the elements."""
FITS_ALIKE = 0.05
"""Of a stress, what fits of two degrees may differ by. In bent blocks of triangular, BCC and FCC
lattices they did by up to 0.041 up to ratio 1/3, where the stress was off by less than 0.07, and by
more than 0.079 from ratio 0.45 on, where it was off by 0.09 to 20."""


@dataclass(frozen=True)
class Row:
    """One quantity of springs and of elasticity.

    Parameters
    ----------
    quantity, unit
        What, and its unit.
    springs, elasticity
        Sizes, in the unit.
    difference
        Of the two, over the size of elasticity's.
    uncertainty
        How far elasticity's own value may be off, on the same scale.
    verdict
        A word of `judging.compare`.
    """

    quantity: str
    unit: str
    springs: float
    elasticity: float
    difference: float
    uncertainty: float
    verdict: str


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
    notes: tuple[str, ...]
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
    rows = []
    if "displacement" in case.quantities:
        rows.append(_displacement(case, answers[0], reference))
    if reference.contact is not None:
        rows += _contact(case, answers[0], reference)
    makers = {
        "reactions": _reactions,
        "strain energy": _energy,
        "mean stress": _mean_stress,
        "point stress": _point_stress,
    }
    for name, make in makers.items():
        if name in case.quantities:
            progress(name)
            try:
                _refuse_unknown(case, reference)
                rows += make(case, answers[0], reference)
            except (ProblemError, SolverError) as error:
                notes.append(f"{name}: not compared: {error}")
                rows.append(Row(name, "", math.nan, math.nan, math.nan, math.nan, NOT_ASKED))
    if isinstance(case.problem.domain, Mesh):
        progress("springs on the mesh")
    on_mesh, why = compare_on_mesh(case, reference, len(answers[0].lattice.points))
    notes += [why] if why else []
    bridged = say_bridged(answers[0].lattice)
    kind = NOT_TOLD if bridged else _kind_of_error(case, limit, reference)
    given = (answers, support[0], limit, reference, homogenised, tuple(rows), kind, tuple(notes))
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


def _displacement(case: Case, springs: SpringAnswer, reference: Reference) -> Row:
    found, wanted = springs.at(reference.points), reference.displacement.value
    size = max_length(wanted)
    difference = max_length(found - wanted) / size if size else math.inf
    verdict = agreement(difference, reference.error, case.band)
    return Row("displacement", "m", max_length(found), size, difference, reference.error, verdict)


def _contact(case: Case, springs: SpringAnswer, reference: Reference) -> list[Row]:
    """What was not given of depth and force, the half-width and the largest pressure."""
    assert springs.contact is not None  # noqa: S101  the reference has one
    (found,), (wanted, error) = springs.contact.contacts, reference.contact
    given = case.problem.contacts[0].force
    sizes = {
        "contact half-width": ("m", found.half_width, wanted.half_width),
        "largest pressure": ("Pa", found.pressure.max(), wanted.pressure.max()),
    }
    if given is None:
        sizes = {"contact force": ("N", found.total, wanted.total)} | sizes
    else:
        sizes = {"contact depth": ("m", found.depth, wanted.depth)} | sizes
    rows = []
    for name, (unit, own, theirs) in sizes.items():
        off = abs(own / theirs - 1) if theirs else math.inf  # one node of the elements touches
        word = _word(case, off, error)
        rows.append(Row(name, unit, float(own), float(theirs), float(off), error, word))
    return rows


def _reactions(case: Case, springs: SpringAnswer, reference: Reference) -> list[Row]:
    """A row a support, over the largest of all."""
    wanted = reference.reactions
    size = max(float(np.linalg.norm(each.value)) for each in wanted)
    loads = float(np.abs(nodal_forces(case.problem, reference.solutions[0].body)).sum())
    if size <= CARRIES * loads:
        raise ProblemError("the supports carry nothing: the loads balance each other")
    left = springs.network.held.copy()
    rows = []
    for number, (support, each) in enumerate(zip(springs.problem.supports, wanted, strict=True)):
        on = _held_by(support, springs) & left
        left &= ~on
        found = springs.reaction(on)
        difference = float(np.linalg.norm(found - each.value)) / size if size else math.nan
        uncertainty = each.uncertainty / size if size else math.nan
        sizes = float(np.linalg.norm(found)), float(np.linalg.norm(each.value))
        name = f"reaction of support {number + 1}" if len(wanted) > 1 else "reaction"
        rows.append(
            Row(name, "N", *sizes, difference, uncertainty, _word(case, difference, uncertainty))
        )
    return rows


def _held_by(support: Support, springs: SpringAnswer) -> Mask:
    """Components (n, d) of points that a support holds in the network."""
    lattice, region = springs.lattice, support.region
    if isinstance(lattice, CutLattice):
        on = support_selector(lattice)(support)
    else:
        on = region.select(lattice.points, lattice.domain.tolerance)
    asked = [value is not None for value in support.displacement]
    return np.asarray(on[:, None] & np.array(asked))


def _refuse_unknown(case: Case, reference: Reference) -> None:
    """Raise where forces are not known.

    `ProblemError` of large displacements; `SolverError` where the body moves as one, so that what
    is left of forces is rounding.
    """
    if case.geometry == "nonlinear":
        raise ProblemError("to first order alone; leave it out, or take geometry 'linear'")
    if case.problem.contacts:
        raise ProblemError("not beside an obstacle; leave it out")
    domain, law = case.problem.domain, case.problem.material
    longest = max(high - low for low, high in domain.span)
    stiff = float(np.abs(elastic_tensor(law)).max()) * domain.volume * law.thickness
    bent = (max_length(reference.displacement.value) / longest) ** 2
    if abs(float(reference.energy.value[0])) <= UNSTRAINED * stiff * bent:
        raise SolverError("the body moves as one and is not strained")


def _energy(case: Case, springs: SpringAnswer, reference: Reference) -> list[Row]:
    found, wanted = springs.energy, float(reference.energy.value[0])
    difference, uncertainty = abs(found - wanted) / wanted, reference.energy.uncertainty / wanted
    return [
        Row(
            "strain energy",
            "J",
            found,
            wanted,
            difference,
            uncertainty,
            _word(case, difference, uncertainty),
        )
    ]


def _mean_stress(case: Case, springs: SpringAnswer, reference: Reference) -> list[Row]:
    found = springs.mean_stress(case.problem.material.thickness)
    wanted = reference.mean_stress
    size = float(np.abs(wanted.value).max())
    if wanted.uncertainty > size:
        raise SolverError(f"elasticity has {size:.2g} Pa, known to {wanted.uncertainty:.2g}")
    difference, uncertainty = (
        float(np.abs(found - wanted.value).max()) / size,
        wanted.uncertainty / size,
    )
    sizes = float(np.abs(found).max()), size
    return [
        Row(
            "mean stress",
            "Pa",
            *sizes,
            difference,
            uncertainty,
            _word(case, difference, uncertainty),
        )
    ]


def _point_stress(case: Case, springs: SpringAnswer, reference: Reference) -> list[Row]:
    """Root mean square over points inside, at which elasticity's own stress is known well enough.

    Next to corners no mesh knows it, and cells that an outline cuts have none of the body's.
    """
    if case.problem.zones:
        raise ProblemError("the body is of several materials, whose stresses jump between them")
    at, found = _stress_inside(case, springs)
    wanted, uncertainties = reference.stress(at)
    size = float(np.sqrt((wanted**2).sum(axis=1).mean()))
    known = uncertainties <= KNOWN_STRESS * case.band * size
    if known.mean() >= LEAST_KNOWN:
        found, wanted, uncertainties = found[known], wanted[known], uncertainties[known]

    def mean(values: Array) -> float:
        return float(np.sqrt((values**2).sum(axis=-1).mean()))

    difference, uncertainty = mean(found - wanted) / size, mean(uncertainties[:, None]) / size
    name = f"stress at {len(found)} of {len(known)} points"
    word = _word(case, difference, uncertainty, STRESS_BAND)
    return [Row(name, "Pa", mean(found), mean(wanted), difference, uncertainty, word)]


def _stress_inside(case: Case, springs: SpringAnswer) -> tuple[Array, Array]:
    """Some points (q, d) in m inside, and the springs' stress (q, 3) or (q, 6) in Pa there.

    Their own where cells have one. Elsewhere by a strain fitted to displacements: times the tensor
    of a body near ratio 1/2 its error would be far beyond any stress, so fits of two degrees must
    tell the same.
    """
    lattice, law = springs.lattice, case.problem.material
    if isinstance(lattice, PatternLattice):
        (places,) = np.nonzero(springs.surrounded)
        if not len(places):
            raise ProblemError("no point has whole cells all around it; take a smaller spacing")
    else:
        places = np.arange(len(lattice.points))
    some = places[:: max(1, len(places) // STRESSED_POINTS)]
    at = lattice.points[some]
    if isinstance(lattice, PatternLattice):
        with suppress(ProblemError):  # springs that run from cell to cell
            return at, springs.point_stress(law.thickness)[some]
    tensor, x, u = elastic_tensor(law), lattice.points, springs.rest.displacement
    top = 4 if at.shape[1] == 2 else 2  # in space few points lie off a surface of degree 4
    found, lower = (fitted_stress(x, u, at, tensor, degree=each) for each in (top, top - 1))
    apart = float(np.linalg.norm(found - lower) / np.linalg.norm(found))
    if apart > FITS_ALIKE:
        raise SolverError(
            f"cells of this {lattice.name} lattice have no stress of their own, and two fits to "
            f"its displacements tell stresses {apart:.2g} apart, over {FITS_ALIKE:g}"
        )
    return at, found


def _word(case: Case, difference: float, uncertainty: float, times: float = 1.0) -> str:
    return (
        agreement(difference, uncertainty, times * case.band)
        if math.isfinite(difference)
        else NOT_ASKED
    )


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
