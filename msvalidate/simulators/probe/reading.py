"""Result of a probe: stiffness, its uncertainty and the flags.

A flag that refuses invalidates the stiffness.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from typing import Any

import numpy as np

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import Array
from msvalidate.problem.records import dataclass
from msvalidate.simulators.probe.masses import Masses
from msvalidate.springs.constants.stiffness import AXES_OF, invariant_moduli, young_and_ratio
from msvalidate.springs.lattice.patterns import cubic_tensor
from msvalidate_check.causes import Phrase, phrase

SHOWN = 5e-3
"""No number is shown that is not known to this: of E relative, of nu absolute, of a component
of C by its largest."""
BAND = 0.01
"""Largest relative difference that counts as agreement.

It applies to masses, to displacements and to a law's prediction.
"""


@dataclass(frozen=True, eq=False)
class Elastic:
    """The isotropic solid nearest to a stiffness; None where there is none, and then a reason.

    Parameters
    ----------
    C
        (6, 6) Pa, the stiffness.
    E, E_error
        Pa.
    nu, nu_error
        Poisson's ratio.
    because
        Why one is not there; none if both are.
    """

    C: Array
    E: float | None
    nu: float | None
    E_error: float
    nu_error: float
    because: tuple[Phrase, ...]


def anisotropy(C: Array) -> float:
    """Relative distance of a tensor from the nearest isotropic one.

    In Mandel's scaling, in which the components are those of an orthonormal basis, so that the
    number is the same in all axes.
    """
    d = AXES_OF[len(C)]
    scale = np.sqrt(np.repeat([1.0, 2.0], [d, len(C) - d]))
    weight = np.outer(scale, scale)
    whole = float(np.linalg.norm(C * weight))
    K, G = invariant_moduli(C)
    near = cubic_tensor(d, K + (2 - 2 / d) * G, K - 2 * G / d, G)
    return float(np.linalg.norm((C - near) * weight)) / whole if whole else 0.0


def elastic(C: Array, error: float, of_strain: float = 0.0, shown: float = SHOWN) -> Elastic:
    """E and nu of the nearest isotropic solid, and how well they are known.

    E = 9 K G/(3 K + G), nu = (3 K - 2 G)/(6 K + 2 G). K is a mean of components and G a mean
    with weights whose sizes sum to 1: an error of each component makes no larger one of either.
    Strains that are off by a matrix M multiply C by I + M, and K drops out of what that makes of G:
    so each is off by its own part. With δK and δG the sums of both,

    - |δE| ≤ (9 G² δK + 27 K² δG)/(3 K + G)²,
    - |δnu| ≤ 9 (G δK + K δG)/(2 (3 K + G)²).

    Parameters
    ----------
    error
        Of each component of C, Pa, by stresses.
    of_strain
        Relative, by strains.
    """
    K, G = invariant_moduli(C)
    reason = _no_solid(C, K, G, error + of_strain * max_abs(C))
    if reason:
        return Elastic(C, None, None, np.inf, np.inf, reason)
    below = (3 * K + G) ** 2
    E, nu = young_and_ratio(3, K, G)
    K_error, G_error = error + of_strain * K, error + of_strain * G
    E_error = (9 * G**2 * K_error + 27 * K**2 * G_error) / below
    nu_error = 4.5 * (G * K_error + K * G_error) / below
    known_E, known_nu = E_error <= shown * E, nu_error <= shown
    missing = [
        phrase("known of it", name=name, error=size, of=of, needed=shown)
        for name, size, of, known in (
            ("E", E_error / E, phrase("of it"), known_E),
            ("nu", nu_error, Phrase(""), known_nu),
        )
        if not known
    ]
    moduli = E if known_E else None, nu if known_nu else None
    return Elastic(C, *moduli, E_error, nu_error, tuple(missing))


def _no_solid(C: Array, K: float, G: float, error: float) -> tuple[Phrase, ...]:
    """Why no isotropic solid has these moduli; nothing if one has."""
    for name, value in (("bulk", K), ("shear", G)):
        if value <= error:
            key = "vanishes" if abs(value) <= error else "negative"
            return (phrase(key, name=name, value=value, error=error),)
    lowest = float(np.linalg.eigvalsh((C + C.T) / 2)[0])
    if lowest <= error:
        sign = phrase("is negative" if lowest < -error else "is zero")
        return (phrase("singular", sign=sign, value=lowest),)
    return ()


@dataclass(frozen=True)
class Flag:
    """A number that would be 0 of a body that is what a reading takes it for.

    Parameters
    ----------
    name
        What was looked at.
    value
        Without unit.
    limit
        Largest value of a reading that counts.
    because
        Why the limit is where it is, and what a larger value means.
    refuses
        Whether the reading does not count beyond the limit; else it is told and no more.
    """

    name: str
    value: float
    limit: float
    because: Phrase
    refuses: bool = True

    @property
    def holds(self) -> bool:
        """Return True if the value is within the limit."""
        return bool(self.value <= self.limit)

    @property
    def shown(self) -> Phrase:
        """Name and value of the flag as text."""
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
    strain, precision
        How it was read.
    about
        What the simulator says of itself.
    """

    C: Array
    error: float
    causes: Mapping[str, float]
    flags: tuple[Flag, ...]
    masses: Masses | None
    strain: float
    precision: str
    about: Mapping[str, Any]

    @property
    def is_valid(self) -> bool:
        """Return True if no flag refuses and C is known.

        C is known to `shown` relative to its largest component.
        """
        return self.is_known and all(flag.holds for flag in self.flags if flag.refuses)

    @property
    def shown(self) -> float:
        """Largest relative uncertainty of C that counts as known.

        It is `SHOWN` and the accuracy to which steps are solved.
        """
        return SHOWN + self.causes.get(SOLVED, 0.0) / (max_abs(self.C) or 1.0)

    @property
    def is_known(self) -> bool:
        """Return True if C is known to `shown` of its largest component."""
        return bool(self.error <= self.shown * max_abs(self.C))

    @property
    def is_bound(self) -> bool:
        """Return True if C is only an upper bound.

        Inner nodes would move if they were free.
        """
        return any(flag.name == INNER and not flag.holds for flag in self.flags)

    @cached_property
    def elastic(self) -> Elastic:
        """E and nu with their errors, or None with a reason."""
        if self.is_valid:
            parts = sum(self.causes.get(cause, 0.0) for cause in OF_PARTS)
            others = [part for cause, part in self.causes.items() if cause not in OF_PARTS]
            of_parts = parts / max_abs(self.C)
            return elastic(self.C, float(np.linalg.norm(others)), of_parts, self.shown)
        return Elastic(self.C, None, None, np.inf, np.inf, self.refusals())

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
        """Uncertainty of C as text."""
        part = self.error / (max_abs(self.C) or 1.0)
        return phrase("not known", part=part, needed=self.shown)


STRAINS = "rounding of strains"
"""Name of the cause that multiplies C."""
SOLVED = "solves_to"
"""Name of the cause that a step's change of velocity is left unsolved by this part."""
OF_PARTS = (STRAINS, SOLVED)
INNER = "force on inner nodes"
"""Name of the flag by which a lattice is known."""
DAMPING = "damping"
"""Name of the flag of a step that keeps only a part of the velocity that a weight gives."""
