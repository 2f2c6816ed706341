"""A dielectric elastomer actuator: a soft slab squeezed by the field of electrodes on its faces.

`equilibrium_at` and `sweep` follow a `SoftSlab` over the voltage up to where it pulls in,
`turning_point`
beyond; `stiffness_gains` and `first_instability` tell how near it is to that. `Film` is one that
strains as a whole.
"""

from reference_fem.actuator.actuated import ActuatedSlab, solve_actuated
from reference_fem.actuator.continuation import Sweep, equilibrium_at, sweep, turning_point
from reference_fem.actuator.film import Film, PullIn
from reference_fem.actuator.soft_slab import Electric, SoftSlab
from reference_fem.actuator.stability import StabilityLoss, first_instability, stiffness_gains

__all__ = [
    "ActuatedSlab",
    "Electric",
    "Film",
    "PullIn",
    "SoftSlab",
    "StabilityLoss",
    "Sweep",
    "equilibrium_at",
    "first_instability",
    "solve_actuated",
    "stiffness_gains",
    "sweep",
    "turning_point",
]
