"""Figures of random solids and bodies."""

from __future__ import annotations

from functools import partial

from matplotlib.figure import Figure

from msvalidate import kit

from .strewn import STRAIN, Strewn

WORDS = {2: "plane", 3: "space", "blue_noise": "blue noise"}
WORDS |= {rule: f"k ∝ {rule}" for rule in ("1", "1/L", "A/L")}
DRAWN_STRAIN = 0.2
"""At which networks are drawn: their linear answer, large enough to see."""
by_points = partial(kit.series, by="point_set", words=WORDS, size=(2.5, 2.3))
COUNT = "points in the periodic cell (1)"
RATIOS = by_points(
    "random_solids", title="Networks of random points: mean Poisson's ratio", x="count",
    y="nu_mean", labels=(COUNT, "Poisson's ratio (1)"), panel=("axes", "stiffness"), log="x",
    beside={"nu_held": "points held: Cauchy's"},
)  # fmt: skip
SPREAD = by_points(
    "random_solids", title="Networks of random points: scatter of Poisson's ratio", x="count",
    y="nu_std", labels=(COUNT, "st. dev. (1)"), panel=("axes", "stiffness"), log="xy",
    orders=(-0.5,),
)  # fmt: skip
BODIES = by_points(
    "random_bodies", title="Random bodies beside their solids: medians", x="spacings_a_side",
    y="springs_over_solid", panel=("body_load", "stiffness"), rows={"axes": 2}, log="x",
    labels=("spacings to a side (1)", "over solid, less 1 (1)"), level={0.0: "the solid"},
    across=4,
)  # fmt: skip


def drawn(bodies: dict[str, tuple[Strewn, kit.Network, kit.Array]]) -> kit.drawing.Draw:
    """A function that draws bodies by the name of their point set."""

    def draw(_: kit.Tables) -> Figure:
        """Networks of strewn points at rest, in grey, and stretched; the surface is thick."""
        figure, axes = kit.figures.new_figure(len(bodies), size=(2.3, 3), sharex=True, sharey=True)
        strains = {"at rest": (0.0, "#b0b0b0"), "stretched": (DRAWN_STRAIN, kit.figures.COLOURS[0])}
        for axis, (points, (body, network, move)) in zip(axes, bodies.items(), strict=True):
            for name, (strain, colour) in strains.items():
                at = network.points + strain / STRAIN * move
                kit.body_drawing.draw_springs(axis, at, network.springs, name, colour)
                for side in ("left", "right", "bottom", "top"):
                    axis.plot(*at[body.surface(side)].T, lw=1.8, color=colour)
            axis.set(aspect="equal", title=WORDS.get(points, points), xlabel="x (spacings)")
        axes[0].set_ylabel("y (spacings)")
        figure.suptitle(f"Networks of random points stretched along x by {100 * DRAWN_STRAIN:g} %")
        kit.figures.add_shared_legend(figure, axes, columns=2)
        return figure

    return draw
