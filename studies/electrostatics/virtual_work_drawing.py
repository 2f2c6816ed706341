"""The figure of `virtual_work`."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from msvalidate.dielectric.charges.moments import WEIGHTINGS
from msvalidate.judging.evidence import Tables
from msvalidate.output import figures


def draw(tables: Tables) -> Figure:
    """Errors of forces against differences of the energy, and against the closed form."""
    table, flat = tables["virtual_work"], tables["flat_strips"]
    figure, (points, closed) = figures.new(2, size=(3.6, 3.2))
    for place, ((shape, weighting), rows) in enumerate(
        table.groupby(["shape", "weighting"], sort=False)
    ):
        style = {"color": figures.COLOURS[place], "marker": figures.MARKERS[place]}
        name = f"{weighting}, {shape}"
        points.loglog(rows["segments"], rows["force_error"], label=name, **style)
    points.set_xticks(*[sorted(set(table["segments"]))] * 2)
    points.set_title("point by point, against differences of W", fontsize=9)
    points.set_ylabel("error over largest force (1)")
    for place, weighting in enumerate(WEIGHTINGS):
        rows = flat[flat["weighting"] == weighting]
        style = {"color": figures.COLOURS[place]}
        closed.loglog(
            rows["segments"], rows["pull_error"].abs(), **style, label=f"{weighting}, pull"
        )
        closed.loglog(
            rows["segments"],
            rows["stretch_error"].abs(),
            figures.MARKERS[place],
            mfc="none",
            label=f"{weighting}, stretch",
            **style,
        )
    n = np.array([flat["segments"].min(), flat["segments"].max()])
    top = 2 * flat["stretch_error"].abs().max()
    closed.loglog(n, top * (n[0] / n) ** 2, ":", color="grey", label="order 2")
    closed.set_xticks(*[sorted(set(flat["segments"]))] * 2)
    closed.set_title("flat strips against the closed form", fontsize=9)
    closed.set_ylabel("relative error (1)")
    for axis in (points, closed):
        axis.set_xlabel("segments of each electrode (1)")
        axis.legend(fontsize=7)
    return figure
