"""Summary: the report's load cases in one table, with its springs and with isotropic ones.

Question   Displacement where springs and elements differ most, 20 cells on a side of 1 m.
Candidate  The spring network: k2 = 2 k1 with boundary weight 1, as in the report, and k2 = k1/2
           with boundary weight 1/2.
Reference  scikit-fem elements of the target: axial modulus of the springs, nu = 1/2 and 1/3.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pandas as pd

from msvalidate import kit

from .load_cases import BAND, CASES
from .models import MODELS

CELLS = 20
"""Cells on a side of 1 m: the finest square lattice of both modes."""
SPRINGS: dict[str, dict[str, Any]] = {
    "k2 = 2 k1": {"k2": MODELS[1].k[1], "weights": "equal"},
    "k2 = k1/2": {"k2": MODELS[0].k[1], "weights": "shared"},
}
"""Springs in words -> their rows of table `cases`."""
MM = 1e3
"""Millimetres in a metre."""


def summarise(cases: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """Table `summary` from table `cases`: the farthest probe and component of each load case."""
    chosen = cases[(cases["lattice"] == "square") & (cases["cells_y"] == CELLS)]
    rows = []
    for words, model in SPRINGS.items():
        is_model = np.isclose(chosen["k2"].to_numpy(dtype=float), model["k2"])
        own = chosen[is_model & (chosen["weights"] == model["weights"])]
        for case in CASES:
            part = own[own["case"] == case]
            farthest = part.iloc[int(part["total"].abs().argmax())]
            rows.append(_row(f"{case}, {words}", farthest))
    return kit.summary_tables(rows)


def _row(words: str, row: pd.Series) -> dict[str, object]:
    springs, target = MM * row["u_springs"], MM * row["u_target"]
    return kit.summary_row(
        words, springs, target, scale=abs((springs - target) / row["total"]),
        uncertainty=row["reference"], tolerance=BAND,
        more={"place": f"{row['component']}, {row['probe']}"},
    )  # fmt: skip
