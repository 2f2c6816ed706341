"""Convergence: what does it cost to bring a spring network to rest, and how does that grow?

The report claims that a spring network costs O(n) for n nodes, since the time to rest "can be
limited and constant", against O(n^9) by finite elements. One question a file:

- `steps`: steps and force evaluations of every relaxation to a given error, and their growth;
- `dynamic_relaxation`: counts of an independent program, and steps against the condition number;
- `times`: seconds of the same runs, and of a finite element solution of the same body;
- `frontier`: error against the elastic solution for the time that it takes, springs and elements.

Candidate: the table of relaxations. Reference: the direct solution of the same network, predictions
from its frequencies, and scikit-fem finite elements. Seconds are told, and never judged.
"""

from __future__ import annotations

from collections.abc import Mapping

from msvalidate.evidence import Evidence, merged
from msvalidate.problem import ProblemError
from msvalidate.relax import Method
from msvalidate.relaxations import RELAXATIONS
from msvalidate.sweep import Setting
from studies.convergence import dynamic_relaxation, frontier, spoilt, steps, times

METHODS = RELAXATIONS | {dynamic_relaxation.NAME: dynamic_relaxation.METHOD}
QUESTIONS = ("steps", "dynamic_relaxation", "times", "frontier")
FAULTS = {
    name: {"candidate": METHODS | methods, "questions": (question,)}
    for (name, methods), question in zip(
        spoilt.FAULTS.items(), ("steps", "dynamic_relaxation", "dynamic_relaxation"), strict=True
    )
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: Mapping[str, Method] = METHODS,
    setting: Setting | None = None,
    questions: tuple[str, ...] = QUESTIONS,
) -> Evidence:
    """All questions, or those named, for one table of relaxations. `times` needs `steps`."""
    setting = setting or Setting()
    asked = set(questions)
    if not asked or not asked <= set(QUESTIONS) or ("times" in asked and "steps" not in asked):
        raise ProblemError(f"questions: {questions!r}; choose from {', '.join(QUESTIONS)}")
    parts = []
    if "steps" in asked:
        parts.append(steps.run(candidate, setting))
        if "times" in asked:
            parts.append(times.run(candidate, parts[0].tables["steps"], setting))
    if "dynamic_relaxation" in asked:
        parts.append(dynamic_relaxation.run(candidate, setting))
    if "frontier" in asked:
        parts.append(frontier.run(candidate, setting))
    return merged(*parts)
