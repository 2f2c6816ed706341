"""Strips: is the capacitance of two facing strips found, and how fast do errors fall?

Question   Error of the capacitance against the number of segments, for narrow and wide strips.
Candidate  Charges by the method of moments, collocation and Galerkin, uniform and graded segments.
Reference  Love's closed form of two strips without thickness, `facing_strips_capacitance`.
Expected   Charge grows like the inverse root of the distance from an edge. Even segments miss the
           energy of about a segment's length at the tip: order 1. Where the last segment is of the
           order 1/n² (cosine), what is left at the tip falls with order 2, and so does the rest.
           Galerkin's charges are those of most ½QV at given voltages among all that are even on
           segments: its capacitance comes from below.
"""

from __future__ import annotations

from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges import facing_strips, facing_strips_capacitance
from msvalidate.dielectric.charges.moments import WEIGHTINGS

from .common import ChargeSolver

RATIOS = (1.0, 6.0, 10.0)
GRADINGS = {"uniform": 1.0, "cosine": 2.0}
"""Grading -> order that theory gives."""
SEGMENTS = (40, 80, 160, 320, 640)
QUICK_SEGMENTS = (80, 160, 320)
LARGER = 1000.0
"""Factor on all lengths that must leave the capacitance as it is."""
DRAWN = tuple(float(ratio) for ratio in np.geomspace(0.1, 50, 21).round(6))
"""Widths over the gap for which the closed form is drawn."""
ORDER_BECAUSE = (
    "the next term of the error is smaller by a segment over the gap, at most an eighth, and fits "
    "through three sizes or more weigh the finer ones as much"
)
RULES = (
    *(
        kit.Rule(
            f"capacitance of facing strips, graded segments, {weighting}", 1e-4, "1",
            "errors fall with order 2 from 1e-3 or so at 40 segments: 64 times less at 320",
            table="strips", rows={"grading": "cosine", "weighting": weighting},
            by=("width_over_gap",), last=1, value="capacitance_error",
        )
        for weighting in WEIGHTINGS
    ),
    *(
        kit.Rule(
            f"order of the capacitance, {grading} segments, {weighting}", 0.1, "1",
            ORDER_BECAUSE, table="strip_orders", rows={"grading": grading, "weighting": weighting},
            value="order", reference="order_expected",
        )
        for grading, weighting in product(GRADINGS, WEIGHTINGS)
    ),
    kit.Rule(
        "Galerkin's capacitance above the closed form, largest", 1e-10, "1",
        "a maximum over fewer charges is no larger; 1e-10 is rounding times the condition of the "
        "equations",
        table="strips", rows={"weighting": "galerkin"},
        value=lambda rows: rows["capacitance_error"].clip(lower=0.0),
    ),
)  # fmt: skip


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Errors of both weightings with both gradings, and their orders."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(RATIOS, GRADINGS, WEIGHTINGS, numbers))
    table = pd.DataFrame(setting.sweep(partial(strip_rows, candidate), cases, "facing strips"))
    keys = ["width_over_gap", "grading", "weighting"]
    orders = pd.DataFrame([fit_orders(rows) for _, rows in table.groupby(keys, sort=False)])
    return kit.Evidence(
        tables={"strips": table, "strip_orders": orders, "closed_form": closed_form()},
        tolerances=(*RULES, judge_size(candidate, int(table["segments"].min()))),
        figures={"strips": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, orders),),
    )


def strip_rows(candidate: ChargeSolver, case: tuple[float, str, str, int]) -> dict[str, object]:
    """Row of one pair of strips."""
    ratio, grading, weighting, segments = case
    charges = candidate.charges(
        facing_strips(ratio, 1.0, segments, grading=grading), weighting=weighting
    )
    capacitance, exact = float(charges.totals[0]), facing_strips_capacitance(ratio)
    return {
        "width_over_gap": ratio,
        "grading": grading,
        "weighting": weighting,
        "segments": segments,
        "capacitance": capacitance,
        "capacitance_exact": exact,
        "capacitance_error": capacitance / exact - 1,
    }


def fit_orders(rows: pd.DataFrame) -> dict[str, object]:
    """Row of orders."""
    case = rows.iloc[0]
    return {
        "width_over_gap": case["width_over_gap"],
        "grading": case["grading"],
        "weighting": case["weighting"],
        "order": kit.observed_order(1 / rows["segments"], rows["capacitance_error"]),
        "order_expected": GRADINGS[str(case["grading"])],
    }


def closed_form() -> pd.DataFrame:
    """The closed form from narrow to wide strips, beside its two limits."""
    r = np.array(DRAWN)
    wide = r > 1
    plates = r + (1 + np.log(2 * np.pi * r)) / np.pi
    wires = np.pi / np.arccosh(2 / np.minimum(r, 1.0))
    return pd.DataFrame(
        {
            "width_over_gap": r,
            "capacitance_exact": [facing_strips_capacitance(ratio) for ratio in DRAWN],
            "capacitance_limit": np.where(wide, plates, wires),
            "limit": np.where(wide, "wide plates", "two wires"),
        }
    )


def judge_size(candidate: ChargeSolver, size: int) -> kit.Tolerance:
    """Strips that are larger by `LARGER`, in so many segments."""
    small, large = (
        float(candidate.charges(facing_strips(RATIOS[1] * unit, unit, size)).totals[0])
        for unit in (1.0, LARGER)
    )
    return kit.Tolerance(
        "capacitance of strips a thousand times as large", 1e-10, "1",
        "per depth it has no unit of length; rounding times the condition of the equations",
        observed=kit.Observed(large / small, 1.0),
    )  # fmt: skip


def finding(table: pd.DataFrame, orders: pd.DataFrame) -> str:
    """Errors on the finest segments, in a sentence."""
    last = table[table["segments"] == table["segments"].max()]
    last = last[last["weighting"] == "galerkin"]
    said = [
        f"{grading} {rows['capacitance_error'].abs().max():.1e} (order "
        f"{orders[orders['grading'] == grading]['order'].mean():.2f})"
        for grading, rows in last.groupby("grading", sort=False)
    ]
    return (
        f"Capacitance of facing strips with {last['segments'].iloc[0]} segments each, Galerkin, "
        f"w/d = {', '.join(f'{ratio:g}' for ratio in RATIOS)}: largest error "
        + ", ".join(said)
        + "."
    )


def draw(tables: kit.Tables) -> Figure:
    """Errors against the number of segments, and the closed form."""
    table, form = tables["strips"], tables["closed_form"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.5, 2.9))
    *errors, last = kit.figures.widen_third(figure, axes)
    for axis, (grading, order) in zip(errors, GRADINGS.items(), strict=True):
        rows = table[table["grading"] == grading]
        for (ratio, weighting), line in rows.groupby(["width_over_gap", "weighting"], sort=False):
            style = kit.figures.series_style(RATIOS.index(ratio)) | {"ls": "-"}
            if weighting != "galerkin":
                style |= {"ls": "--", "mfc": "none"}
            label = f"w/d = {ratio:g}, {str(weighting).replace('galerkin', 'Galerkin')}"
            axis.loglog(line["segments"], line["capacitance_error"].abs(), label=label, **style)
        most = rows["capacitance_error"].abs().max()
        kit.figures.draw_order(axis, rows["segments"], 2 * most, order)
        kit.figures.tick_at(axis, rows["segments"])
        axis.set(title=f"{grading} segments", xlabel="segments of each strip (1)")
    axes[0].set_ylabel("relative error of\nthe capacitance (1)")
    closed = form["capacitance_exact"]
    last.loglog(form["width_over_gap"], closed, color="black", label="closed form")
    for place, (name, rows) in enumerate(form.groupby("limit", sort=False), start=3):
        width, limit = rows["width_over_gap"], rows["capacitance_limit"]
        last.loglog(width, limit, "--", color=kit.figures.COLOURS[place], label=str(name))
    met = table[table["segments"] == table["segments"].max()]
    orange = kit.figures.COLOURS[1]
    last.loglog(met["width_over_gap"], met["capacitance"], "o", color=orange, label="moments")
    last.set(
        title="capacitance",
        xlabel="width over gap w/d (1)",
        ylabel="capacitance per\ndepth over ε (1)",
    )
    last.legend(fontsize=8)
    figure.suptitle("Capacitance of facing strips")
    kit.figures.add_shared_legend(figure, errors, columns=2)
    return figure
