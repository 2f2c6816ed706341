"""Rest: how many steps to rest, against the damping; where is the optimum?

Question   Is critical damping of the slowest mode the best viscosity, and what does another cost?
Candidate  Algorithm 1's motion, in steps of 0.9 of Euler-Cromer's limit, which falls with the
           damping: the price counts both.
Reference  The slowest mode that the load excites, alone, by the closed form of the damped
           oscillator; and all modes, each by the recursion of the scheme.
Expected   The slowest mode alone gives the steps but for what the others add; all modes give them
           exactly. The optimum is a little below c = 2ω of the slowest mode that is excited, which
           under a symmetric load is not the lowest of the body: an overshoot smaller than the error
           is free.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.damping import approach, decay

from . import bodies
from .bodies import Body, MotionSolver

ERRORS = (1e-3, 1e-6)
"""Displacement errors that count as rest."""
VISIBLE = 1e-6
"""Share of a mode below which no error of `ERRORS` shows it."""
QUICK_BODIES = (
    ("plate sheared", (8, 8), "across"),
    ("plate pulled", (8, 8), "along"),
    ("beam bent", (20, 2), "across"),
)
BODIES = (
    *QUICK_BODIES,
    ("plate sheared", (16, 16), "across"),
    ("plate pulled", (16, 16), "along"),
    ("beam pulled", (20, 2), "along"),
)
RANGE = (0.05, 20.0)
"""Damping over the critical one."""
QUICK_POINTS, POINTS = 5, 17
AROUND = (0.5, 2.0)
"""Dampings over the critical one between which the optimum is sought."""
QUICK_NEAR, NEAR = 5, 13
LOOKS = 50
"""Looks in the predicted number of steps: rest is placed within a part in so many."""
PATIENCE = 20
"""Multiple of the predicted number of steps after which a run is given up."""
RULES = (
    kit.Rule(
        "steps to rest over those of all modes, from 1", 0.02, "1",
        "both are counted in looks, at least 50 in a run, and may end one look apart: the motion "
        "is linear to a part in a million only",
        table="rest", value=kit.Quotient("steps", "steps_modes"), reference=1.0,
    ),
    kit.Rule(
        "steps to rest over those of the slowest mode alone, logarithm to base 2", 0.6, "1",
        "the other modes may move the end by a swing, π/ω_d, which is 0.45 of the time to 1e-3 at "
        "ζ = 0.7; the scheme's own critical damping is 2ω(1 - hω/2), so that at 2ω with hω = 0.16 "
        "the slow root is a third slower",
        table="rest", value=lambda rows: np.log2(rows["steps"] / rows["steps_slowest"]),
    ),
    kit.Rule(
        "best damping from 2ω, logarithm to base 2", 0.7, "1",
        "an overshoot exp(-πζ/√(1 - ζ²)) as small as the error is free: ζ = 0.91 for 1e-3; the "
        "scheme's own critical damping is up to 8 % lower; the grid adds a spacing, up to 41 %",
        table="optimum", value=lambda rows: np.log2(rows["best"]),
    ),
    kit.Rule(
        "best damping from the best of the slowest mode alone, in spacings of the grid",
        1.0 + 1e-9, "1",
        "both are points of one grid; looks and the other modes may let a neighbour win, in steps "
        "that are nearly as few, but none farther away: one spacing, to rounding",
        table="optimum",
        value=lambda rows: np.log(rows["best"] / rows["best_slowest"]) / np.log(rows["spacing"]),
    ),
)  # fmt: skip
Case = tuple[tuple[str, tuple[int, int], str], Sequence[float]]


class Run(NamedTuple):
    """One damping of one body: time step (s), and steps to each error by run and predictions."""

    dt: float
    measured: dict[float, int]
    slowest: dict[float, int]
    modes: dict[float, int]


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Steps to rest over the range of dampings."""
    cases = QUICK_BODIES if setting.quick else BODIES
    points = QUICK_POINTS if setting.quick else POINTS
    near = np.geomspace(*AROUND, QUICK_NEAR if setting.quick else NEAR)
    ratios = sorted({*np.geomspace(*RANGE, points).tolist(), *near.tolist()})
    found = setting.sweep(
        partial(sweep_damping, candidate), product(cases, [ratios]), "steps to rest"
    )
    table = pd.DataFrame([row for rows, _ in found for row in rows])
    spacing = float(near[1] / near[0])
    best = pd.DataFrame([row for _, body in found for row in optima(table, body, spacing)])
    return kit.Evidence(
        tables={"rest": table, "optimum": best},
        tolerances=RULES,
        figures={"rest": draw},
        columns=kit.columns(__file__),
        findings=(finding(best),),
    )


def sweep_damping(
    candidate: MotionSolver, case: Case
) -> tuple[list[dict[str, object]], dict[str, object]]:
    """Rows of one body, one a damping and error; and the row that tells of the body."""
    body = bodies.loaded(*case[0])
    mode = body.lowest_excited(VISIBLE)
    omega = float(body.frequencies[mode])
    rows: list[dict[str, object]] = []
    for ratio in case[1]:
        one = relax_block(candidate, body, ratio, ERRORS)
        for error in ERRORS:
            rows.append(
                {
                    "body": body.name,
                    "c_over_critical": ratio,
                    "error": error,
                    "dt_s": one.dt,
                    "steps": one.measured[error],
                    "steps_slowest": one.slowest[error],
                    "steps_modes": one.modes[error],
                    "time_s": one.measured[error] * one.dt,
                }
            )
    return rows, {
        "body": body.name,
        "mode": mode + 1,
        "omega_rad_s": omega,
        "omega_min_rad_s": float(body.frequencies[0]),
        "omega_max_rad_s": float(body.frequencies[-1]),
        "share": float(body.shares[mode]),
    }


def relax_block(candidate: MotionSolver, body: Body, ratio: float, errors: Sequence[float]) -> Run:
    """Steps to rest at a damping over 2ω of the slowest mode that the load excites."""
    omega = float(body.frequencies[body.lowest_excited(VISIBLE)])
    damping = 2 * ratio * omega
    dt = body.time_step(damping)
    slowest = {error: steps_of_slowest(body, damping, dt, error) for error in errors}
    look = max(1, min(slowest.values()) // LOOKS)
    return Run(
        dt,
        count_steps(candidate, body, damping, dt, look, errors),
        slowest,
        steps_of_modes(body, damping, dt, look, errors),
    )


def count_steps(
    candidate: MotionSolver,
    body: Body,
    damping: float,
    dt: float,
    look: int,
    errors: Sequence[float],
) -> dict[float, int]:
    """Steps after which a run stays within each error, to a look.

    Raises
    ------
    SolverError
        If it does not come to rest.
    """
    state, done = body.start, 0
    last = dict.fromkeys(errors, 0)
    most = PATIENCE * steps_of_slowest(body, damping, dt, min(errors)) + PATIENCE * LOOKS
    while body.left(state) > min(errors):
        if done > most:
            raise kit.SolverError(f"{body.name}: damping {damping:g} 1/s: no rest in {done} steps")
        state = candidate(body.network, state, dt, look, damping)
        done += look
        now = body.error(state)
        last |= {error: done for error in errors if now > error}
    return {error: step + look for error, step in last.items()}


def steps_of_slowest(body: Body, damping: float, dt: float, error: float) -> int:
    """Steps after which the slowest mode that the load excites stays within an error, alone."""
    mode = body.lowest_excited(VISIBLE)
    omega, share = float(body.frequencies[mode]), float(body.shares[mode])
    # Five e-foldings more than asked for: what a double root or a phase adds to the envelope.
    longest = (5 - np.log(error)) / decay(omega, damping)
    way = share * np.abs(approach(omega, damping, dt * np.arange(int(longest / dt) + 2)))
    return int(np.flatnonzero(way > error)[-1]) + 1


def steps_of_modes(
    body: Body, damping: float, dt: float, look: int, errors: Sequence[float]
) -> dict[float, int]:
    """Steps after which the sum of all modes stays within each error, to a look."""
    omegas = body.frequencies
    jump = np.linalg.matrix_power(bodies.one_step(omegas, dt, damping), look)
    state = np.stack([body.shares, np.zeros(len(omegas))], axis=1)[:, :, None]
    last, done = dict.fromkeys(errors, 0), 0
    while True:
        x, v = state[:, 0, 0], state[:, 1, 0]
        now = float(np.linalg.norm(x))
        last |= {error: done for error in errors if now > error}
        if np.hypot(now, np.linalg.norm(v) / omegas[0]) <= min(errors):
            return {error: step + look for error, step in last.items()}
        state = jump @ state
        done += look


def optima(table: pd.DataFrame, body: dict[str, object], spacing: float) -> list[dict[str, object]]:
    """The best damping of one body, one row an error."""
    rows = []
    for error in ERRORS:
        own = table[(table["body"] == body["body"]) & (table["error"] == error)]
        measured, predicted = (
            own.sort_values(column, kind="stable").iloc[0] for column in ("steps", "steps_slowest")
        )
        critical = own[np.isclose(own["c_over_critical"], 1)].iloc[0]
        rows.append(
            body
            | {
                "error": error,
                "best": measured["c_over_critical"],
                "best_slowest": predicted["c_over_critical"],
                "fewest_steps": measured["steps"],
                "steps_at_critical": critical["steps"],
                "spacing": spacing,
            }
        )
    return rows


def finding(best: pd.DataFrame) -> str:
    """Where the optimum is, and what the lowest mode of the body would have said."""
    hidden = best[best["mode"] > 1]
    away = (hidden["omega_rad_s"] / hidden["omega_min_rad_s"]).max()
    extra = (best["steps_at_critical"] / best["fewest_steps"]).max()
    errors = " and ".join(f"{error:g}" for error in ERRORS)
    return (
        f"On {best['body'].nunique()} bodies, to errors of {errors}, the fewest steps are taken at "
        f"{best['best'].min():.2g} to {best['best'].max():.2g} of critical damping, c = 2ω of the "
        f"slowest mode that the load excites; at 2ω itself up to {extra:.2g} times as many. Under "
        f"{hidden['body'].nunique()} symmetric loads that mode is up to {away:.2g} times the "
        "lowest of the body, and so is the best damping."
    )


def draw(tables: kit.Tables) -> Figure:
    """Steps to rest against the damping, by the run and by the slowest mode alone."""
    rest = tables["rest"]
    figure, axes = kit.figures.new_figure(len(ERRORS), size=(3.6, 4.3), sharey=True)
    for axis, error in zip(axes, ERRORS, strict=True):
        shown = rest[rest["error"] == error].groupby("body", sort=False)
        for place, (name, own) in enumerate(shown):
            style, c = kit.figures.series_style(place), own["c_over_critical"]
            axis.loglog(c, own["steps"], ls="", label=str(name), **style)
            axis.loglog(c, own["steps_slowest"], color=style["color"], lw=0.9)
        axis.plot([], [], color="black", lw=0.9, label="slowest excited mode alone")
        axis.axvline(1.0, color="grey", lw=0.8, ls="--", label="critical damping")
        axis.set_title(f"to a displacement error of {error:g}")
        axis.set_xlabel("damping c over 2ω of the\nslowest excited mode (1)")
    axes[0].set_ylabel("time steps to rest (1)")
    figure.suptitle("Time steps to rest against the damping")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
