"""Steps: how much work does each relaxation need, and how does it grow with the network?

Question   Steps and force evaluations to a displacement error of 1e-3 and 1e-6, against the nodes;
           is their number constant, as the report's O(n) needs it to be?
Candidate  The table of relaxations.
Reference  The direct solution of the same network. Steps by prediction: the slowest mode,
           critically damped, is left with (1 + s) exp(-s) after s/omega_min, in steps of 0.9 of
           the limit 2/omega_max.
Expected   sqrt(kappa) grows with the cells along a side: as nodes^(1/2) in the plane, nodes^(1/3)
           in space. Steps of all explicit methods grow so, and the work, steps x springs, as
           nodes^(3/2) and nodes^(4/3). Newton's method takes a constant number. Growth is judged
           here in the plane, and in `space`.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bench.judging import counting
from msvalidate.bench.judging.counting import THRESHOLDS, TIGHT, predict_steps
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Method

from . import bodies

FINENESSES = {
    "plate": (8, 16, 32, 64, 128),
    "beam": (2, 4, 8, 16, 32),
    "cube": (6, 8, 10, 16, 24),
}
"""Cells across: 81 to 16641 nodes, 33 to 5313, and 343 to 15625."""
QUICK = {"plate": (8, 16, 32, 48), "beam": (2, 4, 6, 8), "cube": (6, 8, 10, 12)}
VISCOUS = ("algorithm1", "viscous_leapfrog")
"""Viscous methods of one step and damping: the slowest mode predicts how many steps they take."""
DYNAMIC = (*VISCOUS, "kinetic_damping", "fire", "adaptive")
"""Methods that step in time."""
EXPLICIT = (*DYNAMIC, "conjugate_gradients")
"""Methods that factorise nothing: their work is that of their evaluations."""
FACTORISING = "newton"
"""The method that factorises, and so stops at `bodies.FACTORISED` in space."""
CYCLING = "newton_multigrid"
"""The method whose evaluations are cycles of multigrid, but for one a step."""
REPRODUCED = (*VISCOUS, FACTORISING)
"""Methods whose counts do not hang on rounding. The others choose between ways by the sign of small
differences (FIRE's counts move by a fifth when a stiffness moves by 1e-15), or by a library."""
HERE = {name: f"{name}_here" for name in ("steps", "evaluations", "exponent", "low", "high")}


def run(candidate: Mapping[str, Method], setting: kit.Setting) -> kit.Evidence:
    """Count steps to each threshold, and fit their growth."""
    sizes = QUICK if setting.quick else FINENESSES
    cases = [
        (candidate[name], body, fineness)
        for body in bodies.SIZES
        for fineness, name in product(sizes[body], RELAXATIONS)
        if name != FACTORISING or bodies.is_factor_worthwhile(body, fineness)
    ]
    rows = setting.sweep(count_steps, cases, "steps to rest")
    table = pd.DataFrame([row for pair in rows for row in pair])
    grown = growth(table)
    return kit.Evidence(
        tables=split_table("steps", table) | split_table("growth", grown),
        tolerances=(*RULES, *CUBE, *judge_runs(table)),
        figures={"steps": draw, "cost": draw_cost},
        columns=kit.columns(__file__),
        findings=findings(table, grown),
    )


def split_table(name: str, table: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Two tables of one: what any machine reproduces, and what it may not, renamed."""
    kept = table["method"].isin(REPRODUCED)
    return {
        name: table[kept].reset_index(drop=True),
        f"{name}_here": table[~kept].rename(columns=HERE).reset_index(drop=True),
    }


def together(name: str, tables: kit.Tables) -> pd.DataFrame:
    """One table of the two."""
    back = {here: name for name, here in HERE.items()}
    return pd.concat([tables[name], tables[f"{name}_here"].rename(columns=back)], ignore_index=True)


def count_steps(case: tuple[Method, str, int]) -> list[dict[str, object]]:
    """Rows of one run: the first look at which the error is below each threshold."""
    method, body, fineness = case
    network, reference = bodies.network(body, fineness), bodies.rest_displacement(body, fineness)
    low, high = bodies.frequencies(body, fineness)
    cells_x, cells_y = bodies.cells(body, fineness)[:2]
    reached = counting.count_steps(
        method, network, (low, high), lambda move: bodies.relative_error(move, reference)
    )
    rows: list[dict[str, object]] = []
    for threshold in THRESHOLDS:
        steps, evaluations = reached.get(threshold, (0, 0))
        rows.append(
            {
                "body": body,
                "method": method.name,
                "cells_x": cells_x,
                "cells_y": cells_y,
                "nodes": len(network.points),
                "springs": len(network.springs),
                "root_kappa": high / low,
                "threshold": threshold,
                "outcome": "reached" if threshold in reached else "failed",
                "steps": steps,
                "evaluations": evaluations,
                "predicted_steps": predict_steps(high / low, threshold),
            }
        )
    return rows


def expected(quantity: str, body: str) -> float:
    """Exponent by theory: steps as √κ, and so as the cells along a side; as many cycles always."""
    along = 1 / bodies.dim(body)
    return {
        "steps in nodes": along,
        "steps in kappa": 0.5,
        "cost in nodes": 1 + along,
        "cycles in nodes": 0.0,
    }[quantity]


def growth(table: pd.DataFrame) -> pd.DataFrame:
    """Exponents of steps and cost, per body, method and threshold."""
    rows = []
    done = table[table["outcome"] == "reached"]
    for (body, method, threshold), part in done.groupby(
        ["body", "method", "threshold"], sort=False
    ):
        if len(part) < 3:
            continue
        fits = {
            "steps in nodes": kit.fitted_power(part["nodes"], part["steps"]),
            "steps in kappa": kit.fitted_power(part["root_kappa"] ** 2, part["steps"]),
        }
        if method in EXPLICIT:
            cost = part["evaluations"] * part["springs"]
            fits["cost in nodes"] = kit.fitted_power(part["nodes"], cost)
        if method == CYCLING:
            fits["cycles in nodes"] = kit.fitted_power(part["nodes"], part["evaluations"])
        head = {"body": body, "method": method, "threshold": threshold}
        rows += [head | {"quantity": what} | fit._asdict() for what, fit in fits.items()]
    return pd.DataFrame(rows)


def _exponent(
    words: str, limit: float, because: str, on: tuple[str, ...], methods: tuple[str, ...]
) -> kit.Rule:
    """The exponent, named at the start of the words, that is farthest from `expected`."""
    quantity = words.removeprefix("exponent of ").partition(",")[0]
    kept = set(methods) <= set(REPRODUCED)
    return kit.Rule(
        words, limit, "1", because, table="growth" if kept else "growth_here",
        rows={"threshold": TIGHT, "quantity": quantity, "body": on, "method": methods},
        value="exponent" if kept else HERE["exponent"], reference=expected(quantity, on[0]),
    )  # fmt: skip


LEAPFROG = ("viscous_leapfrog",)
PLATE, IN_SPACE = ("plate",), ("cube",)
RULES = (
    _exponent(
        "exponent of steps in kappa, viscous methods in the plane, worst", 0.05,
        "1/2 where the slowest mode is all; other modes and looks add a step or two per hundred on "
        "the coarsest", bodies.PLANE, VISCOUS,
    ),
    _exponent(
        "exponent of steps in nodes, viscous leapfrog on the plate", 0.05,
        "1/2 + O(1/cells): the clamped edge costs a few per cent of sqrt(kappa) on the coarsest",
        PLATE, LEAPFROG,
    ),
    _exponent(
        "exponent of cost in nodes, viscous methods on the plate, worst", 0.1,
        "3/2, and as above; a spring more or less per node on the boundary adds up to 0.04",
        PLATE, VISCOUS,
    ),
    kit.Rule(
        "steps of viscous leapfrog over the prediction from kappa, worst", 0.05, "1",
        "the prediction is of the slowest mode alone, as if it were the whole displacement; a look "
        "is taken every per cent or two of the way",
        table="steps", rows={"method": LEAPFROG}, reference=1.0,
        value=kit.Quotient("steps", "predicted_steps"),
    ),
)  # fmt: skip
CUBE = (
    _exponent(
        "exponent of steps in kappa, viscous methods on the cube, worst", 0.08,
        "1/2 less what Algorithm 1 loses: of first order, damped critically for the exact motion, "
        "its two rates lie sqrt(e) apart, e = 1.8/sqrt(kappa) = 0.09 on the coarsest cube, which "
        "costs sqrt(e)/4 of the exponent there", IN_SPACE, VISCOUS,
    ),
    _exponent(
        "exponent of steps in nodes, viscous leapfrog on the cube", 0.08,
        "1/3: n cells have n + 1 nodes along an edge, so that it is (1 + 1/n)/3 at first, 0.06 "
        "more with 6 cells; the clamped side adds two hundredths", IN_SPACE, LEAPFROG,
    ),
    _exponent(
        "exponent of cost in nodes, viscous methods on the cube, worst", 0.15,
        "4/3, and as above; nodes of the surface have fewer springs, which adds 0.07",
        IN_SPACE, VISCOUS,
    ),
    _exponent(
        "exponent of steps in nodes, kinetic and adaptive damping and conjugate gradients on the "
        "cube, worst", 1 / 6,
        "nearer to 1/3 than to 0, the report's constant time, and to 2/3, as steepest descent "
        "steps", IN_SPACE, ("kinetic_damping", "adaptive", "conjugate_gradients"),
    ),
    _exponent(
        "exponent of steps in nodes, FIRE on the cube", 0.27,
        "as above, and 0.1 more: its counts hang on the last digits, by a fifth on six times the "
        "nodes; still no constant", IN_SPACE, ("fire",),
    ),
    _exponent(
        "exponent of cycles in nodes, Newton's method by multigrid on the cube", 1 / 6,
        "nearer to constant than to 1/3, as explicit methods step", IN_SPACE, (CYCLING,),
    ),
)  # fmt: skip


def judge_runs(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What is judged of all methods together."""
    newton = table[table["method"].isin(["newton", "newton_multigrid"])]
    return (
        kit.Tolerance(
            "runs that failed", 0, "1", "every method is stable and must arrive at rest",
            observed=kit.Observed(int((table["outcome"] == "failed").sum())),
        ),
        kit.Tolerance(
            "steps of Newton's method to 1e-6, most", 0, "1",
            "rotations of 1e-4 leave an error of that size after the first, of its square after "
            "the second", observed=kit.Observed(int(newton["steps"].max()), 2),
        ),
    )  # fmt: skip


def findings(table: pd.DataFrame, grown: pd.DataFrame) -> tuple[str, ...]:
    """What the report's claims come to."""
    tight = grown[(grown["threshold"] == TIGHT) & grown["method"].isin(DYNAMIC)]
    said = []
    for body in bodies.PLANE:
        part = tight[tight["body"] == body]
        cost = part[part["quantity"] == "cost in nodes"]
        verdict = "refuted" if (cost["low"] > 1).all() else "not decided by these sizes"
        told = "; ".join(
            f"{row.method} {row.exponent:.2f} [{row.low:.2f}, {row.high:.2f}]"
            for row in cost.itertuples(index=False)
        )
        said.append(
            f"The report's O(n), {body}: {verdict}. The work to an error of {TIGHT:g} grows as the "
            f"nodes to the power of: {told}."
        )
    for body in bodies.SIZES:
        last = table[(table["body"] == body) & (table["threshold"] == TIGHT)]
        last = last[last["nodes"] == last["nodes"].max()].sort_values("evaluations", kind="stable")
        counts = ", ".join(
            f"{row.method} {row.evaluations:,}"
            for row in last[last["outcome"] == "reached"].itertuples(index=False)
        )
        said.append(
            f"The {body} of {last['nodes'].max():,} nodes takes, in evaluations of all springs "
            f"(of multigrid cycles, of Newton's method residuals): {counts}."
        )
    return tuple(said)


def draw(tables: kit.Tables) -> Figure:
    """Steps to an error of 1e-6 against the nodes, with the slope of the prediction."""
    return _drawn(together("steps", tables), "steps")


def draw_cost(tables: kit.Tables) -> Figure:
    """Work to an error of 1e-6 of methods that factorise nothing, with the predicted slope."""
    table = together("steps", tables)
    table = table[table["method"].isin(EXPLICIT)]
    return _drawn(table.assign(cost=table["evaluations"] * table["springs"]), "cost")


def style(method: str) -> dict[str, Any]:
    """How a method is drawn, in every figure the same."""
    index = list(RELAXATIONS).index(method)
    line = "-" if index < len(kit.figures.COLOURS) else "--"
    title = RELAXATIONS[method].title
    look = kit.figures.series_style(index) | {
        "linestyle": line,
        "label": title[0].upper() + title[1:],
    }
    # Open and large where others lie on it.
    return look | ({"mfc": "none", "ms": 7.5} if index % len(kit.figures.COLOURS) == 0 else {})


SLOPES = {2: ":", 3: "-."}
"""Lines of the expected slopes in the plane and in space."""
SPACE = {2: "expected in the plane", 3: "expected in space"}
LABELS = {
    "steps": "steps to an error of 1e-6 (1)",
    "cost": "evaluations times springs\nto an error of 1e-6 (1)",
}
TITLES = {
    "steps": "Steps that each way to rest takes",
    "cost": "Work that each explicit way to rest takes",
}


def _drawn(table: pd.DataFrame, quantity: str) -> Figure:
    tight = table[(table["threshold"] == TIGHT) & (table["outcome"] == "reached")]
    tight = tight.dropna(subset=[quantity])  # the baseline has not what depends on the machine
    figure, axes = kit.figures.new_figure(
        len(bodies.SIZES), size=(2.4, 3.9), sharex=True, sharey=True
    )
    for axis, body in zip(axes, bodies.SIZES, strict=True):
        part = tight[tight["body"] == body]
        for method, rows in part.groupby("method", sort=False):
            axis.loglog(rows["nodes"], rows[quantity], **style(str(method)))
        slope = expected(f"{quantity} in nodes", body)
        nodes = np.array([part["nodes"].min(), part["nodes"].max()], dtype=float)
        start = 0.6 * part[part["method"] == part["method"].iloc[0]][quantity].iloc[0]
        line, label = (
            SLOPES[bodies.dim(body)],
            f"slope {Fraction(slope).limit_denominator(9)}: {SPACE[bodies.dim(body)]}",
        )
        axis.loglog(nodes, start * (nodes / nodes[0]) ** slope, line, color="black", label=label)
        axis.set(title=body, xlabel="nodes (1)")
    axes[0].set_ylabel(LABELS[quantity])
    figure.suptitle(TITLES[quantity])
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure
