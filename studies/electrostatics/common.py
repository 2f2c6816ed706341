"""What the questions of the study share: what is judged, electrodes, columns."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from msvalidate import kit
from msvalidate.dielectric import charges as electrostatics
from msvalidate.dielectric.charges import (
    Charges,
    Electrodes,
    Moments,
    electrodes_of_chains,
    facing_strips,
    forces_in_air,
    strip_points,
)
from msvalidate.dielectric.charges.dielectric import ChargesInAir, SlabInAir
from msvalidate.dielectric.charges.moments import Weighting
from msvalidate.dielectric.charges.patches import patch_capacitance
from msvalidate.dielectric.charges.report_model import ReportModel

VOLTAGES = (1.0, 0.0)
"""Of electrodes 0 and 1 (V). Were they ±½, symmetry would keep the charges neutral in any case."""


class ChargeSolver(NamedTuple):
    """A way to find charges and forces; by default the method of moments.

    Attributes
    ----------
    charges
        Charges at voltages (k,) of electrodes; options permittivity and weighting.
    forces
        Force (n, 2) per depth (N/m) on every point.
    tangent
        Derivative (2n, 2n) of `forces` at fixed voltages (N/m²).
    plates
        Capacitance over the permittivity (m) of `Patches` in space.
    in_air, forces_in_air
        A body in air from its `Faces`, and force (n, 2) per depth (N/m) on every point of them.
    report
        The report's model of electrodes; options depth, kernel and charges_on.
    """

    charges: Callable[..., Charges]
    forces: Callable[[Charges], kit.Array]
    tangent: Callable[[Charges], kit.Array]
    plates: Callable[..., float]
    in_air: Callable[..., SlabInAir]
    forces_in_air: Callable[[ChargesInAir], kit.Array]
    report: Callable[..., ReportModel]


def charges(
    electrodes: Electrodes,
    voltages: ArrayLike = VOLTAGES,
    *,
    permittivity: float = 1.0,
    weighting: Weighting = "galerkin",
) -> Charges:
    """Charges of electrodes by the method of moments."""
    moments = Moments(electrodes, permittivity=permittivity, weighting=weighting)
    return moments.charges(voltages)


MOMENTS = ChargeSolver(
    charges,
    electrostatics.forces,
    electrostatics.tangent,
    patch_capacitance,
    SlabInAir,
    forces_in_air,
    ReportModel,
)


def pair(shape: str, width: float, segments: int, *, grading: str = "cosine") -> Electrodes:
    """Electrodes a unit gap apart: facing strips, or a wavy one above one that is shifted.

    The waves are neither symmetric nor as many as the segments, so that no error hides.
    """
    if shape == "flat":
        return facing_strips(width, 1.0, segments, grading=grading)
    upper = strip_points(width, 1.0, segments, grading=grading)
    x = upper[:, 0] / width
    upper[:, 1] += 0.2 * np.sin(15 * x + 0.4) + 0.15 * x
    return electrodes_of_chains(
        upper, strip_points(0.9 * width, 0.0, segments, grading=grading, centre=0.07 * width)
    )
