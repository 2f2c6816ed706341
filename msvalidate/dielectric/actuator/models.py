"""What charges do to a network: forces on its points at a voltage, and how they change.

A model is a function of an actuator, positions and a voltage that returns an `Electric`. With one
more model, write such a function and add it to `MODELS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.charges import (
    Charges,
    ChargesInAir,
    Moments,
    ReportCharges,
    ReportModel,
    SlabInAir,
    faces_of,
    forces,
    forces_in_air,
    report_forces,
    report_tangent,
    tangent,
    tangent_in_air,
)
from msvalidate.problem import Array, Index, ProblemError


class Electric(Protocol):
    """Charges of an actuator at a voltage, and what they do to the network's points."""

    @property
    def charges(self) -> Any:
        """The charges, as their own module describes them."""

    @property
    def loaded(self) -> Index:
        """(k,) points of the network that feel them, each once."""

    def forces(self) -> Array:
        """(k, 2) in N, depth included."""

    def tangent(self) -> Array:
        """(2k, 2k) in N/m, how forces change with positions while charges follow.

        Components of a point stand together.
        """


@dataclass(frozen=True, eq=False)
class Plane:
    """Line charges in the plane, in one medium all around."""

    charges: Charges
    loaded: Index
    depth: float

    @cached_property
    def _forces(self) -> Array:
        return self.depth * forces(self.charges)

    def forces(self) -> Array:
        """(k, 2) in N."""
        return self._forces

    def tangent(self) -> Array:
        """(2k, 2k) in N/m."""
        return self.depth * tangent(self.charges)


@dataclass(frozen=True, eq=False)
class PlateCharges:
    """Charges between parallel plates, by the points of the top one.

    Parameters
    ----------
    voltage
        V.
    gap
        (k,) from the bottom plate up to each point (m).
    width
        (k,) half of what lies between its neighbours, along x (m).
    permittivity
        F/m.
    """

    voltage: float
    gap: Array
    width: Array
    permittivity: float

    @property
    def density(self) -> Array:
        """(k,) charge per area (C/m²) of the top plate; the bottom one has the opposite."""
        return self.permittivity * self.voltage / self.gap

    @property
    def totals(self) -> Array:
        """(2,) of top and bottom, per depth (C/m)."""
        whole = float(self.density @ self.width)
        return np.array([whole, -whole])

    @property
    def energy(self) -> float:
        """½QV per depth (J/m)."""
        return 0.5 * float(self.totals[0]) * self.voltage


@dataclass(frozen=True, eq=False)
class ParallelPlates:
    """The field V/h at each place: W = ½εV² ∫ dx/h, h the gap there, by the trapezoidal rule.

    That is the limit of waves long beside the gap. W depends on widths too: the ends are drawn
    outwards with ½εV²/h, as a dielectric is drawn into a capacitor.
    """

    charges: PlateCharges
    loaded: Index
    depth: float
    spread: Array
    """(k, k) widths from places along x."""

    @property
    def _scale(self) -> float:
        return 0.5 * self.depth * self.charges.permittivity * self.charges.voltage**2

    def forces(self) -> Array:
        """(k, 2) in N on the top's points."""
        inverse = 1 / self.charges.gap
        along = self.spread.T @ inverse
        return self._scale * np.column_stack([along, -self.charges.width * inverse**2])

    def tangent(self) -> Array:
        """(2k, 2k) in N/m."""
        k, inverse = len(self.loaded), 1 / self.charges.gap
        bend = np.zeros((k, 2, k, 2))
        bend[:, 1, :, 1] = np.diag(2 * self.charges.width * inverse**3)
        # Forces along x change with gaps, and the other way round those along y with widths.
        bend[:, 1, :, 0] = cross = -(inverse**2)[:, None] * self.spread
        bend[:, 0, :, 1] = cross.T
        return self._scale * bend.reshape(2 * k, 2 * k)


def _plane(actuator: Actuator, position: Array, voltage: float) -> Plane:
    moments = Moments(actuator.lying(position), permittivity=actuator.permittivity)
    charges = moments.charges(actuator.potentials(voltage))
    return Plane(charges, actuator.loaded, actuator.depth)


def _plates(actuator: Actuator, position: Array, voltage: float) -> ParallelPlates:
    top, bottom = actuator.electrodes
    x, y = position[top].T
    gap = y - position[bottom[0], 1]
    spread = _spread(len(top)) * (1.0 if x[-1] > x[0] else -1.0)
    width = spread @ x
    if not (gap > 0).all() or not (width > 0).all():
        raise ProblemError("electrodes: they cross or touch; leave a gap")
    charges = PlateCharges(voltage, gap, width, actuator.permittivity)
    return ParallelPlates(charges, top, actuator.depth, spread)


def _spread(k: int) -> Array:
    """Matrix (k, k) of half the distance between a point's neighbours; ends stand for one."""
    places = np.eye(k)
    longer = np.concatenate([places[:1], places, places[-1:]])
    return np.asarray(0.5 * (longer[2:] - longer[:-2]))


@dataclass(frozen=True, eq=False)
class Coulomb:
    """The report's charges and forces, which are no derivatives of an energy."""

    charges: ReportCharges
    loaded: Index
    depth: float

    @cached_property
    def _forces(self) -> Array:
        return self.depth * report_forces(self.charges)

    def forces(self) -> Array:
        """(k, 2) in N."""
        return self._forces

    def tangent(self) -> Array:
        """(2k, 2k) in N/m, the symmetric part alone of a lopsided one.

        While the stiffness with it is positive, so are the real parts of all eigenvalues of the
        whole one: what is called stable is, and pull-in is met at the latest where it should be.
        """
        whole = report_tangent(self.charges)
        return 0.5 * self.depth * (whole + whole.T)


@dataclass(frozen=True, eq=False)
class InAir:
    """Free and bound charge on the whole surface of the body, which all feels forces."""

    charges: ChargesInAir
    loaded: Index
    depth: float

    @cached_property
    def _forces(self) -> Array:
        return self.depth * forces_in_air(self.charges)

    def forces(self) -> Array:
        """(k, 2) in N."""
        return self._forces

    def tangent(self) -> Array:
        """(2k, 2k) in N/m."""
        return self.depth * tangent_in_air(self.charges)


def _report(actuator: Actuator, position: Array, voltage: float) -> Coulomb:
    moments = ReportModel(
        actuator.lying(position), permittivity=actuator.permittivity, depth=actuator.depth
    )
    charges = moments.charges(actuator.potentials(voltage))
    return Coulomb(charges, actuator.loaded, actuator.depth)


def _in_air(actuator: Actuator, position: Array, voltage: float) -> InAir:
    around = actuator.outline
    moments = SlabInAir(
        faces_of(position, around, actuator.electrodes),
        ratio=actuator.permittivity_ratio,
        permittivity=actuator.permittivity,
    )
    return InAir(moments.charges(actuator.potentials(voltage)), around, actuator.depth)


MODELS: dict[str, Callable[[Actuator, Array, float], Electric]] = {
    "plane": _plane,
    "parallel_plates": _plates,
    "as_report": _report,
    "in_air": _in_air,
}
"""Name -> what it makes of an actuator at positions (n, 2) in m and a voltage (V)."""


def electrified(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """Charges of an actuator's own model at positions (n, 2) in m and a voltage (V).

    Raises
    ------
    ProblemError
        If electrodes cross or touch there.
    """
    return MODELS[actuator.model](actuator, position, voltage)
