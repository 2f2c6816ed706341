"""Stop rule: how often does the report's rule stop a run that is not at rest?

Question   `while max(velocity) > eps` ends at the start, where nothing moves yet, and may end at
           turning points. When it ends, how far is the body still from rest?
Candidate  Algorithm 1's motion, watched at every step from the first on.
Reference  The static solution; the step of the stop by the recursion of all modes; the slowest
           mode, which at a speed v is v/ω·(ζ + √(ζ² - 1)) from rest when overdamped, and about v/ω
           when critically damped. Beside it, not judged, a rule on residual force and kinetic
           energy: |M⁻¹r| <= τω²|u| and |v| <= τω|u| in the norm of masses bound the error by τ,
           whatever the damping and whoever moves.
Expected   With eps = τ·ω·max|u| an error of τ is asked for. The printed rule gives it near critical
           damping, stops with an error near 2ζτ above it, and at turning points below.
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
from msvalidate.springs.dynamics.damping import decay
from msvalidate.springs.network import internal_force

from . import bodies
from .bodies import Body, MotionSolver

QUICK_BODIES = (("plate sheared", (8, 8), "across"), ("beam bent", (4, 1), "across"))
BODIES = (*QUICK_BODIES, ("plate pulled", (8, 8), "along"), ("beam bent", (10, 2), "across"))
QUICK_RATIOS = (0.1, 1.0, 3.0)
RATIOS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 3.0, 5.0, 10.0)
"""Damping over the critical one."""
ASKED = (1e-1, 1e-2, 1e-3)
"""Errors τ that a user asks for."""
LATE = tuple(asked for asked in ASKED if asked <= 1e-2)
"""Those at which stops are judged: by then the slowest mode alone is left."""
WRONG = 3.0
"""Error over what was asked for beyond which a stop is wrong."""
MOST_STEPS = 200_000
ROUNDED = ("stop_error", "error_over_asked", "residual_error_over_asked")
ROUNDING = 1e-6
"""Over the largest value of such a column: what another machine may give instead."""
RULES = (
    kit.Rule(
        "step of the printed rule's stop, from that of the recursion of all modes", 1.0, "steps",
        "the motion is linear to a part in a million, by which a speed may miss eps at one step "
        "and not at the next",
        table="stop_rule", value=kit.Difference("stop_step", "stop_step_modes"),
    ),
    kit.Rule(
        "error at the printed rule's stop over that asked for, critical damping, log to base 2",
        0.6, "1",
        "e/(v/ω) = 1 + 1/ωt, 1.3 at the first stop; the scheme's own critical damping is "
        "2ω(1 - hω/2), so that at 2ω the slow root makes it up to 1.5",
        table="stop_rule", rows={"c_over_critical": 1, "asked": LATE},
        value=lambda rows: np.log2(rows["error_over_asked"]),
    ),
    kit.Rule(
        "error at the printed rule's stop over the predicted, overdamped, from 1", 0.15, "1",
        "the slow root alone is left; its speed is that of the middle of a step, and points where "
        "the mode is largest need not be those where it started",
        table="stop_rule", reference=1.0,
        rows={"c_over_critical": tuple(r for r in RATIOS if r > 1), "asked": LATE},
        value=kit.Quotient("error_over_asked", "predicted"),
    ),
)  # fmt: skip
Case = tuple[tuple[str, tuple[int, int], str], float]


class Watch(NamedTuple):
    """After each step (k): largest speed, largest error, error, speed and force left, all (1).

    `speed` and `error` are maxima over points, over ω·max|u| and max|u|. The other three are in
    the norm of masses, over ωU, U and ω²U with U that of the way to rest.
    """

    speed: kit.Array
    error: kit.Array
    way: kit.Array
    moving: kit.Array
    pulling: kit.Array


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Watch both rules over dampings and errors asked for."""
    shapes = QUICK_BODIES if setting.quick else BODIES
    ratios = QUICK_RATIOS if setting.quick else RATIOS
    found = setting.sweep(partial(stop_runs, candidate), product(shapes, ratios), "stop rules")
    table = pd.DataFrame([row for rows in found for row in rows])
    return kit.Evidence(
        tables={"stop_rule": table},
        tolerances=RULES,
        figures={"stop_rule": draw},
        columns=kit.columns(__file__),
        findings=(finding(table),),
        # A displacement of 1e-6 m from a place near 1 m is known to 1e-10 of itself, and the
        # thousandth of it that is left at a stop to 1e-7.
        rounding={column: ROUNDING * float(table[column].max()) for column in ROUNDED},
    )


def stop_runs(candidate: MotionSolver, case: Case) -> list[dict[str, object]]:
    """Rows of one body and damping, one an error asked for."""
    shape, ratio = case
    body = bodies.loaded(*shape)
    mode = body.lowest_excited(min(ASKED))
    omega = float(body.frequencies[mode])
    damping = 2 * ratio * omega
    dt = body.time_step(damping)
    swiftest = omega * largest(body.rest)
    seen = watch_run(candidate, body, omega, damping, dt)
    told = stops_of_modes(body, damping, dt, [asked * swiftest for asked in ASKED])
    slow = omega / decay(omega, damping)
    rows = []
    for asked, told_stop in zip(ASKED, told, strict=True):
        stop = first(seen.speed <= asked)
        quiet = (seen.pulling <= asked) & (seen.moving <= asked)
        calm = first(quiet)
        rows.append(
            {
                "body": body.name,
                "c_over_critical": ratio,
                "asked": asked,
                "printed_steps": printed_rule(candidate, body, dt, damping, asked * swiftest),
                "stop_step": stop + 1,
                "stop_step_modes": told_stop,
                "stop_error": seen.error[stop],
                "error_over_asked": seen.error[stop] / asked,
                "predicted": slow if ratio >= 1 else "turning point",
                "wrong_stops": wrong_stops(seen, asked),
                "residual_step": calm + 1,
                "residual_error_over_asked": seen.way[calm] / asked,
            }
        )
    return rows


def watch_run(
    candidate: MotionSolver, body: Body, omega: float, damping: float, dt: float
) -> Watch:
    """Both rules' quantities after every step, until the least error asked for is out of sight."""
    network, state = body.network, body.start
    farthest = largest(body.rest)
    rows: list[Sequence[float]] = []
    while body.left(state) > min(ASKED) / WRONG and len(rows) < MOST_STEPS:
        state = candidate(network, state, dt, 1, damping)
        off = state.position - network.points - body.rest
        pull = np.where(network.fixed, 0.0, internal_force(network, state.position) + network.force)
        rows.append(
            (
                largest(state.velocity) / (omega * farthest),
                largest(off) / farthest,
                body.error(state),
                body.norm(state.velocity) / (omega * body.size),
                body.norm(pull / network.mass[:, None]) / (omega**2 * body.size),
            )
        )
    return Watch(*np.array(rows).T)


def largest(field: kit.Array) -> float:
    """Largest length of a displacement (m) or velocity (m/s), over points (n, d)."""
    return float(np.linalg.norm(field, axis=1).max())


def printed_rule(candidate: MotionSolver, body: Body, dt: float, damping: float, eps: float) -> int:
    """Steps of the report's loop to a speed of eps (m/s): its condition comes before a step."""
    state, steps = body.start, 0
    while largest(state.velocity) > eps and steps < MOST_STEPS:
        state = candidate(body.network, state, dt, 1, damping)
        steps += 1
    return steps


def stops_of_modes(body: Body, damping: float, dt: float, speeds: Sequence[float]) -> list[int]:
    """First steps after the start at which no point of the sum of all modes is above a speed (m/s).

    Speeds descend.

    Raises
    ------
    SolverError
        If one is not reached.
    """
    jump = bodies.one_step(body.frequencies, dt, damping)
    state = np.stack([-body.amplitudes(body.rest), np.zeros(len(jump))], axis=1)[:, :, None]
    stops: list[int] = []
    for step in range(1, MOST_STEPS + 1):
        state = jump @ state
        swiftest = largest((state[:, 1, 0] @ body.shapes).reshape(body.rest.shape))
        while swiftest <= speeds[len(stops)]:
            stops.append(step)
            if len(stops) == len(speeds):
                return stops
    raise kit.SolverError(f"{body.name}: no stop of all modes in {MOST_STEPS} steps")


def first(holds: kit.Mask) -> int:
    """Index of the first step at which a rule holds.

    Raises
    ------
    SolverError
        If it never does.
    """
    if not holds.any():
        raise kit.SolverError(f"a stop rule does not hold in {len(holds)} steps")
    return int(holds.argmax())


def wrong_stops(seen: Watch, asked: float) -> int:
    """Separate times at which the printed rule holds although the error is, or will be, wrong."""
    worst_to_come = np.maximum.accumulate(seen.error[::-1])[::-1]
    wrong = (seen.speed <= asked) & (worst_to_come > WRONG * asked)
    return int(wrong[0]) + int((wrong[1:] & ~wrong[:-1]).sum())


def finding(table: pd.DataFrame) -> str:
    """How wrong the printed rule is, and the other one."""
    bad = table["error_over_asked"] > WRONG
    at_once = int((bad & (table["stop_step"] == 1)).sum())
    swinging = table[table["c_over_critical"] < 1]
    overdamped = table[table["c_over_critical"] > 1]
    wrong = int((table["residual_error_over_asked"] > 1).sum())
    return (
        f"Started from rest the printed loop takes {table['printed_steps'].max()} steps. Checked "
        f"after a step first, it stops with more than {WRONG:g} times the error asked for in "
        f"{bad.sum()} of {len(table)} runs"
        + (f", {at_once} of them after that step" if at_once else "")
        + f": up to {swinging['error_over_asked'].max():.2g} times in {len(swinging)} underdamped "
        f"runs, {overdamped['error_over_asked'].max():.2g} times in {len(overdamped)} overdamped "
        f"ones. The "
        f"rule on residual force and kinetic energy stops {wrong or 'no'} "
        f"run{'' if wrong == 1 else 's'} with more than the error asked for, at most "
        f"{table['residual_error_over_asked'].max():.4g} times it."
    )


def draw(tables: kit.Tables) -> Figure:
    """Error at the stop over that asked for, by both rules."""
    table = tables["stop_rule"]
    shown = table[table["asked"].isin((ASKED[0], ASKED[-1]))]
    figure, axes = kit.figures.new_figure(2, size=(3.6, 4.7), sharey=True)
    titles = {
        "error_over_asked": "stopped by the largest velocity",
        "residual_error_over_asked": "stopped by force and kinetic energy",
    }
    for axis, (column, title) in zip(axes, titles.items(), strict=True):
        groups = shown.groupby(["body", "asked"], sort=False)
        for place, ((name, asked), own) in enumerate(groups):
            style = kit.figures.series_style(place // 2) | {"ls": ":", "lw": 0.8}
            fill = "none" if place % 2 else style["color"]
            label = f"{name}, τ = {asked:g}"
            axis.loglog(own["c_over_critical"], own[column], mfc=fill, label=label, **style)
        axis.axhline(1.0, color="grey", lw=0.8, ls="--", label="error asked for, τ")
        axis.set(title=title, xlabel="damping c over 2ω of the\nslowest excited mode (1)")
    ratios = np.geomspace(1, table["c_over_critical"].max(), 50)
    slow = ratios + np.sqrt(ratios**2 - 1)
    axes[0].plot(ratios, slow, color="black", lw=0.9, label="slow root alone")
    axes[0].set_ylabel("error at the stop over τ (1)")
    figure.suptitle("Error where a rule stops, over the error asked for")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
