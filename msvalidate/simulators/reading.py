"""What a probe read: a stiffness, how well it is known, and the flags without which none counts."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from msvalidate.simulators.masses import Masses
from msvalidate.simulators.moduli import (
    SHOWN,
    Elastic,
    anisotropy,
    bulk_and_shear,
    compliances,
    elastic,
)

ISOTROPIC = 0.01
"""Anisotropy beyond which E and nu are told to be of the isotropic part alone: at it they differ
by direction by about as much as a law is asked to be told apart."""


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
    because: str
    refuses: bool = True

    @property
    def holds(self) -> bool:
        """Whether the value is there and within the limit."""
        return self.value is not None and bool(self.value <= self.limit)

    def line(self) -> str:
        """The flag in one line."""
        value = "not asked" if self.value is None else f"{self.value:.1e}"
        verdict = "ok" if self.holds else ("REFUSED" if self.refuses else "told")
        return f"  {verdict:7} {self.name}: {value} (limit {self.limit:.1e}) {self.because}"


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
        reason = "; ".join(self.refusals())
        return Elastic(None, None, np.inf, np.inf, reason)

    @property
    def E(self) -> float | None:
        """Pa; None where there is none, or none that counts."""
        return self.elastic.E

    @property
    def nu(self) -> float | None:
        """Poisson's ratio; None as for E."""
        return self.elastic.nu

    def refusals(self) -> list[str]:
        """Why the reading does not count."""
        found = [
            f"{flag.name} {'not asked' if flag.value is None else format(flag.value, '.1e')}"
            for flag in self.flags
            if flag.refuses and not flag.holds
        ]
        if not self.is_known:
            part = self.error / (np.abs(self.C).max() or 1.0)
            needed = f"{self.shown:g} is needed"
            found.append(f"C known to {part:.1e} of its largest component, {needed}")
        if self.is_bound:
            found.append("an upper bound alone: inner nodes are not at rest")
        return found

    def lines(self) -> list[str]:
        """The reading in words, its flags with it."""
        by = f"{self.about.get('simulator', 'simulator')} {self.about.get('version', '')}".strip()
        how = f"strain {self.strain:g}, dt {self.dt:g} s, {self.precision}, at {self.forces_at}"
        head = f"{by}, {self.about.get('law', 'law not said')}: {how}"
        return [head, *self._moduli_lines(), *(flag.line() for flag in self.flags)]

    def _moduli_lines(self) -> list[str]:
        known = f"known to {self.error:.1g} Pa in each component"
        largest = np.abs(self.C).max()
        found = [f"C: largest component {largest:.6g} Pa, {known}"]
        if not self.is_known:
            found = ["C: not shown"]
        if not self.is_valid:
            return [*found, f"does not count: {'; '.join(self.refusals())}", *self._mass_lines()]
        e, K_G = self.elastic, bulk_and_shear(self.C)
        for name, value, error in (("E", e.E, e.E_error), ("nu", e.nu, e.nu_error)):
            said = f"{value:.6g} ± {error:.1g}" if value is not None else f"none: {e.because}"
            found.append(f"{name}: {said}")
        part = anisotropy(self.C)
        axes, ratios = compliances(self.C)
        found.append(f"K {K_G[0]:.6g} Pa, G {K_G[1]:.6g} Pa, each ± {self.error:.1g} Pa")
        if np.isfinite(axes).all():
            found.append(
                f"along the axes: 1/S_ii {axes.min():.6g} to {axes.max():.6g} Pa, nu_ij "
                f"{ratios.min():.5f} to {ratios.max():.5f}"
            )
        of = "E and nu are of the isotropic part alone" if part > ISOTROPIC else "isotropic"
        return [*found, f"anisotropy {part:.1e}: {of}", *self._mass_lines()]

    def _mass_lines(self) -> list[str]:
        return [self.masses.line()] if self.masses else ["masses: not observed; forces were told"]

    def table(self) -> pd.DataFrame:
        """The reading as rows: quantity, value, error or limit, unit, holds, because.

        A value that does not count or does not exist is NaN, and says why.
        """
        e, K_G = self.elastic, bulk_and_shear(self.C)
        why = "; ".join(self.refusals())
        nan, valid = float("nan"), self.is_valid
        rows: list[tuple[str, float, float, str, bool, str]] = [
            ("E", nan if e.E is None else e.E, e.E_error, "Pa", e.E is not None, e.because),
            ("nu", nan if e.nu is None else e.nu, e.nu_error, "1", e.nu is not None, e.because),
            ("K", K_G[0] if valid else nan, self.error, "Pa", valid, why),
            ("G", K_G[1] if valid else nan, self.error, "Pa", valid, why),
            ("anisotropy", anisotropy(self.C) if valid else nan, SHOWN, "1", valid, why),
        ]
        for flag in self.flags:
            value = nan if flag.value is None else flag.value
            rows.append((flag.name, value, flag.limit, "1", flag.holds, flag.because))
        columns = ["quantity", "value", "error_or_limit", "unit", "holds", "because"]
        return pd.DataFrame(rows, columns=columns)


STRAINS = "rounding of strains"
"""Name of the cause that multiplies C."""
SOLVED = "solves_to"
"""Name of the cause that a step's change of velocity is left unsolved by this part."""
OF_PARTS = (STRAINS, SOLVED)
INNER = "force on inner nodes"
"""Name of the flag by which a lattice is known."""
