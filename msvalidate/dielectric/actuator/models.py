"""What charges do to a network: forces on its points at a voltage, and how they change.

A model is a function of a device, positions and a voltage that returns an `Electric`. With one more
model, write such a function and add a row to `MODELS`: actuators take it by its name there.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from msvalidate.dielectric.actuator.surface import SAME_PLACE
from msvalidate.dielectric.charges import (
    Charges,
    ChargesInAir,
    Electrodes,
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
from msvalidate.network import Network
from msvalidate.problem import Array, Index, ProblemError
from msvalidate.problem.records import dataclass

LARGEST_RATIO = 1e6
"""Permittivity ratio in air up to which equilibria are sought: forces are differences of terms so
many times as large, which rounding by some 1e-15 leaves known to 1e-9, and a residual is asked to
be below 1e-8 of the loads. Beyond, an equilibrium that is not found says nothing of pull-in."""


class Device(Protocol):
    """What a model sees of an actuator: see `device.Actuator`."""

    @property
    def network(self) -> Network:
        """The plane network."""

    @property
    def electrodes(self) -> tuple[Index, ...]:
        """Chains of points of the top electrode and the bottom one."""

    @property
    def loaded(self) -> Index:
        """(k,) points of the network that the electrodes' points are."""

    @property
    def outline(self) -> Index:
        """(k,) points around the body."""

    @property
    def model(self) -> str:
        """Name of one of `MODELS`."""

    @property
    def permittivity(self) -> float:
        """F/m."""

    @property
    def permittivity_ratio(self) -> float:
        """Permittivity over that of what surrounds the body."""

    @property
    def depth(self) -> float:
        """Of the body out of the plane (m)."""

    def lying(self, position: Array) -> Electrodes:
        """The electrodes when the network is at positions (n, 2) in m."""

    def potentials(self, voltage: float) -> Array:
        """Potentials (2,) in V at a voltage (V)."""


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


def _plane(device: Device, position: Array, voltage: float) -> Plane:
    """Exact line charges in a medium of one permittivity all around."""
    moments = Moments(device.lying(position), permittivity=device.permittivity)
    charges = moments.charges(device.potentials(voltage))
    return Plane(charges, device.loaded, device.depth)


def _plates(device: Device, position: Array, voltage: float) -> ParallelPlates:
    """The field between plates at each place: the bottom electrode must be flat and held."""
    top, bottom = device.electrodes
    x, y = position[top].T
    gap = y - position[bottom[0], 1]
    spread = _trapezoidal_weights(len(top)) * (1.0 if x[-1] > x[0] else -1.0)
    width = spread @ x
    if not (gap > 0).all() or not (width > 0).all():
        raise ProblemError("electrodes: they cross or touch; leave a gap")
    charges = PlateCharges(voltage, gap, width, device.permittivity)
    return ParallelPlates(charges, top, device.depth, spread)


def _trapezoidal_weights(k: int) -> Array:
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


def _report(device: Device, position: Array, voltage: float) -> Coulomb:
    """The report's kernel 1/(4πεr) and point forces."""
    moments = ReportModel(
        device.lying(position), permittivity=device.permittivity, depth=device.depth
    )
    charges = moments.charges(device.potentials(voltage))
    return Coulomb(charges, device.loaded, device.depth)


def _in_air(device: Device, position: Array, voltage: float) -> InAir:
    """Bare faces of the dielectric carry bound charge; asks for the permittivity ratio."""
    around = device.outline
    moments = SlabInAir(
        faces_of(position, around, device.electrodes),
        ratio=device.permittivity_ratio,
        permittivity=device.permittivity,
    )
    return InAir(moments.charges(device.potentials(voltage)), around, device.depth)


def _accept(device: Device) -> None:
    """Any actuator will do."""


def _refuse_no_plate(device: Device) -> None:
    top, bottom = device.electrodes
    network = device.network
    height = network.start[bottom, 1]
    if (
        not network.held[bottom, 1].all()
        or np.ptp(height) > SAME_PLACE * np.abs(network.start[top, 1] - height[0]).max()
    ):
        raise ProblemError(
            "electrode 1: bends or can move up; between parallel plates the bottom one is flat "
            'and held: take model="plane", or hold it'
        )


def _refuse_high_ratio(device: Device) -> None:
    if device.permittivity_ratio > LARGEST_RATIO:
        raise ProblemError(
            f"permittivity ratio: {device.permittivity_ratio:g}; above {LARGEST_RATIO:g} forces "
            "in air have too few digits: at such ratios the field outside counts for nothing, "
            f"take {LARGEST_RATIO:g}"
        )


@dataclass(frozen=True)
class Model:
    """A model of charges.

    Parameters
    ----------
    charge
        Makes charges of a device at positions (n, 2) in m and a voltage (V).
    refuse
        Raises `ProblemError` for a device that it is not for.
    conservative
        Whether its forces are slopes of an energy; tests hold it to that.
    """

    charge: Callable[[Device, Array, float], Electric]
    refuse: Callable[[Device], None] = _accept
    conservative: bool = True


MODELS: Mapping[str, Model] = {
    "plane": Model(_plane),
    "parallel_plates": Model(_plates, _refuse_no_plate),
    "as_report": Model(_report, conservative=False),
    "in_air": Model(_in_air, _refuse_high_ratio),
}
"""Name -> model."""


def charge_actuator(device: Device, position: Array, voltage: float) -> Electric:
    """Charges of an actuator's own model at positions (n, 2) in m and a voltage (V).

    Raises
    ------
    ProblemError
        If electrodes cross or touch there.
    """
    return MODELS[device.model].charge(device, position, voltage)
