"""Range of the theory that a verdict rests on: limitations are records, sentences are made last.

A verdict holds if linear theory was in its range, every equilibrium that was sought exists, the
body stayed whole, and no part of the answer is missing. `limitations` decides for all commands.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from scipy.optimize import bisect

from msvalidate.case.file.case import Case
from msvalidate.case.file.units import quantity_text
from msvalidate.case.springs.large import NonlinearAnswer
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Array, Problem, SolverError
from msvalidate.problem.records import dataclass, replace
from msvalidate.springs.statics.breaking import FractureResult
from msvalidate_check.verdict import NOT_RESOLVED, Difference, Verdict
from reference_fem.body import Solution
from reference_fem.converged import Reference
from reference_fem.mesh.gradients import gradients_at_points

STRAIN_LIMIT, STRAINED_VOLUME = 0.05, 0.01
"""Strain up to which linear theory is used without a nonlinear reference, and the part of the
volume that may exceed it: at a corner alone the strain depends on the mesh."""
STRAIN_NODES = 20_000
"""Nodes of the finest mesh on which the strain is evaluated, for time and memory in 3D."""
PENETRATION_LIMIT = 0.1
"""Compression of the layer below an obstacle, relative to its thickness, as for the strain: forces
of a layer differ from linear theory by about this part."""
MARGIN = 0.9
"""Fraction of a limiting load that a remedy names.

The load is then in range when it is tried.
"""
RAY_POINTS = 400
"""Points of a ray through a layer, in equal ratios: its end is then refined by bisection."""
JUST_INSIDE = 1e-3
"""Relative shift of a layer's lower end into the body."""


WORDS: dict[str, dict[str, str]] = tomllib.loads(
    Path(__file__).with_name("limits.toml").read_text(encoding="utf-8")
)
"""Fact and remedy of each kind of limitation."""
THEORIES = ("requested", "frozen")
"""Kinds that name the theory by which a case is judged and leave its verdict."""


@dataclass(frozen=True)
class Limitation:
    """Reason why a verdict is not resolved, or the theory by which it is judged.

    Parameters
    ----------
    kind
        Key of `WORDS`.
    value, limit
        Number that left the range, and the end of the range.
    factor
        Multiple of the load that is in range.
    detail
        Text that the sentence quotes.
    """

    kind: str
    value: float = math.nan
    limit: float = math.nan
    factor: float = math.nan
    detail: str = ""

    @property
    def decides(self) -> bool:
        """True if no verdict but *not resolved* holds."""
        return self.kind not in THEORIES

    @property
    def fact(self) -> str:
        """Sentence without its remedy."""
        return WORDS[self.kind]["fact"].format(**vars(self))

    @property
    def remedy(self) -> str:
        """Sentence about what helps; empty if nothing does."""
        return WORDS[self.kind].get("remedy", "").format(**vars(self))

    @property
    def sentence(self) -> str:
        """Fact and remedy."""
        return f"{self.fact} {self.remedy}".strip()


def limitations(
    case: Case,
    reference: Reference,
    nonlinear: Callable[[], NonlinearAnswer],
    growth: FractureResult | None = None,
    missing: Sequence[Limitation] = (),
) -> tuple[Limitation, ...]:
    """Limitations of a case's verdict, the first one first in its reasons.

    Parameters
    ----------
    case, reference, nonlinear
        The request, its elasticity, and the change by large displacements, which is not called
        where linear theory is requested.
    growth
        Of springs that break.
    missing
        Parts of the answer that an exception removed.
    """
    others = (*_separated(growth), *_penetration(case.problem, reference))
    if case.linear_theory:
        return (Limitation(case.linear_theory), *others, *missing)
    return (*others, *geometric_limitations(case, reference, nonlinear()), *missing)


def limit_rows(rows: Sequence[Difference], limits: Sequence[Limitation]) -> tuple[Difference, ...]:
    """Differences whose words follow from the range of the theory as well."""
    outside = any(each.decides for each in limits)
    return tuple(replace(row, out_of_range=outside) for row in rows)


def limit_verdict(verdict: Verdict, limits: Sequence[Limitation]) -> Verdict:
    """Verdict that follows from the range of the theory as well."""
    rows = limit_rows(verdict.differences, limits)
    outside = any(each.decides for each in limits)
    return replace(verdict, word=NOT_RESOLVED if outside else verdict.word, differences=rows)


def geometric_limitations(
    case: Case, reference: Reference, nonlinear: NonlinearAnswer
) -> list[Limitation]:
    """Limitations by displacements that are large."""
    each = {"of the target's law": nonlinear.target, "of the springs' law": nonlinear.springs}
    errors = [(whose, change.no_finer) for whose, change in each.items() if change]
    absent = [whose for whose, change in each.items() if change is None]
    errors += [(absent[0], nonlinear.failure)] if absent else []
    found = [_unstable(whose, error) for whose, error in errors if error]
    if case.geometry == "nonlinear":
        return found
    if nonlinear.target is None:
        return found or _strain("strain", reference)
    if set(case.quantities) != {"displacement"}:  # of these nonlinear elements are not compared
        found += _strain("strained forces", reference)
    linear, (change, uncertainty, _) = reference.displacement.value, nonlinear.target
    size, known = max_length(linear), uncertainty if math.isfinite(uncertainty) else 0.0
    value = (max_length(change) + known) / size
    if value > case.band:
        both = " theory, ".join(
            f"{quantity_text(each, 'm', case.unit)} in {name}"
            for name, each in (("linear", size), ("nonlinear", max_length(linear + change)))
        )
        kind = "nonlinear with fracture" if case.fracture else "nonlinear"
        found.insert(0, Limitation(kind, value, case.band, detail=both))
    return found


def _unstable(whose: str, error: SolverError) -> Limitation:
    reached = getattr(error, "reached", 0.0)
    if reached > 0:
        return Limitation("unstable", reached, factor=MARGIN * reached, detail=whose)
    return Limitation("unsolved", detail=str(error))


def _strain(kind: str, reference: Reference) -> list[Limitation]:
    """Strain of linear theory, where no nonlinear value measures its error."""
    finest = reference.solutions_up_to(STRAIN_NODES)[-2:]

    def exceeded(load: float) -> float:
        return min(strain_exceeded(one, load) for one in finest)

    load = 1.0
    strain = value = exceeded(load)
    while strain > STRAIN_LIMIT:
        load /= 2
        strain = exceeded(load)
    return [Limitation(kind, value, STRAIN_LIMIT, load)] if load < 1 else []


def strain_exceeded(solution: Solution, load: float = 1.0) -> float:
    """Strain (1) exceeded in `STRAINED_VOLUME` of the volume under a multiple of the load.

    Largest principal value of Green's strain of the linear displacements, whose quadratic part
    measures the error of linear theory by rotations.
    """
    each = gradients_at_points(solution.body)
    H = load * each.of(np.ascontiguousarray(solution.displacement.T))
    green = (H + H.swapaxes(0, 1) + np.einsum("kiqc,kjqc->ijqc", H, H)) / 2
    size = np.abs(np.linalg.eigvalsh(np.moveaxis(green, (0, 1), (-2, -1)))).max(axis=-1).ravel()
    order = np.argsort(-size, kind="stable")
    volume = np.cumsum(each.measure.ravel()[order])
    return float(size[order[np.searchsorted(volume, STRAINED_VOLUME * volume[-1])]])


def _separated(growth: FractureResult | None) -> list[Limitation]:
    """Separation, or a load that nothing bears any more."""
    if growth is None or growth.ended not in ("parted", "falls"):
        return []
    kind = "separated" if growth.load <= 1 else "separated later"
    return [Limitation(kind, growth.load, factor=MARGIN * growth.load)]


def _penetration(problem: Problem, reference: Reference) -> list[Limitation]:
    """Compression of the layer below an obstacle, where the pressure is largest."""
    if reference.contact is None:
        return []
    contact, axis = reference.contact[0], problem.contacts[0].obstacle.axis
    top = contact.points[contact.pressure.argmax()]
    thickness = layer_thickness(problem, top, axis)
    if not thickness:
        return []
    ends = np.array([top, top + (1 - JUST_INSIDE) * thickness * axis])
    moved = contact.solution.at(ends) @ axis
    value = float(moved[0] - moved[1]) / thickness
    if value <= PENETRATION_LIMIT:
        return []
    # The compression grows in proportion to a depth, and at least with the root of a force.
    power = 1 if problem.contacts[0].force is None else 2
    factor = (MARGIN * PENETRATION_LIMIT / value) ** power
    return [Limitation("penetration", value, PENETRATION_LIMIT, factor, f"{thickness:.3g}")]


def layer_thickness(problem: Problem, start: Array, direction: Array) -> float:
    """Length (m) of one material from a place (d,) on, along a unit vector (d,); 0 if none."""
    span = np.array(problem.domain.span)

    def layer(distance: Array) -> Array:
        points = start + distance[:, None] * direction
        number = np.where(problem.domain.contains(points), 0, -1)
        for i, zone in enumerate(problem.zones, 1):
            number[zone.region.select(points, problem.domain.tolerance) & (number >= 0)] = i
        return number

    t = np.linalg.norm(np.ptp(span, axis=1)) * np.geomspace(1e-6, 1.0, RAY_POINTS)
    number = layer(t)
    (inside,) = np.nonzero(number >= 0)
    if not len(inside):
        return 0.0
    first = number[inside[0]]
    (other,) = np.nonzero(number[inside[0] :] != first)
    if not len(other):
        return float(t[-1])
    low, high = t[inside[0] + other[0] + np.array([-1, 0])]
    end = bisect(
        lambda t: (layer(np.array([t]))[0] == first) - 0.5, low, high, (), JUST_INSIDE**2 * low
    )
    return float(end)
