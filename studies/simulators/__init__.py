"""Effective elastic solid of a simulator

A simulator is asked through files or in memory (`msvalidate.simulators`): the gate tries it, the
affine probe reads its law from single steps, bodies of the frozen set are brought to rest, and what
differs is taken apart into law, mass, solver and resolution. One question a file:

- `judged`: the candidate itself, all of it;
- `laws`: laws as documents and sources have them, predicted to first order and read by the probe;
- `faults`: simulators with one known fault each: is every one named, and none on a clean one?
- `recorded`: simulators that people use, from what their adapters left (`make simulators`);
- `curve`: effective modulus and ratio over the ratio asked for, of laws of one of them;
- `held`: elements of high order beside elasticity, and bonds of another program beside our springs;
- `iterations`: states at rest over time step and iterations, of programs that iterate;
- `hanging`: a published comparison of soft-body solvers with finite elements, predicted.

No ranking and no score: documented laws differ on purpose. Not affiliated with any of the programs.
Findings about others' programs are drafts until their authors have been told.

Candidate: a simulator, (request) -> answer; by default linear tetrahedra of a neo-Hookean law.
Reference: the law's derivative at rest, frozen elasticity, and linear elements on the same mesh.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from msvalidate import kit
from msvalidate.problem.checks import format_value
from msvalidate.simulators.exchange.protocol import Simulator

from . import curve, faults, hanging, held, iterations, judged, laws, recorded
from .synthetic import clean, controls

FAULTS: dict[str, dict[str, Any]] = {
    name: {"candidate": simulate, "questions": ("judged",)} for name, simulate in controls().items()
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: Simulator = clean,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    if not callable(candidate):
        raise kit.ProblemError(
            f"candidate: {format_value(candidate)}; give a function of a Request that returns an "
            "Answer, or a Program"
        )
    asked: dict[str, Callable[[], kit.Evidence]] = {
        "judged": partial(judged.run, candidate),
        "laws": laws.run,
        "faults": partial(faults.run, setting),
        "recorded": recorded.run,
        "curve": curve.run,
        "held": held.run,
        "iterations": iterations.run,
        "hanging": hanging.run,
    }
    return kit.gather_evidence(asked, questions)
