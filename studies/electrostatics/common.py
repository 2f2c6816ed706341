"""What the questions of the study share: what is judged, electrodes, columns."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.dielectric import charges as electrostatics
from msvalidate.dielectric.charges import (
    Charges,
    Electrodes,
    Moments,
    electrodes_of_chains,
    facing_strips,
    strip_points,
)
from msvalidate.dielectric.charges.dielectric import ChargesInAir, SlabInAir, forces_in_air
from msvalidate.dielectric.charges.moments import Weighting
from msvalidate.dielectric.charges.patches import patch_capacitance
from msvalidate.dielectric.charges.report_model import ReportModel
from msvalidate.problem import Array

VOLTAGES = (1.0, 0.0)
"""Of electrodes 0 and 1 (V). Were they ±½, symmetry would keep the charges neutral in any case."""
COLUMNS = {
    "width_over_gap": "width of both strips over the gap between them (1)",
    "grading": "segments of one length (uniform), or such that equal angles of a half circle "
    "project on them (cosine)",
    "weighting": "potential asked for at middles of segments (collocation) or as means over them "
    "(galerkin)",
    "segments": "of each electrode, or of the one that is looked at (1)",
    "shape": "of the upper electrode: flat, or wavy over a flat one",
    "order": "exponent of the length of segments that fits the errors (1)",
    "forces_by": "derivatives of the energy, or point sums: Coulomb's law between middles of "
    "springs, halves to each end, or between nodes",
    "pull_error": "force between flat strips over dW/dd of the closed form, less 1 (1)",
    "stretch_error": "forces along flat strips times their place, over w·dW/dw of the closed form, "
    "less 1 (1)",
    "place": "middle of a segment over half the width, 0 in the strip's middle (1)",
    "permittivity_ratio": "of the slab over that of the air around (1)",
}
"""What columns of several tables mean."""


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
        Capacitance (F) of `Patches` in space.
    in_air, forces_in_air
        A body in air from its `Faces`, and force (n, 2) per depth (N/m) on every point of them.
    report
        The report's model of electrodes; options depth, kernel and charges_on.
    """

    charges: Callable[..., Charges]
    forces: Callable[[Charges], Array]
    tangent: Callable[[Charges], Array]
    plates: Callable[..., float]
    in_air: Callable[..., SlabInAir]
    forces_in_air: Callable[[ChargesInAir], Array]
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
