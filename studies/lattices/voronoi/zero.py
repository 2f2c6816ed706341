"""Zero: how can a Voronoi network come out at Poisson's ratio zero, as the report found?

Question   The report joined random particles by Voronoi adjacency and found "nearly no Δy", so that
           its ratio "is always 0". Which networks, ways to hold and measure them, and ways to stop
           too early give that?
Candidate  Linear equilibrium of strewn networks, stretched by their ends and measured by means, as
           the report would; the candidate's solid; Algorithm 1 on the way to rest.
Reference  C12 of a square grid in closed form.
Expected   Springs along the axes alone have C12 = Σ k L² n_x² n_y²/V = 0, and a square grid has no
           others: four cells meet in a point, so diagonal neighbours share no facet. A jitter
           makes one diagonal a square. With k = A/L its facet, and the ratio, grow in proportion to
           the jitter; with k = 1 the ratio jumps.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.constants.homogenise import homogenise

from ..cases import Solid
from . import trials
from .networks import seeds

JITTERS = (0.0, 1e-6, 1e-5, 1e-4, 1e-3, 0.01, 0.1, 0.3, 0.5)
"""Largest move of a grid's point along each axis (spacings)."""
KEPT = 0.01
"""Part of its stiffness that a slack spring keeps."""
NEAR = 0.1
"""A ratio within this of 0 counts as near 0."""
RULES = (
    kit.Rule(
        "square grid: Poisson's ratio 0", 1e-12, "1", "C12 = 0, closed form; left is rounding",
        table="zero_jitter", rows={"jitter": 0.0},
        value=lambda rows: rows[["nu_endless", "nu_means"]].abs().max(axis=1),
    ),
    kit.Rule(
        "nearly square grid, k = A/L: order of the ratio in the jitter", 5e-4, "1",
        "facets are in proportion to the jitter; the next term is the jitter itself, at most 1e-4, "
        "times a number of up to ten, and weighs 1/(2 ln 10) in a slope over two decades: 2e-4, "
        "and a factor of two",
        table="zero_jitter", rows={"stiffness": "A/L", "jitter": JITTERS[1:4]}, value="nu_endless",
        power_of="jitter", reference=1.0,
    ),
    kit.Rule(
        "nearly square grid, k = 1: ratio at a jitter of 1e-6 less that at 1e-5", 5e-5, "1",
        "the same diagonals, turned by twice the jitter, 2e-5, at most; points that relax add a "
        "factor of two or three",
        table="zero_jitter", rows={"stiffness": "1", "jitter": JITTERS[1:3]},
        value=lambda rows: rows["nu_endless"].iloc[0] - rows["nu_endless"].iloc[1],
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs,
    setting: kit.Setting = kit.FULL,
    solid: Solid = homogenise,
) -> kit.Evidence:
    """Try every cause."""
    many, some, few, least = (
        seeds(setting, quick if setting.quick else full)
        for quick, full in ((8, 100), (4, 20), (3, 20), (2, 12))
    )
    most = 100 if setting.quick else 400
    cases = list(product(JITTERS, least))
    found = setting.sweep(
        partial(trials.nearly_square, candidate, solid), cases, "nearly square grids"
    )
    grids = pd.DataFrame([row for rows in found for row in rows])
    kinds = grids.groupby(["jitter", "stiffness"], sort=False)
    jitter = pd.DataFrame(
        {"jitter": size, "stiffness": rule, "count": trials.GRID**2, "seeds": len(least)}
        | {"neighbours": rows["neighbours"].mean(), "nu_endless": rows["nu_endless"].mean()}
        | spread(rows["nu_means"])
        for (size, rule), rows in kinds
    )
    stopped = {
        case: np.array(setting.sweep(partial(trials.stop, *case), least, "Algorithm 1 on its way"))
        for case in product(trials.LOADS, trials.DAMPINGS)
    }

    def strewn(draws: list[int], **how: Any) -> list[float]:
        return setting.sweep(partial(trials.strewn_ratio, candidate, **how), draws, "strewn bodies")

    def slack(which: str) -> list[float]:
        return setting.sweep(
            partial(trials.slack_ratio, candidate, which, KEPT), few, "slack springs"
        )

    def grid(size: float, rule: str) -> pd.Series:
        return kinds.get_group((size, rule))["nu_means"]

    clamped = partial(strewn, ends="clamped")
    late = f"velocity at {trials.EARLY:g} of its peak"
    tried: list[tuple[str, str, Iterable[float]]] = [
        ("none", f"{most} points, k = 1, ends slide", strewn(many, count=most)),
        ("none", f"{most} points, k = A/L, ends slide", strewn(many, count=most, rule="A/L")),
        ("ends clamped", f"{most} points, k = 1", clamped(many, count=most)),
        ("square grid", "no jitter, k = 1", grid(0.0, "1")),
        ("nearly square grid", "jitter 0.01, k = A/L", grid(0.01, "A/L")),
        ("nearly square grid", "jitter 1e-6, k = 1", grid(1e-6, "1")),
        ("few points", "5 points, k = 1, ends slide", strewn(many, count=5)),
        ("few points, ends clamped", "5 points, k = 1", clamped(many, count=5)),
        ("few points, ends clamped", "20 points, k = 1", clamped(many, count=20)),
        ("springs that hardly push", f"{KEPT:g} of k in compression", slack("compressed")),
        ("surface nearly without stiffness", f"{KEPT:g} of k between surface points",
         slack("surface")),
        ("short body, ends clamped", "length/height 1/8", clamped(some, count=288, aspect=1 / 8)),
        ("width measured at a clamp", "length/height 4",
         clamped(some, count=144, aspect=4.0, place="ends")),
        *((f"stopped early, ends {load}", f"damping {times} times critical, {late}", seen[:, 0])
          for (load, times), seen in stopped.items()),
    ]  # fmt: skip
    causes = pd.DataFrame({"cause": c, "network": n} | spread(nu) for c, n, nu in tried)
    rest = [np.median(stopped[load, 1], axis=0) for load in trials.LOADS]
    at_rest = kit.Tolerance(
        "Algorithm 1 at rest: ratio against linear equilibrium", 5e-3, "1",
        "springs turn by the strain of 1e-3, times a factor of order 1 that disorder doubles",
        observed=kit.farthest_value([seen[1] for seen in rest], [seen[2] for seen in rest]),
    )  # fmt: skip
    return kit.Evidence(
        {
            "zero": causes.drop(columns="nu_means_scatter"),
            "zero_jitter": jitter.drop(columns="near_zero_of"),
        },
        tolerances=(*RULES, at_rest),
        figures={"zero": draw},
        columns=kit.columns(__file__),
        findings=findings(causes, jitter, len(least)),
    )


def spread(ratios: Iterable[float]) -> dict[str, Any]:
    """Median, scatter and part near zero of ratios: few points may have any, so no means."""
    nu = np.array([value for value in ratios if np.isfinite(value)])  # NaN: a mechanism
    near = np.abs(nu) < NEAR
    low, middle, high = np.quantile(nu, (0.25, 0.5, 0.75))
    return {
        "nu_means": round(float(middle), 12) + 0.0,  # no -0 where nothing moves
        "nu_means_scatter": abs(round(float(high - low) / 2, 12)),
        "near_zero": float(near.mean()),
        "near_zero_of": f"{near.sum()} of {len(nu)}",
    }


def findings(causes: pd.DataFrame, jitter: pd.DataFrame, stopped: int) -> tuple[str, ...]:
    """The verdict on the report's claim."""
    plain, by_area, five, pulling, short, late = (causes.iloc[row] for row in (0, 1, 7, 9, 11, 14))
    nu = jitter.set_index(["jitter", "stiffness"])["nu_endless"]
    cannot = (
        "The report's ratio of 0 is no property of Voronoi networks: random points have "
        f"{plain['nu_means']:.2f} (k = 1) to {by_area['nu_means']:.2f} (k = A/L) by the report's "
        f"own means, at {plain['network'].split()[0]} points. Exactly 0 needs springs along the "
        "axes alone, which is what Voronoi adjacency makes of a square grid: the report is right "
        "that it drops the diagonals. There the ratio is 0, and shear costs nothing."
    )
    nearly = (
        "The least jitter ends that: at 1e-6 of a spacing the ratio of equal springs is "
        f"{nu[1e-6, '1']:.3f}, while that of A/L grows with the facets, {nu[0.01, 'A/L']:.3f} at "
        f"0.01 and {nu[0.1, 'A/L']:.3f} at 0.1 of a spacing. A nearly square grid weighted by "
        "facets looks like 0; one of equal springs does not."
    )
    others = (
        f"Near 0 without a grid (table zero): 5 points between clamped ends "
        f"({five['nu_means']:.2f}, {five['near_zero_of']} networks within {NEAR:g} of 0), as most "
        "of the points that are measured are held; a body 1/8 as long as high "
        f"({short['nu_means']:.2f}); and a loop that stops early: {late['nu_means']:.2f} with its "
        f"ends moved at once, {trials.DAMPINGS[-1]} times the critical damping and the velocity at "
        f"{trials.EARLY:g} of its peak ({stopped} networks)."
    )
    verdict = (
        "Springs that do not push do the opposite: nothing holds the width, and the ratio is "
        f"{pulling['nu_means']:.1f} where they keep {KEPT:g} of their stiffness. "
        "Likeliest for a ratio of 0 is a grid: the report looked at one and saw its "
        "diagonals vanish. Likeliest for random particles are few of them between clamped ends, "
        "where most points that show the width are held themselves, and an overdamped loop, which "
        "the report prefers, stopped by its velocity before the width has followed the ends."
    )
    return cannot, nearly, others, verdict


def draw(tables: kit.Tables) -> Figure:
    """Ratio of every network that was tried, by the report's means."""
    table = tables["zero"]
    place = -np.arange(len(table))
    figure, (axis,) = kit.figures.new_figure(size=(6.8, 0.22 * len(table) + 1.2))
    axis.axvspan(-NEAR, NEAR, color="#e0e0e0", label=f"within {NEAR:g} of 0")
    axis.plot(table["nu_means"], place, "o", color=kit.figures.COLOURS[0], label="median")
    axis.set_yticks(place, table["cause"] + ": " + table["network"], fontsize=7)
    axis.set(xlabel="Poisson's ratio by means (1)", ylabel="cause: network")
    axis.legend(fontsize=8, loc="lower right")
    figure.suptitle("What may have made the report's Poisson's ratio zero")
    return figure
