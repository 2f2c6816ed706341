"""Rows of the gate: tests, their results, and which remedies and units they leave open."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal

from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.protocol import Answer
from msvalidate.simulators.probe.reading import BAND
from msvalidate_check.causes import Phrase, phrase
from msvalidate_check.scales import FAR_UNIT

Word = Literal["passed", "stopped", "cannot", "told", "not at rest", "not asked"]
PASSED: Word = "passed"
STOPPED: Word = "stopped"
TOLD: Word = "told"
MOVING: Word = "not at rest"
LEFT_OUT: Word = "not asked"
FREE_FALL, AGAIN, MODULUS = "free fall", "the same again", "twice the modulus"
STRETCHED = "stretched step"
CONVERGENCE = HALF_STEP, ITERATIONS, MORE_STEPS = (
    "dt / 2",
    "twice the iterations",
    "twice the steps",
)
"""Rows that test convergence."""
LENGTH, STEP = "rest", "time step"
"""Causes of a displacement that is not converged: too short a run, too long a time step."""
TIMES, SCALE = "times the expected size", 10**1.5
"""Unit of rows on units, and the factor from which a size is nearer to 1000 times the expected one:
documented laws stay within 2, and springs of stiffness E h on each edge within 5."""
UNSTATED = 1e-3
"""Residual motion relative to the displacement that is accepted without a statement.

It is a fifth of the 0.5 % to which moduli are checked.
"""
SHORTER = 3.0
"""Ratio of the changes by half the step and by half the run.

The motion that is left decays exponentially with the length: half of it leaves the square root.
"""
DIVERGED = 0.01
"""Error of the mean velocity relative to the largest, below which forces between nodes diverge."""


@dataclass(frozen=True)
class GateRow:
    """Result of one check.

    Parameters
    ----------
    name
        What.
    value, unit, limit
        Found, and the most that passes; NaN where there is none.
    because
        Why the limit is as wide as it is, a phrase, or what kept it from being tried, in words.
    verdict
        "passed", "stopped", "cannot" (it could not be asked), "told" (no limit), "not asked" (after
        a question that took too long), or "not at rest": within the limit, by what it says may
        still change alone.
    """

    name: str
    value: float
    unit: str
    limit: float
    because: str | Phrase
    verdict: Word


@dataclass(frozen=True)
class Gate:
    """All that was tried of a simulator; one that does not pass has no error to show.

    Parameters
    ----------
    rows
        In order.
    remedies
        `LENGTH`, `STEP`, or both as rivals: causes of a displacement that is not converged.
    """

    rows: tuple[GateRow, ...]
    remedies: tuple[str, ...] = (LENGTH, STEP)

    @property
    def passed(self) -> bool:
        """Return True if a check passed and none stopped."""
        verdicts = {row.verdict for row in self.rows}
        return STOPPED not in verdicts and PASSED in verdicts

    @property
    def moving(self) -> float:
        """Relative change of the displacement by a longer run; 0 at rest."""
        return max((row.value for row in self.rows if row.verdict == MOVING), default=0.0)

    @property
    def stops(self) -> tuple[GateRow, ...]:
        """Rows that stopped it."""
        return tuple(row for row in self.rows if row.verdict == STOPPED)

    @property
    def units(self) -> tuple[GateRow, ...]:
        """Rows on sizes that wrong units explain."""
        return tuple(row for row in self.rows if row.unit == TIMES)

    @property
    def shows_units(self) -> bool:
        """True if the stiffness of one step is wrong by a power of 1000.

        No time step or length of run explains that, as both leave such a step nearly as it is.
        """
        powers = [
            math.log10(abs(row.value)) / 3 for row in self.units if row.name.startswith(STRETCHED)
        ]
        return any(round(n) and abs(n - round(n)) <= math.log10(FAR_UNIT) / 3 for n in powers)

    @property
    def unconverged(self) -> GateRow | None:
        """Test of convergence with the largest change; None if the same question changes too.

        Without such a test it is a modulus that counts in part: unsolved steps hide it.
        """
        rows = [row for row in self.rows if row.name in CONVERGENCE and _fails(row)]
        if not rows and STEP in self.remedies:
            rows = [row for row in self.stops if row.name == MODULUS and row.value < 1 - BAND]
        if any(row.name == AGAIN for row in self.stops):
            return None
        return max(rows, key=lambda row: row.value, default=None)


def _fails(row: GateRow, least: float = math.inf) -> bool:
    """Return true if a test changes the displacement by too much, or by `least`."""
    return row.value > least or (row.verdict in {STOPPED, MOVING} and row.value >= 0)


def remedies_of(rows: Mapping[str, GateRow], first: Answer) -> tuple[str, ...]:
    """Return the causes that the tests of convergence leave open.

    A shorter step may also mean a shorter run. It is the step alone if twice as many steps change
    nothing, if more iterations in each do, or if a run of twice the length is stated to do less.
    """
    half, more = rows[HALF_STEP], rows[MORE_STEPS]
    by_step = half.value > SHORTER * math.sqrt(more.value)
    if _fails(more, UNSTATED) and not by_step:
        return (LENGTH,)
    if not _fails(half, UNSTATED):
        hidden = half.verdict == "cannot" and first.about.get("forces_at") == "end"
        return (LENGTH, STEP) if hidden else (LENGTH,)
    states = "change_when_twice_as_long" in first.about.get("at_rest", {})
    alone = by_step or more.verdict == PASSED or _fails(rows[ITERATIONS], UNSTATED)
    return (STEP,) if alone or (states and half.verdict == STOPPED) else (LENGTH, STEP)


def size_rows(name: str, times: float) -> list[GateRow]:
    """Return a row on a size that is off by `SCALE`, or none."""
    if not times or 1 / SCALE < abs(times) < SCALE:
        return []
    of = phrase(f"units of {name}", part=1 / times)
    return [GateRow(": size", times, TIMES, math.nan, of, TOLD)]
