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

from msvalidate import kit
from msvalidate.dynamics.integrators import INTEGRATORS
from msvalidate.dynamics.scheme import Integrator, LeadingError

from . import common, oscillator
from .common import Schemes

ANGLE = 20.0
"""ω times the time of the motion (rad), three periods."""
EVALUATIONS = tuple(100 * 2**k for k in range(10))
QUICK_EVALUATIONS = (200, 800, 3200, 12800)
WANTED = (1e-3, 1e-6)
MOST = 1e15
"""Evaluations that nobody makes: rounding would hide such steps."""
JUDGED = 12800
"""Evaluations at which errors are held to their leading terms: in both forms."""
TOLD = {name: one for name in common.TRUE if (one := INTEGRATORS[name].leading) is not None}
"""Scheme -> leading term of its error."""


def next_term(scheme: Integrator) -> float:
    """Bound of an error at `JUDGED` over its leading term, less 1: twice its next term.

    Raises
    ------
    ProblemError
        If the scheme tells no leading term.
    """
    return 2 * leading_of(scheme).next_term(ANGLE * scheme.evaluations / JUDGED, ANGLE)


def leading_of(scheme: Integrator) -> LeadingError:
    """Leading term of a scheme's error.

    Raises
    ------
    ProblemError
        If it tells none.
    """
    if scheme.leading is None:
        raise kit.ProblemError(f"{scheme.name}: tells no leading term of its error; give one")
    return scheme.leading


RULES = tuple(
    kit.Rule(
        f"error of 12,800 evaluations over its leading term: {common.title(name)}",
        next_term(INTEGRATORS[name]), "1",
        f"the next term: {leading.because.format(angle=ANGLE)}; twice it, for the terms beyond",
        table="cost", rows={"scheme": name, "evaluations": JUDGED},
        value=kit.Quotient("error", "leading"), reference=1.0,
    )
    for name, leading in TOLD.items()
)  # fmt: skip


def run(candidate: Schemes = INTEGRATORS, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Errors against evaluations, and evaluations for the errors that are wanted."""
    numbers = QUICK_EVALUATIONS if setting.quick else EVALUATIONS
    schemes = common.chosen(candidate, tuple(TOLD))
    cases = list(product(schemes.items(), numbers))
    table = pd.DataFrame(setting.sweep(measure, cases, "cost"))
    needed = pd.DataFrame(
        [evaluations_needed(table, name, w) for name, w in product(schemes, WANTED)]
    )
    return kit.Evidence(
        tables={"cost": table, "cost_needed": needed},
        tolerances=RULES,
        figures={"cost": draw},
        columns=kit.columns(__file__),
        findings=tuple(map(partial(finding, needed), WANTED)),
    )


def measure(case: tuple[tuple[str, Integrator], int]) -> dict[str, object]:
    """Row of one scheme at one number of evaluations."""
    (name, scheme), evaluations = case
    error, leading = errors(scheme, evaluations)
    return {
        "scheme": name,
        "evaluations": evaluations,
        "h_omega": ANGLE / (evaluations // scheme.evaluations),
        "error": error,
        "leading": leading,
    }


def errors(scheme: Integrator, evaluations: int) -> tuple[float, float]:
    """Error at `ANGLE` in so many evaluations, and its leading term."""
    steps = evaluations // scheme.evaluations
    error = abs(oscillator.swing(scheme, steps, ANGLE) - math.cos(ANGLE))
    return error, leading_of(scheme).coefficient(ANGLE) * (ANGLE / steps) ** scheme.order


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


def draw(tables: kit.Tables) -> Figure:
    """Error against evaluations, with the leading terms."""
    figure, (axis,) = kit.figures.new_figure(size=(4.8, 3.8))
    for name, rows in tables["cost"].groupby("scheme", sort=False):
        scheme = str(name)
        axis.loglog(
            rows["evaluations"],
            rows["error"],
            ls="",
            marker=common.marker(scheme),
            color=common.colour(scheme),
            mfc="none",
            ms=7 if INTEGRATORS[scheme].staggered else 4.5,
            label=common.title(scheme),
        )
        axis.loglog(rows["evaluations"], rows["leading"], lw=0.9, color=common.colour(scheme))
    axis.plot([], [], color="black", lw=0.9, label="leading term of each")
    for wanted in WANTED:
        axis.axhline(wanted, color="grey", lw=0.8, ls=":", label="errors asked for")
    axis.set(xlabel="force evaluations for 20 rad (1)", ylabel="error over amplitude (1)")
    axis.set_ylim(1e-8, 10)
    axis.set_xticks([100, 1000, 10000, 100000], ["100", "1000", "10000", "100000"])
    figure.suptitle("Work for an oscillator's motion, by each scheme")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
