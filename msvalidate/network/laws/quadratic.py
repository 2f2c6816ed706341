"""Cells that resist a change of volume alone, U = ½ κ (J - 1)²: what cells are unless named."""

from __future__ import annotations

import numpy as np

from msvalidate.network.laws.law import CellLaw

QUADRATIC = CellLaw(
    "quadratic",
    at_rest=lambda kappa, p: np.zeros_like(kappa),
    change=lambda kappa, p, j: kappa * j,
    curvature=lambda kappa, p, j: kappa + 0.0 * j,
    work=lambda kappa, p, j: 0.5 * kappa * j**2,
    compiled=True,
)
