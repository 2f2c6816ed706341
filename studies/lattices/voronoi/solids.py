"""Random solids: which solid is a Voronoi network?

Question   Modulus, Poisson's ratio and anisotropy of periodic networks between points whose Voronoi
           cells share a facet, over seeds, sizes, kinds of point set and rules of stiffness; and
           which of these serve best.
Candidate  The tensor of the endless network, its points at rest.
Reference  Identities of Voronoi cells and of central springs; small networks by least squares;
           six figures of single networks.
Expected   A facet of area A across a spring of length L is the base of two pyramids, so Σ A L is d
           times the volume. Springs of k = A/L pull with A times the strain when all lengths grow
           alike, and the facets of a closed cell have Σ A n = 0: no point moves, the bulk modulus
           is 1/d for every seed, and E = 1 - nu in the plane and 1 - 2 nu in space. Points held to
           the uniform strain have Cauchy's ratio, 1/3 or 1/4, by any rule. Relaxation takes a part
           b of the bulk modulus and a part g of the shear modulus, and the ratio rises above
           Cauchy's where g > b: with A/L always, as b is none. Of an average over n points the
           spread falls as n^(-1/2).
"""

from __future__ import annotations

import math
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from msvalidate.constants.homogenise import homogenise
from msvalidate.constants.stiffness import isotropic_moduli
from msvalidate.judging.compare import CONFIDENCE, farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.lattice import STIFFNESS_RULES
from msvalidate.lattice.point_sets import POINT_SETS

from ..cases import Solid
from . import best, drawing, energy
from .best import RULES
from .networks import anisotropy, measure, seeds
from .rows import records

COUNTS = {2: (100, 400, 1600), 3: (64, 216, 1000)}
QUOTED = {
    2: {"1": 0.264, "1/L": 0.375, "A/L": 0.597},
    3: {"1": 0.225, "1/L": 0.252, "A/L": 0.329},
}
"""Ratios that an independent program found, each of one network of uniform points."""
NO_SCATTER = 1e-12
"""Standard deviation of a ratio below which it is rounding."""
TOLERANCES = (
    Tolerance(
        "Voronoi cells: Σ A L over d times the volume, less 1", 1e-12, "1",
        "an identity; left is the rounding of sums of up to 7000 terms, each of one sign",
    ),
    Tolerance(
        "Voronoi cells: Σ A n, largest of a cell over its surface", 1e-11, "1",
        "an identity: the cell is closed; facets come from circumcentres of slivers, whose "
        "rounding is 1e-16 times their length over their height, up to 1e4",
    ),
    Tolerance(
        "k = A/L, points held: sum of the tensor's normal block, over d less 1", 1e-12, "1",
        "Σ A L again, by way of the candidate's affine tensor",
    ),
    Tolerance(
        "k = A/L, points at rest: bulk modulus over 1/d less 1", 1e-9, "1",
        "an identity for each seed; left is the rounding of closed cells and of a linear solve, "
        "1e-16 times a condition number of up to 1e6",
    ),
    Tolerance(
        "points held: Poisson's ratio is Cauchy's", 1e-12, "1",
        "C_iijj = C_ijij of central springs, term by term; left is rounding",
    ),
    Tolerance(
        "relaxed above affine: largest eigenvalue of the difference, relative", 1e-12, "1",
        "what relaxation releases is an energy; left is rounding",
    ),
    Tolerance(
        "uniform points: one network's ratio by an independent program, from the mean",
        3.0, "standard deviations",
        "of single networks of the smallest size, as its own is not known; of six fair draws one "
        "is farther out once in sixty times",
    ),
    Tolerance(
        "spread of the ratio: exponent in the number of points, from -1/2", 4.0, "standard errors",
        "a standard deviation from S seeds is known to 1/√(2S - 2); the rules share their points, "
        "so one exponent a kind of point set and dimension counts; what is farther out is no "
        "chance",
    ),
    energy.TOLERANCE,
)  # fmt: skip
COLUMNS = {
    "axes": "2 in the plane, 3 in space",
    "point_set": "kind of random point set",
    "stiffness": "rule of a random network's springs: 1, 1/L or A/L",
    "count": "points in the periodic cell, or in the body (1)",
    "seeds": "random networks drawn (1)",
    "springs_a_point": "springs with stiffness that meet at a point",
    "nu_mean": "Poisson's ratio, mean over the seeds (1)",
    "nu_std": "its standard deviation over the seeds: what one network may be off (1)",
    "nu_low": "lower end of the mean's interval of 95 % (1)",
    "nu_high": "upper end of it (1)",
    "nu_held": "ratio with the points held to the uniform strain (1)",
    "E_mean": "modulus, mean over the seeds, at a spacing of 1 m (N/m in the plane, Pa in space)",
    "E_std": "its standard deviation over the seeds (as E_mean)",
    "E_held": "mean modulus with the points held (as E_mean)",
    "bulk_lost": "part of the bulk modulus that relaxation takes, mean (1)",
    "shear_lost": "part of the shear modulus that relaxation takes, mean (1)",
    "E_lost": "part of the modulus that relaxation takes, mean (1)",
    "anisotropy": "distance from the nearest isotropic tensor over the tensor, mean (1)",
    "mean_anisotropy": "the same of the mean tensor: what more networks do not average away (1)",
    "zener_mean": "2 C44/(C11 - C12) of the mean tensor, along the axes of the point set (1)",
    "nu_exponent": 'p of nu_std ∝ count^p, over all sizes, or "none" where nothing scatters (1)',
    "nu_exponent_error": "standard error of nu_exponent, from the number of seeds alone (1)",
    "anisotropy_exponent": "p of anisotropy ∝ count^p (1)",
    "nu_quoted": "ratio of one network of uniform points, by an independent program (1)",
    "deviations": "nu_quoted - nu_mean of the largest size, in nu_std of the smallest (1)",
    **best.COLUMNS,
    "identity": "which identity of Voronoi cells or central springs",
    "identity_error": "largest departure from it over all networks (1)",
    **energy.COLUMNS,
}
IDENTITIES = {
    "content": "Σ A L = d V",
    "closure": "Σ A n = 0 of each cell",
    "affine_sum": "k = A/L, held: normal block sums to d",
    "bulk": "k = A/L, at rest: bulk modulus 1/d",
    "cauchy": "held: Cauchy's ratio",
    "above_affine": "relaxed <= affine",
}


def run(solid: Solid = homogenise, setting: Setting = FULL) -> Evidence:
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
    groups = networks.groupby(["axes", "point_set", "stiffness", "count"], sort=False)
    solids = pd.DataFrame([summary(rows) for _, rows in groups])
    families = solids.groupby(["axes", "point_set", "stiffness"], sort=False)
    spread = pd.DataFrame([exponents(rows) for _, rows in families])
    quoted = pd.DataFrame(against_quoted(solids))
    identities = pd.DataFrame(
        {"identity": name, "identity_error": float(np.abs(networks[key]).max())}
        for key, name in IDENTITIES.items()
    )
    routes = pd.DataFrame(
        setting.sweep(
            partial(energy.compare_tensors, solid), energy.CASES, "random solids, third route"
        )
    )
    chosen = pd.DataFrame(best.choices(networks))
    values = (
        *(farthest_value(networks[key], 0.0) for key in IDENTITIES),
        farthest_value(quoted["deviations"], 0.0),
        from_half(spread),
        farthest_value(routes["squares_error"], 0.0),
    )
    return Evidence(
        tables={
            "random_solids": solids,
            "random_spread": spread,
            "random_quoted": quoted,
            "random_best": chosen,
            "random_identities": identities,
            "random_energy": routes,
        },
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"random_nu": drawing.ratios, "random_spread": drawing.spread},
        columns=COLUMNS,
        findings=findings(solids, chosen, spread),
        rounding={"identity_error": 1e-10, "squares_error": 1e-10},
    )


def summary(rows: pd.DataFrame) -> dict[str, Any]:
    """One row of the table `random_solids`, from the networks of one kind and size."""
    number = len(rows)
    spread = rows["nu"].std()
    reach = stdtrit(number - 1, 0.5 + CONFIDENCE / 2) * spread / math.sqrt(number)
    head = {key: rows[key].iloc[0] for key in ("axes", "point_set", "stiffness", "count")}
    mean = rows[["nu", "E", "nu_affine", "E_affine", "neighbours", "anisotropy"]].mean()
    lost = rows[["bulk_lost", "shear_lost", "E_lost"]].mean().round(12)
    return head | {
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
        "mean_anisotropy": anisotropy(np.mean(list(rows["tensor"]), axis=0)),
        "zener_mean": isotropic_moduli(np.mean(list(rows["tensor"]), axis=0)).zener,
    }


def exponents(rows: pd.DataFrame) -> dict[str, Any]:
    """One row of the table `random_spread`: how scatter falls with the number of points."""
    count = rows["count"].to_numpy(dtype=float)
    away = np.log(count) - np.log(count).mean()
    # The logarithm of a standard deviation from S fair draws scatters by 1/√(2S - 2).
    error = 1 / math.sqrt(2 * (rows["seeds"].iloc[0] - 1) * (away @ away))
    power = observed_order(count, rows["nu_std"])
    return {key: rows[key].iloc[0] for key in ("axes", "point_set", "stiffness", "seeds")} | {
        "nu_exponent": power if math.isfinite(power) else "none",
        "nu_exponent_error": error,
        "anisotropy_exponent": observed_order(count, rows["anisotropy"]),
    }


def from_half(spread: pd.DataFrame) -> Observed:
    """Mean exponent of the spread from -1/2, in standard errors of that mean."""
    power = pd.to_numeric(spread["nu_exponent"], errors="coerce")
    error = spread.groupby(["axes", "point_set"])["nu_exponent_error"].first()
    together = math.sqrt((error**2).sum()) / len(error)
    return Observed(float((power.mean(skipna=False) + 0.5) / together))


def against_quoted(solids: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of the table `random_quoted`."""
    rows = []
    for dim, ratios in QUOTED.items():
        for rule, quoted in ratios.items():
            small, *_, large = records(solids, axes=dim, point_set="uniform", stiffness=rule)
            rows.append(
                {
                    "axes": dim,
                    "point_set": "uniform",
                    "stiffness": rule,
                    "nu_quoted": quoted,
                    **{
                        key: large[key]
                        for key in ("count", "seeds", "nu_mean", "nu_low", "nu_high")
                    },
                    "nu_std": large["nu_std"],
                    "deviations": (quoted - large["nu_mean"]) / max(small["nu_std"], NO_SCATTER),
                }
            )
    return rows


def findings(solids: pd.DataFrame, chosen: pd.DataFrame, spread: pd.DataFrame) -> tuple[str, ...]:
    """Which solids Voronoi networks are, why, and which is best for what."""
    top = best.largest(solids)
    told = []
    for dim, name in ((2, "In the plane"), (3, "in space")):
        uniform = top[(top["axes"] == dim) & (top["point_set"] == "uniform")]
        ratios = ", ".join(
            f"{row['nu_mean']:.4f} ± {row['nu_high'] - row['nu_mean']:.4f} "
            f"({RULES[row['stiffness']]}; one network ± {row['nu_std']:.4f})"
            for row in records(uniform)
        )
        told.append(f"{name}, {uniform['count'].iloc[0]} uniform points: {ratios}")
    kept = top[(top["axes"] == 2) & (top["stiffness"] == "A/L")].set_index("point_set")
    directions = ", ".join(
        f"{100 * kept['mean_anisotropy'][points]:.1f} % ({points.replace('_', ' ')})"
        for points in POINT_SETS
    )
    power = pd.to_numeric(spread["nu_exponent"], errors="coerce").mean()
    first = "A Voronoi network has no one Poisson's ratio: its rule of stiffness decides. "
    axes = (
        "Jittered points are not isotropic however many: they keep the axes of the grid that they "
        f"were strewn in. The mean tensor of plane networks of A/L is {directions} from isotropic."
    )
    scatter = (
        f"One network's ratio scatters as the number of points to the power {power:.2f} on average."
    )
    return first + "; ".join(told) + ".", why(top), best.finding(chosen), axes, scatter


def why(top: pd.DataFrame) -> str:
    """Why relaxation moves the ratio away from Cauchy's, and which way."""
    plane = top[(top["axes"] == 2) & (top["point_set"] == "uniform")].set_index("stiffness")
    lost = ", ".join(
        f"{100 * plane['bulk_lost'][rule]:.1f} and {100 * plane['shear_lost'][rule]:.1f} % "
        f"({RULES[rule]})"
        for rule in STIFFNESS_RULES
    )
    return (
        "With its points held a network has Cauchy's ratio by any rule. Relaxation takes of the "
        f"bulk and of the shear modulus, for uniform points in the plane, {lost}. The ratio rises "
        "where shear loses more. When all lengths grow alike, a spring of k = 1 pulls by its "
        "length, so a point is drawn to its far neighbours and much of the bulk modulus goes; one "
        "of A/L pulls by its facet, and the facets of a closed cell balance: the bulk modulus is "
        "1/d for every seed, and all that is lost is shear."
    )
