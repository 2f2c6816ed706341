"""One or two whole changes of a field: other axes or signs, a mirror, a coarse mesh, a scale.

The search takes every pair of a field that elasticity could be taken for (itself, its mirror image,
itself at mirrored places, without a component, in the other plane state, linear elements on a
coarse mesh) and of an order and signs of components, and asks how many times the one the other is.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from itertools import permutations, product

import numpy as np

from msvalidate_check.beside import AXES, ROUNDING, Array, Field
from msvalidate_check.causes import Cause, Phrase, phrase
from msvalidate_check.scales import NOTICED, Times, read_scale

MOST_ASKED = 0.1
"""Of the largest displacement: what no explanation leaves."""


@dataclass(frozen=True, eq=False)
class Image:
    """What a field may be a copy of: kind of the cause, phrase, displacements (n, d) in m."""

    kind: str
    of: Phrase
    wanted: Array


@dataclass(frozen=True)
class Frame:
    """An order of components and their signs: kind of the cause, phrases."""

    kind: str
    words: tuple[Phrase, ...]
    order: tuple[int, ...]
    signs: tuple[float, ...]

    def back(self, found: Array) -> Array:
        """A field (n, d) with its components put back."""
        return np.asarray(found[:, list(self.order)] * np.array(self.signs))

    def put(self, wanted: Array) -> Array:
        """A field (n, d) whose components, put back, are these."""
        found = np.empty_like(wanted)
        found[:, list(self.order)] = wanted * np.array(self.signs)
        return found


@cache
def frames(d: int) -> tuple[Frame, ...]:
    """All orders and signs in d dimensions, the plainest first: that of the axes themselves."""
    found = []
    for order in permutations(range(d)):
        for signs in product((1.0, -1.0), repeat=d):
            flips = [AXES[a] for a in range(d) if signs[a] < 0]
            moved = order != tuple(range(d))
            words = [phrase("axes", order=", ".join(AXES[a] for a in order))] * moved
            if len(flips) == d and not moved:
                words.append(phrase("sign"))
            elif flips:
                words.append(phrase("signs", axes=tuple(flips)))
            kind = "axes" if moved else "sign" if flips else ""
            found.append(Frame(kind, tuple(words), order, signs))
    off = {"": 0, "sign": 1, "axes": 2}
    found.sort(key=lambda each: (off[each.kind], sum(s < 0 for s in each.signs)))
    return tuple(found)


def images(field: Field) -> list[Image]:
    """Elasticity, and what is taken for it: see the head of this module."""
    found = [*_unwritten(field), *_other_state(field), *_mirrored(field)]
    least = NOTICED * field.uncertainty  # nearer ones are elasticity itself, as far as is known
    found = [each for each in found if field.left(each.wanted) > least]
    for name, by_ratio in field.known.items():
        found.append(Image("coarse mesh", phrase("named", name=name), by_ratio(field.ratio)))
    return [Image("", phrase("elasticity"), field.wanted), *found]


def _unwritten(field: Field) -> Iterator[Image]:
    """Elasticity without the component that is 0 everywhere."""
    for axis in np.flatnonzero(~field.found.any(axis=0)):
        shown = np.arange(field.found.shape[1]) != axis
        yield Image("component", phrase("component", axis=AXES[axis]), field.wanted * shown)


def _other_state(field: Field) -> Iterator[Image]:
    """Elasticity in the other plane state, which is that of another E and nu in this one.

    Plane stress of E and nu is plane strain of E(1 + 2nu)/(1 + nu)² and nu/(1 + nu); plane strain
    is plane stress of E/(1 - nu²) and nu/(1 - nu).
    """
    other = field.other_state()
    if other is None:
        return
    state, wanted = other
    nu = field.ratio
    E, like = (1 / (1 - nu**2), nu / (1 - nu))
    if state == "plane stress":
        E, like = (1 + 2 * nu) / (1 + nu) ** 2, nu / (1 + nu)
    yield Image("plane state", phrase("plane state", state=state, E=E, nu=like), wanted)


def _mirrored(field: Field) -> Iterator[Image]:
    """The field of the body in a mirror, and at mirrored places, where the body looks alike."""
    if field.elsewhere is None:
        return
    d = len(field.span)
    for axes in (*((axis,) for axis in range(d)), tuple(range(d))):
        turned = np.isin(np.arange(d), axes)
        low, high = np.array(field.span).T
        other = field.elsewhere(np.where(turned, low + high - field.places, field.places))
        if other is None:
            continue
        along = tuple(AXES[axis] for axis in axes)
        if len(axes) == 1:
            of = phrase("mirrored", axes=along)
            yield Image("mirrored", of, other * np.where(turned, -1.0, 1.0))
        yield Image("places", phrase("places", axes=along), other)


def explain_one_change(field: Field, every: list[Image]) -> Iterator[Cause]:
    """Other axes, other signs, or another of all `images`, and nothing besides."""
    itself, *others = every
    for image in others:
        of = phrase("as image" if image.kind == "coarse mesh" else "image", image=image.of)
        yield Cause(image.kind, of=of, left=field.left(field.found, image.wanted))
    seen: list[tuple[str, Array]] = []
    for frame in frames(field.found.shape[1])[1:]:
        if _least_left(field, itself, frame, 1.0, scaled=False) > MOST_ASKED:
            continue
        copy = frame.put(field.wanted)
        if any(kind == frame.kind and field.left(copy, other) <= ROUNDING for kind, other in seen):
            continue
        seen.append((frame.kind, copy))
        of = phrase("image", image=_with_frame(itself, frame))
        yield Cause(frame.kind, of=of, left=field.left(frame.back(field.found)))


def explain_two_changes(field: Field, every: list[Image], most: float) -> Iterator[Cause]:
    """Two of another scale, other axes or signs, and another image, that leave at most so much."""
    for image in every:
        for frame in frames(field.found.shape[1]):
            if image.kind and frame.kind:
                if _least_left(field, image, frame, most, scaled=False) <= most:
                    of = phrase("image", image=_with_frame(image, frame))
                    left = field.left(frame.back(field.found), image.wanted)
                    yield Cause(image.kind, of=of, left=left, beside=frame.kind)
            elif (image.kind or frame.kind) and (
                _least_left(field, image, frame, most, scaled=True) <= most
            ):
                for times in read_scale(field, frame.back(field.found), image.wanted):
                    yield _scaled(image, frame, times)


def _with_frame(image: Image, frame: Frame) -> Phrase:
    """An image with other axes or signs, if there are any."""
    return phrase("with", image=image.of, frame=frame.words) if frame.kind else image.of


def _least_left(field: Field, image: Image, frame: Frame, most: float, *, scaled: bool) -> float:
    """Less than a change can leave, from sums alone: the root of the mean of squares."""
    found, wanted = field.found, image.wanted
    both = sum(
        sign * float(found[:, a] @ wanted[:, k])
        for k, (a, sign) in enumerate(zip(frame.order, frame.signs, strict=True))
    )
    f, w = float((found**2).sum()), float((wanted**2).sum())
    if scaled and both <= 0:
        return most + 1
    scale = both / w if scaled else 1.0
    square = f / scale**2 - 2 * both / scale + w
    return float(np.sqrt(max(square, 0.0) / len(found))) / field.size


def _scaled(image: Image, frame: Frame, times: Times) -> Cause:
    """An image or a frame, and a scale besides."""
    key = "scale and" if times.unit is None else "unit and"
    of = phrase(key, scale=times.scale, image=_with_frame(image, frame), unit=times.unit)
    value = times.scale if times.unit is None else times.many
    return Cause(image.kind or frame.kind, value, of, times.left, times.kind)
