"""Figure of the solvers: seconds of an equilibrium against the points, beside peers."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

from .timing import ABSENT

C = figures.COLOURS
MARKS = "os^vDP*"


def draw(tables: Tables) -> Figure:
    """Every body as the package solves it; and the cube by all programs, where that was asked."""
    beside = tables.get("equilibrium_peers")
    figure, axes = figures.new(1 if beside is None else 2, size=(4.0, 3.4))
    table = tables["equilibria"]
    for place, (body, rows) in enumerate(table.groupby("shape", sort=False)):
        axes[0].loglog(
            rows["points"],
            rows["cpu_seconds"],
            f"{MARKS[place % len(MARKS)]}-",
            color=C[place % len(C)],
            label=str(body),
        )
    axes[0].set_title("springs, as chosen", fontsize=8)
    if beside is not None:
        there = (beside["shape"] == "cube") & (beside["cpu_seconds"] != ABSENT)
        by_program(axes[1], beside[there])
    for axis in axes:
        axis.set(xlabel="points", ylabel="seconds on one core")
        axis.legend(fontsize=6)
    return figure


def by_program(axis: Any, peers: pd.DataFrame) -> None:
    """The cube, by every program that is there."""
    for place, (program, rows) in enumerate(peers.groupby("by", sort=False)):
        axis.loglog(
            rows["points"],
            rows["cpu_seconds"].astype(float),
            f"{MARKS[place % len(MARKS)]}--",
            color=C[place % len(C)],
            label=str(program),
        )
    axis.set_title("the cube by all programs", fontsize=8)
