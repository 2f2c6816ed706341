"""Cost: which accuracy for how many force evaluations?

Question   How many evaluations of the force does each scheme need for an error of 1e-3, and 1e-6?
Candidate  Each scheme's own step on an undamped oscillator; every one takes one evaluation a step.
Reference  The exact motion after 20 rad, and the leading term of each scheme's error there.
Expected   Errors that tend to the leading term, a coefficient times a power of h·ω: explicit
           Euler's amplitude grows by (h·ω)²/2 a step; Euler-Cromer runs half a step ahead and
           stays so; Verlet and leapfrog, whose positions are the same, go by (h·ω)²/24 too fast.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.dynamics.integrators import INTEGRATORS, Integrator
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Tables, Tolerance
from msvalidate.judging.sweep import Setting
from msvalidate.output import figures

from . import common, oscillator
from .common import Schemes

ANGLE = 20.0
"""ω times the time of the motion (rad), three periods."""
EVALUATIONS = tuple(100 * 2**k for k in range(10))
QUICK_EVALUATIONS = (200, 800, 3200, 12800)
WANTED = (1e-3, 1e-6)
MOST = 1e15
"""Evaluations that nobody makes: rounding would hide such steps."""
LEADING = {
    "explicit_euler": (1, 0.5 * ANGLE * abs(math.cos(ANGLE))),
    "euler_cromer": (1, 0.5 * abs(math.sin(ANGLE))),
    "leapfrog": (2, ANGLE / 24 * abs(math.sin(ANGLE))),
    "velocity_verlet": (2, ANGLE / 24 * abs(math.sin(ANGLE))),
}
"""Scheme -> power of h·ω and coefficient of the error's leading term at `ANGLE`, from rest at 1."""
JUDGED = 12800
"""Evaluations at which errors are held to their leading terms: in both forms."""
STEP = ANGLE / JUDGED
TURN = abs(math.tan(ANGLE))
NEXT = {
    "explicit_euler": (
        STEP * ANGLE / 4 + 2 / 3 * STEP * TURN,
        (
            "the amplitude's growth compounds, by h·ω·20/4 of the first term, and the phase lags "
            "by (h·ω)²/3, which adds 2/3·h·ω·tan 20"
        ),
    ),
    "euler_cromer": (
        STEP * ANGLE / 12 + STEP / 4 / TURN,
        (
            "its frequency is Verlet's, (h·ω)²/24 too high: 20/12·h·ω of the first term; and half "
            "a step ahead, squared over 2, turned by 90°"
        ),
    ),
} | dict.fromkeys(
    ("leapfrog", "velocity_verlet"),
    (
        STEP**2 * (9 / 80 + ANGLE / 48 / TURN),
        (
            "the frequency, 2/h·asin(h·ω/2), has the next term 3/640·(h·ω)⁴, 9/80·(h·ω)² of the "
            "first; the phase's own square adds 20/48·(h·ω)²·cot 20"
        ),
    ),
)
"""Scheme -> next term of its error over the leading one at `JUDGED`, as a bound, and why."""
LEADS = {name: 2 * size for name, (size, _) in NEXT.items()}
TOLERANCES = tuple(
    Tolerance(
        f"error of 12,800 evaluations over its leading term: {common.title(name)}",
        LEADS[name],
        "1",
        f"the next term: {NEXT[name][1]}; twice it, for the terms beyond",
    )
    for name in common.REPORTED
)
COLUMNS = {
    **common.COLUMNS,
    "evaluations": "evaluations of the force, one a step, for a motion of 20 rad",
    "error": "distance to the exact motion at the end over the amplitude (1)",
    "leading": "leading term of that error in closed form (1)",
    "wanted": "error that is wanted (1)",
    "evaluations_needed": "evaluations for that error: between two runs, or beyond the last one, "
    'along the line through two errors in logarithms; "never" where the error does not fall',
    "beyond": "yes or no: whether the runs end before that error",
}


def run(candidate: Schemes = INTEGRATORS, setting: Setting | None = None) -> Evidence:
    """Errors against evaluations, and evaluations for the errors that are wanted."""
    setting = setting or Setting()
    numbers = QUICK_EVALUATIONS if setting.quick else EVALUATIONS
    schemes = common.chosen(candidate)
    cases = list(product(schemes.items(), numbers))
    table = pd.DataFrame(setting.sweep(measure, cases, "cost"))
    needed = pd.DataFrame(
        [evaluations_needed(table, name, w) for name, w in product(schemes, WANTED)]
    )
    finest = table[table["evaluations"] == JUDGED].set_index("scheme")
    ratio = finest["error"] / finest["leading"]
    return Evidence(
        tables={"cost": table, "cost_needed": needed},
        observed={
            t.quantity: farthest_value(ratio[name], 1.0)
            for t, name in zip(TOLERANCES, common.REPORTED, strict=True)
        },
        tolerances=TOLERANCES,
        figures={"cost": draw},
        columns=COLUMNS,
        findings=tuple(map(partial(finding, needed), WANTED)),
        rounding={"error": 1e-12},
    )


def measure(case: tuple[tuple[str, Integrator], int]) -> dict[str, object]:
    """Row of one scheme at one number of evaluations."""
    (name, scheme), steps = case
    power, coefficient = LEADING[name]
    return {
        "scheme": name,
        "evaluations": steps,
        "h_omega": ANGLE / steps,
        "error": abs(oscillator.swing(scheme, steps, ANGLE) - math.cos(ANGLE)),
        "leading": coefficient * (ANGLE / steps) ** power,
    }


def evaluations_needed(table: pd.DataFrame, name: str, wanted: float) -> dict[str, object]:
    """Row of a scheme and an error that is wanted."""
    rows = table[table["scheme"] == name]
    error = np.log(rows["error"].to_numpy())
    steps = np.log(rows["evaluations"].to_numpy())
    below = np.flatnonzero(rows["error"] <= wanted)
    at = max(1, int(below[0])) if len(below) else len(rows) - 1
    slope = (steps[at] - steps[at - 1]) / (error[at] - error[at - 1])
    count = steps[at] + slope * (np.log(wanted) - error[at])
    never = slope > 0 or count > np.log(MOST)
    return {
        "scheme": name,
        "wanted": wanted,
        "evaluations_needed": "never" if never else float(np.exp(count)),
        "beyond": "no" if len(below) else "yes",
    }


def finding(needed: pd.DataFrame, wanted: float) -> str:
    """Who needs the fewest evaluations."""
    rows = needed[needed["wanted"] == wanted]
    # Rounded before they are sorted: schemes with the same positions keep their order.
    evaluations = rows.set_index("scheme")["evaluations_needed"]
    evaluations = evaluations[evaluations != "never"].astype(float)
    counts = {str(name): float(f"{count:.2g}") for name, count in evaluations.items()}
    beyond = dict(zip(rows["scheme"], rows["beyond"], strict=True))
    said = ", ".join(
        f"{common.title(name)} {'about ' if beyond[name] == 'yes' else ''}{counts[name]:,.0f}"
        for name in sorted(counts, key=counts.__getitem__)
    )
    return f"Force evaluations for an error of {wanted:.0e} after 20 rad: {said}."


def draw(tables: Tables) -> Figure:
    """Error against evaluations, with the leading terms."""
    figure, (axis,) = figures.new_figure(size=(4.8, 3.8))
    for name, rows in tables["cost"].groupby("scheme", sort=False):
        scheme = str(name)
        axis.loglog(
            rows["evaluations"],
            rows["error"],
            ls="",
            marker=common.marker(scheme),
            color=common.colour(scheme),
            mfc="none",
            ms=7 if scheme == "leapfrog" else 4.5,
            label=common.title(scheme),
        )
        axis.loglog(rows["evaluations"], rows["leading"], lw=0.9, color=common.colour(scheme))
    axis.plot([], [], color="black", lw=0.9, label="leading term of each")
    for wanted in WANTED:
        axis.axhline(wanted, color="grey", lw=0.8, ls=":", label="wanted")
    axis.set(xlabel="force evaluations for 20 rad", ylabel="error over amplitude (1)")
    axis.set_ylim(1e-8, 10)
    axis.set_xticks([100, 1000, 10000, 100000], ["100", "1000", "10000", "100000"])
    figures.add_shared_legend(figure, [axis], columns=3)
    return figure
