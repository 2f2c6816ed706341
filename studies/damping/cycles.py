"""Cycles: does the energy fall under viscosity?

Question   The energy of a damped body falls. Does the scheme's?
Candidate  Algorithm 1's motion of a plate that is let go, at h·ω = 0.1 of its highest frequency.
Reference  The mean of the energy over one period of the slowest mode never rises, and falls by
           exp(-cT) a period: below critical damping all modes lose energy at the rate c.
Expected   Single steps may rise. The scheme keeps v² + ω²x² - hω²xv without damping, so the energy
           gains (h/2)ω²v² a unit of time where the body is fastest, and viscosity takes c·v²: it
           rises there if c < hω²/2.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.dynamics.integrate import State
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.network import energy
from msvalidate.output import figures
from msvalidate.problem import Array

from . import bodies
from .bodies import MotionSolver

PLATE = ("plate", (3, 3), "across")
RATIOS = (0.001, 0.01, 0.1)
"""Damping over the critical one."""
FINE = 0.1
"""Time step times the highest frequency."""
PERIODS = 2
TOLERANCES = (
    Tolerance(
        "rises of the energy's mean over a period", 0.0, "1",
        "viscosity takes energy out of every mode, at hω <= 0.1 more in a period than the scheme's "
        "own swing gives back",
    ),
    Tolerance(
        "fall of that mean in a period over exp(-cT), from 1", 0.02, "1",
        "the old velocity damps by the part h·c/2 more, 0.1 % of cT here, and in a period that is "
        "the undamped one the swings do not quite average out",
    ),
)  # fmt: skip
COLUMNS = {
    **bodies.COLUMNS,
    "period": "periods of the slowest mode since the start (1)",
    "energy": "springs' and kinetic energy, over that at the start (1)",
    "mean": "mean of it over the period before (1)",
    "single_rises": "steps in which the energy rises",
    "mean_rises": "steps in which its mean over a period rises",
    "c_over_swing": "damping over hω²/2 of the slowest mode (1)",
    "fall": "mean over a period, over that a period before (1)",
    "fall_predicted": "exp(-cT) (1)",
}


def run(candidate: MotionSolver, setting: Setting) -> Evidence:
    """Let the plate go at two dampings."""
    found = [watch_run(candidate, ratio) for ratio in RATIOS]
    table = pd.DataFrame([row for row, _ in found])
    values = (
        Observed(float(table["mean_rises"].sum())),
        farthest_value(table["fall"] / table["fall_predicted"], 1.0),
    )
    return Evidence(
        tables={"cycles": table, "energy": found[0][1]},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"energy": draw},
        columns=COLUMNS,
        findings=(finding(table),),
    )


def watch_run(candidate: MotionSolver, ratio: float) -> tuple[dict[str, object], pd.DataFrame]:
    """One row, and the energy against time."""
    body = bodies.loaded(*PLATE)
    network, omega = body.unloaded, float(body.frequencies[0])
    damping = 2 * ratio * omega
    cycle = int(np.ceil(2 * np.pi / omega * body.frequencies[-1] / FINE))
    dt = 2 * np.pi / omega / cycle
    state = State(network.points + body.rest, np.zeros_like(body.rest))
    energies = [energy(network, state.position)]
    for _ in range(PERIODS * cycle):
        state = candidate(network, state, dt, 1, damping)
        kinetic = 0.5 * body.norm(state.velocity) ** 2
        energies.append(energy(network, state.position) + kinetic)
    told = np.array(energies) / energies[0]
    means = np.convolve(told, np.full(cycle, 1 / cycle), mode="valid")
    row = {
        "body": body.name,
        "c_over_critical": ratio,
        "dt_omega": dt * omega,
        "c_over_swing": 2 * damping / (dt * omega**2),
        "steps": PERIODS * cycle,
        "single_rises": count_rises(told),
        "mean_rises": count_rises(means),
        "fall": float(means[cycle] / means[0]),
        "fall_predicted": float(np.exp(-damping * cycle * dt)),
    }
    at = np.arange(cycle - 1, len(told), max(1, cycle // 60))
    return row, pd.DataFrame(
        {"period": at / cycle, "energy": told[at], "mean": means[at - cycle + 1]}
    )


def count_rises(values: Array) -> int:
    """Steps in which a quantity rises by more than rounding."""
    return int((np.diff(values) > 1e-9 * values[:-1]).sum())


def finding(table: pd.DataFrame) -> str:
    """Whether the energy falls."""
    return (
        f"The energy's mean over a period rises in {table['mean_rises'].sum()} steps at any "
        f"damping; the energy itself rises in {table['single_rises'].iloc[0]} of "
        f"{table['steps'].iloc[0]} steps at {RATIOS[0]:g} of critical damping, where c is "
        f"{table['c_over_swing'].iloc[0]:.2g} of hω²/2, and in "
        f"{table['single_rises'].iloc[-1]} at {RATIOS[-1]:g}."
    )


def draw(tables: Tables) -> Figure:
    """Energy and its mean over a period."""
    table = tables["energy"]
    figure, (axis,) = figures.new_figure(size=(4.2, 3.2))
    axis.plot(table["period"], table["energy"], color=figures.COLOURS[0], label="energy")
    axis.plot(table["period"], table["mean"], color=figures.COLOURS[1], label="mean over a period")
    axis.set(
        title=f"Energy in the second period, c = {RATIOS[0]:g} of critical",
        xlabel="time over the slowest mode's period (1)",
    )
    axis.set_ylabel("energy over that at the start (1)")
    axis.legend()
    return figure
