"""Dynamic relaxation: an independent program's counts, and steps against the condition number.

Question   Does the best explicit relaxation take the steps that another program took, and do they
           grow as the square root of the condition number kappa = (omega_max/omega_min)^2?
Candidate  Leapfrog with centred damping at the step 2/sqrt(omega_max^2 + omega_min^2) and the
           damping 2 omega_min, which minimise the largest spectral radius of all modes.
Reference  Counts by an independent program on the same networks. The spectral radius
           1 - 2/sqrt(kappa), which leaves 1/2 sqrt(kappa) ln(1/tolerance) steps at least.
Expected   The same counts within the looks' spacing. Exponent 1/2 in kappa.

Plates of n x n cells with eight neighbours and shared weights, unit mass on every point, left edge
clamped, sheared on the right; relative residual 1e-6 in the Euclidean norm, a look every 10 steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bench.output.figures import COLOURS, new_figure
from msvalidate.springs.dynamics.integrators import LEAPFROG
from msvalidate.springs.dynamics.relax import relax
from msvalidate.springs.dynamics.run import Method, Run
from msvalidate.springs.dynamics.scheme import Integrator
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.dynamics.viscous import viscous

from . import bodies

COUNTED = {8: 240, 16: 440, 32: 830, 64: 1590}
"""Cells along a side -> steps of an independent program, one count of ten steps apart."""
NAME = "dynamic_relaxation"
RESIDUAL = 1e-6
LOOK_EVERY = 10
COUNT = kit.Rule(
    "steps of dynamic relaxation less those of an independent program, worst", LOOK_EVERY, "1",
    "both look every ten steps, and rounding may let one arrive a look later",
    table=NAME, value="steps", reference="independent_steps",
)  # fmt: skip


def judge_growth(table: pd.DataFrame) -> tuple[kit.Tolerance, ...]:
    """Exponents of steps in kappa and of cost in nodes, if all runs arrived."""
    arrived = (table["outcome"] == "reached").all()
    cost = table["steps"] * table["springs"]
    in_kappa, in_nodes = (
        kit.fitted_power(*pair).exponent if arrived else math.nan
        for pair in ((table["kappa"], table["steps"]), (table["nodes"], cost))
    )
    return (
        kit.Tolerance(
            "exponent of the steps of dynamic relaxation in kappa", 0.05, "1",
            "1/2 for one mode; ln of the largest residual's share adds a few per cent on small "
            "plates", observed=kit.Observed(in_kappa, 0.5),
        ),
        kit.Tolerance(
            "exponent of steps x springs of dynamic relaxation in nodes", 0.1, "1",
            "3/2; boundary springs add 0.04 and the clamped edge takes 0.02 at these sizes",
            observed=kit.Observed(in_nodes, 1.5),
        ),
    )  # fmt: skip


def steps_at_best_damping(scheme: Integrator, damping: float, run: Run) -> Iterator[None]:
    """Steps of a viscous scheme; `damping` in units of the critical one of the slowest mode."""
    low, high = run.frequencies
    best = viscous(scheme, dt=2 / math.hypot(low, high), damping=damping * 2 * low)
    yield from best.walk(run)


METHOD = Method(NAME, "dynamic relaxation", partial(steps_at_best_damping, LEAPFROG, 1))
"""Source: [Papadrakakis1981]."""


def run(candidate: Mapping[str, Method], setting: kit.Setting) -> kit.Evidence:
    """Count the steps of the four plates."""
    rows = setting.sweep(partial(count_steps, candidate[NAME]), COUNTED, "dynamic relaxation")
    table = pd.DataFrame(rows)
    return kit.Evidence(
        tables={"dynamic_relaxation": table},
        tolerances=(COUNT, *judge_growth(table)),
        figures={"dynamic_relaxation": draw},
        columns=kit.columns(__file__),
    )


def count_steps(method: Method, n: int) -> dict[str, object]:
    """One plate: steps to the residual, and what was to be expected."""
    network = bodies.network("plate", n)
    network = replace(network, mass=np.ones(len(network.points)))
    low, high = extreme_frequencies(network)
    first = float(np.linalg.norm(network.force[~network.fixed]))
    found: list[int] = []

    def watch(run: Run) -> bool:
        if np.linalg.norm(run.balance()) <= RESIDUAL * first:
            found.append(run.steps)
        return bool(found)

    try:
        relax(network, method, watch=watch, look_every=LOOK_EVERY, frequencies=(low, high))
    except kit.SolverError:
        found.append(0)
    return {
        "cells_x": n,
        "cells_y": n,
        "nodes": len(network.points),
        "springs": len(network.springs),
        "kappa": (high / low) ** 2,
        "outcome": "reached" if found[0] else "failed",
        "steps": found[0],
        "independent_steps": COUNTED[n],
        "least_steps": math.ceil(0.5 * high / low * math.log(1 / RESIDUAL)),
    }


def draw(tables: kit.Tables) -> Figure:
    """Steps against the condition number: counted here, by the other program, and the least."""
    table = tables[NAME]
    kappa, other = table["kappa"], table["independent_steps"]
    figure, (axis,) = new_figure(size=(4.2, 3.2))
    axis.loglog(kappa, other, "s", color=COLOURS[1], ms=8, mfc="none", label="independent program")
    axis.loglog(kappa, table["steps"], "o", color=COLOURS[0], label="this one")
    least = table["least_steps"]
    axis.loglog(kappa, least, ":", color="black", label="from the spectral radius alone")
    axis.set(xlabel="condition number κ (1)", ylabel="steps to a residual of 1e-6 (1)")
    figure.suptitle("Dynamic relaxation of clamped plates")
    axis.legend()
    return figure
