"""What a field does at an electrode's edge, in closed form: a point force, and a face under it.

The charge of an edge grows with the inverse root of the distance, and pulls on a single point with
a finite force along the electrode, outwards. It is the energy that the edge gains as it moves,
F = ½V²·dC/dx. Under a point force on a wedge stresses fall as 1/r ([Michell1902];
[TimoshenkoGoodier1970], §§36-38): with Θ the opening, b the bisector and p across it,

    σ_rr = -(1/r)·[F_b·cosθ/(Θ/2 + ½sinΘ) + F_p·sinθ/(Θ/2 - ½sinΘ)],

so that halving the smallest length r that a lattice resolves adds to the displacement of the point

    (ln 2/E)·[F_b·b/(Θ/2 + ½sinΘ) + F_p·p/(Θ/2 - ½sinΘ)].
"""

from __future__ import annotations

from functools import cache

import numpy as np

from msvalidate import kit
from msvalidate.dielectric.charges import capacitance, electrodes_of_chains, strip_points

from .bodies import COVERED, HEIGHT, LENGTH, plane_material

OPENING = {"full": np.pi / 2, "partial": np.pi}
"""Of the slab under the edge: its corner, or a straight face."""
SEGMENTS = 200
"""Graded to the edges: capacitances to 1e-5."""
STEP = 0.005
"""Part of the electrode by which it is made longer and shorter; the second derivative is small."""


@cache
def growth(covered: str) -> kit.Array:
    """Displacement (2,) in m at 1 V that each halving adds at the right edge, outwards and up."""
    return edge_force(covered) * under_a_force(OPENING[covered], plane_material().E)


def edge_force(covered: str) -> float:
    """Force (N/m) at 1 V along x on each edge of the upper electrode, in a medium of ε = 1 F/m.

    Only its own two edges move, by half of what it is widened each.
    """
    width, middle = LENGTH * COVERED[covered], 0.5 * LENGTH
    lower = strip_points(LENGTH, 0.0, SEGMENTS, centre=middle)
    low, high = (
        capacitance(
            electrodes_of_chains(
                strip_points(width * (1 + step), HEIGHT, SEGMENTS, centre=middle), lower
            )
        )
        for step in (-STEP, STEP)
    )
    return 0.5 * (high - low) / (2 * STEP * width)


def under_a_force(opening: float, modulus: float) -> kit.Array:
    """Displacement (2,) in m per N/m along x that each halving adds at a wedge's point.

    The wedge lies to the left of and below its point: its first side is the upper face.
    """
    half = 0.5 * opening
    bisector = np.array([np.cos(np.pi + half), np.sin(np.pi + half)])
    across = np.array([-bisector[1], bisector[0]])
    along, aside = half + 0.5 * np.sin(opening), half - 0.5 * np.sin(opening)
    push = bisector[0] * bisector / along + across[0] * across / aside
    return np.where(np.abs(push) > 1e-12, np.log(2) / modulus * push, 0.0)
