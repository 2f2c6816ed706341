"""Anybody's displacements beside the frozen set: verdict, parts of the difference, causes."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from msvalidate_check.case_set import ElasticCase
from msvalidate_check.diagnosis import NOTICED, Explanation, Field, explain, split
from msvalidate_check.errors import CheckError
from msvalidate_check.precision import spacing_of_displacements, spacing_of_numbers
from msvalidate_check.words import AGREES, agreement

Array = np.ndarray
BAND = 0.02
"""Largest difference that agrees by default, over the largest displacement."""
SLACK = 2.0
"""Distances between neighbouring numbers of places within which one is a node."""
PLACED, MOST_SLACK = 1e-6, 0.02
"""Of the body's size: how near a place is to the node that it is, and at most."""
UNITS = {"mm": 1e3, "cm": 1e2, "in": 1 / 0.0254, "um": 1e6, "km": 1e-3}
"""Units that places may be in, and how many of them a metre has."""
ALIKE = 0.1
"""Part by which the size of the places and the body's may differ."""
FEWEST = 3
"""Named points that have to be among those given, or all that there are."""
STEPS, SETTLED = 12, 1e-9
"""Of the fit of modulus and ratio."""
SHOWS = 0.1
"""Uncertainty of a ratio from which it does not show in the field."""


@dataclass(frozen=True)
class Material:
    """The material that a field is elasticity of, as nearly as there is one.

    Parameters
    ----------
    E, nu
        In Pa, and 1; NaN where it does not show.
    E_doubt, nu_doubt
        How far they may be off for what the field and the set leave open.
    left
        Largest difference that is left, over the largest displacement.
    """

    E: float
    nu: float
    E_doubt: float
    nu_doubt: float
    left: float


@dataclass(frozen=True)
class Row:
    """Another quantity beside elasticity's.

    Parameters
    ----------
    name, error, doubt
        The difference over the size of elasticity's, and what is not known of it.
    word
        As of a `Verdict`.
    """

    name: str
    error: float
    doubt: float
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
    doubt
        How far elasticity and the rounding of the numbers leave it open.
    band
        Largest difference that agrees.
    parts
        Largest "scale", "rigid motion" and "shape" of the difference, over the same.
    causes
        All that explain the difference; none where there is none to explain.
    material
        The material that it is elasticity of.
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
    doubt: float
    band: float
    parts: Mapping[str, float]
    causes: tuple[Explanation, ...]
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


def check(
    case: ElasticCase,
    points: ArrayLike | None,
    displacement: ArrayLike,
    *,
    band: float = BAND,
    at_rest: float | None = None,
    accuracy: float | None = None,
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
        Of the displacements, over the largest; None has it measured by how they are rounded.
    quantities
        Some of `case.quantities` by name, in the same units: each is held to the same band.

    Raises
    ------
    CheckError
        If the points are not of this case, or an array has another shape or values that are not
        finite.
    """
    d = case.points.shape[1]
    move = _vectors("displacement", displacement, d)
    number, places, notes = _matched(case, points, move)
    found = move[number >= 0]
    order = number[number >= 0]
    wanted = case.wanted[order]
    size = float(np.linalg.norm(wanted, axis=1).max())
    if not size:
        raise CheckError(f"{case}: elasticity does not move at these points; give others too")
    at = case.points[order]
    precision = _precision(found, None if places is None else at, size, accuracy)
    rest = math.nan if at_rest is None else _positive("at_rest", at_rest)
    _positive("band", band)
    doubt = case.uncertainty + precision
    field_ = _field(case, order, at, found, wanted, doubt)
    error = field_.left(found)
    word = agreement(error, doubt, band, 0.0 if math.isnan(rest) else rest)
    causes = explain(field_)
    if rest >= error > NOTICED * doubt:
        still = Explanation("rest", "not at rest: it may still change by as much", 0.0, rest)
        causes = (still, *causes)
    parts = {
        name: float(np.linalg.norm(part, axis=1).max()) / size
        for name, part in split(field_).items()
    }
    rows = tuple(_row(case, name, values, band) for name, values in (quantities or {}).items())
    return Verdict(
        case.name, case.nu, word, error, doubt, band, parts, causes,
        _material(case, order, found, doubt), rest, precision, rows, notes,
    )  # fmt: skip


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


# Points -------------------------------------------------------------------------------------------


def _matched(
    case: ElasticCase, points: ArrayLike | None, move: Array
) -> tuple[Array, Array | None, tuple[str, ...]]:
    """Number (n,) of the named point that each point is, -1 for none; places; sentences."""
    if points is None:
        if len(move) not in (len(case.points), len(case.named)):
            raise CheckError(
                f"displacement: {len(move)} points; {case} on {case.mesh} has {len(case.points)} "
                f"nodes, of which the set knows the first {len(case.named)}: give one or the other"
            )
        return _numbered(case, np.arange(len(move))), None, ()
    given = np.asarray(points)
    if given.ndim == 1:
        if not np.issubdtype(given.dtype, np.integer):
            raise CheckError("points: (n,) numbers that are not whole; give nodes, or places (n, d)")
        _refuse_other_count(given, move)
        if len(given) and not 0 <= given.min() <= given.max() < len(case.points):
            raise CheckError(
                f"points: nodes {given.min()} to {given.max()}; {case} on {case.mesh} has 0 to "
                f"{len(case.points) - 1}"
            )
        number = _numbered(case, given)
        return (number, None, _notes(case, number))
    places = _vectors("points", given, case.points.shape[1])
    _refuse_other_count(places, move)
    number = _placed(case, places)
    return number, places, _notes(case, number)


def _numbered(case: ElasticCase, given: Array) -> Array:
    """The named point of each node; of several that are the same the first counts."""
    number = np.where(given < len(case.named), given, -1)
    _, first = np.unique(number, return_index=True)
    once = np.full(len(number), -1)
    once[first] = number[first]
    if (once >= 0).sum() < min(FEWEST, len(case.named)):
        raise CheckError(
            f"points: {(once >= 0).sum()} of the {len(case.named)} nodes that the set knows, the "
            "first of the mesh; give more"
        )
    return once


def _placed(case: ElasticCase, places: Array) -> Array:
    """The named point at each place."""
    named = case.points[case.named]
    size = float(np.ptp(named, axis=0).max())
    room = min(MOST_SLACK * size, max(PLACED * size, SLACK * spacing_of_numbers(places)))
    number = np.full(len(places), -1)
    for i, x in enumerate(named):
        away = np.abs(places - x).max(axis=1)
        nearest = int(away.argmin())
        if away[nearest] <= room:
            number[nearest] = i
    if (number >= 0).sum() < min(FEWEST, len(named)):
        raise CheckError(_nowhere(case, places, int((number >= 0).sum())))
    return number


def _notes(case: ElasticCase, number: Array) -> tuple[str, ...]:
    missing = len(case.named) - int((number >= 0).sum())
    if not missing:
        return ()
    return (f"{missing} of {len(case.named)} points that the set knows are not among those given",)


def _nowhere(case: ElasticCase, places: Array, found: int) -> str:
    """What to say where places are not the case's: another unit, other axes, another case."""
    low, high = case.points.min(axis=0), case.points.max(axis=0)
    spans = [
        " x ".join(f"{a:.4g} to {b:.4g}" for a, b in zip(*ends, strict=True))
        for ends in ((places.min(axis=0), places.max(axis=0)), (low, high))
    ]
    given, own = np.sort(np.ptp(places, axis=0)), np.sort(high - low)
    hint = "give places of this body at rest, or another case"
    for unit, many in UNITS.items():
        if (np.abs(given / (many * own) - 1) < ALIKE).all():
            hint = f"are they in {unit}? give m"
            break
    else:
        if (np.abs(given / own - 1) < ALIKE).all():
            shifted = np.abs(places.min(axis=0) - low).max() > ALIKE * own.max()
            turned = (np.abs(np.ptp(places, axis=0) / (high - low) - 1) >= ALIKE).any()
            if turned:
                hint = "are the axes in another order?"
            elif shifted:
                hint = "is the origin another one?"
    return (
        f"points: {found} of {len(case.named)} that the set knows are among the {len(places)} "
        f"given, which span {spans[0]} m; {case.name} spans {spans[1]} m: {hint}"
    )


def _vectors(name: str, given: ArrayLike, d: int) -> Array:
    """An array (n, d) of finite numbers; a third component of 0 is left out in the plane."""
    try:
        array = np.asarray(given, dtype=float)
    except (TypeError, ValueError) as error:
        raise CheckError(f"{name}: not numbers; give an array (n, {d})") from error
    if array.ndim == 2 and array.shape[1] == 3 and d == 2 and not array[:, 2].any():
        array = array[:, :2]
    if array.ndim != 2 or array.shape[1] != d or not len(array):
        raise CheckError(f"{name}: shape {array.shape}; give an array (n, {d})")
    bad = np.argwhere(~np.isfinite(array))
    if len(bad):
        row, column = (int(i) for i in bad[0])
        raise CheckError(
            f"{name}: {array[row, column]} along {'xyz'[column]} at point {row}, {len(bad)} in all;"
            " give finite numbers"
        )
    return array


def _refuse_other_count(points: Array, move: Array) -> None:
    if len(points) != len(move):
        raise CheckError(
            f"displacement: {len(move)} of them for {len(points)} points; give one a point"
        )


def _positive(name: str, value: float) -> float:
    try:
        number = float(value)
    except (TypeError, ValueError) as error:
        raise CheckError(f"{name}: {value!r}; give a number") from error
    if not (math.isfinite(number) and number >= 0):
        raise CheckError(f"{name}: {number:g}; give a number from 0")
    return number


# Numbers ------------------------------------------------------------------------------------------


def _precision(found: Array, places: Array | None, size: float, accuracy: float | None) -> float:
    """Rounding of displacements over the largest."""
    if accuracy is not None:
        return _positive("accuracy", accuracy)
    return spacing_of_displacements(found, places) / size


def _field(
    case: ElasticCase, order: Array, at: Array, found: Array, wanted: Array, doubt: float
) -> Field:
    """The field with what it takes to ask for other ratios, places and meshes."""
    named = case.points[case.named]
    size = float(np.ptp(named, axis=0).max())

    def elsewhere(places: Array) -> Array | None:
        away = np.abs(named[None] - places[:, None]).max(axis=2)
        nearest = away.argmin(axis=1)
        if away[np.arange(len(places)), nearest].max() > PLACED * size:
            return None
        return np.asarray(case.wanted[nearest])

    own = case.at_ratio(case.nu)[order]
    return Field(
        at,
        found,
        wanted,
        doubt,
        "loads" if case.driven == "loads" else "supports",
        tuple((float(a), float(b)) for a, b in zip(named.min(0), named.max(0), strict=True)),
        case.nu,
        case.ratios,
        lambda nu: wanted + case.at_ratio(nu)[order] - own,
        elsewhere,
        {name: each[order] for name, each in case.coarse().items()},
    )


def _material(case: ElasticCase, order: Array, found: Array, doubt: float) -> Material:
    """Modulus and ratio of the elasticity that is nearest to a field, by Gauss and Newton's steps.

    u = s·u(nu): columns are u(nu) and ∂u/∂nu, the modulus is E/s. What each may be off by is the
    sum of what every component may be, weighed as the fit weighs them.
    """
    size = float(np.linalg.norm(case.wanted, axis=1).max())
    low, high = case.ratios
    step, scale, nu = 1e-4 * (high - low), 1.0, case.nu
    loads = case.driven == "loads"
    for _ in range(STEPS):
        own = case.at_ratio(nu)[order]
        slope = (case.at_ratio(nu + step)[order] - case.at_ratio(nu - step)[order]) / (2 * step)
        columns = np.column_stack([own.ravel(), scale * slope.ravel()]) if loads else None
        if columns is None:
            columns = slope.reshape(-1, 1)
        target = (found - (0 if loads else own)).ravel()
        if not slope.any() or np.linalg.matrix_rank(columns, tol=1e-9 * size) < columns.shape[1]:
            break
        inverse = np.linalg.pinv(columns)
        change = inverse @ target
        scale = float(change[0]) if loads else 1.0
        new = float(np.clip(nu + change[-1], low, high))
        settled, nu = abs(new - nu) < SETTLED, new
        if settled or scale <= 0:
            break
    else:
        inverse = np.linalg.pinv(columns)
    return _described(case, order, found, doubt, scale, nu)


def _described(
    case: ElasticCase, order: Array, found: Array, doubt: float, scale: float, nu: float
) -> Material:
    size = float(np.linalg.norm(case.wanted, axis=1).max())
    low, high = case.ratios
    step = 1e-4 * (high - low)
    own = case.at_ratio(nu)[order]
    slope = (case.at_ratio(nu + step)[order] - case.at_ratio(nu - step)[order]) / (2 * step)
    loads = case.driven == "loads"
    columns = [own.ravel(), scale * slope.ravel()] if loads else [slope.ravel()]
    weights = np.abs(np.linalg.pinv(np.column_stack(columns))).sum(axis=1) * doubt * size
    left = float(np.linalg.norm(found - scale * own, axis=1).max()) / size
    shows = float(weights[-1]) < SHOWS and bool(slope.any())
    E = case.E / scale if loads and scale > 0 else math.nan
    return Material(
        E,
        nu if shows else math.nan,
        abs(E) * float(weights[0]) / abs(scale) if loads else math.nan,
        float(weights[-1]) if shows else math.nan,
        left,
    )


def _row(case: ElasticCase, name: str, values: ArrayLike, band: float) -> Row:
    if name not in case.quantities:
        known = ", ".join(case.quantities)
        raise CheckError(f"quantity {name!r}: {case.name} has {known}; give one of them")
    wanted, uncertainty = case.quantities[name]
    given = np.atleast_1d(np.asarray(values, dtype=float))
    if given.shape != wanted.shape or not np.isfinite(given).all():
        raise CheckError(f"{name}: shape {given.shape}; give {len(wanted)} finite numbers")
    size = float(np.linalg.norm(wanted))
    if size <= uncertainty:
        raise CheckError(f"{name}: it is 0 in {case.name}, and no error is relative to that")
    error = float(np.linalg.norm(given - wanted)) / size
    doubt = uncertainty / size
    return Row(name, error, doubt, agreement(error, doubt, band))


# Words --------------------------------------------------------------------------------------------


def _lines(verdict: Verdict) -> list[str]:
    """The verdict as text."""
    v = verdict
    beyond = "within" if v.error <= v.band else "beyond"
    found = [
        f"{v.case}, nu = {v.nu:g}: {v.word}: {_percent(v.error)} of the largest displacement off "
        f"elasticity, {beyond} the band of {_percent(v.band)}",
        f"  known to {_percent(v.doubt)}, of which the numbers' own rounding is "
        f"{_percent(v.precision)}; {_rest(v.rest)}",
        "  parts: " + ", ".join(f"{name} {_percent(part)}" for name, part in v.parts.items()),
    ]
    if v.error > NOTICED * v.doubt:
        found += [f"  cause: {each.said}" for each in v.causes] or ["  cause: none of those known"]
        found += _effective(v.material)
    found += [
        f"  {row.name}: {row.word}, {_percent(row.error)} off, known to {_percent(row.doubt)}"
        for row in v.quantities
    ]
    return found + [f"  {note}" for note in v.notes]


def _effective(material: Material) -> list[str]:
    words = []
    if math.isfinite(material.E):
        words.append(f"E = {material.E:.4g} Pa")
    if math.isfinite(material.nu):
        words.append(f"nu = {material.nu:.4g}")
    if not words:
        return []
    return [f"  nearest elasticity: {', '.join(words)}, which leaves {_percent(material.left)}"]


def _rest(rest: float) -> str:
    if math.isnan(rest):
        return "whether it is at rest is unknown"
    return f"it may still change by {_percent(rest)}"


def _percent(part: float) -> str:
    return f"{100 * part:.2g} %"
