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
    """Whether what `elements` told of a reaction (N) or mean stress (Pa) is rounding, no more.

    V σ = ∮ t x dA + ∫ b x dV: where reactions follow, stress has no mean but that of the forces and
    their places. False where supports move the body: there are no forces to sum.
    """
    force, longest, volume = _forces(statement)
    floor = {"reaction": ROUNDING * force, "mean": ROUNDING * force * longest / volume}
    return told <= WRITTEN * floor.get(quantity.split(maxsplit=1)[0], -1.0)


@cache
def _forces(statement: Statement) -> tuple[float, float, float]:
    """Sum of the sizes of the nodal forces (N), longest side (m) and volume (m³)."""
    kind, (points, cells) = next(iter(linear_meshes(statement.grid, 1).items()))
    shape = MESHIO[kind]
    curved = (points, cells, shape) if statement.sides is not None else None
    problem = problem_of(statement, statement.own_ratio, curved)
    body = mesh_discretisation(Mesh(points, cells, shape))
    force = float(np.abs(nodal_forces(problem, body)).sum())
    longest = max(high - low for low, high in problem.domain.span)
    return force, longest, problem.domain.volume * problem.material.thickness
