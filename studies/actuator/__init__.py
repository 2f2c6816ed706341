"""Dielectric elastomer actuator of springs and charges

The report ends with a dielectric elastomer actuator: charges on the springs of a slab's faces,
Coulomb's law between them, and its Figure 8, "to be compared with FEM later". One question a file:

- `profile`: the upper face at low voltage against finite elements, and what happens at edges;
- `permittivity`: whether it enters as the square of the voltage does;
- `air`: how much of the marginal effect is left of a dielectric in air;
- `figure8`: the report's Figure 8 (2) and (3) drawn again, and a verdict on each statement;
- `prestretched`: whether a pre-stretched film is nearly a uniform compression;
- `controls`: which faults this study notices, and how small they may be.

Candidate: an actuator's points at rest at a voltage, by default `actuator.at_voltage`. Reference:
finite elements for the field and the solid, which share no code with it, and closed forms. `bodies`
has the slabs, `edges` the closed form of an edge, `models` the three ways to Figure 8.
"""

from __future__ import annotations

from functools import partial

from msvalidate import kit

from . import actuator_controls, air, figure8, permittivity, prestretched, profile
from .bodies import ActuatorSolver, linear_response, springs

ASKED = {
    "profile": profile.run,
    "permittivity": permittivity.run,
    "figure8": figure8.run,
    "prestretched": prestretched.run,
}
"""Question -> who answers it for a candidate. `air` is asked of linear responses."""
STRETCHED = "half of the electrodes' force in a stretched film"
FAULTS = {
    name: {"candidate": actuator_controls.KINDS[kind].spoilt(size), "questions": (question,)}
    for name, kind, size, question in (
        ("half of the electrodes' force", "forces smaller", 0.5, "profile"),
        ("forces of the face across", "forces of the other face", 1.0, "profile"),
        ("each spring's force in halves to its ends", "forces in halves", 1.0, "profile"),
        ("no force at the edges", "edge forces left out", 1.0, "profile"),
        ("springs 2 % stiffer", "springs stiffer", 0.02, "profile"),
        ("springs 2 % softer", "springs stiffer", -0.02, "profile"),
        ("charges as the report has them", "the report's charges", 1.0, "profile"),
        ("the ratio of permittivities left out", "one medium all around", 1.0, "air"),
        (STRETCHED, "forces smaller", 0.5, "prestretched"),
        ("edges pushed inwards", "edge forces left out", 2.0, "figure8"),
    )
} | {
    "charges as at the start": {
        "candidate": partial(linear_response, None),
        "questions": ("figure8",),
    }
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: ActuatorSolver = springs,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    linear = air.run if candidate is springs else partial(air.run, kit.check_actuator(candidate))
    candidate = kit.check_actuator(candidate)
    asked = {name: partial(ask, candidate, setting) for name, ask in ASKED.items()}
    asked |= {"air": partial(linear, setting=setting)}
    return kit.gather_evidence(
        asked | {"controls": partial(actuator_controls.run, setting)}, questions
    )
