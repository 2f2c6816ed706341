"""Poisson's ratio of the square lattice

Does the report's lattice, square cells with eight neighbours, have Poisson's ratio k2/(2 k1 + k2)?
The report's own block has 5 x 5 cells of equal springs. The other blocks give springs on the
boundary half of the stiffness.

Recommendation: calculate Poisson's ratio of a square lattice from k2/(k1 + k2), choose k2 = k1/2
for an isotropic material, and give boundary springs half of the stiffness.

One question a file:

- `finite_size`: the ratio of N x N cells, by constants, boundary weights, loading and definition;
- `direction`: the ratio against the direction of the pull;
- `rotated`: whether a block cut at an angle to the lattice shows the ratio of its tensor;
- `cube`: the ratio of N x N x N cells in space, by lattice, boundary weights and loading;
- `incompressible`: what the word asks for in the plane, and what k2 = 2 k1 gives;
- `algorithm1`: whether the report's loop comes to the same rest as a static solution;
- `controls`: the smallest fault that this study notices.

Candidate: displacements predicted for a problem and its network, by default the network's static
equilibrium. Reference: scikit-fem finite elements and closed forms.
"""

from __future__ import annotations

from functools import partial

from msvalidate import kit
from msvalidate.springs.network import faults

from . import (
    algorithm1,
    cube,
    direction,
    finite_size,
    incompressible,
    poisson_controls,
    rotated,
)

FAULTS = {
    name: {
        "candidate": partial(poisson_controls.apply_fault, fault, size),
        "questions": ("finite_size",),
    }
    for name, fault, size in (
        ("every spring 1 % stiffer", faults.stiffen_all, 0.01),
        ("diagonals 1 % stiffer", faults.stiffen_diagonals, 0.01),
        ("one spring missing", faults.weaken_one_spring, 1.0),
        ("wrong boundary weights", faults.stiffen_boundary, 1.0),
    )
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_displacements(candidate)
    return kit.gather_evidence(
        {
            "finite_size": partial(finite_size.run, candidate, setting),
            "direction": partial(direction.run, setting=setting),
            "rotated": partial(rotated.run, candidate, setting),
            "cube": partial(cube.run, candidate, setting),
            "incompressible": partial(incompressible.run, candidate, setting),
            "algorithm1": partial(algorithm1.run, candidate=candidate, setting=setting),
            "controls": poisson_controls.run,
        },
        questions,
    )
