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

from msvalidate.dielectric.charges import facing_strips, facing_strips_capacitance
from msvalidate.dielectric.charges.moments import WEIGHTINGS
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.output import figures

from . import common
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
TOLERANCES = (
    *(
        Tolerance(
            f"capacitance of facing strips, graded segments, {weighting}", 1e-4, "1",
            "errors fall with order 2 from 1e-3 or so at 40 segments: 64 times less at 320",
        )
        for weighting in WEIGHTINGS
    ),
    *(
        Tolerance(
            f"order of the capacitance, {grading} segments, {weighting}", 0.1, "1",
            ORDER_BECAUSE,
        )
        for grading, weighting in product(GRADINGS, WEIGHTINGS)
    ),
    Tolerance(
        "Galerkin's capacitance above the closed form, largest", 1e-10, "1",
        "a maximum over fewer charges is no larger; 1e-10 is rounding times the condition of the "
        "equations",
    ),
    Tolerance(
        "capacitance of strips a thousand times as large", 1e-10, "1",
        "per depth it has no unit of length; rounding times the condition of the equations",
    ),
)  # fmt: skip
COLUMNS = {
    **common.COLUMNS,
    "capacitance": "per depth over the permittivity (1)",
    "capacitance_exact": "the same by the closed form (1)",
    "capacitance_error": "of the method of moments over the closed form, less 1 (1)",
    "order_expected": "order that theory gives (1)",
    "capacitance_limit": "by the nearer of its limits (1)",
    "limit": "wide plates: w/d + (1 + ln(2πw/d))/π; two wires: π/arcosh(2d/w), of a quarter of the "
    "width as radius",
}


def run(candidate: ChargeSolver, setting: Setting) -> Evidence:
    """Errors of both weightings with both gradings, and their orders."""
    numbers = QUICK_SEGMENTS if setting.quick else SEGMENTS
    cases = list(product(RATIOS, GRADINGS, WEIGHTINGS, numbers))
    table = pd.DataFrame(setting.sweep(partial(strip_rows, candidate), cases, "facing strips"))
    keys = ["width_over_gap", "grading", "weighting"]
    orders = pd.DataFrame([fit_orders(rows) for _, rows in table.groupby(keys, sort=False)])
    return Evidence(
        tables={"strips": table, "strip_orders": orders, "closed_form": closed_form()},
        observed=by_quantity(TOLERANCES, judge(candidate, table, orders)),
        tolerances=TOLERANCES,
        figures={"strips": draw},
        columns=COLUMNS,
        findings=(finding(table, orders),),
        rounding={"capacitance_error": 1e-11, "order": 1e-5},
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
        "order": observed_order(1 / rows["segments"], rows["capacitance_error"]),
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


def judge(candidate: ChargeSolver, table: pd.DataFrame, orders: pd.DataFrame) -> list[Observed]:
    """What `TOLERANCES` name, in their order."""
    finest = table[table["segments"] == table["segments"].max()].set_index(["grading", "weighting"])
    grouped = orders.set_index(["grading", "weighting"])
    galerkin = table[table["weighting"] == "galerkin"]["capacitance_error"]
    size, ratio = int(table["segments"].min()), RATIOS[1]
    small, large = (
        float(candidate.charges(facing_strips(ratio * unit, unit, size)).totals[0])
        for unit in (1.0, LARGER)
    )
    return [
        *(
            farthest_value(finest.loc[[("cosine", weighting)], "capacitance_error"], 0.0)
            for weighting in WEIGHTINGS
        ),
        *(
            farthest_value(rows["order"], rows["order_expected"])
            for rows in (grouped.loc[[key]] for key in product(GRADINGS, WEIGHTINGS))
        ),
        Observed(max(0.0, float(galerkin.max()))),
        Observed(large / small, 1.0),
    ]


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


def draw(tables: Tables) -> Figure:
    """Errors against the number of segments, and the closed form."""
    table, form = tables["strips"], tables["closed_form"]
    figure, axes = figures.new_figure(2, 2, size=(3.5, 2.9))
    *errors, last = figures.widen_third(figure, axes)
    for axis, (grading, order) in zip(errors, GRADINGS.items(), strict=True):
        rows = table[table["grading"] == grading]
        for (ratio, weighting), line in rows.groupby(["width_over_gap", "weighting"], sort=False):
            style = figures.series_style(RATIOS.index(ratio)) | {"ls": "-"}
            if weighting != "galerkin":
                style |= {"ls": "--", "mfc": "none"}
            label = f"w/d = {ratio:g}, {str(weighting).replace('galerkin', 'Galerkin')}"
            axis.loglog(line["segments"], line["capacitance_error"].abs(), label=label, **style)
        most = rows["capacitance_error"].abs().max()
        figures.draw_order(axis, rows["segments"], 2 * most, order)
        figures.tick_at(axis, rows["segments"])
        axis.set(title=f"{grading} segments", xlabel="segments of each strip (1)")
    axes[0].set_ylabel("relative error of\nthe capacitance (1)")
    closed = form["capacitance_exact"]
    last.loglog(form["width_over_gap"], closed, color="black", label="closed form")
    for place, (name, rows) in enumerate(form.groupby("limit", sort=False), start=3):
        width, limit = rows["width_over_gap"], rows["capacitance_limit"]
        last.loglog(width, limit, "--", color=figures.COLOURS[place], label=str(name))
    met = table[table["segments"] == table["segments"].max()]
    orange = figures.COLOURS[1]
    last.loglog(met["width_over_gap"], met["capacitance"], "o", color=orange, label="moments")
    last.set(
        title="capacitance",
        xlabel="width over gap w/d (1)",
        ylabel="capacitance per\ndepth over ε (1)",
    )
    last.legend(fontsize=8)
    figure.suptitle("Capacitance of facing strips")
    figures.add_shared_legend(figure, errors, columns=2)
    return figure
