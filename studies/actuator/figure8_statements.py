"""What the report says of its Figure 8, as numbers, and what it comes to.

A statement is a number of a slab at rising voltages, above a bound or below it. It is physics where
it holds of springs and of finite elements, the model's where it holds of the report's way alone.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from msvalidate import kit

from . import models
from .bodies import HEIGHT, tips
from .models import SOURCES, Observation

LAYERS = 10
"""Of the springs, of the report's way and of the elements."""
COMMON = 2.0
"""Highest voltage (V) that all of them hold, for either slab."""
RAISED = 1.5
"""Voltage (V) that finer meshes hold too; the edge of 16 layers is lost before `COMMON`."""
LOW = 0.5
"""Voltage (V) at which the field leaves the slab nearly as it is."""
BESIDE = 0.2 * HEIGHT
"""Distance (m) inside an edge at which the marginal effect is told apart from the edge's own."""
OFF_THE_MARGIN = 1.5
"""Distance from an edge, in springs, beyond which a point is not at the margin.

A place one spring from the edge on every mesh moves to the edge as the mesh is refined.
"""
RIPPLE = 0.01
"""Part of the middle's deflection by which a dip must be deeper than what is around it."""


class Statement(NamedTuple):
    """A statement as a number of what was seen at rising voltages, to be above or below a bound."""

    figure: str
    covered: str
    words: str
    measured: str
    number: Callable[[list[Observation]], float]
    bound: float
    above: bool = True
    unit: str = "1"

    def holds(self, number: float) -> bool:
        """Whether it does of a number."""
        return number > self.bound if self.above else number < self.bound


def at(run: list[Observation], voltage: float) -> Observation:
    """What was seen at a voltage (V); raises SolverError if that was not held."""
    for one in run:
        if one.voltage == voltage:
            return one
    held = f"{run[-1].voltage:g} V" if run else "none"
    raise kit.SolverError(
        f"Figure 8: {voltage:g} V was not held, at which its statements are read (last held: "
        f"{held}); lay the candidate beside finite elements at lower voltages first"
    )


def last_two(run: list[Observation]) -> tuple[Observation, Observation]:
    """What was seen at the last two voltages; raises SolverError if `COMMON` was not held."""
    at(run, COMMON)
    return run[-2], run[-1]


def middle(one: Observation) -> float:
    """Deflection (m) of the middle."""
    return float(one.move[len(one.x) // 2, 1])


def margin(one: Observation) -> float:
    """Deflection (m) of the electrode's left edge."""
    return float(one.move[one.covered, 1][0])


def deflection(one: Observation) -> float:
    """Deflection (m) 2 m inside the left edge."""
    x = one.x[one.covered]
    return float(np.interp(x[0] + BESIDE, x, one.move[one.covered, 1]))


def growth(run: list[Observation]) -> float:
    """Marginal effect, 2 m inside the edge over the middle, at `RAISED` over that at `LOW`."""
    low, high = (deflection(at(run, v)) / middle(at(run, v)) for v in (LOW, RAISED))
    return high / low


def count_dips(one: Observation) -> int:
    """Number of dips under the electrode, its edges among them."""
    depth = -one.move[one.covered, 1]
    least = RIPPLE * abs(middle(one))
    count, low, falling = 0, depth[0], False
    high = depth[0]
    for value in depth[1:]:
        if not falling:
            high, low = max(high, value), min(low, value)
            if value < high - least:
                count, falling, low = count + 1, True, value
        else:
            low = min(low, value)
            if value > low + least:
                falling, high = False, value
    return count + (not falling)


def fastest_growth(before: Observation, after: Observation, covered: str) -> float:
    """Distance (m) from the nearest edge of where the upper face sank most."""
    sank = (before.move - after.move)[:, 1]
    return float(np.abs(after.x[sank.argmax()] - tips(covered)).min())


STATEMENTS = (
    Statement(
        "8 (2)", "full", "strong marginal effect", "2 m inside the edge over middle, at 0.5 V",
        lambda run: deflection(at(run, LOW)) / middle(at(run, LOW)), 1.5,
    ),
    Statement(
        "8 (2)", "full", "the effect grows with voltage",
        "2 m inside the edge over middle, at 1.5 V over that at 0.5 V",
        growth, 1.02,
    ),
    Statement(
        "8 (3)", "partial", "at low voltage a slight compression in the middle",
        "thinning of the middle, at 0.5 V", lambda run: -middle(at(run, LOW)) / HEIGHT, 0.05,
        above=False,
    ),
    Statement(
        "8 (3)", "partial", "at low voltage the middle is the main effect",
        "middle over largest deflection of the face, at 0.5 V",
        lambda run: middle(at(run, LOW)) / at(run, LOW).move[:, 1].min(), 0.5,
    ),
    Statement(
        "8 (3)", "partial", "the top becomes wavy at a higher voltage",
        "dips under the electrode at the last voltage held, more than at 0.5 V",
        lambda run: count_dips(run[-1]) - count_dips(at(run, LOW)), 0.5,
    ),
    Statement(
        "8 (3)", "partial", "the unstable part is not at the margin",
        "springs between the edge and what sinks fastest at the last voltage held",
        lambda run: fastest_growth(*last_two(run), "partial") / float(np.diff(run[-1].x[:2])[0]),
        OFF_THE_MARGIN,
    ),
    Statement(
        "8 (3)", "partial", "charges concentrate on the central part after the indentation",
        "charge on the middle half at the last voltage held, less that at 0.5 V",
        lambda run: run[-1].inner - at(run, LOW).inner, 0.0,
    ),
)  # fmt: skip


def judge_statement(
    statement: Statement, seen: Mapping[str, list[Observation]]
) -> dict[str, object]:
    """Row of a statement: its number three ways, and what it comes to."""
    values = [float(statement.number(seen[source])) for source in SOURCES]
    springs_do, fine, coarse, fem_does = (statement.holds(value) for value in values)
    holds = [s for s, v in zip(SOURCES, values, strict=True) if statement.holds(v)]
    row: dict[str, object] = {"figure": statement.figure, "statement": statement.words}
    row |= {"measured": statement.measured, "bound": statement.bound, "unit": statement.unit}
    names = ("in_springs", "in_report", "in_report_coarse", "in_fem")
    row |= dict(zip(names, values, strict=True))
    row |= {"judgement": " and ".join(holds) if holds else "none"}
    return row | {"verdict_on_statement": verdict(springs_do, fem_does, fine, coarse)}


def verdict(springs_do: bool, fem_does: bool, fine: bool, coarse: bool) -> str:
    """What a statement comes to, from the ways in which it holds."""
    if springs_do != fem_does:
        return "open: springs and FEM do not agree"
    if springs_do:
        seen = "" if fine and coarse else ", not shown by the report's way throughout"
        return f"physics{seen}"
    if fine or coarse:
        where = "" if fine and coarse else f" on {LAYERS if fine else models.COARSE} layers"
        return f"made by the report's model{where}"
    return "holds in none of them"
