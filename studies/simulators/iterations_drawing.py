"""Figure of the error at rest against iterations, a line for each program and time step."""

from __future__ import annotations

import pandas as pd
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from msvalidate import kit

LINES = (("-", 1.0), ("--", 0.0), (":", 0.5), ("-.", 0.25))
"""Kind of line and how full its marks are, of time steps, the longest first."""


def mix(colour: str, full: float) -> tuple[float, float, float]:
    """A colour on white: none of it at 0, it alone at 1."""
    red, green, blue = (1 - full * (1 - part) for part in to_rgb(colour))
    return red, green, blue


def iterations(tables: kit.Tables) -> Figure:
    """Error over iterations; colour and mark are the program's, the kind of line the step's."""
    table = tables["iterations"]
    numbers = ["iterations", "time_step", "rest_error"]
    table = table.assign(**{name: pd.to_numeric(table[name], errors="coerce") for name in numbers})
    table = table.dropna(subset=numbers)
    figure, axes = kit.figures.new_figure(size=(6.4, 4.4))
    for place, (name, rows) in enumerate(table.groupby("name", sort=False)):
        steps = sorted(rows["time_step"].unique(), reverse=True)
        style = kit.figures.series_style(place)
        for step, (line, full) in zip(steps, LINES, strict=False):
            drawn = rows[rows["time_step"] == step].sort_values("iterations", kind="stable")
            axes[0].loglog(
                drawn["iterations"], drawn["rest_error"], line,
                label=f"{name}, {1e3 * step:g} ms", **style,
                markerfacecolor=mix(style["color"], full),
            )  # fmt: skip
    axes[0].set(xlabel="iterations in a step (1)", ylabel="error over the displacement (1)")
    figure.suptitle("Hanging block: what iterations and steps leave")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
