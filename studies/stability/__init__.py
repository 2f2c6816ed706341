"""Stable time steps and orders of integrators

The report compares four ways to step in time and prints two of them wrongly.

Recommendation: use leapfrog (velocity Verlet if velocities are needed at the time of positions). It
is symplectic, explicit, of second order, and its stable time step does not depend on the damping.

One question a file:

- `limits`: the largest stable step against the damping, measured, for an oscillator and networks;
- `growth`: how fast a scheme grows that no step makes stable;
- `nonlinear`: whether the limit holds for the network as it is;
- `misprints`: which motions the formulas follow as they are printed;
- `order`: how fast the error falls with the step, without and with damping;
- `drift`: whether the energy stays over ten thousand periods, and how far it fluctuates;
- `figure3`: the report's Figure 3 drawn again, and its words about it put to numbers;
- `passing`: whether underdamped motion pushes particles past each other;
- `cost`: which accuracy for how many force evaluations;
- `controls`: the smallest fault that this study notices;
- `summary`: stable steps and work of the report's four integrators in one table.

Candidate: the table of schemes, name -> record, by default `integrators.INTEGRATORS`: each is held
to what it claims. Reference: closed forms. `networks` has the bodies, `runs` and `oscillator` move
them, `bounded` searches for a limit.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator

from . import (
    cost,
    drift,
    figure3,
    growth,
    limits,
    misprints,
    nonlinear,
    order,
    passing,
    stability_controls,
    summary,
)
from .common import Schemes

ASKED = {
    "limits": limits.run,
    "growth": growth.run,
    "nonlinear": nonlinear.run,
    "misprints": misprints.run,
    "order": order.run,
    "drift": drift.run,
    "figure3": figure3.run,
    "passing": passing.run,
    "cost": cost.run,
}
"""Question -> who answers it for a candidate."""
VERLET = INTEGRATORS["velocity_verlet"]
LAGGED = replace(VERLET, step=INTEGRATORS["verlet_lagged"].step)
FAULTS = {
    "Verlet without its second kick": {
        "candidate": INTEGRATORS | {VERLET.name: stability_controls.with_weak_kick(1.0)},
        "questions": ("limits",),
    },
    "half of Verlet's second kick": {
        "candidate": INTEGRATORS | {VERLET.name: stability_controls.with_weak_kick(0.5)},
        "questions": ("order",),
    },
    "Verlet with the old force in both kicks": {
        "candidate": INTEGRATORS | {VERLET.name: LAGGED},
        "questions": ("drift",),
    },
    "a thousandth of Verlet's second kick missing": {
        "candidate": INTEGRATORS | {VERLET.name: stability_controls.with_weak_kick(0.001)},
        "questions": ("cost",),
    },
    "Euler-Cromer with half the damping": {
        "candidate": INTEGRATORS
        | {"euler_cromer": stability_controls.with_weak_damping("euler_cromer", 0.5)},
        "questions": ("limits",),
    },
    "leapfrog with 1 % less damping": {
        "candidate": INTEGRATORS
        | {"leapfrog": stability_controls.with_weak_damping("leapfrog", 0.01)},
        "questions": ("order",),
    },
}
"""Negative controls: arguments of `run` under which a tolerance must fail. One question that
notices is enough, so the rest is left out."""


def run(
    candidate: Schemes = INTEGRATORS,
    setting: kit.Setting = kit.FULL,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """All questions, or those named, for one table of schemes."""
    candidate = kit.check_table(candidate, Integrator, {})
    asked = {name: cache(partial(ask, candidate, setting)) for name, ask in ASKED.items()}

    def summarised() -> kit.Evidence:
        limited, priced = asked["limits"]().tables["limits"], asked["cost"]().tables["cost_needed"]
        tables = summary.summarise(limited, priced)
        return kit.Evidence(tables, tolerances=summary.RULES, columns=kit.columns(__file__))

    others: dict[str, Callable[[], kit.Evidence]] = {
        "controls": partial(stability_controls.run, setting),
        "summary": summarised,
    }
    return kit.gather_evidence(asked | others, questions)
