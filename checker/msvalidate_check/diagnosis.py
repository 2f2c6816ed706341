"""What a field of displacements would have to be for it to be elasticity's: units, signs, causes.

Each explanation changes the field, or elasticity, in one way, by as few numbers as it has (a scale,
a rigid motion, a ratio), fitted by least squares. It is told where it leaves little of what was
there, and not told where another leaves much less: what fits as well is listed with it, for one
field cannot tell them apart. A scale is one of the load as much as of the modulus, and where only
supports move the body no modulus shows at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from itertools import permutations, product
from typing import Literal

import numpy as np

Array = np.ndarray
Driven = Literal["loads", "weight", "supports", "both"]
"""What moves a body: loads, its own weight alone, its supports, or supports and something else."""
AXES = "xyz"
FITS = 0.1
"""Of the difference that was there, what an explanation may leave."""
AS_WELL = 2.0
"""Times what the best explanation leaves, up to which another fits as well."""
AS_GOOD = 1e-3
"""Of the difference that was there: explanations that leave less than this fit as well."""
NOTICED = 3.0
"""Times the doubt of elasticity and of the numbers, from which a difference is one to explain."""
UNITS = {
    "millimetres": 1e3,
    "centimetres": 1e2,
    "micrometres": 1e6,
    "inches": 1 / 0.0254,
    "kilometres": 1e-3,
    "metres for a case in millimetres": 1e-3,
    "feet": 1 / 0.3048,
    "inches for millimetres": 25.4,
    "millimetres for inches": 1 / 25.4,
}
"""What displacements may be in instead of m, and how many of these a metre has."""
NEAR_UNIT = 0.05
"""Part by which a scale may differ from a unit's: a modulus or a load a little off besides."""
FEW_POINTS = 0.02
"""Part of the points, or one, that may be wrong while all others are right."""
RATIO_STEP, RATIO_STEPS, RATIO_SETTLED = 0.01, 12, 1e-5
"""First change of Poisson's ratio that is tried, how many are, and the last that need be."""
HALF = 0.5
"""Of the difference, what a ratio's first-order effect may leave for it to be worth more solves."""
MOST_RATIO = 0.495
"""Ratio up to which elements without a pressure of their own are asked."""


@dataclass(frozen=True)
class Explanation:
    """One way to understand a field.

    Parameters
    ----------
    name
        A short name, for tables.
    said
        A sentence.
    left
        Largest difference that it leaves, over elasticity's largest displacement.
    value
        The number that it fits: a scale, a ratio, a count; NaN if none.
    """

    name: str
    said: str
    left: float
    value: float = math.nan


@dataclass(frozen=True, eq=False)
class Field:
    """Displacements (n, d) of a candidate and of elasticity at places (n, d), all in m.

    `doubt` is how far elasticity and the numbers themselves may be off, over the largest; `driven`
    what moves the body; `span` its ends (m) along each axis; `ratio` its Poisson's ratio, NaN if it
    has none; `by_ratio` gives elasticity (n, d) of another of `ratios`, None if of no other;
    `elsewhere` gives it at other places (n, d) in m, None where one lies outside the body; `known`
    are fields (n, d) of solvers that are known not to be converged, by what they are of.
    """

    places: Array
    found: Array
    wanted: Array
    doubt: float
    driven: Driven
    span: tuple[tuple[float, float], ...]
    ratio: float = math.nan
    ratios: tuple[float, float] = (0.0, MOST_RATIO)
    by_ratio: Callable[[float], Array] | None = None
    elsewhere: Callable[[Array], Array | None] | None = None
    known: Mapping[str, Array] = field(default_factory=dict)

    @property
    def size(self) -> float:
        """Largest displacement (m) of elasticity."""
        return float(np.linalg.norm(self.wanted, axis=1).max()) or 1.0

    def left(self, found: Array, wanted: Array | None = None) -> float:
        """Largest difference of two fields, over elasticity's largest displacement."""
        away = found - (self.wanted if wanted is None else wanted)
        return float(np.linalg.norm(away, axis=1).max() / self.size)


def explain(field: Field) -> tuple[Explanation, ...]:
    """All explanations of a field that fit, the best first; none where it needs none."""
    before = field.left(field.found)
    if before <= NOTICED * field.doubt:
        return ()
    simple = [
        each
        for ways in (_units, _axes, _mirrored, _positions, _points, _known)
        for each in ways(field)
    ]
    simple += [*_scale(field), *_rigid(field), *_ratio(field)]
    fitting = _fitting(simple, before, field.doubt)
    left = min((each.left for each in fitting), default=before)
    if left > NOTICED * field.doubt:  # two numbers fit any field better: they must do so by far
        both = [each for each in _both(field) if each.left <= FITS * left]
        fitting = both or fitting
    return tuple(fitting)


def _fitting(found: list[Explanation], before: float, doubt: float) -> list[Explanation]:
    """Those that leave little, and of these those that leave about as little as the best."""
    good = [each for each in found if each.left <= FITS * before]
    if not good:
        return []
    least = min(each.left for each in good)
    room = max(AS_WELL * least, NOTICED * doubt, AS_GOOD * before)
    kept = sorted((each for each in good if each.left <= room), key=lambda each: each.left)
    named = {each.name for each in kept}
    if "one point" in named and any(each.name == "scale" for each in kept):
        kept = [each for each in kept if each.name == "one point"]
    return kept


def _fit(columns: Array, target: Array) -> Array:
    """Coefficients (k,) of the best sum of fields (k, n, d) for a field (n, d)."""
    A = columns.reshape(len(columns), -1).T
    size = np.linalg.norm(A, axis=0)
    size[size == 0] = 1.0
    return np.asarray(np.linalg.lstsq(A / size, target.ravel(), rcond=None)[0] / size)


def _best_scale(field: Field, found: Array) -> float:
    """The number of times that a field is elasticity."""
    square = float((field.wanted**2).sum())
    return float((found * field.wanted).sum()) / square if square else math.nan


def _units(field: Field) -> Iterator[Explanation]:
    """Another unit of length, and a modulus or load a little off besides."""
    scale = _best_scale(field, field.found)
    for unit, many in UNITS.items():
        if not (scale > 0 and abs(scale / many - 1) <= NEAR_UNIT):
            continue
        exact, fitted = field.left(field.found / many), field.left(field.found / scale)
        besides = ""
        near = abs(math.log10(many)) < 1
        if exact > max(AS_WELL * fitted, NOTICED * field.doubt):
            if near:  # any number is near some unit
                continue
            besides = f", and {scale / many:.4g} times as large besides"
        said = f"{many:g} times elasticity{besides}: {unit}?"
        yield Explanation("unit", said, fitted if besides else exact, many)


def _scale(field: Field) -> Iterator[Explanation]:
    scale = _best_scale(field, field.found)
    if not math.isfinite(scale):
        return
    if not field.found.any():
        yield Explanation("zero", "nothing moves: the displacements are all 0", 0.0, 0.0)
    if scale <= 0:
        yield from _turned_round(field, scale)
        return
    left = field.left(field.found / scale)
    if field.driven in {"loads", "weight"}:
        yield Explanation(
            "modulus", f"{scale:.4g} times elasticity: a modulus E {1 / scale:.4g} times as large?",
            left, scale,
        )  # fmt: skip
        what = "loads" if field.driven == "loads" else "gravity or masses"
        said = f"{scale:.4g} times elasticity: {what} {scale:.4g} times as large?"
        yield Explanation("load", said, left, scale)
    elif field.driven == "supports":
        yield Explanation(
            "scale",
            f"{scale:.4g} times elasticity: prescribed displacements {scale:.4g} times as large? "
            "(No modulus shows where supports alone move the body.)",
            left,
            scale,
        )
    else:
        yield Explanation("scale", f"{scale:.4g} times elasticity", left, scale)


def _turned_round(field: Field, scale: float) -> Iterator[Explanation]:
    """The other sign, and a scale besides."""
    if scale and abs(scale + 1) > NOTICED * field.doubt:
        said = f"{scale:.4g} times elasticity: the other sign, and {-scale:.4g} times as large?"
        yield Explanation("sign", said, field.left(field.found / scale), scale)


def _axes(field: Field) -> Iterator[Explanation]:
    """Components swapped, or with other signs; the whole field mirrored."""
    d = field.found.shape[1]
    for order in permutations(range(d)):
        for signs in product((1.0, -1.0), repeat=d):
            if order == tuple(range(d)) and set(signs) == {1.0}:
                continue
            changed = field.found[:, list(order)] * np.array(signs)
            flips = [AXES[a] for a in range(d) if signs[a] < 0]
            words = []
            if order != tuple(range(d)):
                words.append(f"components in the order {', '.join(AXES[a] for a in order)}")
            if len(flips) == d and not words:
                words.append("the other sign")
            elif flips:
                words.append(f"the other sign of {' and '.join(flips)}")
            name = "axes" if order != tuple(range(d)) else "sign"
            yield Explanation(name, f"elasticity with {' and '.join(words)}?", field.left(changed))


def _mirrored(field: Field) -> Iterator[Explanation]:
    """The field of the body in a mirror, where the body looks alike in it."""
    if field.elsewhere is None:
        return
    span = field.span
    for axis, (low, high) in enumerate(span):
        places = field.places.copy()
        places[:, axis] = low + high - places[:, axis]
        other = field.elsewhere(places)
        if other is None:
            continue
        mirrored = other * np.where(np.arange(len(span)) == axis, -1.0, 1.0)
        if field.left(mirrored) <= FITS * field.left(field.found):
            continue  # elasticity is its own mirror image: this is no explanation
        said = f"elasticity of the body mirrored along {AXES[axis]}?"
        yield Explanation("mirrored", said, field.left(field.found, mirrored))


def _positions(field: Field) -> Iterator[Explanation]:
    yield Explanation(
        "positions",
        "positions in place of displacements: take the places at rest off",
        field.left(field.found - field.places),
    )


def _points(field: Field) -> Iterator[Explanation]:
    """A few points wrong, all others right: the fewest beyond which the difference drops."""
    away = np.linalg.norm(field.found - field.wanted, axis=1) / field.size
    order = np.argsort(-away, kind="stable")
    most = max(1, int(FEW_POINTS * len(away)))
    if len(away) < 4:
        return
    falling = away[order]
    drops = (falling[1 : most + 1] <= FITS * falling[:most]) & (falling[:most] > 0)
    if not drops.any():
        return
    count = int(drops.argmax()) + 1
    left = float(falling[count])
    where = ", ".join(f"{x:.4g}" for x in field.places[order[0]])
    few = f"{count} points" if count > 1 else "one point"
    rest = f"to {left:.1g} of the largest" if left > field.doubt else "to what is known"
    said = f"{few} wrong, the first at ({where}) m; all others are right {rest}"
    yield Explanation("one point", said, left, float(count))


def _known(field: Field) -> Iterator[Explanation]:
    """A solver that is right and not converged, as far as its own answers are known."""
    for name, wanted in field.known.items():
        said = f"as {name} gives it: take a finer mesh"
        yield Explanation("coarse mesh", said, field.left(field.found, wanted))


def _rigid(field: Field) -> Iterator[Explanation]:
    """A rigid motion beside: supports elsewhere, another frame."""
    modes = _modes(field.places)
    rest = field.found - field.wanted
    part = np.einsum("k,knd->nd", _fit(modes, rest), modes)
    yield Explanation(
        "rigid motion",
        "elasticity and a rigid motion: other supports, or another frame?",
        field.left(field.found - part),
    )


def _modes(places: Array) -> Array:
    """Rigid motions (k, n, d) about the middle."""
    middle = places - places.mean(axis=0)
    size = float(np.abs(middle).max()) or 1.0
    x = middle / size
    n, d = x.shape
    shifts = [np.broadcast_to(along, (n, d)) for along in np.eye(d)]
    if d == 2:
        return np.stack([*shifts, np.column_stack([-x[:, 1], x[:, 0]])])
    return np.stack([*shifts, *(np.cross(axis, x) for axis in np.eye(3))])


def _ratio(field: Field) -> Iterator[Explanation]:
    """Another Poisson's ratio, the modulus kept."""
    found = _fitted_ratio(field, scaled=False)
    if found is not None:
        nu, _, left = found
        said = f"Poisson's ratio {nu:.4g} in place of {field.ratio:g}?"
        yield Explanation("ratio", said, left, nu)


def _both(field: Field) -> Iterator[Explanation]:
    """A scale and another ratio together."""
    found = _fitted_ratio(field, scaled=True)
    if found is not None:
        nu, scale, left = found
        said = f"{scale:.4g} times elasticity of Poisson's ratio {nu:.4g} (given {field.ratio:g})?"
        yield Explanation("scale and ratio", said, left, nu)


def _fitted_ratio(field: Field, *, scaled: bool) -> tuple[float, float, float] | None:
    """Ratio, scale and what they leave; None where none that is known fits.

    Secant steps: elasticity bends with the ratio, near 1/2 above all.
    """
    if field.by_ratio is None:
        return None
    own = field.ratio
    low, high = field.ratios
    other = own + (RATIO_STEP if own + RATIO_STEP <= high else -RATIO_STEP)
    nu, move = own, field.wanted
    for _ in range(RATIO_STEPS):
        slope = (field.by_ratio(other) - move) / (other - nu)
        nu, move = other, field.by_ratio(other)
        if not slope.any():
            return None
        columns = np.stack([move, slope]) if scaled else slope[None]
        target = field.found if scaled else field.found - move
        fitted = _fit(columns, target)
        rest = float(np.linalg.norm(target - np.einsum("k,knd->nd", fitted, columns)))
        if rest > HALF * float(np.linalg.norm(field.found - field.wanted)):
            return None
        scale = float(fitted[0]) if scaled else 1.0
        if scale <= 0:
            return None
        other = min(max(nu + float(fitted[-1]) / scale, low), high)
        if abs(other - nu) < RATIO_SETTLED:
            break
    end = field.by_ratio(other)
    if scaled:
        scale = float((field.found * end).sum() / (end**2).sum())
    return other, scale, field.left(field.found, scale * end)


def split(field: Field) -> dict[str, Array]:
    """Parts (n, d) in m of found - wanted: scale, rigid motion, shape. Their sum is the whole."""
    modes = _modes(field.places)
    columns = np.concatenate([field.wanted[None], modes])
    fitted = _fit(columns, field.found - field.wanted)
    scale = fitted[0] * field.wanted
    rigid = np.einsum("k,knd->nd", fitted[1:], modes)
    return {
        "scale": scale,
        "rigid motion": rigid,
        "shape": field.found - field.wanted - scale - rigid,
    }
