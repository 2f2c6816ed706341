"""Decay: does the velocity decrease exponentially, and at which rate?

Question   The report: with F = -c·v the velocity "can decrease exponentially". It does where
           nothing but viscosity acts; at which rate does that of an elastic body?
Candidate  Algorithm 1's motion of a free pair of points, and of a plate let go in its lowest mode.
Reference  c for a free motion; c/2 of the envelope of a mode below critical damping; above it
           c/2 - √(c²/4 - ω²), about ω²/c: the more viscosity, the slower.
Expected   All three, to the O(h) of the scheme.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.damping import decay
from msvalidate.springs.dynamics.integrate import State
from msvalidate.springs.network import spring_network

from . import bodies
from .bodies import LOAD, MotionSolver

PLATE = ("plate", (4, 4), "across")
RATIOS = (0.1, 0.2, 0.5, 2.0, 5.0, 10.0)
"""Damping over the critical one."""
PART = 0.1
"""Of the stability limit: the time step."""
LOOK = 0.15
"""Time between looks times the frequency, or the damping of a free motion."""
FOLDS = 6.0
"""E-foldings that are watched; a rate is fitted to the second half, where one root is left."""
RULES = (
    kit.Rule(
        "fitted rate of decay over the predicted, from 1", 0.02, "1",
        "the old velocity damps by -ln(1 - hc)/h instead of c, h·c/2 more: 0.8 % at most where "
        "it swings; above critical damping that speeds up the fast root instead",
        table="decay", value=kit.Quotient("rate_over_c", "rate_over_c_predicted"), reference=1.0,
    ),
)  # fmt: skip


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Fit the rates."""
    found = setting.sweep(partial(fit_decay, candidate), (None, *RATIOS), "rates of decay")
    table = pd.DataFrame(found)
    return kit.Evidence(
        tables={"decay": table},
        tolerances=RULES,
        figures={"decay": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
    )


def free_pair() -> kit.Network:
    """Two points joined by a spring of no stiffness: nothing but viscosity acts."""
    return spring_network([[0.0, 0.0], [1.0, 0.0]], [[0, 1]], 0.0)


def fit_decay(candidate: MotionSolver, ratio: float | None) -> dict[str, object]:
    """One row: the free pair, or the plate's lowest mode at a damping over the critical one."""
    if ratio is None:
        network, damping, dt, omega, name = free_pair(), 1.0, 0.01, 1.0, "free pair"
        predicted, weights = damping, network.points / 2 + 0.5
        state = State(network.points, np.full(network.points.shape, LOAD))
    else:
        body = bodies.loaded(*PLATE)
        network, omega, name = body.unloaded, float(body.frequencies[0]), body.name
        damping, predicted = 2 * ratio * omega, decay(omega, 2 * ratio * omega)
        dt, shape = body.time_step(damping, PART), body.shapes[0].reshape(body.rest.shape)
        weights = network.mass[:, None] * shape
        moved = network.points + LOAD * shape / np.abs(shape).max()
        state = State(moved, np.zeros_like(shape))
    look = max(1, int(LOOK / omega / dt))
    times = look * dt * np.arange(1.0, int(FOLDS / predicted / (look * dt)) + 2)
    speeds = np.zeros(len(times))
    for i in range(len(times)):
        state = candidate(network, state, dt, look, damping)
        speeds[i] = abs(float((weights * state.velocity).sum()))
    if ratio is not None and ratio < 1:
        times, speeds = crests(times, speeds)
    else:
        late = times > times[-1] / 2
        times, speeds = times[late], speeds[late]
    # The rate is minus the slope of the logarithm.
    rate = -np.polyfit(times, np.log(np.maximum(speeds, 1e-300)), 1)[0]
    return {
        "motion": name,
        "c_over_critical": "free" if ratio is None else ratio,
        "h_c": dt * damping,
        "rate_over_c": float(rate) / damping,
        "rate_over_c_predicted": predicted / damping,
    }


def crests(times: kit.Array, speeds: kit.Array) -> tuple[kit.Array, kit.Array]:
    """Crests of a swinging speed, each by a parabola through three of its points."""
    low, top, high = speeds[:-2], speeds[1:-1], speeds[2:]
    at = np.flatnonzero((low < top) & (top >= high))
    bend, tilt = (low + high - 2 * top)[at], (high - low)[at] / 2
    step = times[1] - times[0]
    return np.asarray(times[1 + at] - step * tilt / bend), np.asarray(top[at] - tilt**2 / bend / 2)


def finding(table: pd.DataFrame) -> str:
    """Rates of decay over c."""
    strong = table.iloc[-1]
    return (
        f"Velocity dies out at {table['rate_over_c'].iloc[0]:.3g} c where nothing else acts, "
        f"at {table['rate_over_c'].iloc[1]:.3g} c in a swinging mode, and at only "
        f"{strong['rate_over_c']:.2g} c at {strong['c_over_critical']:g} times critical damping."
    )


def draw(tables: kit.Tables) -> Figure:
    """Rate over c against the damping."""
    table = tables["decay"]
    modes = table[table["c_over_critical"] != "free"]
    free = table[table["c_over_critical"] == "free"]["rate_over_c"].iloc[0]
    figure, (axis,) = kit.figures.new_figure(size=(4.0, 3.3))
    x = modes["c_over_critical"].astype(float)
    axis.loglog(x, modes["rate_over_c"], "o", color=kit.figures.COLOURS[0], label="lowest mode")
    ratios = np.geomspace(x.min(), x.max(), 100)
    told = [decay(1.0, 2 * ratio) / (2 * ratio) for ratio in ratios]
    axis.loglog(ratios, told, color="black", lw=0.9, label="closed form")
    axis.axhline(free, color=kit.figures.COLOURS[1], ls="--", label="free motion")
    axis.set(xlabel="damping c over 2ω (1)", ylabel="rate of decay of the velocity over c (1)")
    axis.set_title("How fast damping takes the velocity")
    axis.legend()
    return figure
