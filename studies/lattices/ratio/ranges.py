"""Figure of the ranges of Poisson's ratio that lattices reach, by each route."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from msvalidate.constants.routes import ROUTES
from msvalidate.judging.evidence import Tables
from msvalidate.output import figures


def draw(tables: Tables) -> Figure:
    """Ranges of the ratio as bars, a row for each lattice and route."""
    table = tables["routes"]
    figure, (axis,) = figures.new_figure(size=(5.2, 0.27 * len(table) + 1.3))
    names = list(dict.fromkeys(table["lattice"]))
    for place, (_, row) in enumerate(table.iterrows()):
        y = place + 0.6 * names.index(row["lattice"])
        colour = figures.COLOURS[list(ROUTES).index(row["route"])]
        low, high = row["nu_from"], row["nu_to"]
        label = row["route"] if place < len(ROUTES) else None
        if low == high:
            axis.plot([low], [y], "D", color=colour, label=label)
        else:
            axis.barh(y, high - low, left=low, color=colour, height=0.75, label=label)
        axis.text(
            high + (0.02 if low < high else 0.05),
            y,
            f"{low:.3g} to {high:.3g}" if low < high else f"{low:.3g}",
            va="center",
            fontsize=7,
        )
    middle = [
        np.mean([i for i, name in enumerate(table["lattice"]) if name == own]) + 0.6 * number
        for number, own in enumerate(names)
    ]
    axis.set_yticks(middle, names)
    axis.set(xlim=(-1.05, 1.6), xlabel="Poisson's ratio along the lattice's axes (1)")
    axis.set_ylabel("lattice")
    figure.suptitle("Ranges of Poisson's ratio by each route")
    axis.invert_yaxis()
    axis.grid(visible=False, axis="y")
    figures.add_shared_legend(figure, [axis], columns=3)
    return figure
