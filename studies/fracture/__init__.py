"""Fracture of spring lattices

"Let springs break at a critical stretch" is the usual reason for a lattice. One question a file:

- `plates`, `tips` (in `intensity`): K of cracks that do not grow, and where a lattice's tip is;
- `small`, `growth`: at which fracture energy a crack grows, by the rule for the stretch;
- `paths`: the way that it takes in turned and random lattices;
- `moving`: where the energy goes in motion.

Candidate: springs that break while loads are raised, at rest. Reference: finite elements, closed
forms, values of independent programs.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

from msvalidate import kit
from msvalidate.springs.dynamics.ledger import Ledger
from msvalidate.springs.network.breakage import Breakage
from msvalidate.springs.statics.breaking import propagate_crack

from . import faults, growth, intensity, moving, paths
from .springs import Grow

FAULTS = faults.FAULTS
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(
    candidate: Grow = propagate_crack,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
    known: dict[tuple[str, float], float] = intensity.KNOWN,
    moved: float = 0.0,
    rule: str = "growth",
    springs: type[Breakage] = Breakage,
    ledger: type[Ledger] = Ledger,
) -> kit.Evidence:
    """All questions, or those named, for one way to grow cracks, set a stretch and keep books."""
    if not callable(candidate):
        raise kit.ProblemError(f"candidate: {candidate!r}; give a function as breaking.grow is")
    asked: dict[str, Callable[[], kit.Evidence]] = {
        "plates": partial(intensity.run_plates, setting, known),
        "tips": partial(intensity.run_tips, setting, moved),
        "small": partial(growth.run_small, candidate),
        "growth": partial(growth.run_growth, candidate, setting, rule),
        "paths": partial(paths.run, candidate, setting),
        "moving": partial(moving.run, candidate, setting, springs, ledger),
    }
    return kit.gather_evidence(asked, questions)
