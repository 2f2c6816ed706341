"""Orders: with which power of the spacing does the discretisation error fall at each probe?"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pandas as pd

from msvalidate.singularity import clamped_free_exponent
from studies.displacement.load_cases import CASES
from studies.displacement.models import MODELS, Model, homogenised

PLAUSIBLE = (0.5, 3.0)
"""Outside this, or where the error changes sign, two sizes give no order."""
CLAMPED_CORNERS = {
    ("square", "block"): (90,),
    ("square", "bar"): (90,),
    ("triangular", "block"): (60,),
    ("triangular", "bar"): (60, 120),
}
"""Angles (degrees) inside the body between a held edge and the free edge next to it."""
BY = ["case", "lattice", "k1", "k2", "probe", "component"]


def observed(cases: pd.DataFrame) -> pd.DataFrame:
    """Order of the discretisation error for every two sizes that follow each other."""
    rows = []
    shared = cases[cases["weights"] == "shared"]
    for key, group in shared.groupby(BY, sort=False):
        head = dict(zip(BY, key, strict=True))
        model = next(m for m in MODELS if (m.lattice, m.k) == (head["lattice"], key[2:4]))
        corner = twice_exponent(str(head["case"]), model)
        series = group.sort_values("cells_y")[["cells_y", "discretisation"]].to_numpy()
        for (coarse, before), (fine, after) in pairwise(series):
            found = order(before, after, fine / coarse)
            row = {"cells_y_coarse": int(coarse), "cells_y": int(fine), "order": found}
            rows.append(head | row | {"twice_corner_exponent": corner})
    return pd.DataFrame(rows)


def order(before: float, after: float, ratio: float) -> float | str:
    """Power with which an error fell as the spacing was divided by `ratio`, or a word."""
    if before * after <= 0:
        return "not asymptotic"
    power = float(np.log(before / after) / np.log(ratio))
    return power if PLAUSIBLE[0] <= power <= PLAUSIBLE[1] else "not asymptotic"


def finest(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of the finest two sizes of each lattice."""
    last = table.groupby("lattice")["cells_y"].transform("max")
    return table[table["cells_y"] == last]


def twice_exponent(case: str, model: Model) -> float | str:
    """Twice the displacement's exponent at the worst clamped corner: an energy's order there."""
    held = CASES[case].held
    if not {"left", "right"} & set(held):
        return "no clamp"
    angles = CLAMPED_CORNERS[model.lattice, "bar" if case == "bending" else "block"]
    tensor = homogenised(model).C
    return float(2 * min(clamped_free_exponent(tensor, np.deg2rad(a)) for a in angles))
