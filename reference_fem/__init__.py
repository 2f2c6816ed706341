"""Finite element reference on scikit-fem; shares the statement of the problem, no numerical code.

Entry points: `solve_problem` for a `Problem`, `solve` or `solve_mixed` for a mesh as arrays, and a
`Solver` for many loads of one body.
"""

from reference_fem.body import Solution, solve_problem
from reference_fem.discretisation import Discretisation, discretise
from reference_fem.elasticity import solve
from reference_fem.from_mesh import mesh_discretisation
from reference_fem.meshing import box_discretisation, polygon_discretisation
from reference_fem.mixed import solve_mixed
from reference_fem.refinement import Estimate, refine
from reference_fem.solver import Solved, Solver

__all__ = [
    "Discretisation",
    "Estimate",
    "Solution",
    "Solved",
    "Solver",
    "box_discretisation",
    "discretise",
    "mesh_discretisation",
    "polygon_discretisation",
    "refine",
    "solve",
    "solve_mixed",
    "solve_problem",
]
