"""Compiled curvature of the energy of Hooke's springs along a direction; plain: `mode_energy`."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.springs.kernels.compiling import compiled
from msvalidate.springs.kernels.values import Axes


@compiled()
def curvature(
    axes: Axes,
    u: Array,
    direction: Array,
    springs: Index,
    vector: Array,
    stiffness: Array,
    rest_length: Array,
) -> float:
    """Second derivative of the energy along `direction`."""
    total = 0.0
    for e in range(len(springs)):
        i, j = springs[e, 0], springs[e, 1]
        square = apart = along = 0.0
        for a in range(len(axes)):
            now = vector[e, a] + (u[j, a] - u[i, a])
            change = direction[j, a] - direction[i, a]
            square += now * now
            apart += change * change
            along += now * change
        stretched = along * along / square
        slack = 1 - rest_length[e] / np.sqrt(square)
        total += stiffness[e] * (stretched + slack * (apart - stretched))
    return total
