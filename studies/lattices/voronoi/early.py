"""Stopped early: what ratio does Algorithm 1 show on its way to rest?

Ends may be moved apart at once, as a body with held ends is, or pulled by forces. Of the first the
strain between the ends is there from the start, and the width has yet to follow.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.dynamics.integrators import EULER_CROMER
from msvalidate.dynamics.spectrum import extreme_frequencies
from msvalidate.judging.candidate import AT_REST
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Observed
from msvalidate.judging.sweep import Setting
from msvalidate.network import Network
from msvalidate.problem import Array
from msvalidate.relaxation.relax import relax
from msvalidate.relaxation.run import Run
from msvalidate.relaxation.viscous import viscous
from msvalidate.statics.equilibrium import equilibrium

from .networks import seeds
from .rows import only, records
from .strewn import STRAIN, Strewn, gauge, ratio, stretch_body, strewn

COUNT = 100
LOADS = ("moved", "pulled")
DAMPINGS = (1, 10, 100)
"""Over twice the lowest frequency, which is critical for the slowest motion; the report prefers an
overdamped system."""
STOPS = (0.3, 0.1, 0.03, 0.01)
"""Of the largest velocity so far: the report's loop ends when the largest falls below some ε."""
REST = "rest"
COLUMNS = {
    "ends_by": "how the ends come apart: moved at once, or pulled by forces",
    "damping_factor": "damping over the critical one of the slowest motion (1)",
    "stop": 'largest velocity at the stop over the largest so far, or "rest" (1)',
    "periods": "time until then, in periods of the slowest motion, mean over the seeds (1)",
    "axial_part": "mean axial strain between the ends over that at rest, mean (1)",
    "inner_part": "axial strain of the middle half over that at rest, mean (1)",
    "lateral_part": "lateral strain over that at rest, mean (1)",
    "nu_rest": "ratio by linear equilibrium, median over the seeds (1)",
}
EARLY = 0.1
"""Stop that tables and findings tell of."""
NEAR = 0.1
"""A ratio within this of 0 counts as near 0."""


def table(setting: Setting) -> pd.DataFrame:
    """Table `zero_early`."""
    draws = seeds(setting, 2 if setting.quick else 12)
    dampings = DAMPINGS[::2] if setting.quick else DAMPINGS
    cases = list(product(LOADS, dampings, draws))
    found = setting.sweep(stops, cases, "Algorithm 1 on its way")
    every = pd.DataFrame([row for rows in found for row in rows])
    rows = []
    for (load, damping, stop), same in every.groupby(
        ["ends_by", "damping_factor", "stop"], sort=False
    ):
        mean = same[["periods", "axial_part", "inner_part", "lateral_part"]].mean()
        rows.append(
            {
                "ends_by": load,
                "damping_factor": damping,
                "stop": stop,
                "stiffness": "1",
                "count": COUNT,
                "seeds": len(draws),
            }
            | mean.to_dict()
            | {"nu_rest": same["nu_rest"].median()}
            | spread(same["nu"])
        )
    return pd.DataFrame(rows)


def spread(ratios: Iterable[float]) -> dict[str, float]:
    """Median, scatter and part near zero of ratios: few points may have any, so no means."""
    nu = np.array(list(ratios))
    low, middle, high = np.quantile(nu, (0.25, 0.5, 0.75))
    return {
        "nu_means": round(float(middle), 12) + 0.0,  # no -0 where nothing moves
        "nu_means_scatter": abs(round(float(high - low) / 2, 12)),
        "near_zero": float((np.abs(nu) < NEAR).mean()),
    }


def stops(case: tuple[str, int, int]) -> list[dict[str, Any]]:
    """What one body shows at each stop, and, critically damped, at rest."""
    load, damping, seed = case
    body = strewn("uniform", COUNT, "1", seed)
    _, network = stretch_body(body)
    static = equilibrium(network)
    if load == "pulled":
        # The same ends, each point drawn by the force that held it.
        right = body.ends("left", "right")[1]
        held = np.array(network.held)
        held[right, 0] = False
        force = np.where(right[:, None], static.reaction, 0.0)
        network = replace(
            network, held=held, displacement=np.zeros(held.shape), force=np.array(force)
        )
    lowest, highest = extreme_frequencies(network)
    rest = strains(body, network, static.displacement)
    left = list(STOPS)
    rows: list[dict[str, Any]] = []
    fastest = 0.0

    def look(run: Run) -> bool:
        nonlocal fastest
        speed = float(np.abs(run.velocity).max())
        fastest = max(fastest, speed)
        while left and run.steps and speed < left[0] * fastest:
            rows.append(seen(left.pop(0), run.steps * run.dt, run.displacement))
        return damping > 1 and not left

    def seen(stop: float | str, time: float, move: Array) -> dict[str, Any]:
        shown = strains(body, network, move)
        return {
            "ends_by": load,
            "damping_factor": damping,
            "stop": stop,
            "periods": time * lowest / (2 * np.pi),
            "axial_part": shown[0] / rest[0],
            "inner_part": shown[1] / rest[1],
            "lateral_part": shown[2] / rest[2],
            "nu": shown[2] / shown[0],
            "nu_rest": rest[2] / rest[0],
        }

    end = relax(
        network,
        viscous(EULER_CROMER, damping=2 * lowest * damping),
        tolerance=AT_REST,
        watch=look,
        look_every=1,
        frequencies=(lowest, highest),
    )
    if damping == 1:
        rows.append(seen(REST, end.steps * end.dt, end.equilibrium.displacement))
    return rows


def strains(body: Strewn, network: Network, move: Array) -> tuple[float, float, float]:
    """Axial strain between the ends' means, that of the middle half, and the lateral contraction.

    The second is the slope of a line through the displacements there.
    """
    x = network.points[:, 0]
    left, right = body.ends("left", "right")
    axial = (move[right, 0].mean() - move[left, 0].mean()) / gauge(body)
    inner = np.abs(x / body.box.size[0] - 0.5) < 0.25
    slope = np.polyfit(x[inner], move[inner, 0], 1)[0]
    return float(axial), float(slope), ratio(body, move) * STRAIN


def at_rest(found: pd.DataFrame) -> Observed:
    """Ratio at Algorithm 1's rest, from that of linear equilibrium, where they differ most."""
    rest = records(found, stop=REST)
    return farthest_value([row["nu_means"] for row in rest], [row["nu_rest"] for row in rest])


def causes(found: pd.DataFrame) -> list[tuple[str, str, dict[str, Any]]]:
    """Lines of the table `zero`."""
    return [
        (
            f"stopped early, ends {load}",
            f"damping {damping} times critical, velocity at {EARLY:g} of its peak",
            only(found, ends_by=load, damping_factor=damping, stop=EARLY),
        )
        for load in LOADS
        for damping in (DAMPINGS[0], DAMPINGS[-1])
    ]


def sentence(found: pd.DataFrame) -> str:
    """What stopping early does."""
    over = only(found, ends_by="moved", damping_factor=DAMPINGS[-1], stop=EARLY)
    return (
        f"{over['nu_means']:.2f} with its ends moved at once, {DAMPINGS[-1]} times the critical "
        f"damping and the velocity at {EARLY:g} of its peak ({over['seeds']} networks)."
    )
