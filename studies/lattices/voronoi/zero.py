"""Zero: how can a Voronoi network come out at Poisson's ratio zero, as the report found?

Question   The report joined random particles by Voronoi adjacency and found "nearly no Δy", so that
           its ratio "is always 0". Which networks, ways to hold and measure them, and ways to stop
           too early give that?
Candidate  Linear equilibrium of strewn networks, stretched by their ends and measured by means, as
           the report would; the candidate's solid; Algorithm 1 on the way to rest.
Reference  C12 of a square grid in closed form; finite elements of a clamped body.
Expected   Springs along the axes alone have C12 = Σ k L² n_x² n_y²/V = 0, and a square grid has no
           others: four cells meet in a point, so diagonal neighbours share no facet. Any jitter
           makes one diagonal a square. With k = A/L its facet, and the ratio, grow in proportion to
           the jitter; with k = 1 the ratio jumps.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.constants.homogenise import homogenise
from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting

from ..cases import Solid
from . import bodies, early, zero_figures
from .networks import seeds
from .rows import only
from .strewn import PLACES
from .trials import (
    GRID,
    SLACK_COUNT,
    clamped,
    clamped_elastic,
    few,
    nearly_square,
    with_slack,
)

JITTERS = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3, 0.5)
"""Largest move of a grid's point along each axis (spacings)."""
COUNTS = (5, 10, 20, 40, 100, 400)
KEPT = (1.0, 0.3, 0.1, 0.03, 0.01)
"""Part of its stiffness that a spring in compression keeps."""
ASPECTS = (0.125, 0.25, 0.5, 1.0, 2.0, 4.0)
"""Length over height."""
TOLERANCES = (
    Tolerance(
        "square grid: Poisson's ratio 0", 1e-12, "1",
        "C12 = 0, closed form; left is rounding",
    ),
    Tolerance(
        "nearly square grid, k = A/L: order of the ratio in the jitter", 5e-4, "1",
        "facets are in proportion to the jitter; the next term is the jitter itself, at most 1e-4, "
        "times a number of up to ten, and weighs 1/(2 ln 10) in a slope over two decades: 2e-4, "
        "and a factor of two",
    ),
    Tolerance(
        "nearly square grid, k = 1: ratio at a jitter of 1e-6 less that at 1e-5", 5e-5, "1",
        "the same diagonals, turned by twice the jitter, 2e-5, at most; points that relax add a "
        "factor of two or three",
    ),
    Tolerance(
        "Algorithm 1 at rest: ratio against linear equilibrium", 5e-3, "1",
        "springs turn by the strain of 1e-3, times a factor of order 1 that disorder doubles",
    ),
)  # fmt: skip
COLUMNS = {
    "jitter": "largest move of a point of a square grid along each axis (spacings)",
    "stiffness": "rule of a random network's springs: 1, 1/L or A/L",
    "count": "points in the periodic cell, or in the body (1)",
    "seeds": "random networks drawn (1)",
    "ends": "how pulled ends are held: slide, clamped, or half (free, with the bottom on its line)",
    "mechanisms": bodies.COLUMNS["mechanisms"],
    "neighbours": "springs that meet at a point, mean (1)",
    "held_measured": "part of the measured top and bottom points that cannot move up or down, as "
    "their height is held, mean (1)",
    "nu_endless": "ratio of the endless network along the axes, mean over the seeds (1)",
    "nu_means": "ratio by the report's means: width change of a body with held ends, median over "
    "the seeds (1)",
    "nu_means_scatter": "half the distance of its quartiles over the seeds (1)",
    "near_zero": "part of the networks whose nu_means is within 0.1 of 0 (1)",
    "kept": "part of its stiffness that a slack spring keeps (1)",
    "slack": "which springs are slack: those in compression, or those between surface points",
    "slack_part": "part of the springs that are slack, mean (1)",
    "aspect": "length over height of the body (1)",
    "place": "where the width is measured: whole, middle quarter or the eighth next to each end",
    "nu_elastic": "the same of the elastic body with the network's mean moduli, by FEM (1)",
    "cause": "what might have made the ratio zero",
    "network": "what was stretched",
    "near_zero_of": "how many networks' nu_means is near 0, of how many that stand",
    **early.COLUMNS,
}


def run(
    candidate: DisplacementSolver = solve_springs,
    setting: Setting = FULL,
    solid: Solid = homogenise,
) -> Evidence:
    """Try every cause."""
    jitter = pd.DataFrame(jitter_rows(candidate, solid, setting))
    few = pd.DataFrame(few_points(candidate, setting))
    slack = pd.DataFrame(slacken_rows(candidate, setting))
    length = pd.DataFrame(lengths(candidate, solid, setting))
    stopped = early.table(setting)
    causes = pd.DataFrame(summary(jitter, few, slack, length, stopped))
    small = jitter[(jitter["jitter"] > 0) & (jitter["jitter"] <= 1e-4)]
    by_area, equal = (small[small["stiffness"] == rule] for rule in ("A/L", "1"))
    grid = jitter[jitter["jitter"] == 0]
    values = (
        farthest_value(grid[["nu_endless", "nu_means"]].to_numpy(), 0.0),
        Observed(observed_order(by_area["jitter"], by_area["nu_endless"]), 1.0),
        Observed(equal["nu_endless"].iloc[0], equal["nu_endless"].iloc[1]),
        early.at_rest(stopped),
    )
    return Evidence(
        tables={
            "zero": causes,
            "zero_jitter": jitter,
            "zero_few": few,
            "zero_slack": slack,
            "zero_length": length,
            "zero_early": stopped,
        },
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"zero": zero_figures.causes},
        columns=COLUMNS,
        findings=findings(jitter, few, slack, length, stopped),
        rounding={"nu_endless": 1e-9, "nu_means": 1e-9, "nu_means_scatter": 1e-9},
    )


def jitter_rows(
    candidate: DisplacementSolver, solid: Solid, setting: Setting
) -> list[dict[str, Any]]:
    """Rows of the table `zero_jitter`."""
    draws = seeds(setting, 2 if setting.quick else 12)
    cases = list(product(JITTERS, draws))
    seen = setting.sweep(partial(nearly_square, candidate, solid), cases, "nearly square grids")
    found = pd.DataFrame([row for rows in seen for row in rows])
    return [
        {"jitter": jitter, "stiffness": rule, "count": GRID**2, "seeds": len(draws)}
        | {"neighbours": rows["neighbours"].mean(), "nu_endless": rows["nu_endless"].mean()}
        | early.spread(rows["nu_means"])
        for (jitter, rule), rows in found.groupby(["jitter", "stiffness"], sort=False)
    ]


def few_points(candidate: DisplacementSolver, setting: Setting) -> list[dict[str, Any]]:
    """Rows of the table `zero_few`."""
    draws = seeds(setting, 8 if setting.quick else 100)
    counts = COUNTS[:-1] if setting.quick else COUNTS
    cases = [(count, seed) for count in counts for seed in draws]
    seen = setting.sweep(partial(few, candidate), cases, "few points")
    table = pd.DataFrame([row for rows in seen for row in rows])
    return [
        {"count": count, "ends": ends, "stiffness": rule, "seeds": len(draws)}
        | {"mechanisms": int(rows["nu"].isna().sum())}
        | {"held_measured": rows["held_measured"].mean()}
        | early.spread(rows["nu"].dropna())
        for (count, ends, rule), rows in table.groupby(["count", "ends", "stiffness"], sort=False)
    ]


def slacken_rows(candidate: DisplacementSolver, setting: Setting) -> list[dict[str, Any]]:
    """Rows of the table `zero_slack`."""
    draws = seeds(setting, 3 if setting.quick else 20)
    kinds = [("compressed", kept) for kept in KEPT] + [("surface", 0.01)]
    cases = [(*kind, seed) for kind in kinds for seed in draws]
    found = pd.DataFrame(
        setting.sweep(partial(with_slack, candidate), cases, "slack springs"),
        columns=["slack", "kept", "nu", "slack_part"],
    )
    return [
        {"slack": slack, "kept": kept, "stiffness": "1", "count": SLACK_COUNT}
        | {"seeds": len(draws), "slack_part": rows["slack_part"].mean()}
        | early.spread(rows["nu"])
        for (slack, kept), rows in found.groupby(["slack", "kept"], sort=False)
    ]


def lengths(candidate: DisplacementSolver, solid: Solid, setting: Setting) -> list[dict[str, Any]]:
    """Rows of the table `zero_length`."""
    draws = seeds(setting, 4 if setting.quick else 20)
    cases = [(aspect, seed) for aspect in ASPECTS for seed in draws]
    found = iter(setting.sweep(partial(clamped, candidate), cases, "clamped lengths"))
    family = (2, "uniform", "1")
    tensor = bodies.mean_tensors(solid, setting, [family], seeds(setting))[family]
    elastic = setting.sweep(partial(clamped_elastic, tensor), ASPECTS, "clamped elastic bodies")
    rows = []
    for aspect, exact in zip(ASPECTS, elastic, strict=True):
        seen = np.array([next(found) for _ in draws])
        rows += [
            {"aspect": aspect, "place": place, "stiffness": "1", "seeds": len(draws)}
            | {"nu_elastic": nu_elastic}
            | early.spread(nu)
            for place, nu, nu_elastic in zip(PLACES, seen.T, exact, strict=True)
        ]
    return rows


def summary(
    jitter: pd.DataFrame,
    few: pd.DataFrame,
    slack: pd.DataFrame,
    length: pd.DataFrame,
    stopped: pd.DataFrame,
) -> list[dict[str, Any]]:
    """Rows of the table `zero`: every cause in one line."""
    most = few["count"].max()
    slide = partial(only, few, ends="slide")
    held = partial(only, few, ends="clamped", stiffness="1")
    pulling = only(slack, slack="compressed", kept=KEPT[-1])
    bare = only(slack, slack="surface")
    short = only(length, aspect=0.125, place="whole")
    between = f"{bare['kept']:g} of k between surface points"
    cases = [
        ("none", f"{most} points, k = 1, ends slide", slide(count=most, stiffness="1")),
        ("none", f"{most} points, k = A/L, ends slide", slide(count=most, stiffness="A/L")),
        ("ends clamped", f"{most} points, k = 1", held(count=most)),
        ("square grid", "no jitter, k = 1", only(jitter, jitter=0.0, stiffness="1")),
        ("nearly square grid", "jitter 0.01, k = A/L", only(jitter, jitter=0.01, stiffness="A/L")),
        ("nearly square grid", "jitter 1e-6, k = 1", only(jitter, jitter=1e-6, stiffness="1")),
        ("few points", "5 points, k = 1, ends slide", slide(count=5, stiffness="1")),
        ("few points, ends clamped", "5 points, k = 1", held(count=5)),
        ("few points, ends clamped", "20 points, k = 1", held(count=20)),
        ("springs that hardly push", f"{pulling['kept']:g} of k in compression", pulling),
        ("surface nearly without stiffness", between, bare),
        ("short body, ends clamped", "length/height 1/8", short),
        ("width measured at a clamp", "length/height 4", only(length, aspect=4.0, place="ends")),
        *early.causes(stopped),
    ]
    return [
        {
            "cause": cause,
            "network": network,
            "nu_means": row["nu_means"],
            "near_zero": row["near_zero"],
            "near_zero_of": count_near_zero(row),
        }
        for cause, network, row in cases
    ]


def count_near_zero(row: dict[str, Any]) -> str:
    """How many networks of a row are near 0, of those that are no mechanisms."""
    standing = row["seeds"] - row.get("mechanisms", 0)
    return f"{round(row['near_zero'] * standing)} of {standing}"


def findings(
    jitter: pd.DataFrame,
    few: pd.DataFrame,
    slack: pd.DataFrame,
    length: pd.DataFrame,
    stopped: pd.DataFrame,
) -> tuple[str, ...]:
    """The verdict on the report's claim."""
    most = few["count"].max()
    plain, by_area = (
        only(few, count=most, ends="slide", stiffness=rule)["nu_means"] for rule in ("1", "A/L")
    )
    five = only(few, count=5, ends="clamped", stiffness="1")
    equal, slight, some = (
        only(jitter, jitter=size, stiffness=rule)["nu_endless"]
        for size, rule in ((1e-6, "1"), (0.01, "A/L"), (0.1, "A/L"))
    )
    short = only(length, aspect=0.125, place="whole")
    pulling = only(slack, slack="compressed", kept=KEPT[-1])
    cannot = (
        "The report's ratio of 0 is no property of Voronoi networks: random points have "
        f"{plain:.2f} (k = 1) to {by_area:.2f} (k = A/L) by the report's own means, at {most} "
        "points. Exactly 0 needs springs along the axes alone, which is what Voronoi adjacency "
        "makes of a square grid: the report is right that it drops the diagonals. There the ratio "
        "is 0, and shear costs nothing."
    )
    nearly = (
        f"The least jitter ends that: at 1e-6 of a spacing the ratio of equal springs is "
        f"{equal:.3f}, while that of A/L grows with the facets, {slight:.3f} at 0.01 and "
        f"{some:.3f} at 0.1 of a spacing. A nearly square grid weighted by facets looks like "
        "0; one of equal springs does not."
    )
    others = (
        "Near 0 without a grid (table zero): 5 points between clamped ends "
        f"({five['nu_means']:.2f}, {count_near_zero(five)} networks within {early.NEAR:g} of 0), "
        f"as "
        f"{100 * five['held_measured']:.0f} % of the points that are measured are held; a body "
        f"1/8 as long as high ({short['nu_means']:.2f}); and a loop that stops early: "
        f"{early.sentence(stopped)}"
    )
    verdict = (
        "Springs that do not push do the opposite: nothing holds the width, and the ratio is "
        f"{pulling['nu_means']:.1f} where they keep {pulling['kept']:g} of their stiffness. "
        "Likeliest for a ratio that is always 0 is a grid: the report looked at one and saw its "
        "diagonals vanish. Likeliest for random particles are few of them between clamped ends, "
        "where most points that show the width are held themselves, and an overdamped loop, which "
        "the report prefers, stopped by its velocity before the width has followed the ends."
    )
    return cannot, nearly, others, verdict
