"""How many times a field is another, and what that number may be: a unit, a modulus, a load."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from msvalidate_check.beside import Array, Field, best_scale
from msvalidate_check.causes import Cause, Phrase, phrase

AS_WELL = 2.0
"""Times what the best explanation leaves, up to which another fits as well."""
AS_GOOD = 1e-3
"""Part that is none: of a difference what explanations leave that fit as well, of a number what it
differs by from the one that it is."""
FITS = 0.1
"""Of the difference that was there, what an explanation may leave; of what one fault leaves, what
two at once may."""
NOTICED = 3.0
"""Times the uncertainty of elasticity and of the numbers, from which a difference is explained."""
UNITS = {
    "metres": 1.0,
    "millimetres": 1e3,
    "centimetres": 1e2,
    "micrometres": 1e6,
    "inches": 1 / 0.0254,
    "kilometres": 1e-3,
    "feet": 1 / 0.3048,
}
"""Phrase of what displacements may be in, and how many of these a metre has."""
MIXED_UNITS = {
    "metres read as millimetres": 1e-3,
    "inches for millimetres": 25.4,
    "millimetres for inches": 1 / 25.4,
}
"""Phrases of two units that are confused, with the factor of displacements in m."""
STIFFNESS_UNITS = {
    1e3: "N/m and N/mm, or Pa and kPa",
    1e-3: "N/m and N/mm, or Pa and kPa",
    1e6: "Pa and MPa",
    1e-6: "Pa and MPa",
}
"""Factor of a stiffness by which units are confused, and these units."""
NEAR_UNIT = 1.05
"""Times by which a scale may differ from a unit's: a modulus or a load a little off besides."""
FAR_UNIT = 3.0
"""The same of units that are a thousand times off and more: no modulus is as wrong as that."""


@dataclass(frozen=True)
class Times:
    """A number of times: kind "unit", "unit of k" or "scale", its own and the whole, and `left`.

    `unit` names a unit, and what is off besides; None of a plain number.
    """

    kind: str
    many: float
    scale: float
    unit: Phrase | None
    left: float


def read_scale(field: Field, found: Array, wanted: Array) -> list[Times]:
    """What a field's scale may be: units that fit, else a plain number; none if it is not above 0.

    What is left is measured after the field is divided by it, in elasticity's size.
    """
    scale = best_scale(found, wanted)
    if not (math.isfinite(scale) and scale > 0):
        return []
    left = field.left(found / scale, wanted)
    units = list(_units(field, found, wanted, scale, left))
    exact = [each for each in units if each.scale == each.many]
    return exact or units or [Times("scale", scale, scale, None, left)]


def _units(field: Field, found: Array, wanted: Array, scale: float, left: float) -> Iterator[Times]:
    """Units of length and of stiffness, and a modulus or load off besides."""
    named = [("unit", many, phrase("named", name=name)) for name, many in units_of(field).items()]
    if field.driven in {"loads", "weight"}:
        named += [("unit of k", 1 / factor, _stiffness(factor)) for factor in STIFFNESS_UNITS]
    for kind, many, unit in named:
        apart = max(scale / many, many / scale)
        powers = abs(math.log10(many))
        if apart > (FAR_UNIT if powers >= 3 else NEAR_UNIT):
            continue
        exact = field.left(found / many, wanted)
        if apart <= NEAR_UNIT and exact <= max(AS_WELL * left, NOTICED * field.uncertainty):
            yield Times(kind, many, many, unit, exact)
        elif powers >= 1:  # any number is near some unit that is close to 1
            besides = phrase("unit besides", unit=unit, times=scale / many)
            yield Times(kind, many, scale, besides, left)


def units_of(field: Field) -> dict[str, float]:
    """Units that displacements may be in, with the factor by which they appear too large.

    The factor is relative to the unit in which they were read.
    """
    if field.read_unit == 1.0:
        return {name: many for name, many in UNITS.items() if many != 1.0} | MIXED_UNITS
    factors = {name: field.read_unit * many for name, many in UNITS.items()}
    return {name: many for name, many in factors.items() if abs(many - 1.0) > AS_GOOD}


def _stiffness(factor: float) -> Phrase:
    return phrase("of stiffness", part=factor, units=STIFFNESS_UNITS[factor])


def stiffness_unit(part: float) -> Phrase | None:
    """Units of stiffness whose confusion has this factor, or None."""
    near = (f for f in STIFFNESS_UNITS if abs(math.log(part / f)) <= math.log(NEAR_UNIT))
    return next(map(_stiffness, near), None)


def explain_scale(field: Field) -> Iterator[Cause]:
    """The field is elasticity times a number: a unit, a modulus, a load."""
    times = read_scale(field, field.found, field.wanted)
    for each in times:
        if each.unit is not None:
            said = phrase("unit", scale=each.scale, unit=each.unit)
            yield Cause(each.kind, each.many, said, each.left)
    if not times:
        return
    scale = best_scale(field.found, field.wanted)
    left = field.left(field.found / scale)
    kinds = {
        "loads": {"modulus": "modulus", "load": "loads"},
        "weight": {"modulus": "modulus", "load": "weight"},
        "supports": {"scale": "supports"},
        "both": {"scale": "scale"},
    }[field.driven]
    if field.driven == "loads" and len(field.span) == 2:
        kinds["thickness"] = "thickness"
    for kind, key in kinds.items():
        yield Cause(kind, scale, phrase(key, scale=scale, part=1 / scale), left)
