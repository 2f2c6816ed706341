"""Anybody's displacements beside the frozen set: verdict, parts of the difference, causes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike

from msvalidate_check.beside import longest
from msvalidate_check.case_set import ElasticCase, case_facts, elastic_case
from msvalidate_check.causes import Cause, phrase
from msvalidate_check.diagnosis import NOTICED, Field, explain, split
from msvalidate_check.errors import CheckError
from msvalidate_check.material import Material, nearest_material
from msvalidate_check.points import (
    PLACED,
    matched,
    nearest_of_pairs,
    pairs_within,
    positive,
    vectors,
)
from msvalidate_check.words import AGREES, agreement

Array = np.ndarray
OF_MATERIAL = frozenset({"modulus", "load", "scale", "ratio", "unit"})
"""Kinds of causes after which the nearest material is one."""
ALMOST, MANY, HUGE = 0.995, 10.0, 1e6
"""Parts from which text takes three digits, says times in place of %, and writes powers of ten."""
LEAST_SHOWN = 5e-9
"""Part below which text says 0."""
ACCURACY = 1e-6
"""Of displacements, over the largest, where nobody says: six digits, or single precision."""
BAND = 0.02
"""Largest difference that agrees by default, over the largest displacement."""


@dataclass(frozen=True)
class Row:
    """Another quantity beside elasticity's.

    Parameters
    ----------
    name, error, uncertainty
        The difference over the size of elasticity's, and what is not known of it.
    word
        As of a `Verdict`.
    """

    name: str
    error: float
    uncertainty: float
    word: str


@dataclass(frozen=True)
class Verdict:
    """What is said of a field; true where it agrees.

    Parameters
    ----------
    case, nu
        Which.
    word
        "agrees", "differs", "not resolved" or "not at rest".
    error
        Largest difference over the largest displacement.
    uncertainty
        How far elasticity and the rounding of the numbers leave it open.
    band
        Largest difference that agrees.
    parts
        Largest "scale", "rigid motion" and "shape" of the difference, over the same.
    causes
        All that explain the difference; none where there is none to explain.
    material
        The material that it is elasticity of; NaN where it differs and no cause is of a material.
    rest
        How much it may still change, over the largest; NaN if nobody says.
    precision
        Of its numbers, over the largest.
    quantities
        Other quantities that were given.
    notes
        Sentences on points that are missing or doubled.
    """

    case: str
    nu: float
    word: str
    error: float
    uncertainty: float
    band: float
    parts: Mapping[str, float]
    causes: tuple[Cause, ...]
    material: Material
    rest: float
    precision: float
    quantities: tuple[Row, ...] = ()
    notes: tuple[str, ...] = field(default=())

    def __bool__(self) -> bool:
        return self.word == AGREES and all(row.word == AGREES for row in self.quantities)

    @property
    def E(self) -> float:
        """Modulus (Pa) of the material that the field is elasticity of."""
        return self.material.E

    @property
    def effective_nu(self) -> float:
        """Poisson's ratio of the material that the field is elasticity of."""
        return self.material.nu

    def __str__(self) -> str:
        return "\n".join(_lines(self))


@np.errstate(over="ignore", invalid="ignore")  # of a cause that would be beyond all numbers
def check(
    case: ElasticCase,
    points: ArrayLike | None,
    displacement: ArrayLike,
    *,
    band: float = BAND,
    at_rest: float | None = None,
    accuracy: float = ACCURACY,
    quantities: Mapping[str, ArrayLike] | None = None,
) -> Verdict:
    """Compare displacements with elasticity's.

    Parameters
    ----------
    case
        From `elastic_case`.
    points
        (n, d) places at rest in m, (n,) whole numbers of the mesh's nodes, or None for all nodes in
        their order. Points that the set does not know are left out.
    displacement
        (n, d) in m.
    band
        Largest difference that agrees, over the largest displacement.
    at_rest
        How much the displacements may still change, over the largest; None if it is not known.
    accuracy
        How far the displacements may be off by their digits, over the largest: of differences of
        positions in single precision, 6e-8 of the largest coordinate.
    quantities
        Some of `case.quantities` by name, in the same units: each is held to the same band.

    Raises
    ------
    CheckError
        If the points are not of this case, or an array has another shape or values that are not
        finite.
    """
    if not isinstance(case, ElasticCase):
        raise CheckError(f"case: {str(case)[:40]!r}; give what elastic_case returns")
    given = _matched(case, points, displacement, accuracy)
    rest = math.nan if at_rest is None else positive("at_rest", at_rest)
    positive("band", band)
    error = given.field.left(given.field.found)
    causes = _causes(given, error, rest)
    return Verdict(
        case.name,
        case.nu,
        agreement(error, given.field.uncertainty, band, 0.0 if math.isnan(rest) else rest),
        error,
        given.field.uncertainty,
        band,
        {name: longest(part) / given.field.size for name, part in split(given.field).items()},
        causes,
        _material(case, given, error, causes),
        rest,
        given.precision,
        _rows(case, {} if quantities is None else quantities, band),
        given.notes,
    )


def assert_elastic(
    case: ElasticCase,
    points: ArrayLike | None,
    displacement: ArrayLike,
    band: float = BAND,
    **more: object,
) -> Verdict:
    """Raise `AssertionError` unless displacements agree with elasticity's; else the verdict.

    Arguments are those of `check`.
    """
    __tracebackhide__ = True
    verdict = check(case, points, displacement, band=band, **more)  # type: ignore[arg-type]
    if not verdict:
        raise AssertionError(str(verdict))
    return verdict


# Numbers ------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class _Matched:
    """Displacements at nodes of a case.

    Parameters
    ----------
    order
        (m,) nodes.
    field
        What is found and wanted there.
    precision
        Of the numbers given, over the largest displacement wanted.
    notes
        On points that are missing or doubled.
    """

    order: Array
    field: Field
    precision: float
    notes: tuple[str, ...]


def _matched(
    case: ElasticCase,
    points: ArrayLike | None,
    displacement: ArrayLike,
    accuracy: float,
) -> _Matched:
    """What was given at nodes of the case, in their order; raises `CheckError` as `check`."""
    move = vectors("displacement", displacement, case.points.shape[1])
    number, notes = matched(case, points, move)
    order, found = number[number >= 0], move[number >= 0]
    wanted = case.wanted[order]
    size = longest(wanted)
    if not size:
        raise CheckError(f"{case}: elasticity does not move at these points; give others too")
    precision = positive("accuracy", accuracy)
    uncertainty = case.uncertainty * longest(case.wanted) / size + precision
    field_ = _field(case, order, case.points[order], found, wanted, uncertainty)
    return _Matched(order, field_, precision, notes)


def _causes(given: _Matched, error: float, rest: float) -> tuple[Cause, ...]:
    """All that explain the difference; that it is not at rest comes first, where that may do."""
    causes = explain(given.field)
    if rest >= error > NOTICED * given.field.uncertainty:
        return (Cause("rest", rest, phrase("rest"), 0.0), *causes)
    return causes


def _material(
    case: ElasticCase, given: _Matched, error: float, causes: tuple[Cause, ...]
) -> Material:
    """The material that is nearest; NaN where there is a difference that is of no material."""
    rounding = given.precision * given.field.size
    near = nearest_material(case, given.order, given.field.found, rounding)
    if error > NOTICED * given.field.uncertainty and not any(
        each.kinds <= OF_MATERIAL for each in causes
    ):
        return Material(left=near.left)
    return near


def _field(
    case: ElasticCase, order: Array, at: Array, found: Array, wanted: Array, uncertainty: float
) -> Field:
    """The field with what it takes to ask for other ratios, places and meshes."""
    named = case.points[case.named]
    size = float(np.ptp(named, axis=0).max())

    def elsewhere(places: Array) -> Array | None:
        nearest = nearest_of_pairs(named, places, *pairs_within(named, places, PLACED * size))
        return None if (nearest < 0).any() else np.asarray(case.wanted[nearest])

    own = case.at_ratio(case.nu)[order]
    return Field(
        at,
        found,
        wanted,
        uncertainty,
        case.driven,
        tuple((float(a), float(b)) for a, b in zip(named.min(0), named.max(0), strict=True)),
        case.nu,
        case.ratios,
        lambda nu: wanted + case.at_ratio(nu)[order] - own,
        elsewhere,
        _coarse(case, order),
        lambda: case.in_other_state(order),
    )


def _coarse(case: ElasticCase, order: Array) -> dict[str, Callable[[float], Array]]:
    """What linear elements on each mesh of the case say, by ratio.

    Between the set's ratios their difference from elasticity is the polynomial through all of them.
    """
    grid = [float(nu) for nu in case_facts(case.name)["ratios"]]

    @cache
    def away(name: str) -> Array:
        every = [elastic_case(case.name, nu, case.mesh) for nu in grid]
        return np.stack([each.coarse().get(name, each.wanted) - each.wanted for each in every])

    def at(name: str, nu: float) -> Array:
        own = case.wanted + case.at_ratio(nu) - case.at_ratio(case.nu)
        weights = [math.prod((nu - b) / (a - b) for b in grid if b != a) for a in grid]
        return np.asarray((own + np.einsum("r,rpd->pd", weights, away(name)))[order])

    return {name: partial(at, name) for name in case.coarse()}


def _rows(case: ElasticCase, quantities: Mapping[str, ArrayLike], band: float) -> tuple[Row, ...]:
    if not isinstance(quantities, Mapping):
        kind = type(quantities).__name__
        raise CheckError(f"quantities: a {kind}; give values by name, {{name: values}}")
    return tuple(_row(case, name, values, band) for name, values in quantities.items())


def _row(case: ElasticCase, name: str, values: ArrayLike, band: float) -> Row:
    if name not in case.quantities:
        known = ", ".join(case.quantities)
        raise CheckError(f"quantity {name!r}: {case.name} has {known}; give one of them")
    wanted, uncertainty = case.quantities[name]
    try:
        given = np.atleast_1d(np.asarray(values, dtype=float))
    except (TypeError, ValueError) as why:
        raise CheckError(f"{name}: {str(values)[:40]!r}; give {len(wanted)} numbers") from why
    if given.shape != wanted.shape or not np.isfinite(given).all():
        raise CheckError(f"{name}: shape {given.shape}; give {len(wanted)} finite numbers")
    size = float(np.linalg.norm(wanted))
    if size <= uncertainty:
        raise CheckError(f"{name}: it is 0 in {case.name}, and no error is relative to that")
    error = float(np.linalg.norm(given - wanted)) / size
    uncertainty /= size
    return Row(name, error, uncertainty, agreement(error, uncertainty, band))


# Words --------------------------------------------------------------------------------------------


def _lines(verdict: Verdict) -> list[str]:
    """The verdict as text."""
    v = verdict
    beyond = "within" if v.error <= v.band else "beyond"
    parts = ", ".join(f"{name} {_percent(part)}" for name, part in v.parts.items())
    known = f"known to {_percent(v.uncertainty)}, rounding of the numbers {_percent(v.precision)}"
    of = "" if v.error >= MANY else "of "
    off = f"{_percent(v.error)} {of}the largest displacement"
    found = [
        f"{v.case}, nu = {v.nu:g}: {v.word}",
        f"  {off}, {beyond} the band of {_percent(v.band)}",
        f"  {known}; {_rest(v.rest)}",
        f"  parts: {parts}",
    ]
    if v.error > NOTICED * v.uncertainty:
        found += [f"  cause: {each.said}" for each in v.causes] or ["  cause: none of those known"]
        found += _effective(v.material)
    found += [
        f"  {row.name}: {row.word}, {_percent(row.error)} off, known to {_percent(row.uncertainty)}"
        for row in v.quantities
    ]
    return found + [f"  {note}" for note in v.notes]


def _effective(material: Material) -> list[str]:
    """Each number with its uncertainty."""
    words = []
    for name, unit in (("E", " Pa"), ("G", " Pa"), ("K", " Pa"), ("nu", "")):
        value, uncertainty = getattr(material, name), getattr(material, f"{name}_uncertainty")
        if math.isfinite(value):
            words.append(f"{name} = {value:.4g} ± {uncertainty:.1g}{unit}")
    if not words:
        return []
    return [f"  nearest elasticity: {', '.join(words)}, which leaves {_percent(material.left)}"]


def _rest(rest: float) -> str:
    if math.isnan(rest):
        return "whether it is at rest is unknown"
    return f"it may still change by {_percent(rest)}"


def _percent(part: float) -> str:
    if part < LEAST_SHOWN:
        return "0 %"
    if part >= MANY:
        return f"{part:.0f} times" if part < HUGE else f"{part:.3g} times"
    return f"{100 * part:.2g} %" if part < ALMOST else f"{100 * part:.0f} %"
