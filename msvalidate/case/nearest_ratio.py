"""The ratio nearest to a material's that springs alone have, and what it costs to take it."""

from __future__ import annotations

import numpy as np

from msvalidate.constants.stiffness import CAUCHY
from msvalidate.problem import Box, Isotropic, Problem, Support, Traction
from msvalidate.problem.records import replace
from reference_fem import box_discretisation, solve_problem

ELEMENTS = {2: ("Q2", 4), 3: ("H2", 2)}
"""Axes -> element, and elements across a block: errors are a tenth of what is compared."""
LONG = 4
"""Length of the second block over its thickness; the first is a square or cube."""
LOCKING = 0.4
"""Ratio above which displacement elements of these meshes are too stiff."""


def nearest_by_springs(material: Isotropic) -> Isotropic:
    """The material with the ratio of springs alone: 1/3 in plane stress, 1/4 in strain and space.

    In the plane honeycomb has others too, see `constants.routes`.
    """
    return replace(material, nu=CAUCHY[2] if material.state == "plane_stress" else CAUCHY[3])


def price_of_ratio(material: Isotropic, other: Isotropic) -> tuple[float, float]:
    """Least and largest change of displacements, over the largest, by another ratio.

    By elements, over a square or cube and a bar, clamped at one end, each pulled, sheared and bent
    there, or pressed from above.
    """
    d = material.dim
    element, across = ELEMENTS[d]
    found = []
    for long in (1, LONG):
        box = Box((float(long),) + (1.0,) * (d - 1))
        body = box_discretisation(box, (long * across,) + (across,) * (d - 1), element)
        clamp = Support(box.side("left"), (0.0,) * d)
        for side, way in (
            ("right", (1.0, 0.0, 0.0)),
            ("right", (0.0, 1.0, 0.0)),
            ("top", (0.0, -1.0, 0.0)),
        ):
            load = Traction(box.side(side), tuple(material.E * part for part in way[:d]))
            u, v = (
                solve_problem(
                    Problem(box, each, supports=(clamp,), loads=(load,)),
                    body,
                    mixed=each.nu > LOCKING and each.state != "plane_stress",
                ).at(body.points)
                for each in (material, other)
            )
            found.append(float(np.abs(u - v).max() / np.abs(u).max()))
    return min(found), max(found)
