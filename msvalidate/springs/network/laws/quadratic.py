"""Quadratic volume energy of cells, U = ½ κ (J - 1)², the default law."""

from __future__ import annotations

import numpy as np

from msvalidate.springs.network.laws.law import CellLaw

QUADRATIC = CellLaw(
    "quadratic",
    at_rest=lambda kappa, p: np.zeros_like(kappa),
    change=lambda kappa, p, j: kappa * j,
    curvature=lambda kappa, p, j: kappa + 0.0 * j,
    work=lambda kappa, p, j: 0.5 * kappa * j**2,
    compiled=True,
)
