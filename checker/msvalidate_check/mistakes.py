"""Known mistakes compared with a field: each is a path of fields, solved on the same body."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise

import numpy as np

from msvalidate_check.beside import ROUNDING, Array, Factor, Field, Mistake, best_scale, fit
from msvalidate_check.causes import Cause, Phrase, phrase
from msvalidate_check.scales import AS_GOOD, AS_WELL, FITS, stiffness_unit

MAX_BESIDE = 1.5
"""Largest factor that is fitted besides a known mistake.

A larger one is the main cause itself; with a free size most smooth fields resemble some mesh.
"""
AS_NAMED = 0.005
"""Relative difference of a fitted factor from the one that has a name: three digits of a constant,
and what linear interpolation along a path leaves."""
LEAST_SHARE = 0.1
"""Part of the difference that a fitted rest length must explain itself: a smaller one fits only
what another spacing leaves."""


FREE = {"k2 = 2 k1", "k alike", "axes alone", "not converged"}
"""Phrases of mistakes with a number of no meaning of its own, which is fitted."""


def explain_mistakes(field: Field) -> Iterator[Cause]:
    """Compute the nearest field of each kind of known mistake, alone and with a wrong stiffness.

    Mistakes in `FREE` are omitted if one without a fitted number fits and leaves less than twice as
    much.
    """
    causes = list(_every_kind(field))
    most = max(FITS * field.difference, field.uncertainty)
    whole = {"", "k without h"}
    fixed = [each for each in causes if _first_key(each) not in FREE and each.beside in whole]
    least = min([each.left for each in fixed if each.left <= most], default=math.inf)
    for each in causes:
        if _first_key(each) not in FREE or AS_WELL * max(each.left, ROUNDING) < least:
            yield each


def _first_key(cause: Cause) -> str:
    """Key of a mistake's own phrase."""
    return (cause.of["one"] if cause.of.key == "mistake and" else cause.of).key


def _every_kind(field: Field) -> Iterator[Cause]:
    """The nearest field of each kind, alone and with a wrong stiffness."""
    alone = list(_nearest(field, field.mistakes))
    yield from alone
    plain = [each for each in field.mistakes if not (each.scaled or each.simpler)]
    left = {cause.kind: cause.left for cause in alone}
    exact = max(AS_GOOD * field.difference, field.uncertainty)
    if any(left.get(each.kind, math.inf) <= exact for each in plain):  # one mistake is enough
        return
    scale = best_scale(field.found, field.wanted)
    size = field.left(field.found / scale) if scale > 0 else math.inf
    fits = max(FITS * field.difference, field.uncertainty)
    if size <= exact or field.driven == "supports":  # a factor is enough, or no modulus shows
        return
    built = [each for each in plain if each.kind != "not converged"]  # its size is no modulus
    for cause in _nearest(field, [replace(each, scaled=True, beside="scale") for each in built]):
        room = AS_WELL * cause.left + AS_GOOD * field.difference
        if cause.left <= fits and room < min(size, left.get(cause.kind, size)):
            yield cause


def _nearest(field: Field, mistakes: Iterable[Mistake]) -> Iterator[Cause]:
    """The nearest field of each kind, if it fits better than the simpler kind that it contains."""
    best: dict[str, tuple[Cause, Mistake]] = {}
    for mistake in mistakes:
        for parameter, nearest, scale in _fits(field, mistake):
            if not scale > 0:
                continue
            unit = mistake.beside == "scale" and _named_stiffness(mistake, 1 / scale, parameter)
            if mistake.beside and not (unit or 1 / MAX_BESIDE < scale < MAX_BESIDE):
                continue
            left = field.left(field.found / scale, nearest)
            if mistake.kind not in best or left < best[mistake.kind][0].left:
                cause = _cause(field, mistake, parameter, 1 / scale, left)
                best[mistake.kind] = cause, mistake
    for cause, mistake in best.values():
        room = AS_WELL * cause.left + AS_GOOD * field.difference
        if not mistake.scaled:
            room = max(room, cause.left + LEAST_SHARE * field.difference)
        simpler = mistake.simpler
        if math.isfinite(cause.left) and (simpler not in best or room < best[simpler][0].left):
            yield cause


def _fits(field: Field, mistake: Mistake) -> Iterator[tuple[float, Array, float]]:
    """Parameter, field (n, d) in m and factor of the fits along a path."""
    path = mistake.path()
    for parameter, nearest in path:
        yield parameter, nearest, best_scale(field.found, nearest) if mistake.scaled else 1.0
    for (first, one), (last, other) in pairwise(path):
        part, scale = _between(field.found, one, other, scaled=mistake.scaled)
        if 0 < part < 1:
            yield first + part * (last - first), one + part * (other - one), scale


def _between(candidate: Array, one: Array, other: Array, *, scaled: bool) -> tuple[float, float]:
    """Part of the way from one field (n, d) to another that is nearest, and its factor."""
    if not scaled:
        return float(fit((other - one)[None], candidate - one)[0]), 1.0
    first, last = fit(np.stack([one, other]), candidate)
    scale = float(first + last)
    return (float(last / scale), scale) if scale > 0 else (0.0, 1.0)


def _cause(
    field: Field, mistake: Mistake, parameter: float, stiffness: float, left: float
) -> Cause:
    """A mistake as a cause, with its fitted numbers."""
    value = stiffness if mistake.scaled and mistake.beside != "scale" else parameter
    length = f"{field.length(parameter)} {field.unit[0]}"
    named = mistake.named if mistake.scaled and mistake.beside != "scale" else {}
    of = mistake_phrase(mistake.key or mistake.kind, value, parameter, named, length)
    beside, unit = mistake.beside, stiffness_unit(stiffness)
    if beside == "scale":
        beside = _named_stiffness(mistake, stiffness, parameter) or beside
    if beside:
        other = phrase(f"and {beside}", scale=1 / stiffness, part=stiffness, unit=unit)
        of = phrase("mistake and", one=of, other=other)
    return Cause(mistake.kind, value, of, left, beside)


def _named_stiffness(mistake: Mistake, stiffness: float, parameter: float) -> str:
    """Kind of a factor of the stiffness with a name, beside a known mistake; "" if it has none."""
    factors = mistake.named.items()
    names = (name for name, of in factors if abs(stiffness / of(parameter) - 1) <= AS_NAMED)
    return next(names, "unit of k" if stiffness_unit(stiffness) else "")


def mistake_phrase(
    key: str, value: float, at: float, named: Mapping[str, Factor], length: str = ""
) -> Phrase:
    """Sentence of a known mistake, as of a `Mistake`, with its number at a parameter.

    `length` is the parameter as text, if it is a spacing.
    """
    known = (name for name, factor in named.items() if abs(value / factor(at) - 1) <= AS_NAMED)
    return phrase(next(known, key), value=value, length=length)
