"""Anybody's displacements beside a case's elasticity: verdict, parts of the difference, causes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import cache, partial

import numpy as np
import pandas as pd

from msvalidate.case.compare.budget import point_table
from msvalidate.case.compare.quantities import difference_row
from msvalidate.case.compare.validity import Limitation, limit_verdict, limitations
from msvalidate.case.file.case import Case
from msvalidate.case.file.units import user_unit
from msvalidate.case.judge.matching import Matched, match
from msvalidate.case.judge.mistake_fields import known_mistakes
from msvalidate.case.judge.results import Result, refuse_extreme
from msvalidate.case.springs.large import answer_in_full, converge_case
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Isotropic, Load, Problem, ProblemError, SolverError, Weight
from msvalidate.problem.checks import require_type
from msvalidate.problem.progress import report_stage
from msvalidate.problem.records import dataclass, replace
from msvalidate_check.beside import MOST_RATIO
from msvalidate_check.causes import Cause
from msvalidate_check.diagnosis import Driven, Field, explain, split
from msvalidate_check.verdict import Difference, Verdict, judge_field
from reference_fem.body import solve_problem
from reference_fem.converged import NEARLY_INCOMPRESSIBLE, Reference
from reference_fem.first_mesh import first_mesh

STAGES = ("points", "elements", "causes", "large displacements", "pictures")
"""Stages of a judgement, as the progress reports them."""
Known = Mapping[str, Callable[[float], Array]]
RATIO_NODES = 10_000
"""Nodes of the mesh on which other ratios are tried."""
LEAST_MIXED, MOST_MIXED = 0.01, 0.4999
"""Ratios between which mixed elements are tried."""
MEANINGS = {
    "scale": "elasticity times a number: modulus, load, unit",
    "rigid motion": "the body moved as one: supports, frame",
    "shape": "what is left: ratio, mesh, rest, single points",
}


@dataclass(frozen=True, eq=False)
class Judged:
    """Displacements from a file beside elasticity.

    Parameters
    ----------
    case, result, matched, reference
        What was asked, what was given, its points in the body, and elasticity there.
    verdict
        On the displacements, in the range of the theory.
    limitations
        Of the verdict.
    omitted
        Sentences on causes that were not tried, and why.
    """

    case: Case
    result: Result
    matched: Matched
    reference: Reference
    verdict: Verdict
    limitations: tuple[Limitation, ...] = ()
    omitted: tuple[str, ...] = ()

    @property
    def displacement(self) -> Difference:
        """The displacements' difference."""
        return self.verdict.displacement

    @property
    def size(self) -> float:
        """Largest displacement (m) of elasticity."""
        return max_length(self.reference.displacement.value)

    @property
    def relative(self) -> Array:
        """Length (m,) of the difference at each point over the largest displacement."""
        away = self.matched.displacement - self.reference.displacement.value
        return np.asarray(np.linalg.norm(away, axis=1) / (self.size or 1.0))


def judge_result(
    case: Case,
    result: Result,
    *,
    unit: float = 1.0,
    residual_motion: float | None = None,
) -> Judged:
    """Compare displacements with the elasticity that a case asks for.

    Parameters
    ----------
    case, result
        What was asked, and what `read_result` found.
    unit
        What the file's lengths are multiples of, in m.
    residual_motion
        How much they may still change, over the largest, if the file does not say.

    Raises
    ------
    ProblemError
        If no point lies in the body, or the case asks what has no answer.
    SolverError
        If there is no trustworthy reference.
    """
    require_type("case", case, Case)
    require_type("result", result, Result)
    refuse_extreme("displacement", result.displacement)
    report_stage("points", STAGES)
    body = first_mesh(case.problem)
    matched = match(case, result, unit, body)
    report_stage("elements", STAGES)
    reference = converge_case(case, matched.places, body)
    wanted = reference.displacement.value
    size = max_length(wanted)
    if not size:
        raise ProblemError("case: elasticity does not move at these points; load the body")
    rest = result.rest if residual_motion is None else residual_motion
    uncertainty = reference.error + result.accuracy + matched.contradiction / size
    report_stage("causes", STAGES)
    catalogue = known_mistakes(case, matched.places, reference)
    field = _field(case.problem, matched, reference, uncertainty, result.known)
    # Elements on the result's own mesh, where they are known, leave nothing to be tried.
    excluded = {"coarse mesh"} if result.known else set()
    if rest <= uncertainty:  # as stated, nothing is missing
        excluded.add("not converged")
    mistakes = tuple(each for each in catalogue.mistakes if each.kind not in excluded)
    field = replace(field, mistakes=mistakes, unit=user_unit("m", case.unit), read_unit=unit)
    omitted: list[str] = []
    verdict = judge_field(field, case.band, rest, partial(_explained, omitted=omitted))
    report_stage("large displacements", STAGES)
    alone = replace(case, quantities=("displacement",))
    limits = limitations(alone, reference, lambda: answer_in_full(case, reference))
    verdict = limit_verdict(verdict, limits)
    omitted += catalogue.omitted
    return Judged(case, result, matched, reference, verdict, limits, tuple(omitted))


def _explained(field: Field, omitted: list[str]) -> tuple[Cause, ...]:
    """All causes; if a model has no answer, those that need no model, and a record of the reason.

    Parameters
    ----------
    omitted
        Sentences on causes that were not tried, to which the reason is added.
    """
    try:
        return explain(field)
    except (ProblemError, SolverError, RuntimeError) as error:  # the last of a plain factor
        omitted.append(f"Other ratios, plane states and known mistakes are not compared: {error}.")
        plain = replace(field, by_ratio=None, known={}, other_state=lambda: None, mistakes=())
        return explain(plain)


def _field(
    problem: Problem, matched: Matched, reference: Reference, uncertainty: float, known: Known
) -> Field:
    """The field with what it takes to ask for other ratios, states, meshes and places."""
    solution, law = reference.finest, problem.material

    def elsewhere(places: Array) -> Array | None:
        if reference.large is not None:  # the solution is that of linear theory
            return None
        try:
            return solution.at(places)
        except (ProblemError, SolverError):
            return None

    found = Field(
        matched.places,
        matched.displacement,
        reference.displacement.value,
        uncertainty,
        driven_by(problem),
        problem.domain.span,
        float(getattr(law, "nu", math.nan)),
        elsewhere=elsewhere,
    )
    if not isinstance(law, Isotropic) or problem.zones:
        return found
    asked = {name: _at(matched, each) for name, each in known.items()}
    return replace(_with_other_laws(found, problem, law, reference), known=asked)


def _with_other_laws(field: Field, problem: Problem, law: Isotropic, reference: Reference) -> Field:
    """The field with elasticity of other ratios and in the other plane state."""
    # Changes with the ratio need no finer mesh than this: they are small themselves.
    plain = reference.solutions_up_to(RATIO_NODES)[-1]
    own = plain.at(field.places)
    mixed = plain.pressure is not None

    def of(other: Isotropic, *, mixed: bool) -> Array:
        found = solve_problem(replace(problem, material=other), plain.body, mixed=mixed)
        return np.asarray(field.wanted + found.at(field.places) - own)

    @cache
    def by_ratio(nu: float) -> Array:
        return of(replace(law, nu=nu), mixed=mixed)

    @cache
    def other_state() -> tuple[str, Array] | None:
        if law.state == "solid":
            return None
        if law.state == "plane_strain":
            return "plane stress", of(replace(law, state="plane_stress"), mixed=False)
        needed = law.nu >= NEARLY_INCOMPRESSIBLE
        return "plane strain", of(replace(law, state="plane_strain"), mixed=needed)

    # Where elements of each kind exist: mixed ones need a pressure that grows with volume.
    low, high = (LEAST_MIXED, MOST_MIXED) if mixed else (0.0, MOST_RATIO)
    ratios = (min(law.nu, low), max(law.nu, high))
    return replace(field, ratios=ratios, by_ratio=by_ratio, other_state=other_state)


def _at(matched: Matched, by_ratio: Callable[[float], Array]) -> Callable[[float], Array]:
    """A field of a result's points, by ratio, at those that were matched."""
    return cache(lambda nu: by_ratio(nu)[matched.number])


def driven_by(problem: Problem) -> Driven:
    """Classify what moves a body: "loads", "weight", "supports" or "both".

    It is "weight" if no other load acts. The depth of an obstacle counts as a support.
    """
    moved = any(contact.force is None for contact in problem.contacts) or any(
        callable(value) or value for support in problem.supports for value in support.displacement
    )
    loads = [load for load in problem.loads if _acts(load)]
    if loads and moved:
        return "both"
    if moved:
        return "supports"
    heavy = loads and all(isinstance(load, Weight) for load in loads)
    return "weight" if heavy else "loads"


def _acts(load: Load) -> bool:
    """Return True if a load is other than zero."""
    (value,) = (
        getattr(load, name) for name in ("traction", "force", "acceleration") if hasattr(load, name)
    )
    return callable(value) or bool(np.any(value))


def budget(found: Judged) -> pd.DataFrame:
    """Contributions to the largest difference, with the columns of `budget.budget`."""
    wanted = found.reference.displacement.value
    field = Field(
        found.matched.places,
        found.matched.displacement,
        wanted,
        found.displacement.uncertainty,
        driven_by(found.case.problem),
        found.case.problem.domain.span,
    )
    total = found.matched.displacement - wanted
    at = int(np.linalg.norm(total, axis=1).argmax())
    length = float(np.linalg.norm(total[at]))
    along = total[at] / (length or 1.0)
    uncertainty, rest = found.displacement.uncertainty, found.displacement.residual_motion
    rows = [
        (name, float(part[at] @ along) / found.size + 0.0, uncertainty, MEANINGS[name])
        for name, part in split(field).items()
    ]
    rows.append(("total", length / found.size, uncertainty, "result - elasticity"))
    known = not math.isnan(rest)
    said = "how much it may still change, as stated" if known else "nobody says; rest unknown"
    rows.append(("rest", 0.0 if known else math.nan, rest, said))
    rows.append(("numbers", 0.0, found.result.accuracy, "rounding of the file's numbers"))
    rows.append(("reference", 0.0, found.reference.error, "elasticity's own error"))
    return pd.DataFrame(rows, columns=["part", "value", "uncertainty", "meaning"])


def tables(found: Judged) -> dict[str, pd.DataFrame]:
    """Tables of a judgement, by name."""
    causes = pd.DataFrame(
        [each.row() for each in found.verdict.causes], columns=["name", "said", "left", "value"]
    )
    made = {
        "quantities": pd.DataFrame([difference_row(found.displacement)]),
        "causes": causes,
        "budget": budget(found),
        "compared": point_table(found.matched.places, found.matched.displacement, found.reference),
    }
    return {name: table for name, table in made.items() if len(table)}
