"""Figure of the pre-stretched films, as a function of the tables."""

from __future__ import annotations

from matplotlib.figure import Figure

from msvalidate.judging.evidence import Tables
from msvalidate.output import figures

STYLES = {"stretched": "-", "as slender": "--"}
MEASURES = {
    "deflection": "deflection over the middle's (1)",
    "pull": "pull per length over the middle's (1)",
}


def faces(tables: Tables) -> Figure:
    """Deflection and pull along the left half of every film."""
    table = tables["prestretched_faces"]
    films = table[["film", "slenderness", "prestretch"]].drop_duplicates()
    ratios = [round(ratio) for ratio in sorted(films["slenderness"])]
    colours = dict(zip(ratios, figures.COLOURS, strict=False))
    figure, axes = figures.new_figure(2, size=(4.8, 3.4))
    for axis, (measure, label) in zip(axes, MEASURES.items(), strict=True):
        for film, ratio, stretch in films.itertuples(index=False):
            rows = table[(table["film"] == film) & (table["slenderness"] == ratio)]
            left = rows[rows["part"] <= 0.5]
            name = f"stretched by {stretch:g}" if stretch > 1 else "never stretched"
            style = {"ls": STYLES[film], "color": colours[round(ratio)]}
            name = f"{name}, {ratio:.1f} heights long"
            axis.plot(left["part"] * ratio, left[measure], label=name, **style)
        axis.axhspan(0.95, 1.05, color="#e6e6e6", lw=0, zorder=0, label="like the middle")
        axis.set(xlim=(0, 3), ylim=(0.7, 2.1), ylabel=label)
        axis.set_xlabel("distance from the film's end over its height (1)")
    axes[0].set_title("compression")
    axes[1].set_title("force")
    figures.add_shared_legend(figure, axes, columns=3)
    return figure
