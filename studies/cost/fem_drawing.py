"""Figure of the question `fem`: seconds of assembly and solution against the unknowns."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

from .timing import ABSENT

C = figures.COLOURS
PROGRAMS: dict[str, dict[str, Any]] = {
    "ours": {"color": C[0], "marker": "o"},
    "ours, SuperLU": {"color": C[4], "marker": "s"},
    "ours, multigrid": {"color": C[2], "marker": "P"},
    "spsolve": {"color": C[1], "marker": "^"},
    "NGSolve": {"color": C[3], "marker": "D"},
}
TASKS = ("assembly", "solution")


def draw(tables: Tables) -> Figure:
    """Assembly and solution, plane and solid."""
    table = tables["fem"]
    table = table[table["cpu_seconds"] != ABSENT]
    figure, axes = figures.new(2, 2, size=(3.8, 2.8), sharex="col", sharey="row")
    for axis, (task, dim) in zip(axes, ((t, d) for t in TASKS for d in (2, 3)), strict=True):
        part = table[(table["task"] == task) & (table["axes"] == dim)]
        for program, rows in part.groupby("program", sort=False):
            seconds = rows["cpu_seconds"].astype(float)
            axis.loglog(rows["unknowns"], seconds, label=str(program), **PROGRAMS[str(program)])
        axis.set_title(f"{task}, {'plane' if dim == 2 else 'solid'}", fontsize=9)
        if dim == 2:
            axis.set_ylabel("seconds on one core")
        if task == TASKS[-1]:
            axis.set_xlabel("unknowns")
    figures.shared_legend(figure, axes, columns=3)
    return figure
