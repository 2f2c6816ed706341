"""Contact of spring networks: pressing, impact and friction

The report would have springs examined for contact too. One question a file:

- `small`, `line`, `deep` (in `resting`): forces on small lattices, half-width and pressure under a
  round obstacle, and a block pressed deep by a disc;
- `moving`: a bar against a wall, and friction that sticks and slides.

Candidate: networks at rest against obstacles, and ground springs in motion. Reference: values of
independent programs for the same blocks, finite elements, closed forms.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from msvalidate import kit
from msvalidate.springs.statics.contact import solve_contact

from . import moving, resting

FAULTS = {**resting.FAULTS, **moving.FAULTS}
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: resting.Press = solve_contact,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
    width: resting.Width = resting.second_moment,
    block: tuple[float, float] = resting.BLOCK,
    ground: type[moving.Pulled] = moving.Pulled,
) -> kit.Evidence:
    """All questions, or those named, for one way to press, and one kind of ground springs."""
    if not callable(candidate):
        raise kit.ProblemError(f"candidate: {candidate!r}; give a function as contact.press is")
    asked: dict[str, Callable[[], kit.Evidence]] = {
        "small": partial(resting.run_small, candidate),
        "line": partial(resting.run_line, candidate, setting, width, block),
        "deep": partial(resting.run_deep, candidate),
        "moving": partial(moving.run, setting, ground),
    }
    return kit.gather_evidence(asked, questions)
