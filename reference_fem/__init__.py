"""Finite element reference on scikit-fem; shares the statement of the problem, no numerical code.

Entry points: `solve_problem` for a `Problem`, `solve` or `solve_mixed` for a mesh as arrays, and a
`Solver` for many loads of one body. Of a dielectric `Slab` with electrodes in air: `slab_mesh`,
`charged` and `respond`, or `capacitance` and `surface_profile` with their errors; `solve_potential`
for a mesh as arrays. At large strain: `finite_strain` for a solid, `actuator` and `actuator_gains`
for a slab squeezed by its field, `film` for one that strains as a whole.
"""

from reference_fem.body import Solution, solve_problem
from reference_fem.discretisation import Discretisation, discretise
from reference_fem.elasticity import solve
from reference_fem.electrostatics import Dielectric, Potential, solve_potential
from reference_fem.from_mesh import mesh_discretisation
from reference_fem.meshing import box_discretisation
from reference_fem.mixed import solve_mixed
from reference_fem.refinement import Estimate, refine
from reference_fem.slab import Electrode, Slab, facing_slab
from reference_fem.slab_capacitance import Capacitance, capacitance, far_boundary
from reference_fem.slab_charged import Charged, charged
from reference_fem.slab_mesh import SlabMesh, moved_air, slab_mesh
from reference_fem.slab_response import respond, surface_profile
from reference_fem.solver import Solved, Solver
from reference_fem.triangles import polygon_discretisation

__all__ = [
    "Capacitance",
    "Charged",
    "Dielectric",
    "Discretisation",
    "Electrode",
    "Estimate",
    "Potential",
    "Slab",
    "SlabMesh",
    "Solution",
    "Solved",
    "Solver",
    "box_discretisation",
    "capacitance",
    "charged",
    "discretise",
    "facing_slab",
    "far_boundary",
    "mesh_discretisation",
    "moved_air",
    "polygon_discretisation",
    "refine",
    "respond",
    "slab_mesh",
    "solve",
    "solve_mixed",
    "solve_potential",
    "solve_problem",
    "surface_profile",
]
