"""A dielectric elastomer actuator: a soft slab squeezed by the field of electrodes on its faces.

`equilibrium_at` and `sweep` follow a `SoftSlab` over the voltage up to where it pulls in,
`turning_point` beyond.
"""

from reference_fem.actuator.actuated import ActuatedSlab, solve_actuated
from reference_fem.actuator.continuation import Sweep, equilibrium_at, sweep, turning_point
from reference_fem.actuator.soft_slab import Electric, SoftSlab

__all__ = [
    "ActuatedSlab",
    "Electric",
    "SoftSlab",
    "Sweep",
    "equilibrium_at",
    "solve_actuated",
    "sweep",
    "turning_point",
]
