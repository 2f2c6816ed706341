"""Known mistakes compared with a field: each is a path of fields, solved on the same body."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise

import numpy as np

from msvalidate_check.beside import Array, Factor, Field, Mistake, best_scale, fit
from msvalidate_check.causes import Cause, Phrase, phrase
from msvalidate_check.scales import AS_GOOD, AS_WELL

AS_NAMED = 0.005
"""Relative difference of a fitted factor from the one that has a name: three digits of a constant,
and what linear interpolation along a path leaves."""


def explain_mistakes(field: Field) -> Iterator[Cause]:
    """Compute the nearest field of each kind of known mistake."""
    best: dict[str, tuple[Cause, str]] = {}
    for mistake in field.mistakes:
        for parameter, nearest, scale in _fits(field, mistake):
            left = field.left(field.found / scale, nearest) if scale > 0 else math.inf
            if mistake.kind not in best or left < best[mistake.kind][0].left:
                cause = _cause(mistake, parameter, 1 / scale, left)
                best[mistake.kind] = cause, mistake.simpler
    for cause, simpler in best.values():
        room = AS_WELL * cause.left + AS_GOOD * field.difference
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


def _cause(mistake: Mistake, parameter: float, stiffness: float, left: float) -> Cause:
    """A mistake as a cause, with its fitted numbers."""
    value = stiffness if mistake.scaled else parameter
    of = mistake_phrase(
        mistake.key or mistake.kind, value, parameter, mistake.named, mistake.beside
    )
    return Cause(mistake.kind, value, of, left, mistake.beside)


def mistake_phrase(
    key: str, value: float, at: float, named: Mapping[str, Factor], beside: str = ""
) -> Phrase:
    """Sentence of a known mistake, as of a `Mistake`, with its number at a parameter."""
    known = (name for name, factor in named.items() if abs(value / factor(at) - 1) <= AS_NAMED)
    of = phrase(next(known, key), value=value)
    return phrase("mistake and", one=of, other=phrase(f"and {beside}")) if beside else of
