"""Validity of springs by body and question

- `good_for`: ten rows to choose by, from the tables of the other studies;
- `ordinary`: parts as `case run` finds them, a plate with two holes and a bracket in space;
- `part`: one part by every spring model and by elements, error against springs and against time.

It runs after the others and reads what they found; what has not run is read from the committed
baseline. Candidate: those results; and, for the part, displacements predicted for a problem and its
network. Reference: elasticity, as in each study.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache, partial

from msvalidate import kit
from msvalidate.springs.network import faults

from . import good_for, ordinary, part

READS_RESULTS = True


def solve_stiffened(problem: kit.Problem, network: kit.Network, answer: kit.Answer) -> kit.Array:
    """A candidate whose springs are 1 % stiffer."""
    return kit.solve_springs(problem, faults.stiffen_all(network, 0.01), answer)


def solve_slanted(problem: kit.Problem, network: kit.Network, answer: kit.Answer) -> kit.Array:
    """A candidate whose diagonals are 2 % stiffer."""
    return kit.solve_springs(problem, faults.stiffen_diagonals(network, 0.02), answer)


def solve_without_volumes(
    problem: kit.Problem, network: kit.Network, answer: kit.Answer
) -> kit.Array:
    """A candidate that leaves the energy of volumes out."""
    return kit.solve_springs(problem, replace(network, volumes=None), answer)


FAULTS = {
    name: {"springs": springs, "questions": ("part",)}
    for name, springs in {
        "every spring 1 % stiffer": solve_stiffened,
        "diagonals 2 % stiffer": solve_slanted,
        "energy of volumes left out": solve_without_volumes,
    }.items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: kit.Results | None = None,
    setting: kit.Setting = kit.FULL,
    springs: kit.DisplacementSolver = kit.solve_springs,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named."""
    results = kit.check_results(candidate, quick=setting.quick)
    own = cache(partial(part.run, kit.check_displacements(springs), setting))
    return kit.gather_evidence(
        {
            "good_for": lambda: good_for.run(results, {**own().tables, **ordinary.run().tables}),
            "part": own,
            "ordinary": ordinary.run,
        },
        questions,
    )
