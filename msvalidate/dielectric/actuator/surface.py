"""The surface of a plane network: where springs have the body on one side only."""

from __future__ import annotations

from typing import Any

import numpy as np
import shapely

from msvalidate.network import Network
from msvalidate.problem import Array, Index, Mask, ProblemError

SAME_PLACE = 1e-9
"""Distance over the length of a segment below which its middle is on the surface: rounding of
coordinates is 1e-16, and what is not on the surface is a good part of a segment away."""


def is_off_surface(network: Network, pairs: Index) -> Index:
    """Which of some springs, pairs of points (s, 2), have the body on both sides or on neither.

    Faces between springs, as these cross, are found among springs up to two away.
    """
    near = np.zeros(len(network.points), dtype=bool)
    near[pairs] = True
    near[network.springs[near[network.springs].any(axis=1)]] = True
    body = _enclosed_shape(network, np.asarray(near[network.springs].any(axis=1)))
    ends = network.points[pairs]
    away = shapely.distance(shapely.boundary(body), shapely.points(ends.mean(axis=1)))
    length = np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1)
    # An empty boundary is at a distance of NaN.
    return np.asarray(np.flatnonzero(~(away <= SAME_PLACE * length)))


def outline(network: Network) -> Index:
    """Points (k,) around a plane network, counter-clockwise, the last not the first again.

    Raises
    ------
    ProblemError
        If the body is in parts, or springs cross at the surface where there is no point.
    """
    body = _enclosed_shape(network, np.ones(len(network.springs), dtype=bool))
    if body.geom_type != "Polygon":
        raise ProblemError("network: its springs enclose no body in one part; join them by points")
    corners = shapely.get_coordinates(shapely.orient_polygons(body).exterior)[:-1]
    tree = shapely.STRtree(shapely.points(network.points))
    _, found = tree.query_nearest(shapely.points(corners), all_matches=False)
    away: Array = np.linalg.norm(network.points[found] - corners, axis=1)
    if away.max() > SAME_PLACE * np.ptp(network.points, axis=0).max():
        x, y = corners[away.argmax()]
        raise ProblemError(
            f"network: springs cross at ({x:g}, {y:g}) m on the surface; put a point there"
        )
    return np.asarray(found, dtype=np.intp)


def _enclosed_shape(network: Network, which: Mask) -> Any:
    """What some springs (mask, m) enclose between them, as a shape."""
    lines = shapely.linestrings(network.points[network.springs[which]])
    faces = shapely.get_parts(shapely.polygonize([shapely.unary_union(lines)]))
    return shapely.unary_union(faces)
