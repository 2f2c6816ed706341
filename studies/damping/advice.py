"""Advice: is it better to damp too much than too little?

Question   The report would rather overdamp when the critical value is unknown. What does a wrong
           guess cost, in steps, to either side?
Candidate  Algorithm 1's motion to displacement errors of 1e-3 and 1e-6.
Reference  The slowest mode alone: its rate is c/2 below critical damping, so a third of c takes
           about three times as long; above it is c/2 - √(c²/4 - ω²), 1/5.8 of ω at three times c.
Expected   Overdamping costs about twice what underdamping by the same factor does, and more where
           it shortens the stable step as well.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.dynamics.damping import decay

from . import bodies, rest
from .bodies import MotionSolver

BODIES = (("plate sheared", (8, 8), "across"), ("beam bent", (20, 2), "across"))
GUESSED = (1 / 10, 1 / 3, 1.0, 3.0, 10.0)
"""Of the critical damping."""
WRONG = (1 / 3, 3.0)
ON = ["body", "error"]
"""Columns of what a price is compared with: the same body, to the same error."""
RULES = (
    kit.Rule(
        "price of a wrong damping over the predicted, logarithm to base 2", 0.3, "1",
        "steps to rest are within a fifth of those of the slowest mode alone, with either damping",
        table="advice", value=lambda rows: np.log2(rows["price"] / rows["price_predicted"]),
    ),
    kit.Rule(
        "bodies on which a third of the damping costs more than three times it", 0.0, "1",
        "the slowest mode's rates are ω/3 and ω/5.8, and the critical run's own factor 1 + ωt is "
        "common to both",
        table="advice", value=lambda rows: _dearer(*_prices(rows)),
    ),
)  # fmt: skip


def _dearer(under: pd.Series[float], over: pd.Series[float]) -> int:
    return int((under > over).sum())


def _prices(table: pd.DataFrame) -> list[pd.Series[float]]:
    """Prices by body and error of a third of the damping, and of three times it."""
    return [table[table["c_over_critical"] == guess].set_index(ON)["price"] for guess in WRONG]


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Prices of wrong dampings."""
    found = setting.sweep(partial(price_guess, candidate), BODIES, "price of a guess")
    table = pd.DataFrame([row for rows in found for row in rows])
    for column, steps in (("price", "steps"), ("price_predicted", "steps_slowest")):
        right = table[table["c_over_critical"] == 1].set_index(ON)[steps].rename("right")
        table[column] = table[steps] / table.join(right, on=ON)["right"]
    table = table.drop(columns="steps_slowest")
    return kit.Evidence(
        tables={"advice": table},
        tolerances=RULES,
        figures={"advice": draw},
        columns=kit.columns(__file__),
        findings=(finding(*_prices(table)),),
    )


def price_guess(
    candidate: MotionSolver, shape: tuple[str, tuple[int, int], str]
) -> list[dict[str, object]]:
    """Steps to rest of one body, one row for each damping and error."""
    body = bodies.loaded(*shape)
    omega = float(body.frequencies[0])
    rows: list[dict[str, object]] = []
    for guess in GUESSED:
        run = rest.relax_block(candidate, body, guess, rest.ERRORS)
        rows += [
            {
                "body": body.name,
                "error": error,
                "c_over_critical": guess,
                "dt_s": run.dt,
                "steps": run.measured[error],
                "steps_slowest": run.slowest[error],
                "rate_price": omega / decay(omega, 2 * guess * omega),
            }
            for error in rest.ERRORS
        ]
    return rows


def finding(under: pd.Series[float], over: pd.Series[float]) -> str:
    """What a wrong guess costs to either side, to each error."""
    if (under < over).all():
        verdict = "it is cheaper to damp too little"
    elif (under > over).all():
        verdict = "it is cheaper to damp too much"
    else:
        verdict = "it depends on the body and the error which is cheaper"
    costs = (
        f"{limits(over, error)} and {limits(under, error)} to an error of {error:g}"
        for error in rest.ERRORS
    )
    return (
        f"Steps relative to critical damping, three times too strong and three times too weak: "
        f"{'; '.join(costs)}. On these {under.index.get_level_values('body').nunique()} bodies "
        f"{verdict}."
    )


def limits(prices: pd.Series[float], error: float) -> str:
    """The smallest and the largest price to an error."""
    own = prices.xs(error, level="error")
    return f"{own.min():.3g} to {own.max():.3g}"


def draw(tables: kit.Tables) -> Figure:
    """Price of a wrong damping."""
    figure, (axis,) = kit.figures.new_figure(size=(4.2, 3.6))
    for place, ((name, error), own) in enumerate(tables["advice"].groupby(ON, sort=False)):
        style, c = kit.figures.series_style(place), own["c_over_critical"]
        axis.loglog(c, own["price"], ls="", label=f"{name} cells, {error:g}", **style)
        axis.loglog(c, own["price_predicted"], color=style["color"], lw=0.9)
    axis.plot([], [], color="black", lw=0.9, label="slowest mode alone")
    axis.set(
        title="Price of a wrong damping,\nto displacement errors of 1e-3 and 1e-6",
        xlabel="damping over the critical one (1)",
        ylabel="steps over those at critical damping (1)",
    )
    axis.legend()
    return figure
