"""Displacements with two known faults at once, and garbage, for cases of the set: what is said?"""

from __future__ import annotations

import math
import runpy
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import numpy as np

from msvalidate_check import ElasticCase, check, elastic_case
from msvalidate_check.case_set import case_facts, case_names
from tests.checker.faulty_fields import RATIO
from tests.table import stored_rows

Array = np.ndarray
CHANCE = 7_041_776
SHOWS = 0.03
"""Of the given field's size: what each of two faults must change to be one that can be told."""
EVERY = 5
"""Each pair of faults is put into every fifth case, beginning with another one."""
GARBAGE = {
    "noise alone", "polynomial", "a tenth noise", "millimetres, a third noise", "waves",
    "another body's",
}  # fmt: skip
NUMBER_OFF = 0.2
"""Part of its own change by which a number that is told may be off."""
SOLVER = Path(__file__).resolve().parents[2] / "checker" / "example" / "my_solver.py"
OWN_MESHES = (
    ("twisted_bar", "tet4_2", 1.0, 0.45),
    ("twisted_bar", "tet4_2", 1.1, 0.3),
    ("cantilever_gravity", "tet4", 1.0, 0.4),
    ("cantilever_load", "tri3_2", 1.0, 0.37),
    ("cook", "tri3_3", 1.1, 0.3),
    ("cook", "tri3", 1.0, 0.1),
    ("clamped_pull", "tri3_2", 1.0, 0.35),
    ("lame_ring", "tri3_2", 1.3, 0.3),
)
"""Body, mesh, modulus over the case's, ratio: solved with linear elements."""


@dataclass(frozen=True)
class Doubly:
    """A field and what is wrong with it: names of causes, the number of times, the ratio.

    No names: it is garbage, and any cause is a wrong one.
    """

    faults: str
    case: ElasticCase
    displacement: Array
    causes: frozenset[str]
    times: float = 1.0
    ratio: float = math.nan
    more: dict = field(default_factory=dict)


@dataclass(frozen=True)
class Changed:
    """A field with faults so far: displacements (p, d) in m."""

    u: Array
    times: float = 1.0
    ratio: float = math.nan


def size(u: Array) -> float:
    return float(np.linalg.norm(u, axis=1).max())


def turned(case: ElasticCase, u: Array) -> Array:
    """A rigid motion of a quarter of the field's size."""
    x = case.points[case.named] - case.points[case.named].mean(axis=0)
    motion = np.column_stack([-x[:, 1] + x[:, 0].max(), x[:, 0], *(0 * x[:, 2:]).T])
    return u + 0.25 * size(u) * motion / size(motion)


def with_one_moved(_: ElasticCase, u: Array) -> Array:
    moved = u.copy()
    moved[len(u) // 2, -1] += 0.7 * size(u)
    return moved


def mirrored(case: ElasticCase, u: Array) -> Array:
    """The mirrored field along x; unchanged where the nodes are no mirror image of themselves."""
    x = case.points[case.named]
    there = x.copy()
    there[:, 0] = x[:, 0].min() + x[:, 0].max() - x[:, 0]
    away = np.abs(x[None] - there[:, None]).max(axis=2)
    if away.min(axis=1).max() > 1e-9:
        return u
    return u[away.argmin(axis=1)] * np.where(np.arange(x.shape[1]) == 0, -1.0, 1.0)


def shuffled(_: ElasticCase, u: Array) -> Array:
    return u[np.random.default_rng(CHANCE).permutation(len(u))]


AFTER: dict[str, Callable[[ElasticCase, Array], Array]] = {
    "millimetres": lambda _, u: 1e3 * u,
    "inches": lambda _, u: u / 0.0254,
    "modulus": lambda _, u: u / 1.1,
    "softer": lambda _, u: u / 0.75,
    "sign": lambda _, u: -u,
    "sign of y": lambda _, u: u * np.where(np.arange(u.shape[1]) == 1, -1.0, 1.0),
    "axes": lambda _, u: u[:, [1, 0, *range(2, u.shape[1])]],
    "mirrored": mirrored,
    "rigid motion": turned,
    "one point": with_one_moved,
    "reversed": lambda _, u: u[::-1],
    "permuted": shuffled,
    "positions": lambda case, u: case.points[case.named] + u,
}
TIMES = {"millimetres": 1e3, "inches": 1 / 0.0254, "modulus": 1 / 1.1, "softer": 1 / 0.75}
CAUSE = {
    "millimetres": "unit", "inches": "unit", "modulus": "scale", "softer": "scale",
    "sign of y": "sign", "reversed": "node order", "permuted": "node order",
}  # fmt: skip


def faulty_pairs() -> Iterator[Doubly]:
    """All fields, the same ones every time."""
    for number, name in enumerate(case_names()):
        ratios = case_facts(name)["ratios"]
        case = elastic_case(name, RATIO[0.3 not in ratios])
        for turn, pair in enumerate(stored_rows("faulty_pairs")):
            if (number + turn) % EVERY == 0:
                yield from _with(case, ratios, pair, number)
        if number % 2:
            yield from garbage(case, number)
    yield from own_solutions()


def _with(case: ElasticCase, ratios: list, pair: tuple[str, ...], number: int) -> Iterator[Doubly]:
    """The case with these faults, if each of them shows."""
    at = Changed(case.wanted)
    for fault in pair:
        before, at = at, _next(case, ratios, at, fault, pair, number)
        if size(at.u - before.u) < SHOWS * max(size(at.u), size(before.u)):
            return
    causes = frozenset(CAUSE.get(fault, fault) for fault in pair)
    yield Doubly(" + ".join(pair), case, at.u, causes, at.times, at.ratio)


def _next(
    case: ElasticCase, ratios: list, at: Changed, fault: str, pair: tuple[str, ...], number: int
) -> Changed:
    others = [nu for nu in ratios if nu != case.nu]
    nu = others[number % len(others)]
    if fault == "ratio" and "coarse mesh" in pair:
        meshes = list(elastic_case(case.name, nu).coarse().values())
        return Changed(meshes[number % len(meshes)], 1.0, nu) if meshes else at
    if fault == "ratio":
        other = elastic_case(case.name, nu).wanted
        many = float((other * at.u).sum() / (at.u**2).sum())
        only_scales = size(other - many * at.u) < SHOWS * abs(many - 1) * size(at.u)
        return at if only_scales else Changed(other, 1.0, nu)
    if fault == "coarse mesh":
        meshes = list(case.coarse().values())
        return Changed(meshes[number % len(meshes)]) if meshes else at
    return Changed(AFTER[fault](case, at.u), at.times * TIMES.get(fault, 1.0), at.ratio)


def garbage(case: ElasticCase, number: int) -> Iterator[Doubly]:
    """Fields that are no elasticity: noise of three sizes, polynomials, other bodies' fields."""
    chance = np.random.default_rng(CHANCE + number)
    u, x = case.wanted, case.points[case.named]
    noise = chance.normal(size=u.shape)
    for times in (1e-3, 1.0, 1e3):
        yield Doubly("noise alone", case, times * size(u) * noise, frozenset())
    y = (x - x.mean(axis=0)) / np.ptp(x)
    bent = np.stack([y[:, i] * y[:, j] for i in range(y.shape[1]) for j in range(i + 1)], axis=1)
    bent = bent @ chance.normal(size=(bent.shape[1], y.shape[1])) + y @ chance.normal(
        size=(y.shape[1],) * 2
    )
    if len(u) > 8:  # of fewer points many a polynomial is elasticity's
        for times in (1.0, 40.0):
            yield Doubly("polynomial", case, times * size(u) / size(bent) * bent, frozenset())
        yield Doubly("a tenth noise", case, u + 0.1 * size(u) * noise, frozenset())
        mm = 1e3 * (u + 0.3 * size(u) * noise)
        yield Doubly("millimetres, a third noise", case, mm, frozenset())
        half = u + 0.3 * size(u) * np.cos(9 * y + number)
        yield Doubly("waves", case, half, frozenset())
    body = case_facts(case.name)["body"]
    others = [
        each for each in case_names()
        if case_facts(each)["body"] != body and elastic_of(each).wanted.shape == u.shape
    ]  # fmt: skip
    if others and len(u) > 8:
        other = elastic_of(others[number % len(others)])
        yield Doubly("another body's", case, other.wanted, frozenset())


@cache
def elastic_of(name: str) -> ElasticCase:
    return elastic_case(name, RATIO[0.3 not in case_facts(name)["ratios"]])


def own_solutions() -> Iterator[Doubly]:
    """Linear elements on a mesh of the case, with another modulus or ratio, solved here."""
    solve = runpy.run_path(str(SOLVER))["solve"]
    for body, mesh, stiffer, nu in OWN_MESHES:
        case = elastic_case(body, 0.3, mesh)
        u = solve(
            case.points, case.cells, stiffer * case.E, nu, case.state, case.thickness, case.force,
            case.held, case.value,
        )  # fmt: skip
        second = "ratio" if nu != case.nu else "scale"
        times, ratio = 1 / stiffer, nu if nu != case.nu else math.nan
        causes = frozenset({"coarse mesh", second})
        yield Doubly(f"own mesh + {second}", case, u[: len(case.named)], causes, times, ratio)


def told_of(doubly: Doubly) -> tuple[str, bool, list[str]]:
    """Right, part, none or wrong; whether a modulus or ratio is false; what was told."""
    case = doubly.case
    verdict = check(case, case.points[case.named], doubly.displacement, **doubly.more)
    told = [_parts(each.name) for each in verdict.causes]
    wanted = _plain(doubly.causes)
    false = [_is_false(doubly, _parts(each.name), each.value) for each in verdict.causes]
    if not told:
        word = "none"
    elif any(each == wanted and not wrong for each, wrong in zip(told, false, strict=True)):
        word = "right"
    elif any(each < wanted or _plain(each | {"unit"}) == wanted for each in told):
        word = "part"
    else:
        word = "wrong"
    return word, word != "right" and any(false), [each.said for each in verdict.causes]


def _parts(name: str) -> frozenset[str]:
    """Causes in one name: modulus and load are a scale, and one beside a unit is the unit's."""
    same = {"modulus": "scale", "load": "scale"}
    return _plain(frozenset(same.get(part, part) for part in name.split(" and ")))


def _plain(causes: frozenset[str]) -> frozenset[str]:
    return causes - {"scale"} if "unit" in causes else causes


def _is_false(doubly: Doubly, told: frozenset[str], value: float) -> bool:
    """Whether a number of times or a ratio that is told is not the field's."""
    if "ratio" in told:
        own = doubly.case.nu
        true = own if math.isnan(doubly.ratio) else doubly.ratio
        return not abs(value - true) <= NUMBER_OFF * abs(true - own)
    if told & {"scale", "unit"}:
        return not abs(abs(value) - doubly.times) <= NUMBER_OFF * abs(doubly.times - 1)
    return False
