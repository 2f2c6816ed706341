"""Relaxation: how many steps to rest, how many seconds, and how do both grow?

Question   Steps and seconds of every relaxation to a displacement error of 1e-3 and 1e-6, against
           the points; the seconds beside the steps times the kernel's time for one.
Candidate  The table of relaxations, on a clamped plate, sheared.
Reference  The direct solution of the same network. Steps by prediction: the slowest mode,
           critically damped, is left with (1 + s) exp(-s) after s/omega_min, in steps of 0.9 of
           the limit 2/omega_max.
Expected   Explicit methods step as nodes^0.5 in the plane, as the root of the condition number
           does. Newton's method takes the same few iterations at each size. What an explicit
           method does beside its steps is a small part of it.

Steps are judged, seconds are told. Seconds are of the steps and the looks in between, without the
frequencies that set step and damping.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.bench.judging.counting import THRESHOLDS, TIGHT, predict_steps
from msvalidate.springs.dynamics.relaxations import RELAXATIONS
from msvalidate.springs.dynamics.run import Method

from . import drawing, resting
from .timing import GROWTH, ROUNDS

NODES = (1_000, 3_000, 10_000, 30_000, 100_000)
QUICK_NODES = (200, 600, 2_000)
MOST_NODES = {
    **dict.fromkeys(("algorithm1", "fire", "adaptive", "conjugate_gradients"), 10_000),
    **dict.fromkeys(("viscous_leapfrog", "newton"), 30_000),
}
"""Of methods that are slower than others of their kind."""
VISCOUS = ("viscous_leapfrog", "algorithm1")
NEWTON = ("newton", "newton_multigrid")
REPRODUCED = (*VISCOUS, "newton")
"""Methods whose counts do not hang on the last digits."""
VARIES = "varies"


def run(candidate: Mapping[str, Method], setting: kit.Setting) -> kit.Evidence:
    """Count steps to each threshold, time them, and fit their growth."""
    sizes = QUICK_NODES if setting.quick else NODES
    cases = [
        (candidate[name], nodes)
        for nodes in sizes
        for name in RELAXATIONS
        if nodes <= MOST_NODES.get(name, nodes)
    ]
    rounds = 1 if setting.quick else ROUNDS
    counted = setting.one_by_one(partial(measure, rounds), cases, "steps and seconds to rest")
    table = pd.DataFrame([row for rows in counted for row in rows])
    grown = growth(table)
    return kit.Evidence(
        tables={"relaxation": format_table(table), "relaxation_growth": grown},
        tolerances=judge(table, grown),
        figures={"relaxation": drawing.relaxation},
        columns=kit.columns(__file__),
        findings=findings(table, grown),
    )


def measure(rounds: int, case: tuple[Method, int]) -> list[dict[str, Any]]:
    """Rows of one method on one plate: counts, and the seconds of runs of as many steps."""
    method, nodes = case
    net, (low, high) = resting.plate(nodes), resting.frequencies(nodes)
    reached = resting.counted(method, nodes)
    rows, none = [], dict.fromkeys(resting.TIMED, 0.0)
    for threshold in THRESHOLDS:
        steps, evaluations = reached.get(threshold, (0, 0))
        rows.append(
            {
                "method": method.name,
                "nodes": len(net.points),
                "springs": len(net.springs),
                "threshold": threshold,
                "outcome": "reached" if threshold in reached else "failed",
                "steps_here": steps,
                "evaluations_here": evaluations,
                "predicted_steps": predict_steps(high / low, threshold),
            }
            | (resting.seconds(method, nodes, steps, rounds) if steps else none)
        )
    return rows


def format_table(table: pd.DataFrame) -> pd.DataFrame:
    """The table as it is kept: counts that any machine reproduces in a column of their own."""
    same = table["method"].isin(REPRODUCED)
    steps = table["steps_here"].astype(object).where(same, VARIES)
    return table.assign(steps=steps)


def growth(table: pd.DataFrame) -> pd.DataFrame:
    """Exponents of steps, of cycles and of seconds in nodes, per method and threshold."""
    rows = []
    done = table[table["outcome"] == "reached"]
    for (method, threshold), part in done.groupby(["method", "threshold"], sort=False):
        if len(part) < 3:
            continue
        grows = {"steps": part["steps_here"], "seconds": part["cpu_seconds"]}
        if method == "newton_multigrid":
            grows["cycles"] = part["evaluations_here"]
        for quantity, values in grows.items():
            fitted = dict(zip(GROWTH, kit.fitted_power(part["nodes"], values), strict=True))
            rows.append({"method": method, "threshold": threshold, "quantity": quantity} | fitted)
    return pd.DataFrame(rows)


def judge(table: pd.DataFrame, grown: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """What the tolerances judge, in their order."""
    tight = table[(table["threshold"] == TIGHT) & (table["outcome"] == "reached")]
    leapfrog = tight[tight["method"] == "viscous_leapfrog"]
    newton = tight[tight["method"].isin(NEWTON)].groupby("method")["steps_here"]
    spread = (newton.max() - newton.min()).max()
    exponents = grown.set_index(["quantity", "method"])["exponent_here"]
    return (
        kit.Tolerance(
            "runs that did not reach an error", 0, "1", "every method comes to rest here",
            observed=kit.Observed(int((table["outcome"] == "failed").sum())),
        ),
        kit.Tolerance(
            "exponent of viscous steps in nodes, worst", 0.05, "1",
            "1/2 + O(1/cells): the clamped edge and a look every per cent cost a few per cent of "
            "the steps on the coarsest plate",
            observed=_worst(exponents, "steps", VISCOUS, 0.5),
        ),
        kit.Tolerance(
            "exponent of the steps of kinetic damping in nodes, worst", 0.1, "1",
            "1/2 as above; restarts come in whole numbers, about ten to an error of 1e-3, so that "
            "one more or less on a decade of nodes is 0.04",
            observed=_worst(exponents, "steps", ("kinetic_damping",), 0.5),
        ),
        kit.Tolerance(
            "steps of viscous leapfrog to 1e-6 over the prediction, worst", 0.05, "1",
            "the prediction is of the slowest mode alone, as if it were the whole displacement; a "
            "look is taken every per cent of the way",
            observed=kit.farthest_value(leapfrog["steps_here"] / leapfrog["predicted_steps"],
            1.0) if len(leapfrog) else kit.Observed(math.nan, 1.0),
        ),
        kit.Tolerance(
            "iterations of Newton's methods to 1e-6, most less fewest over sizes, worst", 1, "1",
            "shears of 1e-3 leave an error of that size after the first iteration, of its square "
            "after the second: near 1e-6, so that one size may need one more",
            observed=kit.Observed(float(spread)),
        ),
    )  # fmt: skip


def _worst(
    exponents: pd.Series, quantity: str, methods: tuple[str, ...], law: float
) -> kit.Observed:
    """The exponent farthest from its law; NaN, which fails, where too few runs came to rest."""
    known = [exponents.get((quantity, method)) for method in methods]
    values = [float(v) for found in known for v in ([np.nan] if found is None else found)]
    return kit.farthest_value(values, law)


def findings(table: pd.DataFrame, grown: pd.DataFrame) -> tuple[str, ...]:
    """Who is fastest on the largest plate, and what explicit methods do beside their steps."""
    tight = table[(table["threshold"] == TIGHT) & (table["outcome"] == "reached")]
    last = tight[tight["nodes"] == tight["nodes"].max()].sort_values("cpu_seconds", kind="stable")
    ranks = ", ".join(
        f"{row.method} {row.cpu_seconds:.2g} s in {row.steps_here:,} steps"
        for row in last.itertuples(index=False)
    )
    said = [f"On this machine the plate of {last['nodes'].max():,} points took: {ranks}."]
    stepped = tight[tight["kernel_seconds"] > 0]
    beside = stepped["cpu_seconds"] / stepped["kernel_seconds"]
    told = ", ".join(
        f"{method} {ratio:.2f}"
        for method, ratio in beside.groupby(stepped["method"]).last().items()
    )
    said.append(f"Seconds over steps times the kernel's own, on each one's largest plate: {told}.")
    rates = grown[(grown["quantity"] == "seconds") & (grown["threshold"] == TIGHT)]
    powers = ", ".join(
        f"{row.method} {row.exponent_here:.2f}" for row in rates.itertuples(index=False)
    )
    said.append(f"Seconds to 1e-6 grow as the points to the power of: {powers}.")
    return tuple(said)
