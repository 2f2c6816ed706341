"""Assignment of points of a result to points of the body."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from msvalidate.case.file.case import Case, make_lattice, spacing_of
from msvalidate.case.file.units import quantity_text, user_unit
from msvalidate.case.judge.results import Result
from msvalidate.case.springs.lattice_springs import compared_points
from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import AXES, SHAPES, Array, Index, Mask, ProblemError
from msvalidate.problem.normals import nearest_on_facets
from msvalidate.problem.records import dataclass
from msvalidate.problem.shapes import is_on_any
from msvalidate_check.points import ALIKE, PLACED, UNITS, pairs_within
from reference_fem.mesh.discretisation import Discretisation

MOSTLY = 0.5
"""Minimum fraction of the points that lie in the body."""
OUTSIDE = "lie outside the body and are left out"
SHOWN = 5
"""Points that a sentence names one by one."""


@dataclass(frozen=True, eq=False)
class Matched:
    """Points of a result that lie in the body, and what is wrong with others.

    Parameters
    ----------
    places, displacement, number
        (m, d) in m, in the body; (m, d) in m; and (m,) which points of the result they are.
    outside
        (k, d) in m, those that are in no part of the body.
    doubled
        (l, d) in m, places that stand in the file more than once; the first is taken.
    missing
        (j, d) in m, points of the case that the file says nothing of.
    contradiction
        Largest difference (m) of displacements that stand in the file for one place.
    notes
        Sentences on these.
    """

    places: Array
    displacement: Array
    number: Index
    outside: Array
    doubled: Array
    missing: Array
    contradiction: float
    notes: tuple[str, ...]


def match(case: Case, result: Result, unit: float, body: Discretisation) -> Matched:
    """The points of a result in the body.

    Parameters
    ----------
    case, result
        Results without places have numbers of the case's points: of the mesh's nodes, of its list,
        or of the lattice's points, from 0.
    unit
        What the file's lengths are multiples of, in m.
    body
        Of the elements: what its cells hold is inside.

    Raises
    ------
    ProblemError
        If no point lies in the body, or numbers are of no point.
    """
    move, tolerance, known = unit * result.displacement, case.problem.domain.tolerance, None
    if result.points is not None:
        places = unit * result.points
        owner = _first_of_each(places, tolerance)
    else:
        known, of_case = _numbered(case)
        number = _of_case(result, len(known))
        places = known[number]
        _, first, which = np.unique(number, return_index=True, return_inverse=True)
        owner = first[which]
    first, again = np.unique(owner), np.flatnonzero(owner != np.arange(len(places)))
    doubled, apart = places[again], move[again] - move[owner[again]]
    at, room = places[first], placement_tolerance(case)
    if known is None:
        inside, at = _into_body(body, at, room, tolerance)
        if inside.mean() < MOSTLY:
            hint = _unit_meant(case, places[first])
            raise ProblemError(_nowhere(case, places[first], int(inside.sum()), hint))
        missing = _missing(case, at[inside], room)
    else:
        inside = of_case[number[first]]
        if not inside.any():
            said = "result: its points lie outside the body; give others of the case too"
            raise ProblemError(said)
        missing = known[np.setdiff1d(np.flatnonzero(of_case), number)]
    outside, contradiction = places[first[~inside]], max_length(apart) if len(apart) else 0.0
    what = "places" if known is None else "numbers"
    notes = [
        *_noted(f"of {len(first)} points {OUTSIDE}", outside, case.unit),
        *_noted(f"{what} stand in the file more than once; the first counts", doubled, case.unit),
        *_noted("points of the case are not in the file", missing, case.unit),
    ]
    if contradiction:
        size = quantity_text(contradiction, "m", case.unit)
        said = f"displacements of one place differ by up to {size}"
        notes.append(f"{said}, which leaves that open")
    first, at = first[inside], at[inside]
    given = (outside, doubled, missing, contradiction, tuple(notes))
    return Matched(at, move[first], first, *given)


def _of_case(result: Result, count: int) -> Index:
    """Numbers of a case's points that a result has, of so many."""
    number: Index = result.id  # type: ignore[assignment]
    if number.min() < 0 or number.max() >= count:
        raise ProblemError(
            f"result: id {number.min()} to {number.max()}; the case has points 0 to {count - 1}: "
            "give these, or places"
        )
    return number


def _numbered(case: Case) -> tuple[Array, Mask]:
    """Points (n, d) in m that numbers are of, and which (n,) lie in the body: a lattice's may not.

    Of a lattice they are all, as `points.csv` of a run numbers them.
    """
    own = isinstance(case.points, str) and case.points == "lattice"
    lattice = make_lattice(case, spacing_of(case)) if own else None
    points = compared_points(case) if lattice is None else lattice.points
    return points, getattr(lattice, "inside", np.ones(len(points), dtype=bool))


def _first_of_each(places: Array, tolerance: float) -> Index:
    """The first point (n,) that is at the place of each.

    First of each cell of a grid so fine that all in a cell are at one place; then of cells next to
    each other, of which a point has few beside it, however often a place is repeated.
    """
    with np.errstate(over="ignore"):  # places beyond all numbers of cells share the last
        cell = np.floor(places * (np.sqrt(places.shape[1]) / tolerance))
    order = np.lexsort(cell.T)  # which leaves those of one cell in their order
    fresh = np.ones(len(places), dtype=bool)
    fresh[1:] = (cell[order][1:] != cell[order][:-1]).any(axis=1)
    owner = np.empty(len(places), dtype=np.int64)
    owner[order] = order[fresh][np.cumsum(fresh) - 1]
    first = np.sort(order[fresh])
    one, other = pairs_within(places[first], places[first], tolerance)
    near = np.linalg.norm(places[first[one]] - places[first[other]], axis=1) <= tolerance
    one, other = first[one[near]], first[other[near]]
    before = np.arange(len(places))
    np.minimum.at(before, other, one)
    while (before[before] != before).any():
        before = before[before]
    return np.asarray(before[owner])


def placement_tolerance(case: Case) -> float:
    """Distance (m) from the body that the file's own rounding explains."""
    size = max(high - low for low, high in case.problem.domain.span)
    return max(case.problem.domain.tolerance, PLACED * size)


def _into_body(
    body: Discretisation, places: Array, room: float, tolerance: float
) -> tuple[Mask, Array]:
    """Mask (n,) of places in the body, and places moved there.

    Places outside by at most `room` (m) are moved onto the surface and count as inside.
    """
    shape = SHAPES[body.element.shape]
    inside = is_on_any(shape, body.points[body.cells], places, tolerance)
    at = places.copy()
    (rest,) = np.nonzero(~inside)
    if len(rest):
        on, distance = nearest_on_facets(body.points[body.surface], places[rest])
        near = distance <= room
        at[rest[near]] = on[near]
        inside[rest[near]] = True
    return inside, at


def _missing(case: Case, places: Array, room: float) -> Array:
    """Points of the case, where it names some, that no place is at."""
    if isinstance(case.points, str) and case.points == "lattice":
        return np.empty((0, places.shape[1]))
    wanted = compared_points(case)
    _, there = pairs_within(places, wanted, max(room, case.problem.domain.tolerance))
    return np.asarray(np.delete(wanted, there, axis=0))


def _unit_meant(case: Case, places: Array) -> str:
    """Words for the unit in which places would be as large as the body, "" if they are."""
    low, high = np.array(case.problem.domain.span).T
    given = np.sort(np.ptp(places, axis=0))
    own = np.sort(high - low)
    for unit, many in UNITS.items():
        if (np.abs(given / (many * own) - 1) < ALIKE).all():
            return f" (are they in {unit}? --unit {unit})"
    if (np.ptp(places, axis=0) <= 1.05 * (high - low)).all():
        return ""
    turned = (given <= 1.05 * own).all()
    return " (are the axes in another order?)" if turned else ""


def _nowhere(case: Case, places: Array, inside: int, hint: str) -> str:
    """Message with the spans if few points lie in the body."""
    spans = {"the file has": np.array([places.min(axis=0), places.max(axis=0)]).T}
    spans["the body"] = np.array(case.problem.domain.span)
    words, (unit, size) = [], user_unit("m", case.unit)
    for who, span in spans.items():
        along = zip(AXES, span / size, strict=False)
        words.append(f"{who} {', '.join(f'{a} {p:.4g} to {q:.4g}' for a, (p, q) in along)}")
    count = f"{inside} of {len(places)} points" if inside else "no point"
    spans_said = f" {unit}, ".join(words)
    return f"result: {count} in the body: {spans_said} {unit}{hint}; give places of this body"


def _noted(said: str, places: Array, length: str) -> Sequence[str]:
    """A sentence that counts places and names the first."""
    if not len(places):
        return ()
    unit, size = user_unit("m", length)
    shown = [f"({', '.join(f'{x / size:.4g}' for x in place)})" for place in places[:SHOWN]]
    more = ", ..." if len(places) > SHOWN else ""
    return (f"{len(places)} {said}: {', '.join(shown)}{more} {unit}.",)
