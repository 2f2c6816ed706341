"""Relaxation of a damped lattice

Algorithm 1 adds a virtual viscosity F = -c·v and lets the body move until it is still. One question
a file:

- `figure2`: the report's curves of one particle, under-, over- and critically damped;
- `rest`: steps to rest against the damping, and where the optimum is;
- `stop_rule`: how often the printed rule, the largest velocity, stops wrongly;
- `advice`: what too much and too little viscosity cost;
- `decay`: whether the velocity falls exponentially, and at which rate;
- `direction`: when points move in the false direction;
- `wave`: how fast the strain wave runs, and what the held edge returns;
- `controls`: faulty motions, and the smallest fault that this study notices.

Candidate: the motion of a network, `euler_cromer` of `springs.dynamics.integrate` by default.
Reference: the damped oscillator and the waves of elasticity in closed form, and the scheme's
recursion mode by mode.
"""

from __future__ import annotations

from functools import partial

from msvalidate import kit

from . import advice, damping_controls, decay, direction, figure2, rest, stop_rule, wave
from .bodies import MOTION, MotionSolver

ASKED = {
    "figure2": figure2.run,
    "rest": rest.run,
    "stop_rule": stop_rule.run,
    "advice": advice.run,
    "decay": decay.run,
    "direction": direction.run,
    "wave": wave.run,
}
"""Question -> who answers it for a candidate."""

FAULTS = {
    name: {"candidate": damping_controls.apply_fault(kind, size), "questions": (question,)}
    for name, kind, size, question in (
        ("damping halved", "damping", -0.5, "rest"),
        ("forces 10 % too large", "kick", 0.1, "wave"),
        ("half of the first kick lost", "first kick", 0.5, "figure2"),
        (damping_controls.NEW_VELOCITY, damping_controls.NEW_VELOCITY, 1.0, "direction"),
        ("forces a fiftieth of a step late", "lagged force", 0.02, "figure2"),
    )
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out. (A force a whole step late diverges.)"""


def run(
    candidate: MotionSolver = MOTION,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one candidate."""
    candidate = kit.check_motion(candidate)
    asked = {name: partial(ask, candidate, setting) for name, ask in ASKED.items()}
    return kit.gather_evidence(asked | {"controls": damping_controls.run}, questions)
