"""Negative controls of the study: ways to break springs and to keep books that are wrong."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Index
from msvalidate.problem.records import replace
from msvalidate.springs.network import Network
from msvalidate.springs.network.breakage import critical_stretches
from msvalidate.springs.statics.breaking import Break, BreakingPath, FractureResult

from .intensity import INFINITE
from .moving import Late, Mends


class EitherWay(BreakingPath):
    """Springs that break when they are compressed as well, as one program's do."""

    def next(self) -> tuple[float, Index] | None:
        """The largest change of length, of either sign."""
        part = np.where(self.stiffness > 0, np.abs(self.elongation(self.unit)) / self.length, 0.0)
        return 1 / float(part.max()), np.flatnonzero(part >= (1 - 1e-9) * part.max())


class OwnAlone(BreakingPath):
    """What a break releases booked as the springs' own energy alone."""

    def cut(self, springs: Index, needed: float) -> Break | None:
        """As of springs that break."""
        found = super().cut(springs, needed)
        return replace(found, released=found.own) if found else None


def by(way: type[BreakingPath]) -> object:
    """As `grow`, on another way, without its look at the ledger."""

    def grow(
        network: Network, critical_stretch: ArrayLike, raised: float = 1.0, *,
        crack: Index | tuple[()] = (), most_breaks: int | None = None,
    ) -> FractureResult:  # fmt: skip
        stretch = critical_stretches(network, critical_stretch)
        own = way(network, stretch, crack=np.asarray(crack, dtype=np.intp))
        return own.follow(raised, math.inf if most_breaks is None else most_breaks)

    return grow


FAULTS: dict[str, dict[str, object]] = {
    "springs that break when compressed": {"candidate": by(EitherWay), "questions": ("small",)},
    "released booked as the springs' own": {"candidate": by(OwnAlone), "questions": ("small",)},
    "a spring that comes back when it shortens": {"springs": Mends, "questions": ("moving",)},
    "tip off by half a cell": {"moved": 0.5, "questions": ("tips",)},
    "viscous work with the velocity after the step": {"ledger": Late, "questions": ("moving",)},
    "the springs' own energy called growth": {"rule": "springs", "questions": ("growth",)},
    "plates of infinite height": {"known": INFINITE, "questions": ("plates",)},
}
