"""Quantities of a case's springs beside elasticity: a `Difference` each."""

from __future__ import annotations

import math
from contextlib import suppress
from typing import Any

import numpy as np

from msvalidate.case.file.case import Case
from msvalidate.case.springs.lattice_springs import SpringAnswer
from msvalidate.linear_algebra.norms import max_abs, max_length
from msvalidate.problem import Array, Mask, ProblemError, SolverError, Support
from msvalidate.problem.progress import report_step
from msvalidate.problem.records import dataclass
from msvalidate.springs.bodies.cut_network import support_selector
from msvalidate.springs.lattice import CutLattice, PatternLattice
from msvalidate.springs.statics.stress import fitted_stress
from msvalidate_check.verdict import Difference
from reference_fem.body import nodal_forces
from reference_fem.converged import Reference
from reference_fem.elasticity import elastic_tensor
from reference_fem.limits import CARRIES

KNOWN_STRESS, LEAST_KNOWN = 0.5, 0.5
"""Limits of the uncertainty of reference stresses.

The first is the largest uncertainty of a point that counts, relative to the band; the second is the
minimum fraction of such points.
"""
UNSTRAINED = 1e-14
"""Strain energy, over that of a strain as large as displacement over length, that is rounding."""
STRESS_BAND = 2.0
"""Band of stress at points, relative to the band of displacements.

Stress follows from the difference of two displacements over a cell, and each may use up the band.
"""
STRESSED_POINTS = 400
"""Points, about, at which stresses are compared: each is looked for in the elements."""
POINT_STRESS = "point stress"
"""Quantity of a case with a band of its own."""
FITS_ALIKE = 0.05
"""Largest relative difference between the stresses of fits of two degrees.

In bent blocks of triangular, BCC and FCC lattices they differed by up to 0.041 up to ratio 1/3,
where the stress was off by less than 0.07, and by more than 0.079 from ratio 0.45 on, where it was
off by 0.09 to 20.
"""


@dataclass(frozen=True)
class NotCompared:
    """A quantity that was requested and not compared, and why.

    `failed` if an answer was sought and is missing; else the case has no such quantity.
    """

    quantity: str
    why: str
    failed: bool = False

    def __str__(self) -> str:
        return f"{self.quantity}: not compared: {self.why}"


def compare_quantities(
    case: Case, springs: SpringAnswer, reference: Reference
) -> tuple[tuple[Difference, ...], list[NotCompared]]:
    """A difference a quantity that a case asks for, and what was not compared, and why."""
    rows, notes = list[Difference](), list[NotCompared]()
    if "displacement" in case.quantities:
        rows.append(_displacement(case, springs, reference))
    if reference.contact is not None:
        rows += _contact(case, springs, reference)
    makers = {
        "reactions": _reactions,
        "strain energy": _energy,
        "mean stress": _mean_stress,
        POINT_STRESS: _point_stress,
    }
    for name, make in makers.items():
        if name in case.quantities:
            report_step("%s", name)
            try:
                _refuse_unknown(case, reference)
                rows += make(case, springs, reference)
            except (ProblemError, SolverError) as error:
                notes.append(NotCompared(name, str(error), isinstance(error, SolverError)))
                rows.append(Difference(name))
    return tuple(rows), notes


def _displacement(case: Case, springs: SpringAnswer, reference: Reference) -> Difference:
    found, wanted = springs.at(reference.points), reference.displacement.value
    size = max_length(wanted)
    error = max_length(found - wanted) / size if size else math.inf
    sizes = max_length(found), size
    return Difference("displacement", "m", *sizes, error, reference.error, case.band)


def _contact(case: Case, springs: SpringAnswer, reference: Reference) -> list[Difference]:
    """Compare the contact force or depth, the half-width and the largest pressure.

    Force and depth are alternatives: the one that the case prescribes is not compared.
    """
    assert springs.contact is not None  # noqa: S101  the reference has one
    (found,), (wanted, error) = springs.contact.contacts, reference.contact
    given = case.problem.contacts[0].force
    each = {
        "contact half-width": ("m", found.half_width, wanted.half_width),
        "largest pressure": ("Pa", found.pressure.max(), wanted.pressure.max()),
    }
    if given is None:
        each = {"contact force": ("N", found.total, wanted.total)} | each
    else:
        each = {"contact depth": ("m", found.depth, wanted.depth)} | each
    rows = []
    for name, (unit, own, theirs) in each.items():
        off = abs(own / theirs - 1) if theirs else math.nan  # one node of the elements touches
        sizes = float(own), float(theirs)
        rows.append(Difference(name, unit, *sizes, float(off), error, case.band))
    return rows


def _reactions(case: Case, springs: SpringAnswer, reference: Reference) -> list[Difference]:
    """A row a support, over the largest of all."""
    wanted = reference.reactions
    size = max(float(np.linalg.norm(each.value)) for each in wanted)
    loads = float(np.abs(nodal_forces(case.problem, reference.solutions[0].body)).sum())
    if size <= CARRIES * loads:
        raise ProblemError("the supports carry nothing: the loads balance each other")
    left = springs.network.fixed.copy()
    rows = []
    for number, (support, each) in enumerate(zip(springs.problem.supports, wanted, strict=True)):
        on = held_by(support, springs) & left
        left &= ~on
        found = springs.reaction(on)
        difference = float(np.linalg.norm(found - each.value)) / size if size else math.nan
        uncertainty = float(each.uncertainty) / size if size else math.nan
        sizes = float(np.linalg.norm(found)), float(np.linalg.norm(each.value))
        name = f"reaction of support {number + 1}" if len(wanted) > 1 else "reaction"
        rows.append(Difference(name, "N", *sizes, difference, uncertainty, case.band))
    return rows


def held_by(support: Support, springs: SpringAnswer) -> Mask:
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
    stiff = max_abs(elastic_tensor(law)) * domain.volume * law.thickness
    bent = (max_length(reference.displacement.value) / longest) ** 2
    if abs(float(reference.energy.value[0])) <= UNSTRAINED * stiff * bent:
        raise SolverError("the body moves as one and is not strained")


def _energy(case: Case, springs: SpringAnswer, reference: Reference) -> list[Difference]:
    found, wanted = springs.energy, float(reference.energy.value[0])
    known = float(reference.energy.uncertainty)
    off = abs(found - wanted) / wanted
    return [Difference("strain energy", "J", found, wanted, off, known / wanted, case.band)]


def _mean_stress(case: Case, springs: SpringAnswer, reference: Reference) -> list[Difference]:
    found = springs.mean_stress(case.problem.material.thickness)
    wanted = reference.mean_stress
    size = max_abs(wanted.value)
    if size < wanted.uncertainty < np.inf:
        raise SolverError(f"elasticity has {size:.2g} Pa, known to {wanted.uncertainty:.2g}")
    difference = max_abs(found - wanted.value) / size
    uncertainty = float(wanted.uncertainty) / size
    sizes = max_abs(found), size
    return [Difference("mean stress", "Pa", *sizes, difference, uncertainty, case.band)]


def _point_stress(case: Case, springs: SpringAnswer, reference: Reference) -> list[Difference]:
    """Root mean square over points inside, at which elasticity's own stress is known well enough.

    Next to corners no mesh knows it, and cells that an outline cuts have none of the body's.
    """
    if case.problem.zones:
        raise ProblemError("the body is of several materials, whose stresses jump between them")
    at, found = _stress_inside(case, springs)
    wanted, uncertainties = reference.stress(at)

    def mean(values: Array) -> float:
        return float(np.sqrt((values**2).sum(axis=-1).mean()))

    size = mean(wanted)
    known = uncertainties <= KNOWN_STRESS * case.band * size
    if known.mean() >= LEAST_KNOWN:
        found, wanted, uncertainties = found[known], wanted[known], uncertainties[known]
    difference, uncertainty = mean(found - wanted) / size, mean(uncertainties[:, None]) / size
    places = "inner points" if isinstance(springs.lattice, PatternLattice) else "points"
    name = f"stress at {len(found)} of {len(known)} {places}"
    sizes, band = (mean(found), mean(wanted)), STRESS_BAND * case.band
    return [Difference(name, "Pa", *sizes, difference, uncertainty, band, of=POINT_STRESS)]


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


def difference_row(found: Difference) -> dict[str, Any]:
    """A difference as a row of a table."""
    return {
        "quantity": found.quantity,
        "unit": found.unit,
        "springs": found.found,
        "elasticity": found.wanted,
        "difference": found.error,
        "uncertainty": found.uncertainty,
        "verdict": found.word,
    }
