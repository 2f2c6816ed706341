"""Anybody's displacements beside the frozen set: verdict, parts of the difference, causes."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from numpy.typing import ArrayLike

from msvalidate_check.beside import longest
from msvalidate_check.case_set import ElasticCase, case_facts, elastic_case
from msvalidate_check.diagnosis import NOTICED, Field
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
from msvalidate_check.text import MANY, percent
from msvalidate_check.verdict import Difference, Verdict, judge_field

Array = np.ndarray
OF_MATERIAL = frozenset({"modulus", "load", "scale", "ratio", "unit"})
"""Kinds of causes after which the nearest material is one."""
ACCURACY = 1e-6
"""Of displacements, over the largest, where nobody says: six digits, or single precision."""
BAND = 0.02
"""Largest difference that agrees by default, over the largest displacement."""


@dataclass(frozen=True, eq=False, kw_only=True)
class FieldVerdict(Verdict):
    """What is said of a field of the frozen set; true where it agrees.

    Parameters
    ----------
    case, nu
        Which.
    material
        The material that it is elasticity of; NaN where it differs and no cause is of a material.
    precision
        Of its numbers, over the largest.
    notes
        Sentences on points that are missing or doubled.
    """

    case: str
    nu: float
    material: Material
    precision: float
    notes: tuple[str, ...] = ()

    @property
    def error(self) -> float:
        """Largest difference over the largest displacement."""
        return self.displacement.error

    @property
    def uncertainty(self) -> float:
        """How far elasticity and the rounding of the numbers leave it open."""
        return self.displacement.uncertainty

    @property
    def quantities(self) -> tuple[Difference, ...]:
        """Of the other quantities that were given."""
        return self.differences[1:]

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
) -> FieldVerdict:
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
        Some of `case.compare.quantities` by name, in the same units: each is held to the same band.

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
    judged = judge_field(given.field, band, rest)
    differences = (
        *judged.differences,
        *_quantities(case, {} if quantities is None else quantities, band),
    )
    return FieldVerdict(
        **vars(judged) | {"differences": differences},
        case=case.name,
        nu=case.nu,
        material=_material(case, given, judged),
        precision=given.precision,
        notes=given.notes,
    )


def assert_elastic(
    case: ElasticCase,
    points: ArrayLike | None,
    displacement: ArrayLike,
    band: float = BAND,
    **more: object,
) -> FieldVerdict:
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


def _material(case: ElasticCase, given: _Matched, judged: Verdict) -> Material:
    """The material that is nearest; NaN where there is a difference that is of no material."""
    rounding = given.precision * given.field.size
    near = nearest_material(case, given.order, given.field.found, rounding)
    own = judged.displacement
    if own.error > NOTICED * own.uncertainty and not any(
        each.kinds <= OF_MATERIAL for each in judged.causes
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


def _quantities(
    case: ElasticCase, quantities: Mapping[str, ArrayLike], band: float
) -> tuple[Difference, ...]:
    if not isinstance(quantities, Mapping):
        kind = type(quantities).__name__
        raise CheckError(f"quantities: a {kind}; give values by name, {{name: values}}")
    return tuple(_quantity(case, name, values, band) for name, values in quantities.items())


def _quantity(case: ElasticCase, name: str, values: ArrayLike, band: float) -> Difference:
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
    sizes = float(np.linalg.norm(given)), size
    return Difference(name, "", *sizes, error, uncertainty / size, band)


# Words --------------------------------------------------------------------------------------------


def _lines(v: FieldVerdict) -> list[str]:
    """The verdict as text."""
    own, *others = v.differences
    beyond = "within" if own.error <= own.band else "beyond"
    parts = ", ".join(f"{name} {percent(part)}" for name, part in v.parts.items())
    known = f"known to {percent(own.uncertainty)}, rounding of the numbers {percent(v.precision)}"
    of = "" if own.error >= MANY else "of "
    off = f"{percent(own.error)} {of}the largest displacement"
    found = [
        f"{v.case}, nu = {v.nu:g}: {v.word}",
        f"  {off}, {beyond} the band of {percent(own.band)}",
        f"  {known}; {_rest(own.residual_motion)}",
        f"  parts: {parts}",
    ]
    if own.error > NOTICED * own.uncertainty:
        found += [f"  cause (leaves {percent(each.left)}): {each.said}" for each in v.causes]
        found += [] if v.causes else ["  cause: none of those known"]
        found += _effective(v.material)
    found += [
        f"  {e.quantity}: {e.word}, {percent(e.error)} off, known to {percent(e.uncertainty)}"
        for e in others
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
    return [f"  nearest elasticity: {', '.join(words)}, which leaves {percent(material.left)}"]


def _rest(rest: float) -> str:
    if math.isnan(rest):
        return "whether it is at rest is unknown"
    return f"it may still change by {percent(rest)}"
