"""What a field of displacements would have to be for it to be elasticity's: units, signs, causes.

Each explanation changes the field, or elasticity, in one way, by as few numbers as it has (a scale,
a rigid motion, a ratio), fitted by least squares. It is told where it leaves little of the
difference, in elasticity's size and in the field's own, and not told where another leaves much
less: what fits as well is listed with it, for one field cannot tell them apart. Two faults at once
are told where both are simple and together leave far less than one alone. A scale is one of the
load as much as of the modulus, and where only supports move the body no modulus shows at all.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from msvalidate_check.beside import (
    Array,
    Driven,
    Field,
    fit,
    longest,
    rigid_motions,
    split,
)
from msvalidate_check.causes import Cause, Phrase, phrase
from msvalidate_check.changes import Image, explain_one_change, explain_two_changes, images
from msvalidate_check.mistakes import explain_mistakes
from msvalidate_check.ratios import explain_ratio, explain_ratio_besides
from msvalidate_check.scales import (
    AS_GOOD,
    AS_WELL,
    FITS,
    NOTICED,
    explain_scale,
    read_scale,
    units_of,
)

__all__ = ["FITS", "NOTICED", "Driven", "Field", "explain", "split"]
FEW_POINTS = 0.02
"""Part of the points, or one, that may be wrong while all others are right."""
FEWEST, FEWEST_BESIDES = 4, 9
"""Points of which one can be told from the others, and where these are wrong too."""
RIGHT = 0.02
"""Of the largest displacement, what a number that is fitted may leave, unless less is known: as
much as agrees by default. Bodies that bend by other loads are alike to some 4 %."""
WHOLE = {
    "unit",
    "unit of k",
    "sign",
    "axes",
    "mirrored",
    "places",
    "component",
    "positions",
    "node order",
}
"""Faults without a number to fit: a solver that errs besides has them too."""
OF_SIZE = {"scale", "unit", "unit of k", "modulus", "load", "thickness"}
"""Kinds of causes that change the size of a field alone."""
OF_UNKNOWN = {"coarse mesh", "coarse springs", "not converged"}
"""Kinds of causes whose fields are those of a mesh or a relaxation that is not known."""
NEAR = 0.25
"""Of the difference, what such a cause may leave where nothing fits: meshes of one size differ."""
MOST_NODES = 1000
"""Up to which an order of nodes is looked for: each is held to every other one."""


def explain(field: Field) -> tuple[Cause, ...]:
    """All explanations of a field that fit, the best first; none where it needs none."""
    if field.left(field.found) <= NOTICED * field.uncertainty:
        return ()
    if not field.found.any():
        return (Cause("zero", 0.0, phrase("zero"), 0.0),)
    before = min(1.0, field.difference)
    every = images(field)
    alone = list(_one_fault(field, every))
    most = max(FITS * before, field.uncertainty)
    little = [each for each in alone if _is_little(each, most, field.uncertainty)]
    one = _best(little, before, field.uncertainty)
    one = _with_rivals(one, little, {each.kind for each in field.mistakes})
    left = min(before, *(each.left for each in alone))
    if left <= AS_GOOD * before:
        return tuple(one)
    most = FITS * left
    pairs = _two_faults(field, every, most)
    two = _plainest([each for each in pairs if _is_little(each, most, field.uncertainty)])
    if two and left > NOTICED * field.uncertainty:
        one = []
    if not (one or two):
        near = [each for each in alone if each.kind in OF_UNKNOWN and each.left <= NEAR * before]
        one = sorted(near, key=lambda each: each.left)
    return (*two, *one)


def _is_little(found: Cause, most: float, uncertainty: float) -> bool:
    """Whether an explanation leaves little: less where it fits a number, which fits any field."""
    if found.kinds <= WHOLE:
        return found.left <= most
    return found.left <= min(most, max(RIGHT, NOTICED * uncertainty))


def _one_fault(field: Field, every: list[Image]) -> Iterator[Cause]:
    yield from explain_scale(field)
    yield from explain_one_change(field, every)
    yield from explain_mistakes(field)
    for ways in (_positions, _points, _rigid, explain_ratio):
        yield from ways(field)
    yield from _node_order(field, field.found, 1.0, "")


def _two_faults(field: Field, every: list[Image], most: float) -> Iterator[Cause]:
    """Pairs of faults; `most` is what they may leave."""
    yield from explain_two_changes(field, every, most)
    yield from explain_ratio_besides(field)
    yield from _positions_besides(field)
    yield from _points_besides(field)
    yield from _node_order_in_units(field)


def _best(good: list[Cause], before: float, uncertainty: float) -> list[Cause]:
    """Of those that leave little those that leave about as little as the best."""
    if not good:
        return []
    least = min(each.left for each in good)
    room = max(AS_WELL * least, NOTICED * uncertainty, AS_GOOD * before)
    return sorted((each for each in good if each.left <= room), key=lambda each: each.left)


def _with_rivals(best: list[Cause], little: list[Cause], mistakes: set[str]) -> list[Cause]:
    """The best explanations, with the rivals that leave little too.

    In bending a coarse mesh or other springs change a field by almost a uniform factor. Those of
    size alone have known mistakes as rivals, and known mistakes those of size, which come first if
    the mistake leaves no less than half as much. Units come before plain numbers, and the sign of
    a load before a mirror image that is the same.
    """
    kinds = {kind for each in best for kind in each.kinds}
    others = mistakes if kinds <= OF_SIZE else OF_SIZE if kinds & mistakes else set()
    rivals = [each for each in little if each.kinds <= others and each not in best]

    def rank(cause: Cause) -> float:
        if cause in best and cause.kind in {"unit", "unit of k"}:  # no chance gives such a number
            return 0.0
        if cause in best and cause.kind in {"load sign", "load missing"}:
            return -1.0
        return cause.left * (1 if cause.kinds <= OF_SIZE else AS_WELL)

    return sorted([*best, *rivals], key=rank)


def _plainest(found: list[Cause]) -> list[Cause]:
    """Of pairs the best of each name, and of these those that leave about as little."""
    best: dict[str, Cause] = {}
    for each in found:
        if each.name not in best or AS_WELL * each.left < best[each.name].left:
            best[each.name] = each
    least = min((each.left for each in best.values()), default=0.0)
    room = max(AS_WELL * least, AS_GOOD)
    kept = (each for each in best.values() if each.left <= room)
    return sorted(kept, key=lambda each: each.left)


# Other changes ------------------------------------------------------------------------------------


def _positions(field: Field) -> Iterator[Cause]:
    left = field.left(field.found - field.places)
    yield Cause("positions", of=phrase("positions"), left=left)


def _positions_besides(field: Field) -> Iterator[Cause]:
    """Positions in another unit, or of a body that moves more or less."""
    for unit, many in units_of(field).items():
        left = field.left(field.found / many - field.places)
        of = phrase("positions in unit", unit=unit)
        yield Cause("positions", many, of, left, "unit")
    moved = field.found - field.places
    for times in read_scale(field, moved, field.wanted):
        away = longest(moved - times.scale * field.wanted)
        left = max(times.left, away / field.size, away / longest(field.found))
        key = "positions and scale" if times.unit is None else "positions and unit"
        of = phrase(key, scale=times.scale, unit=times.unit)
        yield Cause("positions", times.many, of, left, times.kind)


def _points(field: Field) -> Iterator[Cause]:
    """A few points wrong, all others right in themselves."""
    found = _few_wrong(field, field.found, field.wanted)
    if found is not None:
        count, first, left = found
        key = "right" if left > field.uncertainty else "right as known"
        of = phrase(key, points=_few(field, count, first), left=left)
        yield Cause("one point", float(count), of, left)


def _points_besides(field: Field) -> Iterator[Cause]:
    """A few points wrong, and all others elasticity times a number, or as a coarse mesh has them.

    The number is the median over the points, which a few do not move.
    """
    exact = max(AS_GOOD, NOTICED * field.uncertainty)
    length = (field.wanted**2).sum(axis=1)
    large = length > length.max() / 100
    many = np.median((field.found * field.wanted).sum(axis=1)[large] / length[large])
    if len(length) < FEWEST_BESIDES:
        return
    if many > 0:
        found = _few_wrong(field, field.found / many, field.wanted)
        if found is not None and found[2] <= exact < abs(many - 1):
            of = phrase("others scaled", points=_few(field, *found[:2]), scale=float(many))
            yield Cause("one point", float(many), of, found[2], "scale")
    for name, by_ratio in field.known.items():
        found = _few_wrong(field, field.found, by_ratio(field.ratio))
        if found is not None and found[2] <= exact:
            image = phrase("named", name=name)
            of = phrase("others coarse", points=_few(field, *found[:2]), image=image)
            yield Cause("one point", float(found[0]), of, found[2], "coarse mesh")


def _few_wrong(field: Field, found: Array, wanted: Array) -> tuple[int, int, float] | None:
    """How many points are wrong, which is most, what the others leave; None if not a few are.

    They are the fewest beyond which the difference drops.
    """
    away = np.linalg.norm(found - wanted, axis=1) / field.size
    if len(away) < FEWEST:
        return None
    order = np.argsort(-away, kind="stable")
    most = max(1, int(FEW_POINTS * len(away)))
    falling = away[order]
    drops = (falling[1 : most + 1] <= FITS * falling[:most]) & (falling[:most] > 0)
    if not drops.any():
        return None
    count = int(drops.argmax()) + 1
    return count, int(order[0]), float(falling[count])


def _few(field: Field, count: int, first: int) -> Phrase:
    where = ", ".join(field.length(x, 4) for x in field.places[first])
    key = "points" if count > 1 else "one point"
    return phrase(key, count=count, place=where, unit=field.unit[0])


def _rigid(field: Field) -> Iterator[Cause]:
    """A rigid motion beside: supports elsewhere, another frame."""
    modes = rigid_motions(field.places)
    rest = field.found - field.wanted
    part = np.einsum("k,knd->nd", fit(modes, rest), modes)
    left = field.left(field.found - part)
    yield Cause("rigid motion", of=phrase("rigid motion"), left=left)


def _node_order_in_units(field: Field) -> Iterator[Cause]:
    """Nodes in another order, in a unit that the mean length of displacements shows."""
    scale = float(np.linalg.norm(field.found) / (np.linalg.norm(field.wanted) or 1.0))
    for unit, many in units_of(field).items():
        if abs(scale / many - 1) <= max(AS_GOOD, field.uncertainty):
            yield from _node_order(field, field.found / many, many, unit)


def _node_order(field: Field, found: Array, many: float, unit: str) -> Iterator[Cause]:
    """Elasticity of other nodes, each of one: the order of the nodes is lost."""
    if len(found) > MOST_NODES:
        return

    def cause(key: str, left: float) -> Cause:
        of = phrase(f"{key} in unit", unit=unit) if unit else phrase(key)
        return Cause("node order", many, of, left, "unit" if unit else "")

    backwards = field.left(found[::-1])
    room = min(FITS * min(1.0, field.difference), RIGHT)
    if backwards <= room:
        yield cause("reversed", backwards)
        return
    left = _matched(found, field.wanted, room * field.size)
    if left is not None:
        yield cause("other nodes", left / field.size)


def _matched(found: Array, wanted: Array, room: float) -> float | None:
    """Largest distance of vectors (n, d) that are matched one to one; None if some is beyond room.

    The nearest first: where many are alike, any of them will do.
    """
    square = np.zeros((len(found), len(found)))
    for a in range(found.shape[1]):
        square += (found[:, None, a] - wanted[None, :, a]) ** 2
    near = square <= room**2
    if not (near.any(axis=0).all() and near.any(axis=1).all()):
        return None
    most = 0.0
    for row in np.argsort(near.sum(axis=1), kind="stable"):
        column = int(square[row].argmin())
        most = max(most, float(square[row, column]))
        if most > room**2:
            return None
        square[:, column] = np.inf
    return float(np.sqrt(most))
