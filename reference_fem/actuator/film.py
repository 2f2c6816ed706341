"""A dielectric film that strains as a whole between its electrodes: voltage, and where it pulls in.

The last axis runs through the film, of height h at rest and l·h under voltage; its sides have the
stretch λ. Per volume of the film at rest the free energy at a fixed voltage V is

    W(λ, l) - ½ ε (V/h)² λ^(d-1)/l,

the second term the energy of its capacitance, of which equal and opposite charges pay twice. At
rest its derivatives vanish [ZhaoSuo2007]:

    -∂W/∂l = ½ ε (V/h)² λ^(d-1)/l²       and, of free sides,       λ ∂W/∂λ = -(d - 1) l ∂W/∂l.

A film that keeps its volume has λ^(d-1) = 1/l, and one derivative along that path. As a film gets
thinner the same voltage makes a larger field: past a largest voltage it collapses.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import positive_number, require_one_of
from msvalidate.problem.records import dataclass
from reference_fem.large_strain.hyperelastic import Law, refuse_other_laws

THINNEST = 0.05
"""Ratio of thickness down to which a largest voltage is looked for."""
LOOKS = 400
"""Ratios that are looked at for it: one lies within 0.3 % of each."""
ROUNDING = 1e-9
"""Of a stress, that may be rounding in a nearly incompressible law."""
WIDEST = 1e3
"""Stretch of the sides up to which one is looked for."""
FLATTEST = 1e-6
"""Ratio of thickness below which none is taken: its cube is still far from rounding."""

SIDES = ("held", "free", "volume kept")


@dataclass(frozen=True, eq=False)
class Film:
    """A uniform film of one law.

    Source: [ZhaoSuo2007].

    Parameters
    ----------
    law
        Its energy density; of two axes in plane strain, of three if it stretches alike along both
        of its sides.
    height
        At rest, in m.
    permittivity
        ε in F/m, whatever the strain: an ideal dielectric.
    sides
        "held", so that λ = 1; "free"; or "volume kept", free and incompressible whatever the law
        says of J.

    Raises
    ------
    ProblemError
        If a value is out of its range.
    """

    law: Law
    height: float = 1.0
    permittivity: float = 1.0
    sides: str = "free"

    def __post_init__(self) -> None:
        positive_number("height of a film", self.height, "m")
        positive_number("permittivity of a film", self.permittivity, "F/m")
        require_one_of("sides of a film", self.sides, SIDES)
        refuse_other_laws(self.law)

    def stretch(self, ratio: float) -> float:
        """Stretch λ of the sides at a ratio of thickness.

        Raises
        ------
        ProblemError
            If the ratio is below `FLATTEST`.
        SolverError
            If free sides find none up to `WIDEST`, or down to its inverse.
        """
        if positive_number("ratio of thickness", ratio) < FLATTEST:
            raise ProblemError(
                f"ratio of thickness: {ratio:g}; no film is that thin, give {FLATTEST:g} or more"
            )
        if self.sides == "held" or ratio == 1:
            return 1.0
        if self.sides == "volume kept":
            return float(ratio ** (-1 / (self.law.dim - 1)))
        widens = self._unbalance(ratio, 1.0) < 0
        last, side = 1.0, 1.0
        while (self._unbalance(ratio, side) < 0) == widens:
            last, side = side, side * 1.5 if widens else side / 1.5
            if not 1 / WIDEST <= side <= WIDEST:
                raise SolverError(
                    f"film: its sides find no rest at a ratio of thickness {ratio:g}; take one "
                    "nearer 1, or a law that a squeeze makes thinner"
                )
        return float(
            brentq(lambda side: self._unbalance(ratio, side), last, side, xtol=1e-15, rtol=1e-14)
        )

    def voltage(self, ratio: float) -> float:
        """Voltage (V) that holds a ratio of thickness, from 0 to 1.

        Raises
        ------
        ProblemError
            If the ratio is none that a voltage makes.
        SolverError
            If there is none, as the law pulls the film thinner by itself.
        """
        if positive_number("ratio of thickness", ratio) > 1:
            raise ProblemError(f"ratio of thickness: {ratio:g}; a voltage makes the film thinner")
        stretch = self.stretch(ratio)
        across, through = self._stress(ratio, stretch)
        # ½ ε (V/h)² λ^(d-1)/l by the squeeze; with the volume kept, a pressure joins both stresses.
        kept = self.sides == "volume kept"
        work = 0.5 * (across * stretch - through * ratio) if kept else -through * ratio
        if work < -ROUNDING * (abs(across) + abs(through)):
            raise SolverError(f"film: its law pulls it thinner at a ratio of thickness {ratio:g}")
        square = 2 * max(work, 0.0) * ratio / (self.permittivity * stretch ** (self.law.dim - 1))
        return self.height * float(np.sqrt(square))

    def pull_in(self) -> PullIn | None:
        """The first largest voltage as the film gets thinner; None if it rises to `THINNEST`."""
        ratios = np.geomspace(1.0, THINNEST, LOOKS)
        voltages = np.array([self.voltage(ratio) for ratio in ratios])
        (tops,) = np.nonzero((voltages[1:-1] >= voltages[:-2]) & (voltages[1:-1] > voltages[2:]))
        if not len(tops):
            return None
        low, high = ratios[tops[0] + 2], ratios[tops[0]]
        best = minimize_scalar(
            lambda ratio: -self.voltage(ratio),
            bounds=(low, high),
            method="bounded",
            options={"xatol": 1e-9},
        )
        ratio = float(best.x)
        return PullIn(ratio, self.stretch(ratio), self.voltage(ratio), self.height)

    def _unbalance(self, ratio: float, stretch: float) -> float:
        """P_11 λ + P_dd l, which is 0 where free sides rest: ∂W/∂λ is (d - 1) P_11."""
        across, through = self._stress(ratio, stretch)
        return across * stretch + through * ratio

    def _stress(self, ratio: float, stretch: float) -> tuple[float, float]:
        """First Piola stress (Pa) along a side and through the film."""
        F = np.diag([stretch] * (self.law.dim - 1) + [ratio])
        P = self.law.stress(F[None])[0]
        return float(P[0, 0]), float(P[-1, -1])


@dataclass(frozen=True)
class PullIn:
    """Where a film's voltage is largest.

    Parameters
    ----------
    ratio, stretch
        Of its thickness and of its sides.
    voltage, height
        In V, and in m at rest.
    """

    ratio: float
    stretch: float
    voltage: float
    height: float

    @property
    def nominal_field(self) -> float:
        """Voltage over the height at rest (V/m)."""
        return self.voltage / self.height

    @property
    def true_field(self) -> float:
        """Voltage over the thickness (V/m)."""
        return self.nominal_field / self.ratio
