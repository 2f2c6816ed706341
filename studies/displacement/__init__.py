"""Displacement: how far are the report's load cases from elasticity, and why?

A single difference from FEM mixes five causes; this study takes them apart. One question a file:

- `budget`: every case, lattice, size and boundary rule against its target, cause by cause;
- `shapes`: the report's Figures 4 to 7 drawn again, and its words about them put to numbers;
- `target`: what the "incompressible" lattice is measured against is a choice, and decides;
- `identities`: which networks are exactly a known discretisation;
- `controls`: which faults the study notices, and how small they may be.

The load cases are data in `load_cases`, the springs in `models` and `measuring`, the reference in
`elastic`. Candidate: displacements predicted for a problem and its network: Algorithm 1, nonlinear
and linear equilibrium. Reference: scikit-fem finite elements and closed forms.
"""

from __future__ import annotations

from functools import cache, partial

from msvalidate.candidate import Candidate, springs
from msvalidate.evidence import Evidence, answers
from msvalidate.sweep import Setting
from studies.displacement import budget, controls, elastic, identities, measuring, shapes, target

FAULTS = {
    name: {"candidate": controls.candidate_with(kind, size), "questions": ("identities",)}
    for name, (kind, size) in controls.ASKED.items()
} | {
    "budget of springs 0.1 % softer": {
        "candidate": controls.candidate_with("stiffness of every spring", -0.001),
        "questions": ("budget",),
    }
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out; the budget, which has no exact answer, must too."""


def run(
    candidate: Candidate = springs,
    setting: Setting | None = None,
    questions: tuple[str, ...] | None = None,
) -> Evidence:
    """All questions, or those named, for one candidate."""
    setting = setting or Setting()
    bodies = cache(partial(elastic.solved, setting))
    measured = cache(partial(measuring.all_measured, candidate, setting))
    return answers(
        {
            "budget": lambda: budget.run(measured(), bodies()),
            "shapes": lambda: shapes.run(measured(), bodies()),
            "target": lambda: target.run(candidate, setting),
            "identities": lambda: identities.run(candidate, setting),
            "controls": lambda: controls.run(bodies()),
        },
        questions,
    )
