"""The figure of `virtual_work`."""

from __future__ import annotations

from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.dielectric.charges.moments import WEIGHTINGS


def draw(tables: kit.Tables) -> Figure:
    """Errors of forces against differences of the energy, and against the closed form."""
    table, flat = tables["virtual_work"], tables["flat_strips"]
    figure, (points, closed) = kit.figures.new_figure(2, size=(3.5, 3.6))
    pairs = table.groupby(["shape", "weighting"], sort=False)
    for place, ((shape, weighting), rows) in enumerate(pairs):
        name, style = f"{_called(weighting)}, {shape}", kit.figures.series_style(place)
        points.loglog(rows["segments"], rows["force_error"], label=name, **style)
    kit.figures.tick_at(points, table["segments"])
    points.set_title("point by point,\nagainst differences of energy")
    points.set_ylabel("error over largest force (1)")
    for place, weighting in enumerate(WEIGHTINGS):
        rows = flat[flat["weighting"] == weighting]
        pull, stretch = rows["pull_error"].abs(), rows["stretch_error"].abs()
        style = kit.figures.series_style(place) | {"ls": "", "mfc": "none"}
        closed.loglog(
            rows["segments"], pull, color=style["color"], label=f"{_called(weighting)}, pull"
        )
        closed.loglog(rows["segments"], stretch, label=f"{_called(weighting)}, stretch", **style)
    kit.figures.draw_order(closed, flat["segments"], 2 * flat["stretch_error"].abs().max(), 2)
    kit.figures.tick_at(closed, flat["segments"])
    closed.set(title="flat strips,\nagainst the closed form", ylabel="relative error (1)")
    for axis in (points, closed):
        axis.set_xlabel("segments of each\nelectrode (1)")
        axis.legend(fontsize=8)
    figure.suptitle("Error of electric forces")
    return figure


def _called(weighting: object) -> str:
    return str(weighting).replace("galerkin", "Galerkin")
