"""Finite element reference; shares the statement of the problem, no numerical code.

It stands on scikit-fem [scikitfem]. Entry points: `solve_problem` for a `Problem`, `solve` for a
mesh as arrays, and a `Solver` for many loads of one body. Of a dielectric `Slab` with electrodes in
air: `slab_mesh`, `solve_charges` and `respond`. At large strain: `large_strain` for a solid,
`actuator` for a slab squeezed by its field.
"""

from reference_fem.body import Solution, solve_problem
from reference_fem.elasticity import solve
from reference_fem.electric import (
    Charged,
    Dielectric,
    Electrode,
    Potential,
    Slab,
    SlabMesh,
    facing_slab,
    move_air,
    respond,
    slab_mesh,
    solve_charges,
)
from reference_fem.mesh import (
    Discretisation,
    box_discretisation,
    make_discretisation,
    mesh_discretisation,
    polygon_discretisation,
)
from reference_fem.richardson import Estimate, refine
from reference_fem.systems import Solver, SystemSolution

__all__ = [
    "Charged",
    "Dielectric",
    "Discretisation",
    "Electrode",
    "Estimate",
    "Potential",
    "Slab",
    "SlabMesh",
    "Solution",
    "Solver",
    "SystemSolution",
    "box_discretisation",
    "facing_slab",
    "make_discretisation",
    "mesh_discretisation",
    "move_air",
    "polygon_discretisation",
    "refine",
    "respond",
    "slab_mesh",
    "solve",
    "solve_charges",
    "solve_problem",
]
