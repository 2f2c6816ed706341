"""Outlines and shaded surfaces of meshes in figures."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.colors import LightSource
from mpl_toolkits.mplot3d.art3d import Poly3DCollection

from msvalidate.problem import Array, Index, Mask
from reference_fem.mesh.discretisation import Discretisation

SHARP = math.cos(0.5)
"""Cosine of the smallest angle between facets whose common edge is drawn.

Facets of a curve meet at less.
"""
TURNED = 115
"""Sum of the azimuths (degrees) of the light and of the viewer.

That of the light is clockwise from y, that of the viewer counter-clockwise from x: the light comes
from 25 degrees to the left of the viewer.
"""


def outline_edges(mesh: Discretisation) -> Index:
    """Return node pairs (e, 2) of the outline in 2D, of sharp edges in 3D."""
    facets = mesh.surface
    if mesh.dim == 3:
        return sharp_edges(mesh.points, flat_facets(facets))
    if facets.shape[1] == 2:
        return facets
    return np.concatenate([facets[:, [0, 2]], facets[:, [2, 1]]])


def flat_facets(facets: Index) -> Index:
    """Corners (f, 3 or 4) of facets in 3D."""
    return facets[:, : 3 if facets.shape[1] in (3, 6) else 4]


def draw_surface(axis: Any, places: Array, colours: Any, **style: Any) -> None:
    """Shaded surface of flat facets (f, k, 3), whose axes are drawn in this order."""
    light = LightSource(azdeg=TURNED - axis.azim, altdeg=np.copysign(45, axis.elev))
    style |= {"shade": True, "lightsource": light, "linewidths": 0.3, "rasterized": True}
    axis.add_collection3d(Poly3DCollection(places, facecolors=colours, edgecolors=colours, **style))


def hidden(axis: Any, points: Array, surface: Array) -> Mask:
    """Mask (n,) of points (n, 3) behind a closed surface, as drawn on axes.

    The surface has facets (s, k, 3). A facet that faces the viewer covers a point to the left of
    all its edges, and hides it if all its corners are nearer to the viewer.
    """
    turn = axis.get_proj()[:3, :3].T
    corners = surface @ turn
    edge, off = np.roll(corners, -1, axis=1) - corners, (points @ turn)[:, None, None] - corners
    covers = (edge[..., 0] * off[..., 1] > edge[..., 1] * off[..., 0]).all(axis=2)
    return np.asarray((covers & (off[..., 2] > 0).all(axis=2)).any(axis=1))


def sharp_edges(points: Array, facets: Index) -> Index:
    """Sharp edges (e, 2) between flat facets (f, 3 or 4)."""
    x = points[facets]
    normal = np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    pairs = np.sort(np.stack([facets, np.roll(facets, -1, axis=1)], axis=2).reshape(-1, 2), axis=1)
    owner = np.repeat(np.arange(len(facets)), facets.shape[1])
    order = np.lexsort(pairs.T[::-1])
    pairs, owner = pairs[order], owner[order]
    same: Mask = (pairs[1:] == pairs[:-1]).all(axis=1)
    first = np.flatnonzero(same)
    cosine = (normal[owner[first]] * normal[owner[first + 1]]).sum(axis=1)
    return np.asarray(pairs[first[cosine < SHARP]])
