"""Random solids: which solid is a Voronoi network?

Question   Modulus, Poisson's ratio and anisotropy of periodic networks between points whose Voronoi
           cells share a facet, over seeds, sizes, kinds of point set and rules of stiffness.
Candidate  The tensor of the endless network, its points at rest.
Reference  Identities of Voronoi cells and of central springs; small networks by least squares;
           six figures of single networks.
Expected   A facet of area A across a spring of length L is the base of two pyramids, so Σ A L is d
           times the volume. Springs of k = A/L pull with A times the strain when the lengths grow
           alike, and the facets of a closed cell have Σ A n = 0: no point moves, the bulk modulus
           is 1/d for each seed, and E = 1 - nu in the plane and 1 - 2 nu in space. Points held to
           the uniform strain have Cauchy's ratio, 1/3 or 1/4, by each rule. Relaxation takes a part
           b of the bulk modulus and a part g of the shear modulus, and the ratio rises above
           Cauchy's where g > b: with A/L too, as b is none. Of an average over n points the
           spread falls as n^(-1/2).
"""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from msvalidate import kit
from msvalidate.bench.judging.compare import CONFIDENCE
from msvalidate.springs.constants.homogenise import homogenise
from msvalidate.springs.constants.stiffness import isotropic_moduli
from msvalidate.springs.lattice import STIFFNESS_RULES
from msvalidate.springs.lattice.point_sets import POINT_SETS

from ..cases import Solid
from . import drawing, energy
from .networks import anisotropy, measure, seeds

COUNTS = {2: (100, 400, 1600), 3: (64, 216, 1000)}
QUOTED = {
    2: {"1": 0.264, "1/L": 0.375, "A/L": 0.597},
    3: {"1": 0.225, "1/L": 0.252, "A/L": 0.329},
}
"""Ratios that an independent program found, each of one network of uniform points."""
NO_SCATTER = 1e-12
"""Standard deviation of a ratio below which it is rounding."""
KIND = ["axes", "point_set", "stiffness"]
identity = partial(kit.Tolerance, unit="1")
IDENTITIES = {
    "content": identity(
        "Voronoi cells: Σ A L over d times the volume, less 1", 1e-12,
        because="an identity; left is the rounding of sums of up to 7000 terms, each of one sign",
    ),
    "closure": identity(
        "Voronoi cells: Σ A n, largest of a cell over its surface", 1e-11,
        because="an identity: the cell is closed; facets come from circumcentres of slivers, whose "
        "rounding is 1e-16 times their length over their height, up to 1e4",
    ),
    "affine_sum": identity(
        "k = A/L, points held: sum of the tensor's normal block, over d less 1", 1e-12,
        because="Σ A L again, by way of the candidate's affine tensor",
    ),
    "bulk": identity(
        "k = A/L, points at rest: bulk modulus over 1/d less 1", 1e-9,
        because="an identity for each seed; left is the rounding of closed cells and of a linear "
        "solve, 1e-16 times a condition number of up to 1e6",
    ),
    "cauchy": identity(
        "points held: Poisson's ratio is Cauchy's", 1e-12,
        because="C_iijj = C_ijij of central springs, term by term; left is rounding",
    ),
    "above_affine": identity(
        "relaxed above affine: largest eigenvalue of the difference, relative", 1e-12,
        because="what relaxation releases is an energy; left is rounding",
    ),
}  # fmt: skip
"""What holds for every network, by its name in `networks.measure`."""


def deviations(rows: pd.DataFrame) -> list[float]:
    """Quoted ratios less the means of the largest size, in deviations of the smallest."""
    found = []
    for (dim, _, rule), family in rows.groupby(KIND, sort=False):
        one = max(family["nu_std"].iloc[0], NO_SCATTER)
        found.append((QUOTED[int(str(dim))][str(rule)] - family["nu_mean"].iloc[-1]) / one)
    return found


def exponent(rows: pd.DataFrame) -> tuple[float, float]:
    """How one family's spread goes with the number of points, and the standard error of that."""
    away = np.log(rows["count"]) - np.log(rows["count"]).mean()
    # The logarithm of a standard deviation from S fair draws scatters by 1/√(2S - 2).
    error = 1 / math.sqrt(2 * (rows["seeds"].iloc[0] - 1) * (away @ away))
    return kit.observed_order(rows["count"], rows["nu_std"]), error


def from_half(rows: pd.DataFrame) -> float:
    """Mean exponent of the spread from -1/2, in standard errors of that mean."""
    found = np.array([exponent(family) for _, family in rows.groupby(KIND, sort=False)])
    power, error = found[:, 0], found[:: len(STIFFNESS_RULES), 1]
    return float((power.mean() + 0.5) * len(error) / math.sqrt((error**2).sum()))


RULES = (
    kit.Rule(
        "uniform points: one network's ratio by an independent program, from the mean",
        3.0, "standard deviations",
        "of single networks of the smallest size, as its own is not known; of six fair draws one "
        "is farther out once in sixty times",
        table="random_solids", rows={"point_set": "uniform"}, value=deviations,
    ),
    kit.Rule(
        "spread of the ratio: exponent in the number of points, from -1/2", 4.0, "standard errors",
        "a standard deviation from S seeds is known to 1/√(2S - 2); the rules share their points, "
        "so one exponent a kind of point set and dimension counts; what is farther out is no "
        "chance",
        table="random_solids", value=from_half,
    ),
    energy.RULE,
)  # fmt: skip


def run(solid: Solid = homogenise, setting: kit.Setting = kit.FULL) -> kit.Evidence:
    """Draw networks, and say what solids they are."""
    sizes = {dim: counts[:2] if setting.quick else counts for dim, counts in COUNTS.items()}
    cases = [
        (dim, points, count, seed)
        for dim, counts in sizes.items()
        for points, count in product(POINT_SETS, counts)
        for seed in seeds(setting)
    ]
    found = setting.sweep(partial(measure, solid), cases, "random solids")
    networks = pd.DataFrame([row for rows in found for row in rows])
    groups = networks.groupby([*KIND, "count"], sort=False)
    solids = pd.DataFrame([summary(rows) for _, rows in groups])
    compared = setting.sweep(
        partial(energy.compare_tensors, solid), energy.CASES, "random solids, third route"
    )
    identities = tuple(
        replace(rule, observed=kit.farthest_value(networks[key], 0.0))
        for key, rule in IDENTITIES.items()
    )
    return kit.Evidence(
        {"random_solids": solids, "random_energy": pd.DataFrame(compared)},
        tolerances=(*identities, *RULES),
        figures={"random_nu": drawing.RATIOS, "random_spread": drawing.SPREAD},
        columns=kit.columns(__file__),
        findings=findings(solids),
    )


def summary(rows: pd.DataFrame) -> dict[str, Any]:
    """One row of the table `random_solids`, from the networks of one kind and size."""
    number = len(rows)
    spread = rows["nu"].std()
    reach = stdtrit(number - 1, 0.5 + CONFIDENCE / 2) * spread / math.sqrt(number)
    mean = rows[["nu", "E", "nu_affine", "E_affine", "neighbours", "anisotropy"]].mean()
    lost = rows[["bulk_lost", "shear_lost", "E_lost"]].mean().round(12)
    tensor = np.mean(list(rows["tensor"]), axis=0)
    return {key: rows[key].iloc[0] for key in (*KIND, "count")} | {
        "seeds": number,
        "springs_a_point": mean["neighbours"],
        "nu_mean": mean["nu"],
        "nu_std": spread,
        "nu_low": mean["nu"] - reach,
        "nu_high": mean["nu"] + reach,
        "nu_held": mean["nu_affine"],
        "E_mean": mean["E"],
        "E_std": rows["E"].std(),
        "E_held": mean["E_affine"],
        "bulk_lost": abs(lost["bulk_lost"]),  # no -0 where nothing is lost
        "shear_lost": lost["shear_lost"],
        "E_lost": lost["E_lost"],
        "anisotropy": mean["anisotropy"],
        "mean_anisotropy": anisotropy(tensor),
        "zener_mean": isotropic_moduli(tensor).zener,
    }


def findings(solids: pd.DataFrame) -> tuple[str, ...]:
    """Which solids Voronoi networks are, why, and how they scatter."""
    top = solids[solids["count"] == solids.groupby("axes")["count"].transform("max")]
    ratios, least = [], []
    for dim, place in ((2, "in the plane"), (3, "in space")):
        largest = top[top["axes"] == dim]
        uniform = largest[largest["point_set"] == "uniform"]
        one = ", ".join(
            f"{row['nu_mean']:.4f} ± {row['nu_high'] - row['nu_mean']:.4f} "
            f"(k = {row['stiffness']}; one network ± {row['nu_std']:.4f})"
            for _, row in uniform.iterrows()
        )
        ratios.append(f"{place}, {uniform['count'].iloc[0]} uniform points: {one}")
        best = largest.nsmallest(1, "nu_std").iloc[0]
        least.append(f"{place} {best['point_set'].replace('_', ' ')} k = {best['stiffness']}")
    plane = top[(top["axes"] == 2) & (top["point_set"] == "uniform")]
    lost = ", ".join(
        f"{100 * row['bulk_lost']:.1f} and {100 * row['shear_lost']:.1f} % (k = {row['stiffness']})"
        for _, row in plane.iterrows()
    )
    kept = top[(top["axes"] == 2) & (top["stiffness"] == "A/L")]
    directions = ", ".join(
        f"{100 * row['mean_anisotropy']:.1f} % ({row['point_set'].replace('_', ' ')})"
        for _, row in kept.iterrows()
    )
    power = np.mean([exponent(family)[0] for _, family in solids.groupby(KIND)])
    rules = (
        "A Voronoi network has no one Poisson's ratio: its rule of stiffness decides. "
        f"{'; '.join(ratios).replace('in', 'In', 1)}."
    )
    relaxed = (
        "With its points held a network has Cauchy's ratio by each rule. Relaxation takes of the "
        f"bulk and of the shear modulus, for uniform points in the plane, {lost}. The ratio rises "
        "where shear loses more. When the lengths grow alike, a spring of k = 1 pulls by its "
        "length, so a point is drawn to its far neighbours and much of the bulk modulus goes; one "
        "of A/L pulls by its facet, and the facets of a closed cell balance: the bulk modulus is "
        "1/d for the seeds tried, and only shear is lost."
    )
    axes = (
        "Jittered points are not isotropic however many: they keep the axes of the grid that they "
        f"were strewn in. The mean tensor of plane networks of A/L is {directions} from isotropic."
    )
    scatter = (
        f"One network's ratio scatters as the number of points to the power {power:.2f} on "
        f"average; least of all {'; '.join(least)}."
    )
    return rules, relaxed, axes, scatter
