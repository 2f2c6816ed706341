"""What a field of displacements would have to be for it to be elasticity's: units, signs, causes.

Each explanation changes the field, or elasticity, in one way, by as few numbers as it has (a scale,
a rigid motion, a ratio), fitted by least squares. It is told where it leaves little of what was
there, and not told where another leaves much less: what fits as well is listed with it, for one
field cannot tell them apart. A scale is one of the load as much as of the modulus, and where only
supports move the body no modulus shows at all.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import permutations, product

import numpy as np

from msvalidate.problem import AXES, Array, Problem, rigid_motions

FITS = 0.25
"""Of the difference that was there, what an explanation may leave."""
AS_WELL = 2.0
"""Times what the best explanation leaves, up to which another fits as well."""
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
RATIO_STEP = 0.01
"""Change of Poisson's ratio with which its first-order effect is found."""


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

    `doubt` is how far elasticity and the numbers themselves may be off, over the largest;
    `by_ratio` gives elasticity (n, d) of another Poisson's ratio, None where there is none;
    `elsewhere` gives it at other places (n, d) in m, None where one lies outside the body.
    """

    places: Array
    found: Array
    wanted: Array
    doubt: float
    problem: Problem
    by_ratio: Callable[[float], Array] | None = None
    elsewhere: Callable[[Array], Array | None] | None = None

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
        each for ways in (_units, _axes, _mirrored, _positions, _points) for each in ways(field)
    ]
    simple += [*_scale(field), *_rigid(field), *_ratio(field)]
    fitting = _fitting(simple, before, field.doubt)
    if not fitting:
        fitting = _fitting(list(_both(field)), before, field.doubt)
    return tuple(fitting)


def _fitting(found: list[Explanation], before: float, doubt: float) -> list[Explanation]:
    """Those that leave little, and of these those that leave about as little as the best."""
    good = [each for each in found if each.left <= FITS * before]
    if not good:
        return []
    least = min(each.left for each in good)
    room = max(AS_WELL * least, NOTICED * doubt)
    kept = sorted((each for each in good if each.left <= room), key=lambda each: each.left)
    named = {each.name for each in kept}
    if "unit" in named:  # a unit is a scale that has a reason
        kept = [each for each in kept if each.name not in {"scale", "modulus", "load"}]
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
    scale = _best_scale(field, field.found)
    for unit, many in UNITS.items():
        if scale > 0 and abs(scale / many - 1) <= NEAR_UNIT:
            left = field.left(field.found / many)
            yield Explanation("unit", f"{many:g} times elasticity: {unit}?", left, many)


def _scale(field: Field) -> Iterator[Explanation]:
    scale = _best_scale(field, field.found)
    if not (math.isfinite(scale) and scale > 0):
        return
    left = field.left(field.found / scale)
    loaded = bool(field.problem.loads)
    moved = _moves_supports(field.problem)
    if loaded and not moved:
        yield Explanation(
            "modulus", f"{scale:.4g} times elasticity: a modulus E {1 / scale:.4g} times as large?",
            left, scale,
        )  # fmt: skip
        yield Explanation(
            "load", f"{scale:.4g} times elasticity: loads {scale:.4g} times as large?", left, scale
        )
    elif moved and not loaded:
        yield Explanation(
            "scale",
            f"{scale:.4g} times elasticity: prescribed displacements {scale:.4g} times as large? "
            "(No modulus shows where supports alone move the body.)",
            left,
            scale,
        )
    else:
        yield Explanation("scale", f"{scale:.4g} times elasticity", left, scale)


def _moves_supports(problem: Problem) -> bool:
    return any(
        callable(value) or value for support in problem.supports for value in support.displacement
    )


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
    span = field.problem.domain.span
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
    """A few points wrong, all others right."""
    away = np.linalg.norm(field.found - field.wanted, axis=1) / field.size
    order = np.argsort(-away, kind="stable")
    most = max(1, int(FEW_POINTS * len(away)))
    if len(away) < 4:
        return
    for count in sorted({1, 2, most}):
        if count > most:
            continue
        left = float(away[order[count]])
        if left <= FITS * float(away[order[count - 1]]):
            where = ", ".join(f"{x:.4g}" for x in field.places[order[0]])
            few = f"{count} points" if count > 1 else "one point"
            said = f"{few} wrong, the first at ({where}) m; all others are right"
            yield Explanation("one point", said, left, float(count))
            return


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
    return np.moveaxis(rigid_motions(middle / size), 2, 0)


def _sensitivity(field: Field) -> Array | None:
    """Change (n, d) of elasticity with Poisson's ratio, per unit of it."""
    if field.by_ratio is None:
        return None
    nu = getattr(field.problem.material, "nu", math.nan)
    step = RATIO_STEP if nu + RATIO_STEP < 0.49 else -RATIO_STEP
    return np.asarray((field.by_ratio(nu + step) - field.wanted) / step)


def _ratio(field: Field) -> Iterator[Explanation]:
    """Another Poisson's ratio, the modulus kept."""
    slope = _sensitivity(field)
    if slope is None or field.by_ratio is None or not slope.any():
        return
    nu = float(getattr(field.problem.material, "nu", math.nan))
    (change,) = _fit(slope[None], field.found - field.wanted)
    guess = nu + float(change)
    if not 0 <= guess < 0.495:
        return
    moved = field.by_ratio(guess)
    left = field.left(field.found, moved)
    yield Explanation("ratio", f"Poisson's ratio {guess:.4g} in place of {nu:g}?", left, guess)


def _both(field: Field) -> Iterator[Explanation]:
    """A scale and another ratio together."""
    slope = _sensitivity(field)
    if slope is None or field.by_ratio is None or not slope.any():
        return
    nu = float(getattr(field.problem.material, "nu", math.nan))
    a, b = _fit(np.stack([field.wanted, slope]), field.found)
    guess = nu + float(b / a) if a else math.nan
    if not (math.isfinite(guess) and 0 <= guess < 0.495 and a > 0):
        return
    moved = field.by_ratio(guess)
    scale = float((field.found * moved).sum() / (moved**2).sum())
    left = field.left(field.found, scale * moved)
    said = f"{scale:.4g} times elasticity of Poisson's ratio {guess:.4g} (given {nu:g})?"
    yield Explanation("scale and ratio", said, left, guess)


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
