"""Cells under pressure, U = -p ln J + (λ/2) ln²J: the neo-Hookean volume term.

λ is the cells' stiffness and p their pressure at rest, which balances the tension of springs of no
rest length; p = μ of these. J stays above 0. Source: W = (μ/2)(F:F - d - 2 ln J) + (λ/2) ln²J,
[SimoPister1984].
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array
from msvalidate.springs.network.laws.law import CellLaw


def excess_of_log(x: Array) -> Array:
    """Compute x - log(1 + x) without cancellation for small x."""
    y = x / (2 + x)  # log(1 + x) = 2 artanh y
    series = x * y - 2 * y**3 * (1 / 3 + y**2 * (1 / 5 + y**2 / 7))
    return np.where(np.abs(x) < 1e-2, series, x - np.log1p(x))


LOGARITHMIC = CellLaw(
    "logarithmic",
    at_rest=lambda stiffness, p: -p,
    change=lambda stiffness, p, j: (stiffness * np.log1p(j) + p * j) / (1 + j),
    curvature=lambda stiffness, p, j: (stiffness * (1 - np.log1p(j)) + p) / (1 + j) ** 2,
    work=lambda stiffness, p, j: p * excess_of_log(j) + 0.5 * stiffness * np.log1p(j) ** 2,
    barrier=True,
)
