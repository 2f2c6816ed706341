"""A bonded film that keeps its volume: its stiffness against waves of the surface, by elements.

A field E between a conducting surface and the base softens a wave u·cos(kx) by εE²·k·coth(kh)·u;
where that is the film's own stiffness S·u the wave is free to grow. `actuator.uniform` has S in
closed form; here it is measured on half a wave.
"""

from __future__ import annotations

import numpy as np

from msvalidate import kit
from reference_fem import box_discretisation, solve_problem

CELLS = 24
"""Along half a wave."""
LEAST_UP = 8
"""Cells up a film that is thin beside its waves: an even film has squares of half a wave's."""


def field(kappa: float, ratio: float = 0.5) -> float:
    """Field over √(μ/ε) at which a wave of κ = kh grows, the film's stiffness from mixed elements.

    Half a wave of a film of height 1 m and shear modulus 1 Pa, by default at a Poisson's ratio of
    1/2; its sides slide up and down where the wave has its crest and its trough.
    """
    box = kit.Box((np.pi / kappa, 1.0))

    def wave(points: kit.Array) -> kit.Array:
        return np.column_stack([np.zeros(len(points)), np.cos(kappa * points[:, 0])])

    slide = tuple(kit.Support(box.side(name), (0.0, None)) for name in ("left", "right"))
    problem = kit.Problem(
        box,
        kit.Isotropic(2 * (1 + ratio), ratio, "plane_strain"),
        (kit.Support(box.side("bottom"), (0.0, 0.0)), *slide),
        (kit.Traction(box.side("top"), wave),),
        name="film under a wave of traction",
    )
    up = max(LEAST_UP, round(CELLS * kappa / np.pi))
    found = solve_problem(problem, box_discretisation(box, (CELLS, up), "Q2"), mixed=True)
    stiffness = 1 / amplitude(found.at(surface(box)), kappa * surface(box)[:, 0])
    return float(np.sqrt(stiffness * np.tanh(kappa) / kappa))


def surface(box: kit.Box) -> kit.Array:
    """Points of the top, corners and mid-sides of cells."""
    x = np.linspace(0.0, box.size[0], 2 * CELLS + 1)
    return np.column_stack([x, np.full(len(x), box.size[1])])


def amplitude(displacement: kit.Array, angle: kit.Array) -> float:
    """Of cos(angle) in the displacement up, by the trapezium rule: exact for these waves."""
    weight = np.full(len(angle), 2 / (len(angle) - 1))
    weight[[0, -1]] /= 2
    return float(weight @ (displacement[:, 1] * np.cos(angle)))
