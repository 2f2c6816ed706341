"""Compiled curvature of the energy along a direction; plain form: `network.tangent`."""

from __future__ import annotations

import numpy as np

from msvalidate.kernels.cells import volume_curvature
from msvalidate.kernels.compiling import compiled
from msvalidate.kernels.values import Axes, Cells
from msvalidate.problem import Array, Index


def curvature(
    axes: Axes,
    u: Array,
    direction: Array,
    springs: Index,
    vector: Array,
    stiffness: Array,
    rest_length: Array,
    volumes: Cells,
) -> float:
    """Second derivative of the energy along `direction`."""
    total = volume_curvature(axes, u, direction, volumes)
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


curvature = compiled(curvature)
