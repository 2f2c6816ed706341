"""Charges of electrodes and the forces on them, by the method of moments.

Plane electrodes are chains of straight segments that each carry an even line charge; their
interactions are exact integrals. Nothing here is shared with `reference_fem.electric`.

`moments` is the plane model in one medium, `dielectric` a body in air with electrodes on its
surface, `report_model` the report's model with its switches, `patches` conductors in space, whose
capacitances are known.
"""

from msvalidate.dielectric.charges.dielectric import SlabInAir
from msvalidate.dielectric.charges.electrodes import (
    Electrodes,
    electrodes_of_chains,
    facing_strips,
    strip_points,
)
from msvalidate.dielectric.charges.exact import (
    disc_capacitance,
    facing_strips_capacitance,
    square_capacitance,
)
from msvalidate.dielectric.charges.faces import faces_of
from msvalidate.dielectric.charges.forces import (
    forces,
    forces_in_air,
    tangent,
    tangent_in_air,
)
from msvalidate.dielectric.charges.moments import Charges, Moments, capacitance
from msvalidate.dielectric.charges.report_model import (
    ReportCharges,
    ReportModel,
    report_forces,
    report_tangent,
)

__all__ = [
    "Charges",
    "Electrodes",
    "Moments",
    "ReportCharges",
    "ReportModel",
    "SlabInAir",
    "capacitance",
    "disc_capacitance",
    "electrodes_of_chains",
    "faces_of",
    "facing_strips",
    "facing_strips_capacitance",
    "forces",
    "forces_in_air",
    "report_forces",
    "report_tangent",
    "square_capacitance",
    "strip_points",
    "tangent",
    "tangent_in_air",
]
