"""Cost: which accuracy for how many force evaluations?

Question   How many evaluations of the force per period keep a motion within 1e-3 and 1e-6?
Candidate  The step of each scheme on an undamped oscillator; average acceleration takes one
           evaluation per step as well, because the force is linear.
Reference  The exact motion, and the motion of each scheme in closed form. The error is the largest
           distance of the state (position and velocity/ω together, at one time) from the exact
           state over ten periods, relative to the amplitude. A position at one instant is no
           measure: an error of phase vanishes at a turning point, an error of amplitude at a zero.
Expected   In ten periods, θ = 20π, explicit Euler grows by θ·h·ω/2; Euler-Cromer is an ellipse, off
           by h·ω/2 throughout; Verlet and leapfrog lead by θ·(h·ω)²/24, average acceleration lags
           by θ·(h·ω)²/12 and Runge-Kutta is off by θ·(h·ω)⁴/120. Growing errors are proportional to
           the time, so that a quarter of a period more changes a number by at most 1/40.
"""

from __future__ import annotations

import math
from functools import partial
from itertools import islice, product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.optimize import brentq

from msvalidate import kit
from msvalidate.springs.dynamics.integrators import INTEGRATORS
from msvalidate.springs.dynamics.scheme import Integrator, UndampedMotion

from . import common, oscillator
from .common import Schemes

PERIODS = 10
ANGLE = 2 * math.pi * PERIODS
"""Frequency times the duration of the motion (rad)."""
INSTANTS = 256 * PERIODS
"""Instants at which the closed form is compared; they miss its maximum by 1e-4 of it."""
EVALUATIONS = tuple(50 * 2**k for k in range(8))
QUICK_EVALUATIONS = EVALUATIONS[::2][:3]
WANTED = (1e-3, 1e-6)
FINEST, COARSEST = 1e-10, 0.5
"""Steps h·ω between which the one for an error is sought."""
SCHEMES = tuple(name for name in common.TRUE if INTEGRATORS[name].undamped_motion is not None)
"""Schemes whose motion has a closed form."""
ROUNDING = 1.5e-11
RULES = (
    kit.Rule(
        "states of an undamped oscillator: distance from each scheme's closed form", ROUNDING, "1",
        "rounding: at most 64,000 steps of 2.2e-16, all on one side",
        table="cost", value="off_closed_form",
    ),
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Errors against evaluations, and evaluations for the errors that are wanted."""
    numbers = QUICK_EVALUATIONS if setting.quick else EVALUATIONS
    schemes = common.chosen(candidate, SCHEMES)
    cases = list(product(schemes.items(), numbers))
    table = pd.DataFrame(setting.sweep(measure, cases, "cost"))
    needed = pd.DataFrame(
        [
            {"scheme": name, "wanted": wanted, "evaluations_needed": needed_for(scheme, wanted)}
            for (name, scheme), wanted in product(schemes.items(), WANTED)
        ]
    )
    return kit.Evidence(
        tables={"cost": table, "cost_needed": needed},
        tolerances=RULES,
        figures={"cost": draw},
        columns=kit.columns(__file__),
        findings=tuple(map(partial(finding, needed), WANTED)),
    )


def measure(case: tuple[tuple[str, Integrator], int]) -> dict[str, object]:
    """Row of one scheme at one number of evaluations per period."""
    (name, scheme), evaluations = case
    error, distance = errors(scheme, evaluations)
    h = step_size(scheme, evaluations)
    return {
        "scheme": name,
        "evaluations": evaluations,
        "h_omega": h,
        "error": error,
        "off_closed_form": distance,
    }


def step_size(scheme: Integrator, evaluations: float) -> float:
    """Step h·ω (rad) of so many evaluations per period."""
    return 2 * math.pi * scheme.evaluations / evaluations


def errors(scheme: Integrator, evaluations: int) -> tuple[float, float]:
    """Largest distances of a run's states from the exact ones and from the closed form."""
    h = step_size(scheme, evaluations)
    steps = np.arange(round(ANGLE / h) + 1.0)
    path = islice(oscillator.states(scheme, h), len(steps))
    states = np.array([complex(x, v) for x, v in path])
    others = np.exp(-1j * h * steps), closed_form(scheme)(h, steps)
    error, distance = (float(np.abs(states - other).max()) for other in others)
    return error, distance


def closed_form(scheme: Integrator) -> UndampedMotion:
    """Closed form of a scheme's undamped motion.

    Raises
    ------
    ProblemError
        If the record has none.
    """
    if scheme.undamped_motion is None:
        raise kit.ProblemError(
            f"{scheme.name}: no closed form of its motion; set `undamped_motion`"
        )
    return scheme.undamped_motion


def needed_for(scheme: Integrator, wanted: float) -> float:
    """Evaluations per period for an error, by the closed form."""
    motion, angles = closed_form(scheme), np.linspace(0, ANGLE, INSTANTS + 1)
    exact = np.exp(-1j * angles)

    def excess(logarithm: float) -> float:
        h = math.exp(logarithm)
        return math.log(np.abs(motion(h, angles / h) - exact).max() / wanted)

    h = math.exp(brentq(excess, math.log(FINEST), math.log(COARSEST), xtol=1e-9))
    return 2 * math.pi * scheme.evaluations / h


def finding(needed: pd.DataFrame, wanted: float) -> str:
    """Evaluations per period of all schemes, the fewest first."""
    rows = needed[needed["wanted"] == wanted]
    # Rounded before they are sorted: schemes with the same motion keep their order.
    counts = {
        str(name): float(f"{count:.2g}")
        for name, count in zip(rows["scheme"], rows["evaluations_needed"], strict=True)
    }
    listed = ", ".join(
        f"{common.title(name)} {counts[name]:,.0f}"
        for name in sorted(counts, key=counts.__getitem__)
    )
    exponent = round(math.log10(wanted))
    return (
        f"Force evaluations per period for an error of 1e{exponent} of the amplitude over "
        f"{PERIODS} periods: {listed}."
    )


def draw(tables: kit.Tables) -> Figure:
    """Largest error over ten periods against evaluations per period, and the errors wanted."""
    figure, (axis,) = kit.figures.new_figure(size=(4.8, 3.8))
    for name, rows in tables["cost"].groupby("scheme", sort=False):
        scheme = str(name)
        axis.loglog(
            rows["evaluations"],
            rows["error"],
            marker=common.marker(scheme),
            color=common.colour(scheme),
            mfc="none",
            lw=0.9,
            ms=7 if INTEGRATORS[scheme].staggered else 4.5,
            label=common.title(scheme),
        )
    for wanted in WANTED:
        axis.axhline(wanted, color="grey", lw=0.8, ls=":", label="errors wanted")
    axis.set(xlabel="force evaluations per period (1)", ylabel="error over amplitude (1)")
    axis.set_ylim(1e-10, 100)
    axis.set_xticks([100, 1000], ["100", "1000"])
    figure.suptitle("Work for ten periods of an oscillator, by each scheme")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
