"""Electrostatic forces on a network's points at a voltage, and their derivatives.

With one more model, write a function of an actuator, positions and a voltage that returns an
`Electric`, add it to `CHARGES`, and its name to `device.MODELS`: actuators take it by that name.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from msvalidate.dielectric.actuator.device import Actuator
from msvalidate.dielectric.charges import (
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
from msvalidate.problem.records import ReadOnly, dataclass


@dataclass(frozen=True, eq=False)
class Electric:
    """Charges of an actuator at a voltage, and what they do to the network's points.

    Parameters
    ----------
    charges
        As their own module describes them.
    loaded
        (k,) points of the network that feel them, each once.
    depth
        Of the body out of the plane (m).
    pull
        Force (k, 2) per depth (N/m) of charges on these points.
    bend
        (2k, 2k) per depth (N/m²), how it changes with positions while charges follow.
    """

    charges: Any
    loaded: Index
    depth: float
    pull: Callable[[Any], Array]
    bend: Callable[[Any], Array]

    @cached_property
    def _forces(self) -> Array:
        return self.depth * self.pull(self.charges)

    def forces(self) -> Array:
        """(k, 2) in N."""
        return self._forces

    def tangent(self) -> Array:
        """(2k, 2k) in N/m. Components of a point stand together."""
        return self.depth * self.bend(self.charges)


@dataclass(frozen=True, eq=False)
class PlateCharges(ReadOnly):
    """Charges between parallel plates: (2,) of top and bottom, per depth (C/m), and ½QV (J/m)."""

    totals: Array
    energy: float


def _plane(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """Exact line charges in a medium of one permittivity all around."""
    moments = Moments(actuator.lying(position), permittivity=actuator.permittivity)
    charges = moments.charges(actuator.potentials(voltage))
    return Electric(charges, actuator.loaded, actuator.depth, forces, tangent)


def _plates(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """The field between plates is V/h at each place: the bottom electrode must be flat and held.

    W = ½εV² ∫ dx/h, h the gap up to each point of the top, by the trapezoidal rule. That is the
    limit of waves long beside the gap. W depends on widths too: the ends are drawn outwards with
    ½εV²/h, as a dielectric is drawn into a capacitor.
    """
    top, bottom = actuator.electrodes
    x, y = position[top].T
    gap, k = y - position[bottom[0], 1], len(top)
    spread = _trapezoidal_weights(k) * (1.0 if x[-1] > x[0] else -1.0)
    width = spread @ x
    if not (gap > 0).all() or not (width > 0).all():
        raise ProblemError("electrodes: they cross or touch; leave a gap")
    inverse, scale = 1 / gap, 0.5 * actuator.permittivity * voltage**2
    pull = scale * np.column_stack([spread.T @ inverse, -width * inverse**2])
    bend = np.zeros((k, 2, k, 2))
    bend[:, 1, :, 1] = np.diag(2 * width * inverse**3)
    # Forces along x change with gaps, and the other way round those along y with widths.
    bend[:, 1, :, 0] = cross = -(inverse**2)[:, None] * spread
    bend[:, 0, :, 1] = cross.T
    bend = scale * bend.reshape(2 * k, 2 * k)
    whole = actuator.permittivity * voltage * float((width / gap).sum())
    charges = PlateCharges(np.array([whole, -whole]), 0.5 * whole * voltage)
    return Electric(charges, top, actuator.depth, lambda _: pull, lambda _: bend)


def _trapezoidal_weights(k: int) -> Array:
    """Matrix (k, k) of half the distance between a point's neighbours; ends stand for one."""
    places = np.eye(k)
    longer = np.concatenate([places[:1], places, places[-1:]])
    return np.asarray(0.5 * (longer[2:] - longer[:-2]))


def _report(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """The report's kernel 1/(4πεr) and point forces, which are no derivatives of an energy."""
    moments = ReportModel(
        actuator.lying(position), permittivity=actuator.permittivity, depth=actuator.depth
    )
    charges = moments.charges(actuator.potentials(voltage))
    return Electric(charges, actuator.loaded, actuator.depth, report_forces, _symmetric_tangent)


def _symmetric_tangent(charges: ReportCharges) -> Array:
    """The symmetric part alone of a lopsided tangent.

    While the stiffness with it is positive, so are the real parts of all eigenvalues of the whole
    one: what is called stable is, and pull-in is met at the latest where it should be.
    """
    whole = report_tangent(charges)
    return 0.5 * (whole + whole.T)


def _in_air(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """Free and bound charge on the whole surface; asks for the permittivity ratio."""
    around = actuator.outline
    moments = SlabInAir(
        faces_of(position, around, actuator.electrodes),
        ratio=actuator.permittivity_ratio,
        permittivity=actuator.permittivity,
    )
    charges = moments.charges(actuator.potentials(voltage))
    return Electric(charges, around, actuator.depth, forces_in_air, tangent_in_air)


CHARGES: Mapping[str, Callable[[Actuator, Array, float], Electric]] = {
    "plane": _plane,
    "parallel_plates": _plates,
    "as_report": _report,
    "in_air": _in_air,
}
"""Name of a model -> charges of an actuator at positions (n, 2) in m and a voltage (V)."""


def charge_actuator(actuator: Actuator, position: Array, voltage: float) -> Electric:
    """Charges of an actuator's own model at positions (n, 2) in m and a voltage (V).

    Raises
    ------
    ProblemError
        If electrodes cross or touch there.
    """
    return CHARGES[actuator.model](actuator, position, voltage)
