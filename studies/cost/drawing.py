"""Figures of the study, as functions of its tables."""

from __future__ import annotations

from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.bench.judging.counting import TIGHT

from .timing import ABSENT, SINGLE

C = kit.figures.COLOURS
Style = dict[str, Any]
WAYS: dict[str, Style] = {
    "general": {"color": C[0], "marker": "o"},
    "general, 2 threads": {"color": C[0], "marker": "o", "ls": "--", "mfc": "none"},
    SINGLE: {"color": C[0], "marker": "o", "ls": "-.", "ms": 3},
    "uniform lattice": {"color": C[2], "marker": "s"},
    "uniform lattice, 2 threads": {"color": C[2], "marker": "s", "ls": "--", "mfc": "none"},
    "NumPy bincount": {"color": C[1], "marker": "^"},
    "SciPy sparse": {"color": C[5], "marker": "v"},
    "LAMMPS": {"color": C[3], "marker": "D"},
}
NETWORKS: dict[str, Style] = {
    "lattice": {"color": C[0], "marker": "o"},
    "lattice with volume energy": {"color": C[1], "marker": "s"},
    "random triangles": {"color": C[2], "marker": "^"},
    "random tetrahedra": {"color": C[3], "marker": "D"},
}
PROGRAMS: dict[str, Style] = {
    "ours": {"color": C[0], "marker": "o"},
    "ours, SuperLU": {"color": C[4], "marker": "s"},
    "ours, multigrid": {"color": C[2], "marker": "P"},
    "spsolve": {"color": C[1], "marker": "^"},
    "NGSolve": {"color": C[3], "marker": "D"},
}
METHODS: dict[str, Style] = {
    "algorithm1": {"color": C[0], "marker": "o", "ls": "--"},
    "viscous_leapfrog": {"color": C[0], "marker": "s"},
    "kinetic_damping": {"color": C[2], "marker": "^"},
    "fire": {"color": C[3], "marker": "D"},
    "adaptive": {"color": C[4], "marker": "v"},
    "conjugate_gradients": {"color": C[5], "marker": "P"},
    "newton": {"color": C[1], "marker": "o"},
    "newton_multigrid": {"color": C[1], "marker": "s", "ls": "--"},
}
LEVELS = {"cache of 256 kB": "0.7", "cache of 4 MB": "0.45", "memory": "0.0"}
"""Where arrays lie -> the grey of what its bandwidth allows."""
DENSE = (0.1, 3.0)
"""Operations a byte from and to which the roofline is drawn."""
PATHS = {
    "general": "general path",
    "general, 2 threads": "general path, 2 threads",
    "uniform lattice, 2 threads": "uniform-lattice path, 2 threads",
    "spsolve": "SciPy, spsolve",
    "uniform lattice": "uniform-lattice path",
    SINGLE: "general path, a step for each pass",
}
NAMES = {
    "algorithm1": "Algorithm 1",
    "fire": "FIRE",
    "adaptive": "adaptive step",
    "newton": "Newton",
    "newton_multigrid": "Newton, multigrid",
}
"""Words for paths and for methods in pictures, where their names are not."""
TASKS = ("assembly", "solution")
MARKS = "os^vDP*"


def lines(
    axis: Axes, table: pd.DataFrame, by: str, x: str, y: str, styles: dict[str, Style]
) -> None:
    """A line for each value of a column, what is absent left out."""
    table = table[table[y] != ABSENT]
    for name, rows in table.groupby(by, sort=False):
        label = PATHS.get(str(name), str(name))
        axis.loglog(rows[x], rows[y].astype(float), label=label, **styles[str(name)])


def kernel(tables: kit.Tables) -> Figure:
    """The lattice by every program, with what memory allows; networks on the general path."""
    table = tables["kernel"]
    figure, (left, right) = kit.figures.new_figure(2, size=(3.4, 4.4), sharey=True)
    lines(left, table[table["network"] == "lattice"], "way", "nodes", "ns_here", WAYS)
    allowed(left, tables)
    lines(right, table[table["way"] == "general"], "network", "nodes", "ns_here", NETWORKS)
    left.set_title("lattice, by every path and program")
    right.set_title("general path, by network")
    figure.suptitle("Time of a spring in a step")
    for axis in (left, right):
        low, high = axis.get_ylim()
        axis.set(xlabel="points (1)", ylim=(min(low, 1.0), max(high, 10.0)))
        axis.tick_params(labelleft=True)
        axis.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.18), fontsize=8)
    left.set_ylabel("time for a spring and step (ns)")
    return figure


def allowed(axis: Axes, tables: kit.Tables) -> None:
    """Draw what the memory's bandwidth allows where each step passes over it, if measured."""
    if "limits" not in tables:
        return
    memory = float(tables["bandwidth"]["gigabytes_per_second"].iloc[-1])
    rows = tables["limits"][tables["limits"]["way"] == SINGLE]
    ns = rows["bytes_a_node"] * rows["nodes"] / rows["springs"] / memory
    axis.loglog(rows["nodes"], ns, ":", color="black", lw=1.1, label="memory, a step for each pass")


def roofline(tables: kit.Tables) -> Figure:
    """Operations a second against operations a byte, below what machine and memory allow."""
    figure, (axis,) = kit.figures.new_figure(size=(5.2, 5.8))
    top = float(tables["arithmetic"]["gigaflops_per_second"].iloc[0])
    speeds = tables["bandwidth"]["gigabytes_per_second"]
    low, high = DENSE
    for (held, grey), speed in zip(LEVELS.items(), speeds, strict=True):
        x = np.array([low, top / speed, high])
        label = f"most from {held}: {speed:.0f} GB/s"
        axis.loglog(x, np.minimum(top, speed * x), color=grey, lw=1.3, label=label)
    axis.axhline(top, color=C[5], ls="--", lw=1.3, label=f"product of matrices: {top:.0f} GFLOP/s")
    for (name, way), part in tables["limits"].groupby(["network", "way"], sort=False):
        style = NETWORKS[str(name)] | {"ls": ":", "lw": 0.8, "ms": 5.5}
        if way != "general":
            style |= {"color": WAYS[str(way)]["color"], "marker": "x" if way == SINGLE else "P"}
        dense = part["operations_a_node"] / part["bytes_a_node"]
        label = f"{name}, {PATHS.get(str(way), way)}"
        axis.loglog(dense, part["gigaflops_per_second"], label=label, **style)
    axis.set(xlabel="operations for each byte moved (1)", ylabel="1e9 operations a second (1/s)")
    axis.set(xlim=DENSE, ylim=(1.0, 2 * top))
    axis.set_title("a mark for each number of points")
    figure.suptitle("Speed of the kernel below what the machine allows")
    kit.figures.add_shared_legend(figure, [axis], columns=1)
    return figure


def real_time(tables: kit.Tables) -> Figure:
    """Seconds of motion that a second makes, against the points."""
    table = tables["real_time"]
    table = table[table["threads"] == 1]
    materials = list(table["material"].unique())
    figure, axes = kit.figures.new_figure(len(materials), size=(2.3, 3.4), sharey=True)
    for axis, name in zip(axes, materials, strict=True):
        lines(axis, table[table["material"] == name], "way", "nodes", "real_time_here", WAYS)
        axis.axhline(1.0, color="black", lw=0.9, ls=":", label="real time")
        axis.set(title=name, xlabel="points (1)")
    axes[0].set_ylabel("seconds of motion a second (1)")
    figure.suptitle("How near to real time a plate of 0.1 m is computed")
    kit.figures.add_shared_legend(figure, axes, columns=4)
    return figure


def elements(tables: kit.Tables) -> Figure:
    """Assembly and solution, plane and solid."""
    table = tables["fem"]
    figure, axes = kit.figures.new_figure(2, 2, size=(3.3, 2.8), sharex="col", sharey="row")
    for axis, (task, dim) in zip(axes, product(TASKS, (2, 3)), strict=True):
        part = table[(table["task"] == task) & (table["axes"] == dim)]
        lines(axis, part, "program", "unknowns", "cpu_seconds", PROGRAMS)
        axis.set_title(f"{task}, {'plane' if dim == 2 else 'solid'}")
        if dim == 2:
            axis.set_ylabel("time on one core (s)")
        if task == TASKS[-1]:
            axis.set_xlabel("unknowns (1)")
    figure.suptitle("Linear finite elements: time by program")
    kit.figures.add_shared_legend(figure, axes, columns=3)
    return figure


def relaxation(tables: kit.Tables) -> Figure:
    """Steps and seconds to an error of 1e-6, the exponents of each method in the legend."""
    table = tables["relaxation"]
    table = table[(table["threshold"] == TIGHT) & (table["outcome"] == "reached")]
    nodes = np.array([table["nodes"].min(), table["nodes"].max()], dtype=float)
    figure, axes = kit.figures.new_figure(2, size=(3.3, 4.4))
    values = {"steps_here": ("steps (1)", 0.5), "cpu_seconds": ("time (s)", 1.5)}
    for axis, (column, (quantity, law)) in zip(axes, values.items(), strict=True):
        for method, rows in table.groupby("method", sort=False):
            name = NAMES.get(str(method), str(method).replace("_", " "))
            name += exponents(tables, str(method))
            axis.loglog(rows["nodes"], rows[column], label=name, **METHODS[str(method)])
        low, high = axis.get_ylim()  # the expected power, in the lower half of the picture
        power = low * (high / low) ** 0.25 * (nodes / nodes[0]) ** law
        axis.loglog(nodes, power, ":", color="black", label="powers 0.5 and 1.5 of the points")
        axis.set(xlabel="points (1)", ylabel=quantity, title="to an error of 1e-6")
    figure.suptitle("Relaxations to rest; in brackets: powers of steps and of seconds")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure


def exponents(tables: kit.Tables, method: str) -> str:
    """Exponents of steps and seconds, in brackets."""
    grown = tables["relaxation_growth"]
    grown = grown[(grown["method"] == method) & (grown["threshold"] == TIGHT)]
    power = grown.set_index("quantity")["exponent_here"]
    if not {"steps", "seconds"} <= set(power.index):
        return ""
    return f" ({power['steps']:.2f}, {power['seconds']:.2f})"


def large(tables: kit.Tables) -> Figure:
    """Newton's method with multigrid and elements on the same cells, in seconds."""
    table = tables["large"]
    figure, (axis,) = kit.figures.new_figure(size=(4.4, 3.4))
    drawn = (
        ("newton_seconds", "s-", C[1], "springs: Newton with multigrid, 1 % strain"),
        ("elements_seconds", "o-", C[0], "elements: one linear solution"),
    )
    for column, mark, colour, label in drawn:
        axis.loglog(table["nodes"], table[column], mark, color=colour, label=label)
    axis.set(xlabel="points (1)", ylabel="time on one core (s)")
    axis.legend(fontsize=8)
    figure.suptitle("Large bodies at rest: springs beside elements")
    return figure


def equilibria(tables: kit.Tables) -> Figure:
    """Every body as the package solves it; and the cube by all programs, where that was asked."""
    drawn = [(tables["equilibria"], "shape", "-", "springs, as chosen")]
    if (beside := tables.get("equilibrium_peers")) is not None:
        there = (beside["shape"] == "cube") & (beside["cpu_seconds"] != ABSENT)
        drawn.append((beside[there], "by", "--", "the cube by all programs"))
    figure, axes = kit.figures.new_figure(len(drawn), size=(3.3, 4.4), sharey=True)
    for axis, (table, by, line, title) in zip(axes, drawn, strict=True):
        for place, (name, rows) in enumerate(table.groupby(by, sort=False)):
            mark, colour = MARKS[place % len(MARKS)], C[place % len(C)]
            seconds = rows["cpu_seconds"].astype(float)
            axis.loglog(rows["points"], seconds, f"{mark}{line}", color=colour, label=str(name))
        axis.set(title=title, xlabel="points (1)")
        axis.legend(loc="upper left", bbox_to_anchor=(-0.1, -0.18), fontsize=8)
    axes[0].set_ylabel("time on one core (s)")
    figure.suptitle("Equilibria: time by body and by program")
    return figure
