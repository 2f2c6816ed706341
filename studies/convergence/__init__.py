"""Cost of equilibrium by relaxations and finite elements

The report claims that a spring network costs O(n) for n nodes, since the time to rest "can be
limited and constant", against O(n^9) by finite elements, n then the nodes along an edge of a cube.

Recommendation: bring a network of this size to equilibrium with Newton's method and a sparse
factor. Explicit relaxations need a number of steps that grows with the square root of the nodes.

One question a file:

- `steps`: steps and force evaluations of every relaxation to a given error, and their growth;
- `space`: their growth in a cube, and that of the work of elements, beside the report's two orders;
- `dynamic_relaxation`: counts of an independent program, and steps against the condition number;
- `strained`: the order of Newton's method at strains of 5 to 10 %;
- `times`: seconds of the same runs, and of a finite element solution of the same body;
- `frontier`: error against the elastic solution for the time that it takes, springs and elements.

Candidate: the table of relaxations. Reference: the direct solution of the same network, predictions
from its frequencies, and scikit-fem finite elements. Seconds are told, and never judged.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache, partial

import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Method

from . import dynamic_relaxation, frontier, space, spoilt, steps, strained, times

METHODS = RELAXATIONS | {dynamic_relaxation.NAME: dynamic_relaxation.METHOD}
FAULTS = {
    name: {"candidate": METHODS | methods, "questions": (question,)}
    for name, (question, methods) in spoilt.FAULTS.items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: Mapping[str, Method] = METHODS,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one table of relaxations."""
    candidate = kit.check_table(candidate, Method, METHODS)
    counted = cache(partial(steps.run, candidate, setting))

    def table(name: str) -> pd.DataFrame:
        return steps.together(name, counted().tables)

    return kit.gather_evidence(
        {
            "steps": counted,
            "space": lambda: space.run(table("steps"), table("growth"), setting),
            "dynamic_relaxation": partial(dynamic_relaxation.run, candidate, setting),
            "strained": partial(strained.run, candidate, setting),
            "times": lambda: times.run(candidate, table("steps"), setting),
            "frontier": partial(frontier.run, candidate, setting),
        },
        questions,
    )
