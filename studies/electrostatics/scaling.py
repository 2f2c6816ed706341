"""Scaling: how does time grow with the number of segments?

Question   Seconds to set up and to solve the equations, and to find forces.
Candidate  Forces; charges by the method of moments, `Moments`.
Reference  None: seconds belong to the machine and are held to nothing. What the charges are worth,
           `strips` and `virtual_work` ask.
Expected   Integrals grow with the square of the number, the factor with its cube.
"""

from __future__ import annotations

import time

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges import Moments
from msvalidate.dielectric.charges.moments import coefficients

from .common import VOLTAGES, ChargeSolver, pair

SEGMENTS = (250, 500, 1000, 2000)
QUICK_SEGMENTS = (250, 500)
"""Of each electrode."""
WIDTH = 6.0


def run(candidate: ChargeSolver, setting: kit.Setting) -> kit.Evidence:
    """Time one size after another, whatever the workers."""
    sizes = QUICK_SEGMENTS if setting.quick else SEGMENTS
    time_solution(candidate, sizes[0])  # compiles
    times = pd.DataFrame([time_solution(candidate, n) for n in sizes])
    return kit.Evidence(
        tables={"scaling": times},
        figures={"scaling": draw},
        columns=kit.columns(__file__),
        findings=(finding(times),),
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
    return {
        "segments": segments,
        "unknowns": len(electrodes.segments),
        "integrals_seconds": integrals,
        "factor_seconds": factor,
        "charges_seconds": charges,
        "forces_seconds": forces,
    }


def finding(times: pd.DataFrame) -> str:
    """Seconds of the largest."""
    last = times.iloc[-1]
    return (
        f"{last['unknowns']:.0f} charges took {last['integrals_seconds']:.2g} s to integrate, "
        f"{last['factor_seconds']:.2g} s with their factor, {last['forces_seconds']:.2g} s for "
        "forces, here."
    )


def draw(tables: kit.Tables) -> Figure:
    """Seconds against charges."""
    times = tables["scaling"]
    figure, (seconds,) = kit.figures.new_figure(size=(4.5, 4.0))
    drawn = {
        "integrals_seconds": "integrals",
        "factor_seconds": "integrals and factor",
        "forces_seconds": "forces",
        "charges_seconds": "charges by factor",
    }
    for place, (column, name) in enumerate(drawn.items()):
        style = kit.figures.series_style(place)
        seconds.loglog(times["unknowns"], times[column].astype(float), label=name, **style)
    n = np.array([times["unknowns"].min(), times["unknowns"].max()])
    square = times["integrals_seconds"].max() * (n / n[-1]) ** 2 / 2
    seconds.loglog(n, square, ":", color="grey", label="square of the number")
    kit.figures.tick_at(seconds, times["unknowns"])
    seconds.set(xlabel="charges (1)", ylabel="time on this machine (s)")
    figure.suptitle("What charges cost")
    kit.figures.add_shared_legend(figure, [seconds], columns=2)
    return figure
