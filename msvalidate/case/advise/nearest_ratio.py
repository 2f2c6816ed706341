"""The ratio that springs alone have in place of a material's, and what it costs to take it."""

from __future__ import annotations

from msvalidate.linear_algebra.norms import max_length
from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.problem.records import replace
from reference_fem import box_discretisation, solve_problem
from reference_fem.converged import is_nearly_incompressible
from reference_fem.mesh.discretisation import Discretisation

ELEMENTS = {2: ("Q2", 4), 3: ("H2", 2)}
"""Axes -> element, and elements across a block: errors are a tenth of what is compared."""


def change_by_ratio(problem: Problem, law: Isotropic, nu: float, body: Discretisation) -> float:
    """Change of elasticity's displacement on a mesh, over the largest, by another ratio."""
    mixed = is_nearly_incompressible(problem)
    own, other = (
        solve_problem(replace(problem, material=each), body, mixed=mixed).displacement
        for each in (law, replace(law, nu=nu))
    )
    return max_length(other - own) / (max_length(own) or 1.0)


def change_of_blocks(material: Isotropic, nu: float) -> tuple[float, float]:
    """Least and largest `change_by_ratio` of a square or cube and of a bar four times as long.

    They are clamped at one end, and each pulled, sheared or bent there, or pressed from above.
    """
    d = material.dim
    element, across = ELEMENTS[d]
    found = []
    for long in (1, 4):
        box = Box((float(long),) + (1.0,) * (d - 1))
        body = box_discretisation(box, (long * across,) + (across,) * (d - 1), element)
        clamp = Support(box.side("left"), (0.0,) * d)
        for side, axis in (("right", 0), ("right", 1), ("top", 1)):
            load = tuple(material.E * (a == axis) for a in range(d))
            problem = Problem(box, material, (clamp,), (Traction(box.side(side), load),))
            found.append(change_by_ratio(problem, material, nu, body))
    return min(found), max(found)
