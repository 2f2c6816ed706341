"""Displacements with one known fault each, for every case of the set: what is said?"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from msvalidate_check import ElasticCase, check, elastic_case
from msvalidate_check.case_set import case_facts, case_names

RATIO = {True: 0.4999, False: 0.3}
"""Poisson's ratio that a case is asked at: rubber's, and all others'."""
CHANCE = 20_261_123


@dataclass(frozen=True)
class Faulty:
    """A field, the causes that explain it, and the number that the first of them fits.

    No causes: nothing is wrong, or nothing known is. `at_rest` is handed to the checker.
    """

    fault: str
    case: ElasticCase
    displacement: np.ndarray
    causes: tuple[str, ...]
    value: float | None = None
    more: dict = field(default_factory=dict)


def faulty_fields(part: int = 1) -> Iterator[Faulty]:
    """Fields of every case, or of one case in `part`; the same ones every time."""
    chance = np.random.default_rng(CHANCE)
    for name in case_names()[::part]:
        ratios = case_facts(name)["ratios"]
        nu = RATIO[0.3 not in ratios]
        case = elastic_case(name, nu)
        yield from _of_numbers(case, chance)
        yield from _of_material(case, ratios, chance)
        yield from _of_components(case)
        yield from _of_solvers(case, chance)


def _size(case: ElasticCase) -> float:
    return float(np.linalg.norm(case.wanted, axis=1).max())


def _of_numbers(case: ElasticCase, chance: np.random.Generator) -> Iterator[Faulty]:
    u = case.wanted
    yield Faulty("none", case, u, ())
    yield Faulty("float32", case, u.astype(np.float32), ())
    yield Faulty("six digits", case, np.array([[float(f"{x:.6g}") for x in row] for row in u]), ())
    x = case.points[case.named]
    moved = (x + u).astype(np.float32).astype(float) - x.astype(np.float32).astype(float)
    said = {"accuracy": 2.0**-23 * np.abs(x + u).max() / _size(case)}
    yield Faulty("float32 positions", case, moved, (), more=said)
    yield Faulty("millimetres", case, 1e3 * u, ("unit",), 1e3)
    yield Faulty("positions", case, x + u, ("positions",))
    if len(u) > 8:
        one = u.copy()
        row = int(chance.integers(len(u)))
        one[row] += 0.3 * _size(case) * _direction(chance, u.shape[1])
        yield Faulty("one point", case, one, ("one point",), 1.0)


def _direction(chance: np.random.Generator, d: int) -> np.ndarray:
    way = chance.normal(size=d)
    return way / np.linalg.norm(way)


def _of_material(case: ElasticCase, ratios: list, chance: np.random.Generator) -> Iterator[Faulty]:
    u, own = case.wanted, case.nu
    loads = case.driven != "supports"
    for part in (-0.1, 0.03, 0.3):
        scale = 1 / (1 + part)
        if loads:
            yield Faulty("modulus", case, scale * u, ("modulus", "load"), scale)
    if case.driven == "weight":
        scale = float(chance.uniform(1.05, 1.6))
        yield Faulty("mass", case, scale * u, ("load", "modulus"), scale)
    for nu in ratios:  # what the set holds at these was found by itself, not by the cubic
        other = elastic_case(case.name, nu).wanted
        if nu != own and np.abs(other - u).max() > 1e-3 * _size(case):
            yield Faulty("ratio", case, other, ("ratio",), nu)
    if own < 0.45 and loads:  # λ in the place of λ + μ
        raw = (4 * own - 1) / (4 * own)
        scale = (1 + own) / (1 + raw)
        off = scale * case.at_ratio(raw)
        if np.abs(off - u).max() > 1e-3 * _size(case):  # no shear block is told by it
            yield Faulty("raw lambda", case, off, _both(case, raw, scale), raw)


def _both(case: ElasticCase, nu: float, scale: float) -> tuple[str, ...]:
    """Causes of a scale and a ratio together: where ratios only scale, a scale alone does."""
    u, other = case.wanted, case.at_ratio(nu)
    same = float((u * other).sum() / (u * u).sum())
    if np.abs(other - same * u).max() < 1e-3 * abs(same * scale - 1) * _size(case):
        return ("modulus", "load")
    return ("scale and ratio",)


def _of_components(case: ElasticCase) -> Iterator[Faulty]:
    u, d = case.wanted, case.points.shape[1]
    swapped = u[:, [1, 0, *range(2, d)]]
    if np.abs(swapped - u).max() > 0.01 * _size(case):
        yield Faulty("swapped axes", case, swapped, ("axes",))
    yield Faulty("sign", case, -u, ("sign",))
    x = case.points[case.named]
    middle = (x.min(axis=0) + x.max(axis=0)) / 2
    for axis in range(d):
        there = x.copy()
        there[:, axis] = 2 * middle[axis] - there[:, axis]
        away = np.abs(x[None] - there[:, None]).max(axis=2)
        if away.min(axis=1).max() > 1e-9:
            continue
        mirrored = u[away.argmin(axis=1)].copy()
        mirrored[:, axis] *= -1
        if np.abs(mirrored - u).max() > 0.01 * _size(case):
            yield Faulty("mirrored", case, mirrored, ("mirrored",))
            return


def _of_solvers(case: ElasticCase, chance: np.random.Generator) -> Iterator[Faulty]:
    for field_ in case.coarse().values():
        if np.abs(field_ - case.wanted).max() > 1e-3 * _size(case):
            yield Faulty("coarse mesh", case, field_, ("coarse mesh",))
    x = case.points[case.named]
    along = (x - x.min(axis=0)) / np.ptp(x, axis=0)
    slow = 0.03 * np.sin(np.pi * along[:, :1] * float(chance.uniform(0.6, 0.9)))
    unrested = case.wanted * (1 - slow)
    yield Faulty("not at rest", case, unrested, ("rest",), more={"at_rest": 0.05})
    yield Faulty("not at rest, unknown", case, unrested, ())


def judged(faulty: Faulty) -> tuple[bool, tuple[str, ...], bool]:
    """Whether the cause is right, those that were told, and whether its size is within 20 %."""
    case = faulty.case
    verdict = check(case, case.points[case.named], faulty.displacement, **faulty.more)
    told = tuple(each.name for each in verdict.causes)
    if faulty.fault == "not at rest, unknown":
        return "at rest is unknown" in str(verdict), told, True
    if not faulty.causes:
        return bool(verdict) and not told, told, True
    right = all(cause in told for cause in faulty.causes[:2])
    first = next((each for each in verdict.causes if each.name in faulty.causes), None)
    sized = True
    if faulty.value is not None and first is not None:
        wanted, origin = faulty.value, 1.0 if faulty.value > 1.5 else 0.0
        if faulty.fault in {"ratio", "raw lambda"}:
            origin = case.nu
        elif faulty.fault in {"modulus", "mass"}:
            origin = 1.0
        sized = abs(first.value - wanted) <= 0.2 * abs(wanted - origin) + 1e-9
    return right, told, sized
