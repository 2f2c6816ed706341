"""Springs of a case that break while its loads are raised: how, their files, picture and words."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate.bench.output.body_drawing import body_axes
from msvalidate.bench.output.figures import COLOURS
from msvalidate.problem import AXES, Array, ProblemError
from msvalidate.problem.checks import positive_number, require_one_of
from msvalidate.problem.records import dataclass
from msvalidate.springs.bodies.toughness import RULES
from msvalidate.springs.statics.breaking import FractureResult

SMALL = 0.05
"""Stretch up to which small displacements are said to do."""
MOST_BREAKS = 1000
"""Events after which a case stops."""


@dataclass(frozen=True)
class Fracture:
    """When springs of a case break, and how far its loads are raised.

    Parameters
    ----------
    critical_stretch, G_c
        One of them: elongation over rest length, or fracture energy (J/m²).
    rule, direction
        Of `G_c`, as in `springs.bodies.toughness.critical_stretch`.
    raised
        Factor of the loads and prescribed displacements.
    """

    critical_stretch: float | None = None
    G_c: float | None = None
    rule: str = RULES[0]
    direction: tuple[float, ...] = (1.0, 0.0)
    raised: float = 1.0

    def __post_init__(self) -> None:
        if (self.critical_stretch is None) == (self.G_c is None):
            raise ProblemError("critical_stretch and G_c: give one of them")
        if self.critical_stretch is not None:
            positive_number("critical_stretch", self.critical_stretch)
        else:
            positive_number("G_c", self.G_c or 0.0, "J/m²")
        require_one_of("rule", self.rule, RULES)
        positive_number("raised", self.raised)


def break_table(growth: FractureResult | None) -> dict[str, pd.DataFrame]:
    """A row each spring that breaks: event, factor of the loads, middle (m), energies (J)."""
    if growth is None:
        return {}
    rows = [
        {
            "event": number, "load": one.load, "needed": one.needed, "spring": int(spring),
            **dict(zip(AXES, _middle(growth, spring), strict=False)),
            "own_energy": one.stored_energy, "released": one.released,
        }
        for number, one in enumerate(growth.breaks, 1)
        for spring in one.springs
    ]  # fmt: skip
    names = ["event", "load", "needed", "spring", *AXES[: growth.network.dim]]
    return {"breaks": pd.DataFrame(rows, columns=[*names, "own_energy", "released"])}


def _middle(growth: FractureResult, spring: int) -> Array:
    return np.asarray(growth.network.points[growth.network.springs[spring]].mean(axis=0))


def break_sentence(growth: FractureResult | None) -> str:
    """Describe the breaks and their dependence on the lattice.

    The text is empty if no spring may break.
    """
    if growth is None:
        return ""
    stretch = float(growth.critical_stretch[0])
    raised = f"At {growth.load:.4g} times the loads, and a critical stretch of {stretch:.3g},"
    if not growth.breaks:
        return f"{raised} no spring has broken."
    first = growth.breaks[0]
    at = ", ".join(f"{x:.3g}" for x in _middle(growth, first.springs[0]))
    ends = {
        "raised": "", "parted": " The body has come apart.",
        "falls": " The next break would let a load fall: no more is borne.",
        "breaks": f" It was stopped after {MOST_BREAKS} events.",
    }  # fmt: skip
    large = "" if stretch <= SMALL else " Such a stretch is not small: all this is of first order."
    loose = f", {len(growth.loose)} points are loose" if len(growth.loose) else ""
    return (
        f"{raised} {len(growth.broken)} springs have broken in {len(growth.breaks)} events, "
        f"the first at {first.load:.4g} times around ({at}) m{loose}. {growth.released:.3g} J "
        f"are released, {100 * growth.stored_energy / growth.released:.0f} % of "
        f"them held by these springs.{ends[growth.ended]} "
        "Elasticity has no such answer: a critical stretch changes with the "
        f"spacing, and paths follow the lattice's rows (study fracture).{large}"
    )


def draw_breaks(growth: FractureResult) -> Figure:
    """Springs, and those that broke, where the body was."""
    points = growth.network.points[:, :2]
    figure, axis = body_axes(points, 0.03 * float(np.ptp(points, axis=0).max()))
    ends = points[growth.network.springs]
    axis.add_collection(LineCollection(list(ends), colors="0.8", linewidths=0.4))
    broken = list(ends[growth.broken])
    axis.add_collection(LineCollection(broken, colors=COLOURS[1], linewidths=1.6, label="broken"))
    if len(growth.loose):
        axis.plot(*points[growth.loose].T, "o", ms=3, color=COLOURS[0], label="loose points")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return figure
