"""Electrostatics of dielectrics, and of a slab with electrodes in air.

A `Slab` is meshed with its air by `slab_mesh`, has its field and Maxwell's forces by
`solve_charges`, its small displacements by `respond`; any mesh is a `Dielectric`'s.
"""

from reference_fem.electric.charges import FAR, Charged, Far, solve_charges
from reference_fem.electric.electrostatics import Dielectric, Potential
from reference_fem.electric.mesh import SlabMesh, move_air, slab_mesh
from reference_fem.electric.response import respond
from reference_fem.electric.slab import Electrode, Slab, facing_slab

__all__ = [
    "FAR",
    "Charged",
    "Dielectric",
    "Electrode",
    "Far",
    "Potential",
    "Slab",
    "SlabMesh",
    "facing_slab",
    "move_air",
    "respond",
    "slab_mesh",
    "solve_charges",
]
