"""Misprints: what do the report's formulas do as they are printed?

Question   The report prints Euler-Cromer with x moved by the old velocity, and velocity Verlet with
           its second half kick from v(t) and F(t). Which motions do these follow?
Candidate  The two variants, run on a network of 6 x 6 points.
Reference  Explicit Euler, step for step; the motion in closed form under the force and half of it.
Expected   Printed Euler-Cromer is explicit Euler, to the last digit. Printed Verlet kicks with half
           the force: its position tends to the motion at ω/√2, and not to that at ω.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import stability_limit

from . import common, order
from .common import Schemes
from .networks import REPORTED, Body, clamped, linear

STEPS = 50
RATIOS = (0.0, 0.3)
"""Damping ratio at the highest frequency."""
PART = 0.2
"""Step over Euler-Cromer's limit."""
SPEED = 0.05
"""Largest start velocity, in sides a period of the fastest mode: springs turn and stretch."""
SAME, HALVED = 1e-12, 0.002
judged = partial(kit.Rule, unit="1", table="misprints", value="difference")
RULES = (
    judged(
        "printed Euler-Cromer against explicit Euler on a network, over the largest displacement",
        SAME, rows={"compared_with": "explicit Euler, step for step"},
        because="one formula in two places: rounding at most, which grows with the motion",
    ),
    judged(
        "printed Verlet against the motion under half the force, finest step", HALVED,
        rows={"compared_with": "motion under half the force"}, reference="difference_expected",
        because="of first order: half the finest step over the time scale, √2/ω, 8e-4 at 800 "
        "steps, times a factor of order 1",
    ),
    judged(
        "printed Verlet against the motion itself, finest step: distance of the two motions",
        HALVED, rows={"compared_with": "motion itself"}, reference="difference_expected",
        because="it tends to another motion, so its error tends to the distance between the two",
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Compare both misprints with what they turn out to be."""
    names = ("explicit_euler", "euler_cromer_as_printed", "verlet_as_printed")
    euler, printed, verlet = common.chosen(candidate, names).values()
    rows = [
        {
            "scheme": names[1],
            "compared_with": "explicit Euler, step for step",
            "damping_ratio": ratio,
            "steps": STEPS,
            "difference": distance_between_motions(euler, printed, ratio),
            "difference_expected": 0.0,
        }
        for ratio in RATIOS
    ]
    steps = order.STEPS[-1]
    moved = order.swing(order.lowest_mode(), verlet, steps)
    half, whole = (np.cos(order.ANGLE * factor) for factor in (np.sqrt(0.5), 1.0))
    for name, motion_of, expected in (
        ("motion under half the force", half, 0.0),
        ("motion itself", whole, abs(whole - half)),
    ):
        rows.append(
            {
                "scheme": names[2],
                "compared_with": name,
                "damping_ratio": 0.0,
                "steps": steps,
                "difference": abs(moved - motion_of),
                "difference_expected": expected,
            }
        )
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"misprints": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def distance_between_motions(one: Integrator, other: Integrator, ratio: float) -> float:
    """Largest distance between two schemes' motions of a network, over the largest displacement."""
    body = Body("square", 6)
    _, network = clamped(body, REPORTED, weights="equal")
    omega = linear(body).omega
    dt = PART * stability_limit(INTEGRATORS["euler_cromer"], *omega)
    paths = [path(network, scheme, dt, 2 * ratio * omega[1]) for scheme in (one, other)]
    return float(np.abs(paths[0] - paths[1]).max() / np.abs(paths[0] - network.points).max())


def path(network: kit.Network, scheme: Integrator, dt: float, damping: float) -> kit.Array:
    """Positions (steps, n, d) in m after a start with the velocity of a twist."""
    x, y = network.points.T
    velocity = SPEED / (2 * np.pi * dt) * np.column_stack([x * y, x * (1 - 2 * y)])
    seen: list[kit.Array] = []
    state = State(network.points, np.where(network.fixed, 0.0, velocity))
    motion(
        network,
        state,
        scheme,
        dt,
        STEPS,
        damping,
        lambda _, now: seen.append(now.position),
        warn=False,
    )
    return np.array(seen)


def finding(table: pd.DataFrame) -> str:
    """What the misprints are, in numbers."""
    euler = table[table["compared_with"].str.startswith("explicit")]["difference"].max()
    half, whole = table["difference"].iloc[-2:]
    same, halved = euler <= SAME, half <= HALVED
    return (
        f"As printed, Euler-Cromer is {'' if same else 'not '}explicit Euler (largest difference "
        f"of a network's motion {euler:.1g}), and velocity Verlet "
        f"{'moves' if halved else 'does not move'} under half the force: after 2 rad it is "
        f"{half:.1e} of the amplitude from that motion, and {whole:.2f} from the right one."
    )
