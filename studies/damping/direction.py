"""Direction: does too much viscosity move points the wrong way?

Question   The report: with too large a coefficient "nodes will move to the false direction" and
           may be unstable. How large is too large?
Candidate  Algorithm 1's motion, of a free pair of points and of a plate let go with random speeds.
Reference  A free velocity is multiplied by 1 - hc a step: it turns round each step above hc = 1
           and grows above 2. A mode of the plate at h is stable to hc = 2 - (hω)²/2.
Expected   Exactly that: the false direction is the scheme's, from the old velocity in the viscous
           force, and goes with a smaller step.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.integrate import State

from . import bodies, decay
from .bodies import LOAD, MotionSolver

PLATE = ("plate", (4, 4), "across")
PRODUCTS = (0.1, 0.5, 0.9, 1.1, 1.5, 1.8, 1.95, 2.1)
"""Time step times damping."""
STIFF = 0.5
"""Time step times the plate's highest frequency: a quarter of the undamped limit."""
STEPS = 30
FACTOR = 1e-7
RULES = (
    kit.Rule(
        "factor of the velocity a step over the predicted, from 1", FACTOR, "1",
        "linear to parts of 1e-6 in thirty steps; rounding is an eps of positions over "
        "displacements of 1e-6",
        table="direction", value=kit.Quotient("factor", "factor_predicted"), reference=1.0,
    ),
    kit.Rule(
        "part of the steps that turn the velocity round, from the predicted", 0.0, "1",
        "a count; no predicted product of two velocities is near zero",
        table="direction", value="turned", reference="turned_predicted",
    ),
)  # fmt: skip


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Try both motions over time step times damping."""
    cases = list(product(("free", "plate"), PRODUCTS))
    table = pd.DataFrame(
        setting.sweep(partial(try_direction, candidate, setting.seed), cases, "direction")
    )
    return kit.Evidence(
        tables={"direction": table},
        tolerances=RULES,
        figures={"direction": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def try_direction(candidate: MotionSolver, seed: int, case: tuple[str, float]) -> dict[str, object]:
    """One row."""
    what, hc = case
    if what == "free":
        network, dt, name, limit = decay.free_pair(), 1.0, "free pair", 2.0
        told = (1 - hc) ** np.arange(STEPS + 1)
        start = np.full(network.points.shape, LOAD)
        ways, sizes = told[1:] * told[:-1], np.abs(told)
    else:
        body = bodies.loaded(*PLATE)
        network = body.unloaded
        dt, name, limit = STIFF / body.frequencies[-1], body.name, 2 - STIFF**2 / 2
        speeds = np.random.default_rng(seed).normal(size=len(body.frequencies))
        start = LOAD * (speeds @ body.shapes).reshape(network.points.shape)
        modal = predict(body.frequencies, dt, hc / dt, speeds)
        ways, sizes = (modal[1:] * modal[:-1]).sum(axis=1), np.linalg.norm(modal, axis=1)
    state = State(network.points, start)
    turned, first = 0, weight_damping(network.mass, start, start)
    for _ in range(STEPS):
        before = state.velocity
        state = candidate(network, state, dt, 1, hc / dt)
        turned += weight_damping(network.mass, before, state.velocity) < 0
    last = weight_damping(network.mass, state.velocity, state.velocity)
    return {
        "moving": name,
        "h_c": hc,
        "turned": turned / STEPS,
        "turned_predicted": float((ways < 0).mean()),
        "factor": (last / first) ** (0.5 / STEPS),
        "factor_predicted": float((sizes[-1] / sizes[0]) ** (1 / STEPS)),
        "limit": limit,
    }


def weight_damping(mass: kit.Array, a: kit.Array, b: kit.Array) -> float:
    """Σ m a·b of two velocities (n, d)."""
    return float(mass @ (a * b).sum(axis=1))


def predict(omegas: kit.Array, dt: float, damping: float, speeds: kit.Array) -> kit.Array:
    """Velocities (steps + 1, m) of modes let go at rest with some speeds, by the recursion."""
    step = bodies.one_step(omegas, dt, damping)
    state = np.stack([np.zeros(len(omegas)), speeds], axis=1)[:, :, None]
    history = [state[:, 1, 0]]
    for _ in range(STEPS):
        state = step @ state
        history.append(state[:, 1, 0])
    return np.array(history)


def finding(table: pd.DataFrame) -> str:
    """When the velocity turns round, and when it grows."""
    free = table[table["moving"] == "free pair"]
    plate = table[table["moving"] != "free pair"]
    turning, growing = free[free["turned"] == 1], free[free["factor"] > 1]
    return (
        f"A free velocity turns round at the steps from hc = {turning['h_c'].min():g} tried "
        f"(1 predicted) and grows from {growing['h_c'].min():g} (2 predicted), on a plate from "
        f"{plate[plate['factor'] > 1]['h_c'].min():g} ({plate['limit'].iloc[0]:.4g} "
        "predicted): points move in the false direction only where the time step is too long "
        "for the viscosity, not because a viscosity is too large."
    )


def draw(tables: kit.Tables) -> Figure:
    """Factor of the velocity a step against time step times damping."""
    figure, (axis,) = kit.figures.new_figure(size=(4.4, 4.0))
    for place, (name, own) in enumerate(tables["direction"].groupby("moving", sort=False)):
        style = kit.figures.series_style(place)
        axis.plot(own["h_c"], own["factor"], ls="", label=str(name), ms=6, **style)
        axis.plot(own["h_c"], own["factor_predicted"], ".", color="white", ms=3)
        limit = f"stability limit, {name}"
        axis.axvline(own["limit"].iloc[0], color=style["color"], lw=0.8, ls=":", label=limit)
    axis.plot([], [], "o", color="grey", mfc="white", ms=4, label="predicted")
    axis.axhline(1.0, color="grey", lw=0.8, ls="--", label="no decay")
    axis.set(xlabel="time step times damping, hc (1)", ylabel="factor of the velocity a step (1)")
    axis.set_title("What damping leaves of a velocity in a step")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
