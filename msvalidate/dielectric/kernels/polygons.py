"""Compiled integrals of 1/r over flat polygons, exact as sums over edges.

With a point's distance `away` from the line of an edge, `height` from the polygon's plane, and
places s along the edge counted from the foot of its perpendicular,

    ∫dA/r = Σ away·[asinh(s/near)] - height·[atan(away·s/(near² + height·r))],

near² = away² + height², r² = near² + s², the brackets from the edge's start to its end
[Wilton1984]. The first is the integral in the plane, the second takes off what r does not fall
below.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array
from msvalidate.springs.kernels.compiling import compiled


@compiled(inner=True)
def edge(away: float, height: float, first: float, last: float) -> float:
    """Contribution of an edge to the integral.

    For a point on its line `away` is 0, and so is the contribution.
    """
    square = away * away + height * height
    if away == 0 or square == 0:
        return 0.0
    near = np.sqrt(square)
    total = away * (np.arcsinh(last / near) - np.arcsinh(first / near))
    if height > 0:
        beyond = np.arctan(away * last / (square + height * np.hypot(near, last)))
        before = np.arctan(away * first / (square + height * np.hypot(near, first)))
        total -= height * (beyond - before)
    return total


@compiled()
def seen(points: Array, corners: Array) -> Array:
    """∫dA/r (k, n) over polygons (n, c, 3) parallel to z = 0, as seen from points (k, 3).

    Corners are in counter-clockwise order; one that is repeated makes an edge of no length.
    """
    total = np.zeros((len(points), len(corners)))
    sides = corners.shape[1]
    for j in range(len(corners)):
        for c in range(sides):
            x, y = corners[j, c, 0], corners[j, c, 1]
            along_x, along_y = (
                corners[j, (c + 1) % sides, 0] - x,
                corners[j, (c + 1) % sides, 1] - y,
            )
            length = np.hypot(along_x, along_y)
            if length == 0:
                continue
            along_x, along_y = along_x / length, along_y / length
            for i in range(len(points)):
                to_x, to_y = x - points[i, 0], y - points[i, 1]
                away = to_x * along_y - to_y * along_x
                first = to_x * along_x + to_y * along_y
                height = abs(corners[j, c, 2] - points[i, 2])
                total[i, j] += edge(away, height, first, first + length)
    return total
