"""Orders: with which power of the spacing does the discretisation error fall at each probe?"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from msvalidate.bench.judging.singularity import clamped_free_exponent

from .load_cases import CASES
from .models import MODELS, Model, homogenised

PLAUSIBLE = (0.5, 3.0)
"""Outside this, or where the error changes sign, two sizes give no order."""
SMOOTH, SMOOTH_ERROR = 1.95, 0.15
"""Order without clamps, from 1.8 to 2.1: 2 in the limit, from below where the loads' ends are not
yet resolved. Held from both sides, since a softer network can show a higher order."""
DOUBTFUL = 0.25
"""Part of the finer size's error that the reference's own may be: it moves the order by 0.3."""
CLAMPED_CORNERS = {
    ("square", "block"): (90,),
    ("square", "bar"): (90,),
    ("triangular", "bar"): (60, 120),
}
"""Angles (degrees) inside the body between a held edge and the free edge next to it. The zigzag
edge of a triangular block has none: what angle it ends at depends on how near one looks."""
BY = ["case", "lattice", "k1", "k2", "probe", "component"]


def observed_orders(cases: pd.DataFrame) -> pd.DataFrame:
    """Order of the discretisation error for every two sizes that follow each other."""
    rows = []
    shared = cases[cases["weights"] == "shared"]
    for key, group in shared.groupby(BY, sort=False):
        head = dict(zip(BY, key, strict=True))
        model = next(m for m in MODELS if (m.lattice, m.k) == (head["lattice"], key[2:4]))
        corner = twice_exponent(str(head["case"]), model)
        columns = ["cells_y", "discretisation", "reference"]
        series = group.sort_values("cells_y", kind="stable")[columns].to_numpy()
        for (coarse, before, _), (fine, after, uncertainty) in pairwise(series):
            found = order(before, after, fine / coarse, uncertainty)
            row = {"cells_y_coarse": int(coarse), "cells_y": int(fine), "order": found}
            rows.append(head | row | {"twice_corner_exponent": corner})
    return pd.DataFrame(rows)


def order(before: float, after: float, ratio: float, uncertainty: float = 0.0) -> float | str:
    """Power with which an error fell as the spacing was divided by `ratio`, or a word.

    `uncertainty` is the uncertainty of `after`.
    """
    if uncertainty > DOUBTFUL * abs(after):
        return "not resolved"
    if before * after <= 0:
        return "not asymptotic"
    power = float(np.log(before / after) / np.log(ratio))
    return power if PLAUSIBLE[0] <= power <= PLAUSIBLE[1] else "not asymptotic"


def finest(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the finest two sizes of each body."""
    last = table.groupby(["case", "lattice"])["cells_y"].transform("max")
    return table[table["cells_y"] == last]


def twice_exponent(case: str, model: Model) -> float | str:
    """Twice the displacement's exponent at the worst clamped corner: an energy's order there."""
    held = CASES[case].supports
    if not {"left", "right"} & set(held):
        return "no clamp"
    kind = (model.lattice, "bar" if case == "bending" else "block")
    if kind not in CLAMPED_CORNERS:
        return "zigzag edge"
    tensor = homogenised(model).C
    return float(
        2 * min(clamped_free_exponent(tensor, np.deg2rad(a)) for a in CLAMPED_CORNERS[kind])
    )
