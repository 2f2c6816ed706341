"""Figure of the pre-stretched films, as a function of the tables."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from msvalidate import kit

MEASURES = {
    "deflection": "deflection over the middle's (1)",
    "pull": "pull per length over the middle's (1)",
}


def faces(tables: kit.Tables) -> Figure:
    """Deflection and pull along the left half of every film."""
    table = tables["prestretched_faces"]
    films = table[["film", "slenderness", "prestretch"]].drop_duplicates()
    ratios = sorted({round(ratio) for ratio in films["slenderness"]})
    colours = dict(zip(ratios, kit.figures.COLOURS, strict=False))
    markers = dict(zip(ratios, kit.figures.MARKERS, strict=False))
    figure, axes = kit.figures.new_figure(2, size=(3.6, 3.9), sharex=True, sharey=True)
    for axis, (measure, label) in zip(axes, MEASURES.items(), strict=True):
        for film, ratio, stretch in films.itertuples(index=False):
            rows = table[(table["film"] == film) & (table["slenderness"] == ratio)]
            left = rows[rows["part"] <= 0.5]
            name = f"stretched by {stretch:g}" if stretch > 1 else "never stretched"
            style: dict[str, Any] = {"color": colours[round(ratio)]}
            if (
                film != "stretched"
            ):  # all of these lie on one line: markers of one on those of others
                open_marker = {"marker": markers[round(ratio)], "mfc": "none"}
                style |= {"ls": "", "ms": 3 + 2.5 * ratios.index(round(ratio)), **open_marker}
            name = f"{name}, {ratio:.1f} heights long"
            axis.plot(left["part"] * ratio, left[measure], label=name, **style)
        axis.axhspan(
            0.95, 1.05, color="#e6e6e6", lw=0, zorder=0, label="like the middle: within 5 %"
        )
        axis.set(xlim=(-0.05, 3), ylim=(0.7, 2.1), ylabel=label)
        axis.set_xlabel("distance from the film's\nend over its height (1)")
    axes[0].set_title("compression")
    axes[1].set_title("force")
    figure.suptitle("How far the end of a film reaches, stretched before or not")
    kit.figures.add_shared_legend(figure, axes, columns=2)
    return figure
