"""Figures of the question `limits`: the roofline, and real time."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

from .kernel_drawing import NETWORK_STYLES, STYLES
from .timing import SINGLE

LEVELS = ("256 kB", "4 MB", "memory")


def roofline(tables: Tables) -> Figure:
    """Operations a second against operations a byte, below what machine and memory allow."""
    figure, (axis,) = figures.new(size=(5.2, 4.0))
    top = float(tables["arithmetic"]["gigaflops_per_second"].iloc[0])
    speeds = tables["bandwidth"]["gigabytes_per_second"]
    for level, speed, grey in zip(LEVELS, speeds, ("0.65", "0.45", "0.0"), strict=True):
        label = f"{level}: {speed:.0f} GB/s"
        x = np.array([0.05, top / speed, 10.0])
        axis.loglog(x, np.minimum(top, speed * x), color=grey, lw=1.1, label=label)
    axis.annotate(
        f"product of matrices, {top:.0f} GFLOP/s",
        (10, top),
        (0, 3),
        fontsize=7,
        textcoords="offset points",
        ha="right",
    )
    for (name, way), part in tables["limits"].groupby(["network", "way"], sort=False):
        style = NETWORK_STYLES[str(name)]
        if way != "general":
            marker = "x" if way == SINGLE else "P"
            style = style | {"color": STYLES[str(way)]["color"], "marker": marker}
        axis.loglog(
            part["operations_a_node"] / part["bytes_a_node"],
            part["gigaflops_per_second"],
            ls="",
            label=f"{name}, {way}",
            **style,
        )
    axis.set(xlabel="operations a byte counted (1)", ylabel="GFLOP/s on one core")
    axis.set_ylim(0.3, 3 * top)
    figures.shared_legend(figure, [axis], columns=2)
    return figure


def real_time(tables: Tables) -> Figure:
    """Seconds of motion that a second makes, against the points."""
    table = tables["real_time"]
    table = table[table["threads"] == 1]
    names = list(table["material"].unique())
    figure, axes = figures.new(len(names), size=(3.2, 3.2), sharey=True)
    for axis, name in zip(axes, names, strict=True):
        for way, rows in table[table["material"] == name].groupby("way", sort=False):
            axis.loglog(rows["nodes"], rows["real_time_here"], label=str(way), **STYLES[str(way)])
        axis.axhline(1.0, color="black", lw=0.9, ls=":", label="real time")
        axis.set_title(name, fontsize=9)
        axis.set_xlabel("points of a plate of 0.1 m")
    axes[0].set_ylabel("seconds of motion a second (1)")
    figures.shared_legend(figure, axes, columns=4)
    return figure
