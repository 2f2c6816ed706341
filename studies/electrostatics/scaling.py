"""Scaling: how do time and iterations grow with the number of segments?

Question   Seconds to set up and to solve the equations; GMRES steps after the surface has moved.
Candidate  Charges after a motion, by default `Moments.moved`, which solves by GMRES with the old
           factor. Dense `Moments`, and `Multipole` where its optional library is installed, are
           timed beside each other.
Reference  A new factor at the new places.
Expected   Integrals grow with the square of the number, the factor with its cube. After small
           motions the old factor is nearly the inverse: each step gains by the relative change of
           the equations, so steps depend on the motion over the gap, hardly on the number. Seconds
           belong to the machine and are held to nothing, and the table `scaling` holds nothing
           else: what its charges are worth, `strips` and `virtual_work` ask.
"""

from __future__ import annotations

import math
import time

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.dielectric.charges import Moments
from msvalidate.dielectric.charges.moments import coefficients
from msvalidate.dielectric.charges.multipole import Multipole
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.output import figures
from msvalidate.problem import Array, ProblemError

from . import common
from .common import VOLTAGES, ChargeSolver, pair

SEGMENTS = (250, 500, 1000, 2000)
QUICK_SEGMENTS = (250, 500)
"""Of each electrode."""
ABSENT = "absent"
"""In the place of a number: an optional library is not installed."""
MOVED, QUICK_MOVED = (800, 1600), (800,)
"""The same of those that move: below 1,500 charges a new factor costs less, and is made."""
MOTIONS = (0.001, 0.01, 0.1)
"""Largest displacement over the gap."""
WIDTH = 6.0
TOLERANCES = (
    Tolerance(
        "charges by iterations after a motion, farthest from those by a new factor",
        1e-9, "of the largest",
        "a residual of 1e-12 times the condition of the graded equations",
    ),
    Tolerance(
        "GMRES steps after a motion by a hundredth of the gap, most", 12, "1",
        "each step gains the relative change of the equations, a tenth at most where segments "
        "turn: twelve for twelve digits",
    ),
)  # fmt: skip
COLUMNS = {
    **common.COLUMNS,
    "unknowns": "charges of both electrodes (1)",
    "integrals_seconds": "to integrate all pairs of segments (s)",
    "factor_seconds": "to set up and factorise the equations, integrals included (s)",
    "charges_seconds": "to find charges with the factor (s)",
    "forces_seconds": "to find forces (s)",
    "multipole_seconds": 'to set up and find charges by fast multipoles (s), or "absent" where '
    "their library is not installed",
    "motion_over_gap": "largest displacement of the upper electrode (1)",
    "iterations": "of GMRES with the old factor (1)",
    "iterated_error": "farthest charge from that by a new factor, over the largest (1)",
    "iterated_seconds": "to set up and find charges with the old factor (s)",
}


def run(candidate: ChargeSolver, setting: Setting) -> Evidence:
    """Time and count, one after another whatever the workers."""
    sizes = QUICK_SEGMENTS if setting.quick else SEGMENTS
    time_solution(candidate, sizes[0])  # compiles
    times = pd.DataFrame([time_solution(candidate, n) for n in sizes])
    larger = QUICK_MOVED if setting.quick else MOVED
    moves = pd.DataFrame([row for n in larger for row in moved(candidate, n)])
    small = moves[moves["motion_over_gap"] == MOTIONS[1]]["iterations"]
    # No steps at all would be those of a new factor, of which nothing is asked here.
    steps = float(small.max()) if (moves["iterations"] > 0).all() else math.nan
    values = farthest_value(moves["iterated_error"], 0.0), Observed(steps)
    return Evidence(
        tables={"scaling": times, "motions": moves},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"scaling": draw},
        columns=COLUMNS,
        findings=(finding(times, moves),),
        rounding={"iterations": 1.0, "iterated_error": 1e-9},
    )


def time_solution(candidate: ChargeSolver, segments: int) -> dict[str, object]:
    """Row of one size, each act once."""
    electrodes = pair("wavy", WIDTH, segments)
    clock = [time.perf_counter()]

    def lap() -> float:
        clock.append(time.perf_counter())
        return clock[-1] - clock[-2]

    coefficients(electrodes, 1.0, "galerkin")
    integrals = lap()
    moments = Moments(electrodes)
    factor = lap()
    found = moments.charges(VOLTAGES)
    charges = lap()
    candidate.forces(found)
    forces = lap()
    try:
        Multipole(electrodes).charges(VOLTAGES)
        multipole: float | str = lap()
    except ProblemError:  # the library is not installed
        multipole = ABSENT
    return {
        "segments": segments,
        "unknowns": len(electrodes.segments),
        "integrals_seconds": integrals,
        "factor_seconds": factor,
        "charges_seconds": charges,
        "forces_seconds": forces,
        "multipole_seconds": multipole,
    }


def moved(candidate: ChargeSolver, segments: int) -> list[dict[str, object]]:
    """Rows of one size: charges after motions, by the old factor and by a new one."""
    electrodes = pair("flat", WIDTH, segments)
    moments = Moments(electrodes)
    rows: list[dict[str, object]] = []
    for motion in MOTIONS:
        points = dent_strip(electrodes.points, motion)
        start = time.perf_counter()
        found = candidate.moved(moments, points)
        seconds = time.perf_counter() - start
        exact = candidate.charges(electrodes.moved(points)).charge
        rows.append(
            {
                "segments": segments,
                "unknowns": len(electrodes.segments),
                "motion_over_gap": motion,
                "iterations": found.iterations,
                "iterated_error": float(np.abs(found.charge - exact).max() / np.abs(exact).max()),
                "iterated_seconds": seconds,
            }
        )
    return rows


def dent_strip(points: Array, motion: float) -> Array:
    """Points with the upper strip lowered in waves, its edges too."""
    upper = points[:, 1] > 0.5
    x = points[:, 0] / WIDTH
    down = motion * np.where(upper, 0.5 + 0.5 * np.cos(3 * np.pi * x + 0.3), 0.0)
    return points - np.column_stack([np.zeros_like(down), down])


def finding(times: pd.DataFrame, moves: pd.DataFrame) -> str:
    """Seconds of the largest, and steps."""
    last = times.iloc[-1]
    steps = ", ".join(
        f"{motion:g}: {rows['iterations'].max()}"
        for motion, rows in moves.groupby("motion_over_gap", sort=False)
    )
    return (
        f"{last['unknowns']:.0f} charges took {last['integrals_seconds']:.2g} s to integrate, "
        f"{last['factor_seconds']:.2g} s with their factor, {last['forces_seconds']:.2g} s for "
        f"forces, here. GMRES steps with the old factor after motions over the gap of {steps}."
    )


def draw(tables: Tables) -> Figure:
    """Seconds against charges, and steps against motion."""
    times, moves = tables["scaling"], tables["motions"]
    figure, (seconds, steps) = figures.new_figure(2, size=(3.5, 4.0))
    drawn = {
        "integrals_seconds": "integrals",
        "factor_seconds": "integrals and factor",
        "forces_seconds": "forces",
        "charges_seconds": "charges by factor",
    }
    if not (times["multipole_seconds"] == ABSENT).any():
        drawn["multipole_seconds"] = "charges by multipoles"
    for place, (column, name) in enumerate(drawn.items()):
        style = figures.series_style(place)
        seconds.loglog(times["unknowns"], times[column].astype(float), label=name, **style)
    n = np.array([times["unknowns"].min(), times["unknowns"].max()])
    square = times["integrals_seconds"].max() * (n / n[-1]) ** 2 / 2
    seconds.loglog(n, square, ":", color="grey", label="square of the number")
    figures.tick_at(seconds, times["unknowns"])
    seconds.set(xlabel="charges (1)", ylabel="time on this machine (s)")
    figure.suptitle("What charges cost: anew, and after a small motion")
    for place, (unknowns, rows) in enumerate(moves.groupby("unknowns", sort=False)):
        style, label = figures.series_style(place + 4), f"{unknowns} charges, steps"
        style |= {"mfc": "none", "ms": 9} if place == 0 else {}  # others lie on it
        steps.semilogx(rows["motion_over_gap"], rows["iterations"], label=label, **style)
    figures.tick_at(steps, moves["motion_over_gap"])
    steps.set(xlabel="largest displacement\nover the gap (1)", ylim=(0, None))
    steps.set_ylabel("GMRES steps with\nthe old factor (1)")
    figures.add_shared_legend(figure, [seconds, steps], columns=2)
    return figure
