"""A dielectric elastomer actuator: a soft slab squeezed by the field of electrodes on its faces.

`equilibrium_at` and `sweep` follow a `SoftSlab` over the voltage up to where it pulls in, `turning`
beyond; `gains` and `first_lost` tell how near it is to that. `Film` is one that strains as a whole.
"""

from reference_fem.actuator.actuated import Actuated, settled
from reference_fem.actuator.continuation import Sweep, equilibrium_at, sweep, turning
from reference_fem.actuator.film import Film, PullIn
from reference_fem.actuator.soft_slab import Electric, SoftSlab
from reference_fem.actuator.stability import Lost, first_lost, gains

__all__ = [
    "Actuated",
    "Electric",
    "Film",
    "Lost",
    "PullIn",
    "SoftSlab",
    "Sweep",
    "equilibrium_at",
    "first_lost",
    "gains",
    "settled",
    "sweep",
    "turning",
]
