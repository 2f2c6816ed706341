"""Displacement errors of the report's load cases

A single difference from FEM mixes several causes; this study takes them apart.

Recommendation: use k2 = k1/2 with boundary weight 1/2, and at least 20 cells across the body. A
lattice with k2 = 2 k1 is a different, anisotropic material, which no refinement corrects.

One question a file:

- `budget`: every case, lattice, size and boundary rule against its target, cause by cause;
- `shapes`: the report's Figures 4 to 7 drawn again, and its words about them put to numbers;
- `emblem`: the bar of Figure 7 with the report's springs and with calibrated ones;
- `target`: what the "incompressible" lattice is measured against is a choice, and decides;
- `identities`: which networks are exactly a known discretisation;
- `bent_bar`: how stiff a bar of cubic cells is in pure bending;
- `solid`: how far cubes and a cantilever of springs are from the elastic solid;
- `controls`: which faults the study notices, and how small they may be.

The load cases are data in `load_cases`, the springs in `models` and `measuring`, the reference in
`elastic`. Candidate: displacements predicted for a problem and its network: Algorithm 1, nonlinear
and linear equilibrium. Reference: scikit-fem finite elements and closed forms.
"""

from __future__ import annotations

from functools import cache, partial

from msvalidate import kit

from . import (
    bent_bar,
    budget,
    displacement_controls,
    elastic,
    emblem,
    identities,
    large,
    measuring,
    shapes,
    solid,
    target,
)

FAULTS = {
    name: {
        "candidate": displacement_controls.candidate_with(kind, size),
        "questions": ("identities",),
    }
    for name, (kind, size) in displacement_controls.ASKED.items()
} | {
    "budget of springs 0.1 % softer": {
        "candidate": displacement_controls.candidate_with("stiffness of every spring", -0.001),
        "questions": ("budget",),
    },
    "bent bar of springs 0.1 % softer": {
        "candidate": displacement_controls.candidate_with("stiffness of every spring", -0.001),
        "questions": ("bent_bar",),
    },
    "bent bar of wrong boundary weights": {
        "candidate": displacement_controls.candidate_with("boundary weights", 1.0),
        "questions": ("bent_bar",),
    },
    "solids of springs 1 % softer": {
        "candidate": displacement_controls.candidate_with("stiffness of every spring", -0.01),
        "questions": ("solid",),
    },
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out; the budget and the solids, which have no exact answer,
must too."""


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_displacements(candidate)
    bodies = cache(partial(elastic.solve_reference, setting))
    measured = cache(partial(measuring.measure_all, candidate, setting))
    return kit.gather_evidence(
        {
            "budget": lambda: budget.run(measured(), bodies(), large.solve(setting)),
            "shapes": lambda: shapes.run(measured(), bodies()),
            "emblem": lambda: emblem.run(measured(), bodies()),
            "target": lambda: target.run(candidate, setting),
            "identities": lambda: identities.run(candidate, setting),
            "bent_bar": lambda: bent_bar.run(candidate, setting),
            "solid": lambda: solid.run(candidate, setting),
            "controls": lambda: displacement_controls.run(bodies()),
        },
        questions,
    )
