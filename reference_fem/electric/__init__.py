"""Electrostatics of dielectrics, and of a slab with electrodes in air.

`solve_potential` takes a mesh as arrays. A `Slab` is meshed with its air by `slab_mesh`, has its
field and Maxwell's forces by `solve_charges`, its small displacements by `respond`; `capacitance`
and
`surface_profile` refine the mesh and come with their errors.
"""

from reference_fem.electric.capacitance import Capacitance, capacitance, far_boundary
from reference_fem.electric.charges import FAR, Charged, Far, solve_charges
from reference_fem.electric.electrostatics import Dielectric, Potential, solve_potential
from reference_fem.electric.mesh import SlabMesh, move_air, slab_mesh
from reference_fem.electric.response import respond, surface_profile
from reference_fem.electric.slab import Electrode, Slab, facing_slab

__all__ = [
    "FAR",
    "Capacitance",
    "Charged",
    "Dielectric",
    "Electrode",
    "Far",
    "Potential",
    "Slab",
    "SlabMesh",
    "capacitance",
    "facing_slab",
    "far_boundary",
    "move_air",
    "respond",
    "slab_mesh",
    "solve_charges",
    "solve_potential",
    "surface_profile",
]
