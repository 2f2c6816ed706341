"""Another Poisson's ratio, alone or with one more fault: fitted by secant steps."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np

from msvalidate_check.beside import Array, Field, best_scale, fit
from msvalidate_check.causes import Cause, phrase
from msvalidate_check.changes import frames
from msvalidate_check.scales import AS_GOOD, NOTICED, read_scale

RATIO_STEP, RATIO_STEPS, RATIO_SETTLED = 0.01, 12, 1e-5
"""First change of Poisson's ratio that is tried, how many are, and the last that need be."""
HALF = 0.5
"""Of the difference, what a ratio's first-order effect may leave for it to be worth more solves."""


def explain_ratio(field: Field) -> Iterator[Cause]:
    """Another ratio, the modulus kept."""
    if field.by_ratio is None:
        return
    nu = _fitted(field, field.by_ratio, scaled=False)
    if nu is not None:
        of = phrase("ratio", nu=nu, given=field.ratio)
        yield Cause("ratio", nu, of, field.left(field.found, field.by_ratio(nu)))


def explain_ratio_besides(field: Field) -> Iterator[Cause]:
    """Another ratio and a scale, other axes or signs, or a coarse mesh."""
    if field.by_ratio is None:
        return
    yield from _with_scale(field, field.by_ratio)
    yield from _with_frame(field, field.by_ratio)
    for name, by_ratio in field.known.items():
        nu = _fitted(field, by_ratio, scaled=False)
        if nu is not None:
            image = phrase("named", name=name)
            of = phrase("coarse mesh and ratio", image=image, nu=nu, given=field.ratio)
            left = field.left(field.found, by_ratio(nu))
            yield Cause("coarse mesh", nu, of, left, "ratio")


def _with_scale(field: Field, by_ratio: Callable[[float], Array]) -> Iterator[Cause]:
    nu = _fitted(field, by_ratio, scaled=True)
    if nu is None:
        return
    image = phrase("of ratio", nu=nu, given=field.ratio)
    for times in read_scale(field, field.found, by_ratio(nu)):
        if abs(times.scale - 1) <= AS_GOOD:
            of = phrase("ratio", nu=nu, given=field.ratio)
            yield Cause("ratio", nu, of, times.left)
        elif abs(times.scale - 1) > NOTICED * field.uncertainty:
            key = "times of ratio" if times.unit is None else "unit and"
            of = phrase(key, scale=times.scale, image=image, unit=times.unit)
            yield Cause(times.kind, nu, of, times.left, "ratio")


def _with_frame(field: Field, by_ratio: Callable[[float], Array]) -> Iterator[Cause]:
    """The axes or signs that are nearest by themselves, as each needs solutions of its own."""
    every = [(frame, frame.back(field.found)) for frame in frames(field.found.shape[1])]
    frame, back = min(every, key=lambda each: float(((each[1] - field.wanted) ** 2).sum()))
    if not frame.kind:
        return
    nu = _fitted(replace(field, found=back), by_ratio, scaled=False)
    if nu is not None:
        image = phrase("of ratio", nu=nu, given=field.ratio)
        of = phrase("image", image=phrase("with", image=image, frame=frame.words))
        yield Cause(frame.kind, nu, of, field.left(back, by_ratio(nu)), "ratio")


def _fitted(field: Field, by_ratio: Callable[[float], Array], *, scaled: bool) -> float | None:
    """The ratio that fits best, None where none that is known does.

    Secant steps: elasticity bends with the ratio, near 1/2 above all.
    """
    low, high = field.ratios
    nu = field.ratio
    other = nu + (RATIO_STEP if nu + RATIO_STEP <= high else -RATIO_STEP)
    move = by_ratio(nu)
    most = HALF * min(float(np.linalg.norm(each)) for each in (field.found - move, field.found))
    for _ in range(RATIO_STEPS):
        slope = (by_ratio(other) - move) / (other - nu)
        nu, move = other, by_ratio(other)
        if not slope.any():
            return None
        columns = np.stack([move, slope]) if scaled else slope[None]
        target = field.found if scaled else field.found - move
        fitted = fit(columns, target)
        rest = float(np.linalg.norm(target - np.einsum("k,knd->nd", fitted, columns)))
        scale = float(fitted[0]) if scaled else 1.0
        if rest > most or scale <= 0:
            return None
        other = min(max(nu + float(fitted[-1]) / scale, low), high)
        if abs(other - nu) < RATIO_SETTLED:
            break
    return other if best_scale(field.found, by_ratio(other)) > 0 else None
