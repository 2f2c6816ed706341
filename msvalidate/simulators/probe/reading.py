"""What a probe read: a stiffness, how well it is known, and the flags without which none counts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from msvalidate.simulators.probe.masses import Masses
from msvalidate.simulators.probe.moduli import SHOWN, Elastic, elastic
from msvalidate_check.causes import Phrase, phrase


@dataclass(frozen=True)
class Flag:
    """A number that would be 0 of a body that is what a reading takes it for.

    Parameters
    ----------
    name
        What was looked at.
    value
        Without unit; None where it could not be asked.
    limit
        Largest value of a reading that counts.
    because
        Why the limit is where it is, and what a larger value means.
    refuses
        Whether the reading does not count beyond the limit; else it is told and no more.
    """

    name: str
    value: float | None
    limit: float
    because: str | Phrase
    refuses: bool = True

    @property
    def holds(self) -> bool:
        """Whether the value is there and within the limit."""
        return self.value is not None and bool(self.value <= self.limit)

    @property
    def shown(self) -> Phrase:
        """Its name and value."""
        if self.value is None:
            return phrase("flag not asked", name=self.name)
        return phrase("flag", name=self.name, value=self.value)


@dataclass(frozen=True, eq=False)
class Reading:
    """Stiffness of a simulator's solid to first order, at rest.

    Parameters
    ----------
    C
        (6, 6) Pa, in order xx, yy, zz, yz, xz, xy with engineering strains: nominal stress by
        strain. As measured: symmetric only as far as the body is.
    error
        Pa, of each component.
    causes
        Cause -> its part, Pa; of independent causes, `error` is the root of the sum of squares.
        `OF_PARTS` count in E and nu by their part of each modulus.
    flags
        In order.
    masses
        Measured; None where a program told forces.
    strain, dt, precision, forces_at
        How it was read; dt in s.
    about
        What the simulator says of itself.
    """

    C: Array
    error: float
    causes: Mapping[str, float]
    flags: tuple[Flag, ...]
    masses: Masses | None
    strain: float
    dt: float
    precision: str
    forces_at: str
    about: Mapping[str, Any]

    @property
    def is_valid(self) -> bool:
        """Whether every flag that refuses holds, and C is known to `shown` of its largest."""
        return self.is_known and all(flag.holds for flag in self.flags if flag.refuses)

    @property
    def shown(self) -> float:
        """Part to which a number is known that counts: `SHOWN`, and what steps are solved to."""
        return SHOWN + self.causes.get(SOLVED, 0.0) / float(np.abs(self.C).max() or 1.0)

    @property
    def is_known(self) -> bool:
        """Whether every component of C is known to `shown` of the largest."""
        return bool(self.error <= self.shown * np.abs(self.C).max())

    @property
    def is_bound(self) -> bool:
        """Whether C is an upper bound alone: inner nodes would move if they were let."""
        return any(flag.name == INNER and not flag.holds for flag in self.flags)

    @cached_property
    def elastic(self) -> Elastic:
        """E and nu with their errors, or None with a reason."""
        if self.is_valid:
            parts = sum(self.causes.get(cause, 0.0) for cause in OF_PARTS)
            others = [part for cause, part in self.causes.items() if cause not in OF_PARTS]
            of_parts = parts / float(np.abs(self.C).max())
            return elastic(self.C, float(np.linalg.norm(others)), of_parts, self.shown)
        return Elastic(None, None, np.inf, np.inf, self.refusals())

    @property
    def E(self) -> float | None:
        """Pa; None where there is none, or none that counts."""
        return self.elastic.E

    @property
    def nu(self) -> float | None:
        """Poisson's ratio; None as for E."""
        return self.elastic.nu

    def refusals(self) -> tuple[Phrase, ...]:
        """Why the reading does not count."""
        found = [flag.shown for flag in self.flags if flag.refuses and not flag.holds]
        if not self.is_known:
            found.append(self.uncertain)
        if self.is_bound:
            found.append(phrase("upper bound"))
        return tuple(found)

    @property
    def uncertain(self) -> Phrase:
        """How well C is known."""
        part = self.error / (np.abs(self.C).max() or 1.0)
        return phrase("not known", part=float(part), needed=self.shown)


STRAINS = "rounding of strains"
"""Name of the cause that multiplies C."""
SOLVED = "solves_to"
"""Name of the cause that a step's change of velocity is left unsolved by this part."""
OF_PARTS = (STRAINS, SOLVED)
INNER = "force on inner nodes"
"""Name of the flag by which a lattice is known."""
