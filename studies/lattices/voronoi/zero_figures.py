"""Figure of what may have made the report's ratio zero, as a function of the tables."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.lattice import STIFFNESS_RULES
from msvalidate.output import figures


def causes(tables: Tables) -> Figure:
    """Ratio against jitter, number of points, length and the time of stopping."""
    figure, axes = figures.new_figure(2, 2, size=(3.4, 3.1), sharey=True)
    _jitter(axes[0], tables["zero_jitter"])
    _few(axes[1], tables["zero_few"])
    _length(axes[2], tables["zero_length"])
    _early(axes[3], tables["zero_early"])
    for axis in axes:
        axis.axhline(0, color="black", lw=0.8)
        axis.set_ylim(-0.08, 0.95)  # legends above
    axes[0].set_ylabel("Poisson's ratio (1)")
    axes[2].set_ylabel("Poisson's ratio, the report's means (1)")
    figure.suptitle("What may have made the report's Poisson's ratio zero")
    return figure


def _jitter(axis: Axes, table: pd.DataFrame) -> None:
    floor = 1e-7  # where the grid itself is drawn: a logarithmic axis has no 0
    for i, rule in enumerate(STIFFNESS_RULES):
        rows = table[table["stiffness"] == rule]
        place = np.maximum(rows["jitter"], floor)
        style = {"marker": figures.MARKERS[i], "color": figures.COLOURS[i]}
        grid = rows["jitter"] == 0
        # Not joined: of equal springs the ratio jumps at 0.
        axis.semilogx(place[grid], rows["nu_endless"][grid], ls="none", **style)
        axis.semilogx(place[~grid], rows["nu_endless"][~grid], label=f"k ∝ {rule}", **style)
    axis.set_xticks([floor, 1e-6, 1e-4, 1e-2], ["0", "1e-6", "1e-4", "0.01"])
    axis.set(title="nearly square grids, endless", xlabel="jitter (spacings)")
    axis.legend(fontsize=7)


def _few(axis: Axes, table: pd.DataFrame) -> None:
    kinds = [("slide", "A/L"), ("slide", "1"), ("clamped", "1")]
    for i, (ends, rule) in enumerate(kinds):
        rows = table[(table["ends"] == ends) & (table["stiffness"] == rule)]
        axis.errorbar(
            rows["count"] * 1.06 ** (i - 1),
            rows["nu_means"],
            rows["nu_means_scatter"],
            marker=figures.MARKERS[i],
            color=figures.COLOURS[i],
            capsize=3,
            elinewidth=0.8,
            label=f"k ∝ {rule}, ends {'slide' if ends == 'slide' else 'clamped'}",
        )
    axis.set_xscale("log")
    counts = sorted(set(table["count"]))
    axis.set_xticks(counts, [str(count) for count in counts])
    axis.set(title="random points, median and quartiles", xlabel="points in the body (1)")
    axis.legend(fontsize=7, loc="upper left")


def _length(axis: Axes, table: pd.DataFrame) -> None:
    for i, (place, rows) in enumerate(table.groupby("place", sort=False)):
        colour = figures.COLOURS[i]
        axis.errorbar(
            rows["aspect"],
            rows["nu_means"],
            rows["nu_means_scatter"],
            fmt=figures.MARKERS[i],
            color=colour,
            capsize=3,
            elinewidth=0.8,
            label=f"springs, {place}",
        )
        axis.plot(
            rows["aspect"], rows["nu_elastic"], "--", color=colour, label=f"elements, {place}"
        )
    axis.set_xscale("log", base=2)
    aspects = sorted(set(table["aspect"]))
    axis.set_xticks(aspects, [f"{aspect:g}" for aspect in aspects])
    axis.set_title("clamped, k ∝ 1: width measured at")
    axis.set_xlabel("length over height (1)")
    axis.legend(fontsize=7, ncols=2, loc="upper left")


def _early(axis: Axes, table: pd.DataFrame) -> None:
    kinds = table.groupby(["ends_by", "damping_factor"], sort=False)
    colours = dict(zip(sorted(set(table["damping_factor"])), figures.COLOURS, strict=False))
    for i, ((load, damping), rows) in enumerate(kinds):
        axis.plot(
            np.arange(len(rows)),
            rows["nu_means"],
            "-" if load == "moved" else ":",
            marker=figures.MARKERS[i],
            color=colours[damping],
            mfc=None if load == "moved" else "white",
            label=f"{load}, {damping} ×",
        )
    stops = list(dict.fromkeys(table["stop"]))
    axis.set_xticks(range(len(stops)), [str(stop) for stop in stops])
    axis.set_title("Algorithm 1 stopped early, damping × critical")
    axis.set_xlabel("velocity at the stop over its peak (1)")
    axis.legend(fontsize=7, ncols=2, loc="upper center")
