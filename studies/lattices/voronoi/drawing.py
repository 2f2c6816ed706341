"""Figures of the random solids, as functions of the tables."""

from __future__ import annotations

import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate.constants.stiffness import CAUCHY
from msvalidate.judging.evidence import Tables
from msvalidate.lattice import STIFFNESS_RULES
from msvalidate.lattice.point_sets import POINT_SETS
from msvalidate.output import figures

LINES = ("-", "--", ":")
SPACES = {2: "plane", 3: "space"}
APART = 1.03
"""Factor between the places of bodies of one spacing."""
DRAWN_STRAIN = 0.2
"""At which networks are drawn: their linear answer, large enough to see."""


def ratios(tables: Tables) -> Figure:
    """Poisson's ratio by rule and point set at the largest size, with its scatter over networks."""
    table = tables["random_solids"]
    figure, axes = figures.new_figure(2, size=(3.3, 3.4), sharey=True)
    for axis, (dim, cauchy) in zip(axes, CAUCHY.items(), strict=True):
        rows = table[table["axes"] == dim]
        rows = rows[rows["count"] == rows["count"].max()]
        for i, points in enumerate(POINT_SETS):
            same = (
                rows[rows["point_set"] == points].set_index("stiffness").loc[list(STIFFNESS_RULES)]
            )
            place = np.arange(len(same)) + 0.18 * (i - 1)
            colour = figures.COLOURS[i]
            axis.errorbar(
                place,
                same["nu_mean"],
                same["nu_std"],
                fmt=figures.MARKERS[i],
                color=colour,
                elinewidth=1,
                capsize=4,
                label=f"{points.replace('_', ' ')} points",
            )
        axis.axhline(cauchy, color="grey", ls="--", label="points held: Cauchy's 1/3, 1/4")
        count, seeds = rows["count"].iloc[0], rows["seeds"].iloc[0]
        axis.set_title(f"{SPACES[dim]}, {count} points, {seeds} networks")
        axis.set_xticks(range(3), [f"k ∝ {rule}" for rule in STIFFNESS_RULES])
        axis.set_xlim(-0.5, 2.5)
        axis.set_xlabel("stiffness of a spring")
    axes[0].set_ylabel("Poisson's ratio, ± 1 st. dev. (1)")
    figure.suptitle("Networks of random points: Poisson's ratio")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure


def spread(tables: Tables) -> Figure:
    """Standard deviation of the ratio over networks against the number of points."""
    table = tables["random_solids"]
    figure, axes = figures.new_figure(2, size=(3.3, 3.6), sharey=True)
    for axis, dim in zip(axes, CAUCHY, strict=True):
        rows = table[table["axes"] == dim]
        for i, points in enumerate(POINT_SETS):
            for line, rule in zip(LINES, STIFFNESS_RULES, strict=True):
                same = rows[(rows["point_set"] == points) & (rows["stiffness"] == rule)]
                axis.loglog(
                    same["count"],
                    same["nu_std"],
                    line,
                    marker=figures.MARKERS[i],
                    color=figures.COLOURS[i],
                    label=f"{points.replace('_', ' ')}, k ∝ {rule}",
                )
        counts = np.array(sorted(set(rows["count"])), dtype=float)
        top = 1.4 * rows["nu_std"].max()
        axis.loglog(counts, top * (counts / counts[0]) ** -0.5, color="grey", label="order -1/2")
        axis.set_xticks(counts, [f"{count:.0f}" for count in counts])
        axis.set(title=SPACES[dim], xlabel="points in the periodic cell (1)")
    axes[0].set_ylabel("st. dev. of Poisson's ratio (1)")
    figure.suptitle("Networks of random points: scatter of Poisson's ratio")
    figures.add_shared_legend(figure, axes, columns=3)
    return figure


def bodies(tables: Tables) -> Figure:
    """Difference of random bodies from their solids against the spacing: medians and quartiles."""
    table = tables["random_bodies"]
    table = table[table["axes"] == 2]
    loads = list(dict.fromkeys(table["body_load"]))
    figure, axes = figures.new_figure(
        2, -(-len(loads) // 2), size=(3.3, 2.8), sharex=True, sharey=True
    )
    for axis, load in zip(axes, loads, strict=True):
        rows = table[table["body_load"] == load]
        for i, points in enumerate(POINT_SETS):
            for j, (line, rule) in enumerate(zip(LINES, STIFFNESS_RULES, strict=True)):
                same = rows[(rows["point_set"] == points) & (rows["stiffness"] == rule)]
                if same.empty:
                    continue
                axis.errorbar(
                    # Side by side, for many lie on each other.
                    APART ** (3 * i + j - 4) / same["spacings_a_side"],
                    100 * same["springs_over_solid"],
                    100 * same["scatter"],
                    ls=line,
                    marker=figures.MARKERS[i],
                    color=figures.COLOURS[i],
                    elinewidth=0.7,
                    capsize=2,
                    label=f"{points.replace('_', ' ')}, k ∝ {rule}",
                )
        axis.axhline(0, color="black", lw=0.8)
        cells = sorted(set(rows["spacings_a_side"]))
        axis.set_xscale("log")
        axis.set_xticks([1 / n for n in cells], [f"1/{n}" for n in cells])
        axis.tick_params(labelbottom=True)
        axis.set_title(load)
    for axis in axes[-2:]:
        axis.set_xlabel("spacing over side (1)")
    for axis in axes[::2]:
        axis.set_ylabel("springs - solid (% of the solid)")
    figure.suptitle("Random bodies beside their solids: medians and quartiles")
    figures.add_shared_legend(figure, axes, columns=3)
    return figure


def networks(tables: Tables) -> Figure:
    """Networks of strewn points at rest, in grey, and stretched; the surface is thick."""
    table = tables["random_networks"]
    figure, axes = figures.new_figure(len(POINT_SETS), size=(2.3, 3.4), sharex=True, sharey=True)
    colour = figures.COLOURS[0]
    for axis, points in zip(axes, POINT_SETS, strict=True):
        rows = table[table["point_set"] == points]
        for strain, shade, name in ((0.0, "#b0b0b0", "at rest"), (DRAWN_STRAIN, colour, "")):
            for part, width in (("spring", 0.5), ("surface", 1.8)):
                some = rows[rows["part"] == part]
                start = some[["x", "y"]].to_numpy() + strain * some[["ux", "uy"]].to_numpy()
                move = some[["ux_end", "uy_end"]].to_numpy()
                end = some[["x_end", "y_end"]].to_numpy() + strain * move
                axis.add_collection(
                    LineCollection(
                        list(np.stack([start, end], axis=1)),
                        colors=shade,
                        linewidths=width,
                        label=f"{name or 'stretched'}: {part}" if points == "uniform" else None,
                    )
                )
        axis.set_aspect("equal")
        axis.autoscale_view()
        axis.grid(visible=False)
        axis.set_title(f"{points.replace('_', ' ')} points")
        axis.set_xlabel("x (spacings)")
    axes[0].set_ylabel("y (spacings)")
    figure.suptitle(f"Networks of random points stretched along x by {100 * DRAWN_STRAIN:g} %")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure
