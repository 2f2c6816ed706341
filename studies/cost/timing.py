"""How contestants are timed: in turn, so that what else the machine does strikes all alike."""

from __future__ import annotations

import gc
import time
from collections.abc import Callable, Hashable, Mapping
from typing import Any, NamedTuple, TypeVar

import pandas as pd

Name = TypeVar("Name", bound=Hashable)
Act = Callable[[], object]
SINGLE = "general, a step a pass"
"""The general path without waves: each step passes over memory once, so its time may be held beside
the bytes of a step. The other ways take several steps in a pass."""
ABSENT = "absent"
"""In the place of a number: a peer that is not installed."""
ROUNDS = 5
"""Of each contestant: a median of fewer hangs on one bad moment."""
QUICK_ROUNDS = 3
GROWTH = {
    "exponent_here": "of the nodes or unknowns in what grows, by least squares in logarithms (1), "
    'or "absent"',
    "low_here": 'lower end of its 95 % interval (1), or "absent"',
    "high_here": 'upper end of its 95 % interval (1), or "absent"',
}
"""Columns of a fitted power."""
SECONDS = {
    "cpu_seconds": "time of the process: median of the rounds, or one round's; 0 of a relaxation "
    'that failed, "absent" where a peer is not installed (s)',
    "least_cpu_seconds": 'shortest of the rounds, or "absent" (s)',
    "most_cpu_seconds": 'longest of the rounds, or "absent" (s)',
}
"""Columns of times."""


class Lap(NamedTuple):
    """Seconds of one round: of the process on all its cores, and of the clock on the wall."""

    cpu: float
    wall: float


def lap(act: Act) -> Lap:
    """Time one act."""
    cpu, wall = time.process_time(), time.perf_counter()
    act()
    return Lap(time.process_time() - cpu, time.perf_counter() - wall)


def in_turn(
    contestants: Mapping[Name, Act], rounds: int = ROUNDS, *, warm: bool = True
) -> dict[Name, list[Lap]]:
    """Laps of every contestant: A B C A B C and so on, after one untimed turn of each if `warm`.

    The untimed turn compiles, fills caches and lets lazy properties be made.
    """
    for act in contestants.values() if warm else ():
        act()
    gc.collect(1)  # what was just made: to look through all libraries takes longer than a round
    laps: dict[Name, list[Lap]] = {name: [] for name in contestants}
    for _ in range(rounds):
        for name, act in contestants.items():
            laps[name].append(lap(act))
    return laps


def summary(rounds: pd.DataFrame, value: str) -> pd.DataFrame:
    """Median, least and most of a column of rounds, a row for each of the other columns' values.

    "absent" stays what it is.
    """
    keys = [str(column) for column in rounds if column not in {"round", value}]
    rows = []
    for key, part in rounds.groupby(keys, sort=False):
        values = part[value]
        gone = (values == ABSENT).any()
        number = values if gone else values.astype(float)
        rows.append(
            {
                **dict(zip(keys, key if isinstance(key, tuple) else (key,), strict=True)),
                value: ABSENT if gone else float(number.median()),
                f"least_{value}": ABSENT if gone else float(number.min()),
                f"most_{value}": ABSENT if gone else float(number.max()),
            }
        )
    return pd.DataFrame(rows)


def ratios(
    rounds: pd.DataFrame, value: str, over: Mapping[str, object], under: Mapping[str, object]
) -> list[float]:
    """Round by round, the value of the rows that match `over` over that of those of `under`.

    Empty where either was not measured.
    """
    a, b = (_matching(rounds, value, wanted) for wanted in (over, under))
    if not (len(a) and len(a) == len(b)) or ABSENT in {*a, *b}:
        return []
    return [float(x) / float(y) for x, y in zip(a, b, strict=True)]


def _matching(rounds: pd.DataFrame, value: str, wanted: Mapping[str, object]) -> list[Any]:
    for column, word in wanted.items():
        rounds = rounds[rounds[column] == word]
    return list(rounds[value])
