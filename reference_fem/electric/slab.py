"""The question: a dielectric slab with electrodes on its top and bottom, in air. Data only."""

from __future__ import annotations

import itertools
from typing import Literal

from msvalidate.problem import PLACEMENT, ProblemError
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    length_in_metres,
    positive_number,
    require_one_of,
    require_type,
)
from msvalidate.problem.records import dataclass

Side = Literal["top", "bottom"]
SIDES: tuple[Side, ...] = ("top", "bottom")


@dataclass(frozen=True)
class Electrode:
    """A conductor without thickness on a part of a slab's surface.

    Parameters
    ----------
    side
        "top" or "bottom".
    start, end
        Where along the slab it begins and ends (m).
    voltage
        Its potential (V).
    """

    side: Side
    start: float
    end: float
    voltage: float

    def __post_init__(self) -> None:
        if not isinstance(self.side, str) or self.side not in SIDES:
            raise ProblemError(
                f"electrode on {format_value(self.side)}: not on the slab's surface; choose top or "
                f"bottom"
            )
        start, end = (
            finite_number("electrode's start", self.start),
            finite_number("electrode's end", self.end),
        )
        finite_number("voltage", self.voltage)
        if not start < end:
            raise ProblemError(
                f"electrode: from {start:g} to {end:g} m; it must end after it starts"
            )


@dataclass(frozen=True)
class Slab:
    """A slab 0 <= x <= length, 0 <= y <= height with electrodes, in air all around.

    Parameters
    ----------
    length, height
        Of the slab (m); electrodes on the top and on the bottom are a height apart.
    electrodes
        Two or more, that do not touch.
    permittivity, air
        Of the slab and of what surrounds it, absolute (F/m).

    Raises
    ------
    ProblemError
        If a number is out of range, an electrode does not lie on the slab or has no length that can
        be told, or two touch.
    """

    length: float
    height: float
    electrodes: tuple[Electrode, ...]
    permittivity: float = 1.0
    air: float = 1.0

    def __post_init__(self) -> None:
        length_in_metres("slab length", self.length)
        length_in_metres("slab height, the gap between electrodes", self.height)
        positive_number("permittivity of the slab", self.permittivity, "F/m")
        positive_number("permittivity of the air", self.air, "F/m")
        if not isinstance(self.electrodes, tuple) or len(self.electrodes) < 2:
            raise ProblemError(
                f"electrodes: {format_value(self.electrodes)}; give a tuple of two or more"
            )
        for i, electrode in enumerate(self.electrodes):
            require_type(f"electrode {i}", electrode, Electrode)
            if electrode.start < -self.tolerance or electrode.end > self.length + self.tolerance:
                raise ProblemError(
                    f"electrode {i}: from {electrode.start:g} to {electrode.end:g} m is not on the "
                    f"slab's surface; keep it within 0 to {self.length:g} m"
                )
            if electrode.end - electrode.start <= 2 * self.tolerance:
                raise ProblemError(
                    f"electrode {i}: {electrode.end - electrode.start:.3g} m long, too short to "
                    f"tell its ends apart; give it more than {2 * self.tolerance:.3g} m"
                )
        for side in SIDES:
            self._refuse_touching(side)

    @property
    def tolerance(self) -> float:
        """Distance (m) below which two places are one."""
        return PLACEMENT * max(self.length, self.height)

    @property
    def voltages(self) -> tuple[float, ...]:
        """Voltages (V) of the electrodes."""
        return tuple(electrode.voltage for electrode in self.electrodes)

    def level(self, side: Side) -> float:
        """Height (m) of the top or the bottom."""
        require_one_of("side", side, SIDES)
        return self.height if side == "top" else 0.0

    def _refuse_touching(self, side: Side) -> None:
        along = sorted(
            (electrode.start, electrode.end, i)
            for i, electrode in enumerate(self.electrodes)
            if electrode.side == side
        )
        for (_, end, i), (start, _, j) in itertools.pairwise(along):
            if start - end <= self.tolerance:
                raise ProblemError(
                    f"electrodes {i} and {j} touch at x = {start:g} m on the {side}; leave a gap"
                )


def facing_slab(
    length: float,
    height: float,
    voltage: float = 1.0,
    *,
    covered: float = 1.0,
    permittivity: float = 1.0,
    air: float = 1.0,
) -> Slab:
    """A slab with electrode 0 at `voltage` on its top and electrode 1 at 0 V over its whole bottom.

    Parameters
    ----------
    length, height, permittivity, air
        As for `Slab`.
    voltage
        Between the electrodes (V).
    covered
        Part of the top, its middle, that electrode 0 covers: above 0, at most 1.

    Raises
    ------
    ProblemError
        If a number is out of range.
    """
    part, whole = positive_number("covered part", covered), length_in_metres("slab length", length)
    if part > 1:
        raise ProblemError(f"covered part: {covered:g}; give at most 1")
    margin = 0.5 * (1 - part) * whole
    top = Electrode("top", margin, whole - margin, voltage)
    return Slab(length, height, (top, Electrode("bottom", 0.0, whole, 0.0)), permittivity, air)
