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
    Explanation,
    Field,
    fit,
    longest,
    rigid_motions,
    split,
)
from msvalidate_check.changes import Image, explain_one_change, explain_two_changes, images
from msvalidate_check.ratios import explain_ratio, explain_ratio_besides
from msvalidate_check.scales import AS_WELL, NOTICED, UNITS, explain_scale, read_scale

__all__ = ["FITS", "NOTICED", "Driven", "Explanation", "Field", "explain", "split"]
FITS = 0.1
"""Of the difference that was there, what an explanation may leave; of what one fault leaves, what
two at once may."""
AS_GOOD = 1e-3
"""Of the difference that was there: explanations that leave less than this fit as well."""
FEW_POINTS = 0.02
"""Part of the points, or one, that may be wrong while all others are right."""
FEWEST, FEWEST_BESIDES = 4, 9
"""Points of which one can be told from the others, and where these are wrong too."""
RIGHT = 0.02
"""Of the largest displacement, what a number that is fitted may leave, unless less is known: as
much as agrees by default. Bodies that bend by other loads are alike to some 4 %."""
WHOLE = {"unit", "sign", "axes", "mirrored", "places", "component", "positions", "node order"}
"""Faults without a number to fit: a solver that errs besides has them too."""
COARSE_KNOWN = 0.005
"""Of the largest displacement, to which linear elements on known meshes are known at any ratio."""
MOST_NODES = 1000
"""Up to which an order of nodes is looked for: each is held to every other one."""
SAME_LENGTH = 1e-3
"""Part by which a unit and the ratio of the mean lengths of two fields may differ."""


def explain(field: Field) -> tuple[Explanation, ...]:
    """All explanations of a field that fit, the best first; none where it needs none."""
    if field.left(field.found) <= NOTICED * field.uncertainty:
        return ()
    if not field.found.any():
        return (Explanation("zero", "nothing moves: the displacements are all 0", 0.0, 0.0),)
    before = min(1.0, field.difference)
    every = images(field)
    alone = list(_one_fault(field, every))
    one = [each for each in alone if _is_little(each, FITS * before, field.uncertainty)]
    one = _best(one, before, field.uncertainty)
    left = min(before, *(each.left for each in alone))
    if left <= AS_GOOD * before:
        return tuple(one)
    most = FITS * left
    pairs = _two_faults(field, every, most)
    two = _plainest([each for each in pairs if _is_little(each, most, field.uncertainty)])
    if two and left > NOTICED * field.uncertainty:
        one = []
    return (*two, *one)


def _is_little(found: Explanation, most: float, uncertainty: float) -> bool:
    """Whether an explanation leaves little: less where it fits a number, which fits any field."""
    faults = set(found.name.split(" and "))
    if "coarse mesh" in faults and len(faults) > 1:
        return found.left <= min(most, COARSE_KNOWN)
    if faults <= WHOLE:
        return found.left <= most
    return found.left <= min(most, max(RIGHT, NOTICED * uncertainty))


def _one_fault(field: Field, every: list[Image]) -> Iterator[Explanation]:
    yield from explain_scale(field)
    yield from explain_one_change(field, every)
    for ways in (_positions, _points, _rigid, explain_ratio):
        yield from ways(field)
    yield from _node_order(field, field.found, 1.0, "")


def _two_faults(field: Field, every: list[Image], most: float) -> Iterator[Explanation]:
    """Pairs of faults; `most` is what they may leave."""
    yield from explain_two_changes(field, every, most)
    yield from explain_ratio_besides(field)
    yield from _positions_besides(field)
    yield from _points_besides(field)
    yield from _node_order_in_units(field)


def _best(good: list[Explanation], before: float, uncertainty: float) -> list[Explanation]:
    """Of those that leave little those that leave about as little as the best."""
    if not good:
        return []
    least = min(each.left for each in good)
    room = max(AS_WELL * least, NOTICED * uncertainty, AS_GOOD * before)
    return sorted((each for each in good if each.left <= room), key=lambda each: each.left)


def _plainest(found: list[Explanation]) -> list[Explanation]:
    """Of pairs the best of each name, and of these those that leave about as little."""
    best: dict[str, Explanation] = {}
    for each in found:
        if each.name not in best or AS_WELL * each.left < best[each.name].left:
            best[each.name] = each
    least = min((each.left for each in best.values()), default=0.0)
    room = max(AS_WELL * least, AS_GOOD)
    kept = (each for each in best.values() if each.left <= room)
    return sorted(kept, key=lambda each: each.left)


# Other changes ------------------------------------------------------------------------------------


def _positions(field: Field) -> Iterator[Explanation]:
    said = "positions in place of displacements: take the places at rest off"
    yield Explanation("positions", said, field.left(field.found - field.places))


def _positions_besides(field: Field) -> Iterator[Explanation]:
    """Positions in another unit, or of a body that moves more or less."""
    said = "positions in place of displacements"
    for unit, many in UNITS.items():
        left = field.left(field.found / many - field.places)
        yield Explanation("positions and unit", f"{said}, in {unit}?", left, many)
    moved = field.found - field.places
    for times in read_scale(field, moved, field.wanted):
        many = times.scale
        away = longest(moved - many * field.wanted)
        left = max(times.left, away / field.size, away / longest(field.found))
        words = f"{said}, and displacements {many:.4g} times elasticity"
        words += f": {times.said}?" if times.said else ""
        yield Explanation(f"positions and {times.name}", words, left, times.many)


def _points(field: Field) -> Iterator[Explanation]:
    """A few points wrong, all others right in themselves."""
    found = _few_wrong(field, field.found, field.wanted)
    if found is not None:
        count, first, left = found
        rest = f"to {left:.1g} of the largest" if left > field.uncertainty else "to what is known"
        said = f"{_few(field, count, first)}; all others are right {rest}"
        yield Explanation("one point", said, left, float(count))


def _points_besides(field: Field) -> Iterator[Explanation]:
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
            said = f"{_few(field, *found[:2])}; all others {many:.4g} times elasticity"
            yield Explanation("one point and scale", said, found[2], float(many))
    for name, by_ratio in field.known.items():
        found = _few_wrong(field, field.found, by_ratio(field.ratio))
        if found is not None and found[2] <= exact:
            said = f"{_few(field, *found[:2])}; all others as {name} give them"
            yield Explanation("one point and coarse mesh", said, found[2], float(found[0]))


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


def _few(field: Field, count: int, first: int) -> str:
    where = ", ".join(f"{x:.4g}" for x in field.places[first])
    return f"{f'{count} points' if count > 1 else 'one point'} wrong, the first at ({where}) m"


def _rigid(field: Field) -> Iterator[Explanation]:
    """A rigid motion beside: supports elsewhere, another frame."""
    modes = rigid_motions(field.places)
    rest = field.found - field.wanted
    part = np.einsum("k,knd->nd", fit(modes, rest), modes)
    said = "elasticity and a rigid motion: other supports, or another frame?"
    yield Explanation("rigid motion", said, field.left(field.found - part))


def _node_order_in_units(field: Field) -> Iterator[Explanation]:
    """Nodes in another order, in a unit that the mean length of displacements shows."""
    scale = float(np.linalg.norm(field.found) / (np.linalg.norm(field.wanted) or 1.0))
    for unit, many in UNITS.items():
        if abs(scale / many - 1) <= max(SAME_LENGTH, field.uncertainty):
            yield from _node_order(field, field.found / many, many, f", in {unit}")


def _node_order(field: Field, found: Array, many: float, besides: str) -> Iterator[Explanation]:
    """Elasticity of other nodes, each of one: the order of the nodes is lost."""
    if len(found) > MOST_NODES:
        return
    name = "node order and unit" if besides else "node order"
    backwards = field.left(found[::-1])
    room = min(FITS * min(1.0, field.difference), RIGHT)
    if backwards <= room:
        said = f"elasticity of the nodes in the reverse order{besides}?"
        yield Explanation(name, said, backwards, many)
        return
    left = _matched(found, field.wanted, room * field.size)
    if left is not None:
        said = f"elasticity of other nodes, each of one{besides}: is their order lost?"
        yield Explanation(name, said, left / field.size, many)


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
