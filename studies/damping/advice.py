"""Advice: is it better to damp too much than too little?

Question   The report would rather overdamp when the critical value is unknown. What does a wrong
           guess cost, in steps, to either side?
Candidate  Algorithm 1's motion to a displacement error of 1e-6.
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
from msvalidate.dynamics.damping import decay

from . import bodies, rest
from .bodies import MotionSolver

BODIES = (("plate sheared", (8, 8), "across"), ("beam bent", (20, 2), "across"))
GUESSED = (1 / 10, 1 / 3, 1.0, 3.0, 10.0)
"""Of the critical damping."""
ERROR = 1e-6
WRONG = (1 / 3, 3.0)
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
    """Prices by body of a third of the damping, and of three times it."""
    return [table[table["c_over_critical"] == guess].set_index("body")["price"] for guess in WRONG]


def run(candidate: MotionSolver, setting: kit.Setting) -> kit.Evidence:
    """Prices of wrong dampings."""
    found = setting.sweep(partial(price_guess, candidate), BODIES, "price of a guess")
    table = pd.DataFrame([row for rows in found for row in rows])
    for column, steps in (("price", "steps"), ("price_predicted", "steps_slowest")):
        right = table[table["c_over_critical"] == 1].set_index("body")[steps]
        table[column] = table[steps] / table["body"].map(right)
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
    """Steps to rest of one body, one row a damping."""
    body = bodies.loaded(*shape)
    omega = float(body.frequencies[0])
    rows: list[dict[str, object]] = []
    for guess in GUESSED:
        found = rest.relax_block(candidate, body, guess, (ERROR,))
        rows.append(
            {
                "body": body.name,
                "c_over_critical": guess,
                "dt_s": found.dt,
                "steps": found.measured[ERROR],
                "steps_slowest": found.slowest[ERROR],
                "rate_price": omega / decay(omega, 2 * guess * omega),
            }
        )
    return rows


def finding(under: pd.Series, over: pd.Series) -> str:
    """What a wrong guess costs to either side."""
    if (under < over).all():
        verdict = "it is cheaper to damp too little"
    elif (under > over).all():
        verdict = "it is cheaper to damp too much"
    else:
        verdict = "it depends on the body which is cheaper"
    return (
        f"Damping three times too strong costs {over.min():.3g} to {over.max():.3g} times the "
        f"steps of critical damping, three times too weak {under.min():.3g} to "
        f"{under.max():.3g}: to an error of {ERROR:g} {verdict}."
    )


def draw(tables: kit.Tables) -> Figure:
    """Price of a wrong damping."""
    figure, (axis,) = kit.figures.new_figure(size=(4.2, 3.6))
    for place, (name, own) in enumerate(tables["advice"].groupby("body", sort=False)):
        style, c = kit.figures.series_style(place), own["c_over_critical"]
        axis.loglog(c, own["price"], ls="", label=f"{name} cells", **style)
        axis.loglog(c, own["price_predicted"], color=style["color"], lw=0.9)
    axis.plot([], [], color="black", lw=0.9, label="slowest mode alone")
    axis.set(
        title=f"Price of a wrong damping,\nto a displacement error of {ERROR:g}",
        xlabel="damping over the critical one (1)",
        ylabel="steps over those at critical damping (1)",
    )
    axis.legend()
    return figure
