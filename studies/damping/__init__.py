"""How does a damped lattice come to rest, and is the report's advice on viscosity sound?

Algorithm 1 adds a virtual viscosity F = -c·v and lets the body move until it is still. One question
a file:

- `figure2`: the report's curves of one particle, under-, over- and critically damped;
- `rest`: steps to rest against the damping, and where the optimum is;
- `stop_rule`: how often the printed rule, the largest velocity, stops wrongly;
- `advice`: what too much and too little viscosity cost;
- `decay`: whether the velocity falls exponentially, and at which rate;
- `direction`: when points move in the false direction;
- `cycles`: whether the energy falls;
- `wave`: how fast the strain wave runs, and what the held edge returns;
- `controls`: faulty motions, and the smallest fault that this study notices.

Candidate: the motion of a network, `euler_cromer` of `msvalidate.integrate` by default. Reference:
the damped oscillator and the waves of elasticity in closed form, and the scheme's recursion mode by
mode.
"""

from __future__ import annotations

from msvalidate.evidence import Evidence, merged
from msvalidate.integrate import euler_cromer
from msvalidate.sweep import Setting
from studies.damping import (
    advice,
    controls,
    cycles,
    decay,
    direction,
    figure2,
    rest,
    stop_rule,
    wave,
)
from studies.damping.bodies import Motion

FAULTS = {
    "damping halved": {"candidate": controls.spoilt("damping", -0.5)},
    "forces 10 % too large": {"candidate": controls.spoilt("kick", 0.1)},
    "half of the first kick lost": {"candidate": controls.spoilt("first kick", 0.5)},
    "viscous force from the new velocity": {
        "candidate": controls.spoilt("viscous force from the new velocity", 1.0)
    },
}
"""Negative controls: arguments of `run` under which a tolerance must fail."""


def run(candidate: Motion = euler_cromer, setting: Setting | None = None) -> Evidence:
    """All questions, for one candidate."""
    setting = setting or Setting()
    return merged(
        *(
            question.run(candidate, setting)
            for question in (
                figure2,
                rest,
                stop_rule,
                advice,
                decay,
                direction,
                cycles,
                wave,
            )
        ),
        controls.run(),
    )
