"""Which random solid is best for what, and which of the others its seeds do not tell from it.

Networks of one seed share their points among the rules, so families are compared seed by seed:
means by Student's t of the differences, spreads by Pitman's and Morgan's test, the correlation of
sums with differences, which is 0 where two variances are equal. Each other family is compared at
95 % by itself.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtr

from msvalidate.constants.stiffness import CAUCHY
from msvalidate.judging.compare import CONFIDENCE
from msvalidate.problem import Array

RULES = {"1": "k = 1", "1/L": "k = 1/L", "A/L": "k = A/L"}
"""How tables and figures call rules of stiffness."""
WANTED = 0.5
"""Ratio of an incompressible solid, and of a sheet of one."""
SPREAD = "least spread of the ratio"
COLUMNS = {
    "criterion": "what a point set and a rule are chosen for, at the largest size",
    "value": "what the criterion asks to be small (1)",
    "next_value": "the same of the second best (1)",
    "not_told_apart": "families that these seeds do not tell from the best, each at 95 %, "
    'or "none"',
}


def choices(networks: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows of the table `random_best`: the best point set and rule by each criterion."""
    rows = []
    for dim, same in largest(networks).groupby("axes", sort=False):
        kinds = same.groupby(["point_set", "stiffness"])
        families = {(str(points), str(rule)): found for (points, rule), found in kinds}
        for criterion, samples in score_families(families, CAUCHY[int(str(dim))]).items():
            chosen = choice(samples, by_spread=criterion == SPREAD)
            rows.append({"axes": dim, "criterion": criterion} | chosen)
    return rows


def score_families(families: dict[Any, pd.DataFrame], cauchy: float) -> dict[str, dict[Any, Array]]:
    """Of each criterion and family, what its networks (s,) show, in the order of the seeds.

    Distances of a mean ratio have the sign that makes their mean positive.
    """

    def away(rows: pd.DataFrame, ratio: float) -> Array:
        distance = rows["nu"].to_numpy() - ratio
        return np.asarray(distance * math.copysign(1.0, distance.mean()))

    of: dict[str, Callable[[pd.DataFrame], Array]] = {
        SPREAD: lambda rows: rows["nu"].to_numpy(),
        "least anisotropy": lambda rows: rows["anisotropy"].to_numpy(),
        "least modulus lost by relaxation": lambda rows: rows["E_lost"].to_numpy(),
        "nearest to Cauchy's ratio": lambda rows: away(rows, cauchy),
        "nearest to a ratio of 1/2": lambda rows: away(rows, WANTED),
    }
    return {
        criterion: {
            key: sample(rows.sort_values("seed", kind="stable")) for key, rows in families.items()
        }
        for criterion, sample in of.items()
    }


def choice(samples: dict[Any, Array], by_spread: bool) -> dict[str, Any]:
    """The family of the least mean, or spread, the next one, and those not told from the best."""
    value = {
        key: float(sample.std(ddof=1) if by_spread else sample.mean())
        for key, sample in samples.items()
    }
    first, *rest = sorted(value, key=lambda key: value[key])
    apart = differ_by_spread if by_spread else differ_by_mean
    alike = [family_name(*key) for key in rest if not apart(samples[first], samples[key])]
    return {
        "point_set": first[0],
        "stiffness": first[1],
        "value": value[first],
        "next_value": value[rest[0]],
        "not_told_apart": "; ".join(alike) or "none",
    }


def differ_by_mean(one: Array, other: Array) -> bool:
    """Whether the mean of the differences (s,) is away from 0, by Student's t.

    Source: [Student1908].
    """
    difference = one - other
    error = difference.std(ddof=1) / math.sqrt(len(difference))
    if error == 0:
        return bool(difference.mean() != 0)
    return is_likely(difference.mean() / error, len(difference) - 1)


def differ_by_spread(one: Array, other: Array) -> bool:
    """Whether two spreads differ, by Pitman's and Morgan's test.

    Source: [Pitman1939], [Morgan1939].
    """
    together, apart = one + other, one - other
    together, apart = together - together.mean(), apart - apart.mean()
    size = np.linalg.norm(together) * np.linalg.norm(apart)
    if size == 0:
        return False
    r = float(together @ apart / size)
    free = len(one) - 2
    return is_likely(r * math.sqrt(free / max(1 - r**2, np.finfo(float).eps)), free)


def is_likely(t: float, free: int) -> bool:
    """Whether Student's t is outside its interval of 95 %.

    Source: [Student1908].
    """
    return bool(2 * stdtr(free, -abs(t)) < 1 - CONFIDENCE)


def largest(table: pd.DataFrame) -> pd.DataFrame:
    """Rows of the largest networks of each dimension."""
    return table[table["count"] == table.groupby("axes")["count"].transform("max")]


def family_name(points: object, rule: str) -> str:
    """A family as sentences call it."""
    return f"{str(points).replace('_', ' ')} {RULES[rule]}"


def others(alike: str) -> str:
    """How many families a cell of `not_told_apart` names."""
    number = alike.count(";") + 1
    return "one other" if number == 1 else f"{number} others"


def finding(best: pd.DataFrame) -> str:
    """Which is best for scatter, how sure that is, and where the rest is told."""
    said = []
    for dim, place in ((2, "the plane"), (3, "space")):
        row = best[(best["axes"] == dim) & (best["criterion"] == SPREAD)].iloc[0]
        alike = row["not_told_apart"]
        said.append(
            f"in {place} {family_name(row['point_set'], row['stiffness'])}, "
            + ("told from every other" if alike == "none" else f"not told from {others(alike)}")
        )
    sure = int((best["not_told_apart"] == "none").sum())
    return (
        f"Which random solid is best depends on what for (table random_best); {sure} of "
        f"{len(best)} winners are told apart from every other. Least spread of the ratio: "
        f"{'; '.join(said)}."
    )
