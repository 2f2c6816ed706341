"""Which quantities follow from balance of forces alone, known to the rounding of sums of forces."""

from __future__ import annotations

from functools import cache

import numpy as np

from cases.make.meshes import MESHIO, linear_meshes
from cases.make.reference import ROUNDING, problem_of
from cases.make.statements import Statement
from msvalidate.problem import Mesh
from reference_fem.body import nodal_forces
from reference_fem.mesh.from_mesh import mesh_discretisation

WRITTEN = 1.01
"""Times the floor: an uncertainty of three digits may be rounded up."""


def known_by_balance(statement: Statement, quantity: str, told: float) -> bool:
    """Whether what `elements` told of a mean stress (Pa) is the rounding of forces, no more."""
    if quantity != "mean stress":
        return False
    return told <= WRITTEN * _rounding_of_mean_stress(statement)


@cache
def _rounding_of_mean_stress(statement: Statement) -> float:
    """Rounding of the moments of the nodal forces over the volume (Pa); 0 if supports move it.

    V σ = ∮ t x dA + ∫ b x dV: stress has no mean but that of the forces and their places.
    """
    kind, (points, cells) = next(iter(linear_meshes(statement.grid, 1).items()))
    shape = MESHIO[kind]
    curved = (points, cells, shape) if statement.sides is not None else None
    problem = problem_of(statement, statement.own_ratio, curved)
    force = float(np.abs(nodal_forces(problem, mesh_discretisation(Mesh(points, cells, shape)))).sum())
    longest = max(high - low for low, high in problem.domain.span)
    return ROUNDING * force * longest / (problem.domain.volume * problem.material.thickness)
