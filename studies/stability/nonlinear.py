"""Nonlinear: does the limit hold for the network as it is, with springs that turn?

Question   Does a small motion of the real network stay bounded 2 % below the limit, and grow 2 %
           above it?
Candidate  `integrate.motion` with each scheme, from a small displacement.
Reference  `stability_limit` at the ends of the network's spectrum.
Expected   Bounded below and growing above, without and with damping.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.springs.dynamics.integrate import State, motion
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.step_limits import stability_limit

from .common import Schemes
from .networks import Body, clamped, free_components, linear

PARTS = (0.98, 1.02)
"""Step over the limit."""
SQUARE = Body("square", 6)
QUICK_CASES = ((SQUARE, 0.3),)
CASES = ((SQUARE, 0.0), (SQUARE, 0.3), (Body("triangular", 6), 0.3))
"""Bodies, and their damping ratios at the highest frequency."""
AMPLITUDE = 1e-9
"""Of the start, over the side of the body: springs turn by as little."""
GROWN = 30.0
"""Growth that is not bounded; below its limit, Euler-Cromer's own ellipse stretches fivefold."""
STEPS = 1200
CHUNK = 50
RULES = (
    kit.Rule(
        "small motions of networks that are bounded above the limit or grow below it", 0.0, "1",
        "2 % from the limit the slowest growth, explicit Euler's at ζ = 0.3, is 0.4 % a step",
        table="nonlinear", value=lambda rows: rows["outcome"] != rows["outcome_predicted"],
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Run every scheme a little below and a little above its limit."""
    asked = QUICK_CASES if setting.quick else CASES
    cases = [
        (body, scheme, ratio)
        for (body, ratio), scheme in product(asked, candidate.items())
        if 0 < scheme[1].limit(ratio) < np.inf
    ]
    found = setting.sweep(partial(outcomes, setting.seed), cases, "networks near their limits")
    table = pd.DataFrame([row for rows in found for row in rows])
    return kit.Evidence(
        tables={"nonlinear": table},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def outcomes(
    seed: int, case: tuple[Body, tuple[str, Integrator], float]
) -> list[dict[str, object]]:
    """Two rows: below the limit and above it."""
    body, (name, scheme), ratio = case
    _, network = clamped(body)
    moving = linear(body)
    damping = 2 * ratio * moving.omega[1]
    limit = stability_limit(scheme, *moving.omega, damping)
    away = np.zeros(network.points.size)
    away[free_components(network)] = moving.start(seed)[:, 0]
    away *= AMPLITUDE / np.abs(away).max()
    rows = []
    for part in PARTS:
        grown = grows(network, scheme, away.reshape(network.points.shape), part * limit, damping)
        rows.append(
            {
                "scheme": name,
                "body": body.lattice,
                "points_a_side": body.points,
                "damping_ratio": ratio,
                "step_over_limit": part,
                "outcome": "grows" if grown else "bounded",
                "outcome_predicted": "grows" if part > 1 else "bounded",
            }
        )
    return rows


def grows(
    network: kit.Network, scheme: Integrator, away: kit.Array, dt: float, damping: float
) -> bool:
    """Whether a motion from a displacement (n, d) in m grows beyond `GROWN` times it."""
    state = State(network.points + away, np.zeros_like(away))
    for _ in range(STEPS // CHUNK):
        try:
            state = motion(network, state, scheme, dt, CHUNK, damping, warn=False)
        except kit.SolverError:
            return True
        if np.abs(state.position - network.points).max() > GROWN * np.abs(away).max():
            return True
    return False
