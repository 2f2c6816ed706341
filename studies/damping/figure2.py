"""Figure 2: the report's curves of one particle, under-, over- and critically damped.

Question   Does the report's 6 x 6 block overshoot as its slowest mode alone would, and do the
           overshoots come when that mode's come?
Candidate  Algorithm 1's motion of the block under a load that comes suddenly, one step for all
           dampings, as in the report.
Reference  The slowest mode in closed form: overshoots exp(-(2k - 1)πζ/√(1 - ζ²)) at
           (2k - 1)π/ω_d with ω_d = ω√(1 - ζ²), none from ζ = 1; and the scheme's own recursion.
Expected   The curve projected on that mode differs from the closed form by O(h), and not at all
           from the recursion. Overshoots to one side come at 1 : 3; the report reads 20 : 55.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.damping import approach

from . import bodies
from .bodies import Body, MotionSolver

RATIOS = (0.2, 0.5, 1.0, 2.0, 5.0)
"""Damping over the critical one, c = 2ω of the slowest mode."""
CELLS = (5, 5)
CONSTANTS = (1.0, 2.0)
"""The report's "incompressible" springs, k2 = 2 k1."""
PART = 0.8
"""Of the limit at the strongest damping: the time step of all curves."""
REFINED = (1, 2, 4)
"""Divisors of the time step."""
PERIODS = 2.0
"""Periods of the undamped slowest mode that are watched."""
SEEN = 0.02
"""Overshoot, over the way to rest, that counts as one."""
REPORTED = (20, 55)
"""Time steps at which the report sees overshoots."""
RECURSION = 1e-8
"""Difference to the recursion that is rounding: an eps of positions over displacements of 1e-6."""
RULES = (
    kit.Rule(
        "slowest mode against the oscillator, over h·ω", 1.0, "1",
        "the kick comes half a step from where a midpoint rule has it, which moves the curve by "
        "h/2 times its largest speed ω, and the damping by h·c/2; twice that bounds it",
        table="scheme",
        value=lambda rows: _coarsest(rows)["from_oscillator"] / _coarsest(rows)["dt_omega"],
    ),
    kit.Rule(
        "slowest mode against the scheme's recursion", RECURSION, "1",
        "rounding is an eps of positions over displacements of 1e-6, gathered over two periods; "
        "geometry changes the frequency of a shearing by the square of 1e-6",
        table="scheme", value="from_recursion",
    ),
)  # fmt: skip


def _coarsest(rows: pd.DataFrame) -> pd.DataFrame:
    found: pd.DataFrame = rows[rows["dt_s"] == rows["dt_s"].max()]
    return found


def judge_curves(scheme: pd.DataFrame, swings: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What compares curves with one another: orders, and overshoots."""
    orders = (
        [kit.observed_order(own["dt_s"], own[column]) for own in by_ratio(scheme)]
        for column in ("from_oscillator", "recursion_from_oscillator")
    )
    mode, predicted = (swings[swings["curve"] == name] for name in ("mode", "predicted"))
    return (
        kit.Tolerance(
            "order in the step of that difference, from that of the recursion", 2e-5, "1",
            "Euler-Cromer's first order and what the next terms make of it: the recursion has all "
            "of them, and is met to 1e-8, which is 6e-6 of the smallest difference; over a factor "
            "of four in the step the two ends move a slope by 0.7 of that each",
            observed=kit.farthest_value(*orders),
        ),
        kit.Tolerance(
            "number of overshoots of the slowest mode from the predicted", 0.0, "1",
            "a count; no predicted overshoot is near the size that counts",
            observed=kit.farthest_value(mode["overshoots"], predicted["overshoots"]),
        ),
        kit.Tolerance(
            "time of its first two overshoots from the predicted", 2.0, "steps",
            "the scheme is half a step ahead, and its old velocity raises the frequency by the "
            "part h·c/4 = 0.7 %, a step in 150; half a step is left for the parabola that finds a "
            "peak",
            observed=kit.farthest_value(*times(mode, predicted)),
        ),
    )  # fmt: skip


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Curves, overshoots, and how the differences fall with the step."""
    body = block()
    dt = shared_step(body)
    cases = list(product(RATIOS, REFINED))
    found = setting.sweep(partial(curve, candidate, body, dt), cases, "x-t curves")
    curves = pd.concat([table for table, _ in found if table is not None], ignore_index=True)
    scheme = pd.DataFrame([row for _, row in found])
    swings = pd.DataFrame([row for ratio in RATIOS for row in overshoots(curves, ratio)])
    return kit.Evidence(
        tables={"figure2": curves, "overshoots": swings, "scheme": scheme},
        tolerances=(*RULES, *judge_curves(scheme, swings)),
        figures={"figure2": draw},
        columns=kit.columns(__file__),
        findings=(finding(swings),),
    )


def block() -> Body:
    """The report's 6 x 6 particles, sheared: all springs and masses alike."""
    return bodies.loaded("report's block", CELLS, "across", constants=CONSTANTS, equal=True)


def shared_step(body: Body) -> float:
    """One time step (s) that is stable at every damping."""
    return body.time_step(2 * max(RATIOS) * float(body.frequencies[0]), PART)


def curve(
    candidate: MotionSolver, body: Body, dt: float, case: tuple[float, int]
) -> tuple[pd.DataFrame | None, dict[str, float]]:
    """The curve at one damping in steps of dt over a divisor, and its differences.

    The curve itself only for the undivided step.
    """
    ratio, divisor = case
    omega = float(body.frequencies[0])
    damping, h = 2 * ratio * omega, dt / divisor
    looks = int(PERIODS * 2 * np.pi / omega / dt)
    corner, mode = watch_curve(candidate, body, damping, h, looks, divisor)
    predicted = 1 - approach(omega, damping, dt * np.arange(looks + 1))
    again = recursion(omega, damping, h, looks, divisor)
    row = {
        "c_over_critical": ratio,
        "dt_s": h,
        "dt_omega": h * omega,
        "steps": looks * divisor,
        "from_oscillator": float(np.abs(mode - predicted).max()),
        "recursion_from_oscillator": float(np.abs(again - predicted).max()),
        "from_recursion": float(np.abs(mode - again).max()),
    }
    if divisor > 1:
        return None, row
    return pd.DataFrame(
        {
            "c_over_critical": ratio,
            "step": np.arange(looks + 1),
            "time_s": dt * np.arange(looks + 1),
            "x_particle": corner,
            "x_mode": mode,
            "x_predicted": predicted,
        }
    ), row


def watch_curve(
    candidate: MotionSolver, body: Body, damping: float, dt: float, looks: int, every: int
) -> tuple[kit.Array, kit.Array]:
    """Displacement of the loaded corner and amplitude of the slowest mode, every few steps.

    Both (looks + 1,), over their values at rest.
    """
    direction = int(np.abs(body.network.force).sum(axis=0).argmax())
    state, whole = body.start, body.amplitudes(body.rest)[0]
    corner, mode = [0.0], [0.0]
    for _ in range(looks):
        state = candidate(body.network, state, dt, every, damping)
        move = state.position - body.network.points
        corner.append(move[-1, direction] / body.rest[-1, direction])
        mode.append(body.amplitudes(move)[0] / whole)
    return np.array(corner), np.array(mode)


def recursion(omega: float, damping: float, dt: float, looks: int, every: int) -> kit.Array:
    """Way (looks + 1,) of the mode from 0 to rest at 1, by the scheme's recursion."""
    jump = np.linalg.matrix_power(bodies.one_step(np.array([omega]), dt, damping)[0], every)
    left = [np.array([1.0, 0.0])]
    for _ in range(looks):
        left.append(jump @ left[-1])
    return 1 - np.array(left)[:, 0]


def overshoots(curves: pd.DataFrame, ratio: float) -> list[dict[str, object]]:
    """Overshoots of the particle, of the mode, and of the mode as predicted, at one damping."""
    own = curves[curves["c_over_critical"] == ratio]
    rows = []
    for name in ("particle", "mode"):
        rows.append(
            {"c_over_critical": ratio, "curve": name} | describe_curves(peaks(own[f"x_{name}"]))
        )
    dt, longest = float(own["time_s"].iloc[1]), len(own) - 1
    return [
        *rows,
        {"c_over_critical": ratio, "curve": "predicted"}
        | describe_curves(theory(ratio, dt, longest)),
    ]


def theory(ratio: float, dt: float, steps: int) -> list[tuple[float, float]]:
    """Step and height of the overshoots that the closed form has, within so many steps."""
    if ratio >= 1:
        return []
    root = np.sqrt(1 - ratio**2)
    beat = np.pi / (block().frequencies[0] * root) / dt
    turns = [(k * beat, float(np.exp(-k * np.pi * ratio / root))) for k in range(1, 100, 2)]
    return [(step, height) for step, height in turns if height >= SEEN and step < steps]


def peaks(way: pd.Series) -> list[tuple[float, float]]:
    """Step and height above 1 of the peaks of a curve, by a parabola through three points."""
    x = way.to_numpy()
    low, top, high = x[:-2], x[1:-1], x[2:]
    at = np.flatnonzero((low < top) & (top >= high) & (top >= 1 + SEEN))
    bend, tilt = low + high - 2 * top, (high - low) / 2
    return [
        (float(1 + i - tilt[i] / bend[i]), float(top[i] - tilt[i] ** 2 / bend[i] / 2 - 1))
        for i in at
    ]


def describe_curves(swings: list[tuple[float, float]]) -> dict[str, object]:
    """Columns of a row that tell of overshoots."""
    steps: list[float] = [step for step, _ in swings]
    return {
        "overshoots": len(swings),
        "first_overshoot": swings[0][1] if swings else "none",
        "first_step": steps[0] if swings else "none",
        "second_step": steps[1] if len(swings) > 1 else "none",
        "second_over_first": steps[1] / steps[0] if len(swings) > 1 else "none",
    }


def by_ratio(table: pd.DataFrame) -> list[pd.DataFrame]:
    """Parts of a table, one a damping."""
    return [own for _, own in table.groupby("c_over_critical")]


def times(*swings: pd.DataFrame) -> list[kit.Array]:
    """Steps (k,) of first and second overshoots that any of two tables has; NaN where one lacks."""
    columns = ["first_step", "second_step"]
    found = [own[columns].apply(pd.to_numeric, errors="coerce").to_numpy() for own in swings]
    some = ~np.logical_and(*map(np.isnan, found))
    return [own[some] for own in found]


def finding(swings: pd.DataFrame) -> str:
    """When the overshoots come, beside the report's."""
    lively = swings[swings["c_over_critical"] == min(RATIOS)].set_index("curve")
    first, second = REPORTED
    return (
        f"At {min(RATIOS):g} of critical damping the block's corner overshoots "
        f"{lively['overshoots']['particle']} times, its slowest mode "
        f"{lively['overshoots']['mode']} times; the second overshoot comes at "
        f"{draw_figure(lively['second_over_first']['particle'])} times the first's time, predicted "
        f"{draw_figure(lively['second_over_first']['predicted'])}; the report reads "
        f"{second / first:.3g}."
    )


def draw_figure(value: object) -> str:
    """A number in three figures, or the word that stands for it."""
    return value if isinstance(value, str) else f"{value:.3g}"


def draw(tables: kit.Tables) -> Figure:
    """x-t curves of the loaded corner and of the slowest mode."""
    figure, axes = kit.figures.new_figure(2, size=(3.6, 3.3), sharey=True)
    titles = {"x_particle": "upper loaded corner", "x_mode": "slowest mode, and predicted"}
    for axis, (column, title) in zip(axes, titles.items(), strict=True):
        for colour, own in zip(kit.figures.COLOURS, by_ratio(tables["figure2"]), strict=False):
            label = f"c = {own['c_over_critical'].iloc[0]:g} of critical"
            axis.plot(own["step"], own[column], color=colour, label=label)
            if column == "x_mode":
                every = own.iloc[:: max(1, len(own) // 25)]
                axis.plot(every["step"], every["x_predicted"], "o", color=colour, ms=2.5)
        axis.axhline(1.0, color="grey", lw=0.8, ls="--", label="at rest")
        axis.set(title=title, xlabel="time step (1)")
    axes[1].plot([], [], "o", color="black", ms=2.5, label="closed form")
    axes[0].set_ylabel("displacement over that at rest (1)")
    figure.suptitle("A plate that comes to rest, after the report's Figure 2")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
