"""Beyond: what does a user hear who asks for a voltage that no slab holds?

Question   Past pull-in there is no equilibrium near by. Is that said in one line that names the
           voltage and the last one held, and is the last equilibrium kept?
Candidate  A way to rest at a voltage.
Reference  The last voltage held on a walk in small steps, and the balance of forces there.
Expected   An error of one line; the equilibrium that comes with it balances to the tolerance and
           lies within the bracket of the walk below the voltage that failed.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.dielectric.actuator import ActuatorEquilibrium, PulledIn, fix_near_tips
from msvalidate.springs.network import configuration_at
from msvalidate.springs.network.residual import force_scale

from . import slab
from .slab import PULL_IN, REACH
from .way import PullInSolver, bonded, sliding

QUICK_LAYERS, LAYERS = 3, 5
QUICK_ASKED, ASKED = (1.02, 20.0), (1.02, 1.5, 20.0)
"""Over the uniform pull-in voltage."""
BODIES = ("between walls", "bonded, edges held", "bonded")
BRACKET = 1e-4
RULES = (
    kit.Rule(
        "residual of the equilibrium kept, over the forces that meet", 1e-9, "1",
        "equilibria are found to 1e-10 of these forces",
        table="beyond", value="residual_over_forces",
    ),
)  # fmt: skip


def run(candidate: PullInSolver, setting: kit.Setting) -> kit.Evidence:
    """Ask for too much, by steps of several sizes, of each body."""
    layers = QUICK_LAYERS if setting.quick else LAYERS
    parts = QUICK_ASKED if setting.quick else ASKED
    cases = [(body, layers, part) for body in BODIES for part in parts]
    table = pd.DataFrame(
        setting.sweep(partial(request_too_much, candidate), cases, "beyond pull-in")
    )
    unclear = int(((table["says"] != "yes") | (table["lines"].astype(str) != "1")).sum())
    first = table.groupby("body")["last_over_pull_in"].transform("first")
    own = (
        kit.Tolerance(
            "voltages beyond pull-in that were held, or refused in no clear line", 0.0, "1",
            "a line that names the voltage asked for and the last one held is what a user needs",
            observed=kit.Observed(float(unclear)),
        ),
        kit.Tolerance(
            "last voltage held over that of another step, from 1", 2e-4, "1",
            "two walks end within the bracket of 1e-4, each of its own",
            observed=kit.farthest_value(table["last_over_pull_in"] / first, 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"beyond": table},
        tolerances=(*RULES, *own),
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def request_too_much(way: PullInSolver, case: tuple[str, int, float]) -> dict[str, object]:
    """What is said, and what is kept."""
    body, layers, part = case
    actuator = sliding(layers) if body == BODIES[0] else bonded(layers)
    if body == BODIES[1]:
        actuator = fix_near_tips(actuator, 0.5 * REACH)
    goal = part * PULL_IN.voltage
    said = ""
    try:
        last = way.at_voltage(actuator, goal, bracket=BRACKET)
    except kit.SolverError as error:
        said = str(error)
        last = error.last if isinstance(error, PulledIn) else way.at_voltage(actuator, 0.0)
    named = f"{goal:.6g}" in said and f"{last.voltage:.6g}" in said
    return {
        "body": body,
        "layers": layers,
        "asked_over_pull_in": part,
        "last_over_pull_in": last.voltage / PULL_IN.voltage,
        "residual_over_forces": relative_residual(last),
        "thickness_least": float(last.top[:, 1].min() / slab.HEIGHT),
        "lines": len(said.splitlines()) or "held",
        "says": "yes" if named else "no",
    }


def relative_residual(held: ActuatorEquilibrium) -> float:
    """Residual over the forces that meet at a point; 0 where there are none."""
    met = force_scale(configuration_at(held.actuator.network, held.position))
    return held.residual / met if met else 0.0


def finding(table: pd.DataFrame) -> str:
    """Where the walks end."""
    ends = ", ".join(
        f"{body} at {float(np.mean(own['last_over_pull_in'])):.4f}"
        for body, own in table.groupby("body", sort=False)
    )
    return (
        f"Asked for up to {max(ASKED):g} times the uniform pull-in voltage, the walk ends with the "
        f"last equilibrium kept: {ends} of it. Points held where they start leave a step beside "
        "them, which goes before the slab inside does."
    )
