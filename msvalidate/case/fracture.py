"""Springs of a case that break while its loads are raised: how, their files, picture and words."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure

from msvalidate.bodies.toughness import critical_stretch
from msvalidate.case.case import Case
from msvalidate.case.springs import SpringAnswer
from msvalidate.lattice.patterns import all_patterns
from msvalidate.output.body_drawing import body_axes
from msvalidate.output.figures import COLOURS
from msvalidate.problem import AXES, Array, ProblemError
from msvalidate.statics.breaking import Growth, grow

SMALL = 0.05
"""Stretch up to which small displacements are said to do."""
MOST_BREAKS = 1000
"""Events after which a case stops."""


def stretch_of(case: Case, answer: SpringAnswer) -> float:
    """Critical stretch of a case's springs.

    Raises
    ------
    ProblemError
        As `bodies.toughness.critical_stretch`, or if there is no one lattice of one material.
    """
    asked = case.fracture
    assert asked is not None  # noqa: S101  the caller has looked
    if asked.critical_stretch is not None:
        return asked.critical_stretch
    make = all_patterns().get(str(case.lattice))
    if make is None or case.problem.zones:
        raise ProblemError(
            f"fracture: G_c of {'several materials' if make else case.lattice}; it is for one "
            "lattice of one material, so give critical_stretch"
        )
    given = answer.calibration or case.constants or ()
    return critical_stretch(
        make(), given, asked.G_c or 0.0, spacing=answer.spacing,
        thickness=case.problem.material.thickness, direction=asked.direction, rule=asked.rule,
    ).critical_stretch  # fmt: skip


def break_springs(case: Case, answer: SpringAnswer) -> Growth:
    """Springs that break as the case's loads are raised; raises as `statics.breaking.grow`."""
    assert case.fracture is not None  # noqa: S101  the caller has looked
    stretch = stretch_of(case, answer)
    return grow(answer.network, stretch, case.fracture.raised, most_breaks=MOST_BREAKS)


def break_table(answer: SpringAnswer) -> dict[str, pd.DataFrame]:
    """A row each spring that breaks: event, factor of the loads, middle (m), energies (J)."""
    growth = answer.growth
    if growth is None:
        return {}
    rows = [
        {
            "event": number, "load": one.load, "needed": one.needed, "spring": int(spring),
            **dict(zip(AXES, _middle(answer, spring), strict=False)),
            "own_energy": one.own, "released": one.released,
        }
        for number, one in enumerate(growth.breaks, 1)
        for spring in one.springs
    ]  # fmt: skip
    names = ["event", "load", "needed", "spring", *AXES[: answer.network.dim]]
    return {"breaks": pd.DataFrame(rows, columns=[*names, "own_energy", "released"])}


def _middle(answer: SpringAnswer, spring: int) -> Array:
    return np.asarray(answer.network.points[answer.network.springs[spring]].mean(axis=0))


def break_sentence(case: Case, answer: SpringAnswer) -> tuple[str, ...]:
    """What broke, and what of it is the lattice's."""
    growth = answer.growth
    if growth is None or case.fracture is None:
        return ()
    stretch = float(growth.critical_stretch[0])
    raised = f"At {growth.load:.4g} times the loads, and a critical stretch of {stretch:.3g},"
    if not growth.breaks:
        return (f"{raised} no spring has broken.",)
    first = growth.breaks[0]
    at = ", ".join(f"{x:.3g}" for x in _middle(answer, first.springs[0]))
    ends = {
        "raised": "", "parted": " The body has come apart.",
        "falls": " The next break would let a load fall: no more is borne.",
        "breaks": f" It was stopped after {MOST_BREAKS} events.",
    }  # fmt: skip
    large = "" if stretch <= SMALL else " Such a stretch is not small: all this is of first order."
    loose = f", {len(growth.loose)} points are loose" if len(growth.loose) else ""
    said = (
        f"{raised} {len(growth.broken)} springs have broken in {len(growth.breaks)} events, "
        f"the first at {first.load:.4g} times around ({at}) m{loose}. {growth.released:.3g} J "
        f"are released, {100 * growth.own / growth.released:.0f} % of them held by these springs."
        f"{ends[growth.ended]} Elasticity has no such answer: a critical stretch changes with the "
        f"spacing, and paths follow the lattice's rows (study fracture).{large}"
    )
    return (said,)


def draw_breaks(answer: SpringAnswer) -> Figure:
    """Springs, and those that broke, where the body was."""
    growth, points = answer.growth, answer.network.points[:, :2]
    assert growth is not None  # noqa: S101  the caller has looked
    figure, axis = body_axes(points, 0.03 * float(np.ptp(points, axis=0).max()))
    ends = points[answer.network.springs]
    axis.add_collection(LineCollection(list(ends), colors="0.8", linewidths=0.4))
    broken = list(ends[growth.broken])
    axis.add_collection(LineCollection(broken, colors=COLOURS[1], linewidths=1.6, label="broken"))
    if len(growth.loose):
        axis.plot(*points[growth.loose].T, "o", ms=3, color=COLOURS[0], label="loose points")
    axis.legend(loc="upper center", bbox_to_anchor=(0.5, -0.16), ncols=2)
    return figure
