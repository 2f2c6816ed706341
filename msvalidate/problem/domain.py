"""Domains of a problem: a box, a polygon or a mesh."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import cached_property
from typing import ClassVar

import numpy as np
import shapely
from numpy.typing import NDArray

from msvalidate.problem.arrays import AXES, PLACEMENT, Array, Mask, Span
from msvalidate.problem.checks import (
    finite_coordinates,
    format_value,
    length_in_metres,
    refuse_far_off,
    refuse_too_many,
    require_type,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.mesh import Mesh
from msvalidate.problem.records import dataclass
from msvalidate.problem.region import Boundary, Part, Region
from msvalidate.problem.zone import CellSet, Zone

SIDES = {
    "left": (0, 0),
    "right": (0, 1),
    "bottom": (1, 0),
    "top": (1, 1),
    "back": (2, 0),
    "front": (2, 1),
}
"""Side name -> (normal axis, 0 for the low or 1 for the high end)."""
MOST_VERTICES = 10_000
"""Maximum number of vertices of a polygon, since searches go over all edges."""


@dataclass(frozen=True)
class Box:
    """Rectangle (2D) or cuboid (3D) with one corner at the origin.

    Its sides are "left" and "right" along x, "bottom" and "top" along y, and "back" and "front"
    along z.

    Parameters
    ----------
    size, more
        Edge lengths (m) along x, y (and z), each > 0, as one tuple or list, or one by one.

    Raises
    ------
    ProblemError
        If there are not 2 or 3 positive lengths, or the shortest is not above 1e-9 of the
        longest.

    Examples
    --------
    >>> from msvalidate import Box
    >>> beam = Box(0.37, 0.2)  # or Box((0.37, 0.2))
    >>> beam.dim, round(beam.volume, 6)
    (2, 0.074)
    >>> print(beam.side("right"))
    (x = 0.37)
    """

    size: tuple[float, ...]

    def __init__(self, size: Sequence[float] | float, *more: float) -> None:
        given = (size, *more) if more or not isinstance(size, list | tuple) else tuple(size)
        if len(given) not in {2, 3}:
            raise ProblemError(f"box size: {format_value(size)}; give 2 or 3 lengths in m")
        object.__setattr__(self, "size", given)
        for axis, edge in zip(AXES, self.size, strict=False):
            length_in_metres(f"box size along {axis}", edge)
        if min(self.size) <= self.tolerance:
            raise ProblemError(
                f"{self}: thinner than {self.tolerance:g} m, where two places are one in a body of "
                "this length; give lengths less far apart"
            )

    def __str__(self) -> str:
        return f"box {' x '.join(f'{edge:g}' for edge in self.size)} m"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.size)

    @property
    def span(self) -> Span:
        """Low and high coordinate (m) along each axis."""
        return tuple((0.0, float(length)) for length in self.size)

    @property
    def volume(self) -> float:
        """Area (m²) in the plane, volume (m³) in space."""
        return math.prod(self.size)

    @property
    def tolerance(self) -> float:
        """Distance (m) below which two places are one."""
        return PLACEMENT * max(self.size)

    def side(self, name: str) -> Region:
        """Return a whole side; names in `problem.SIDES`. Raises `ProblemError` for any other."""
        axis, end = SIDES.get(name, (self.dim, 0)) if isinstance(name, str) else (self.dim, 0)
        if axis >= self.dim:
            names = ", ".join(side for side, (a, _) in SIDES.items() if a < self.dim)
            raise ProblemError(f"side {format_value(name)}: a {self.dim}D box has {names}")
        return Region(tuple(self.size[a] * end if a == axis else None for a in range(self.dim)))

    def on_boundary(self, places: Array) -> bool:
        """Return True if all points (k, d) in m lie on one side."""
        return any(
            bool((np.abs(places[:, axis] - end) <= self.tolerance).all())
            for axis in range(self.dim)
            for end in self.span[axis]
        )

    def contains(self, points: Array) -> Mask:
        """Mask (n,) of the points (n, d) in the body, its surface included."""
        away = np.maximum(-points, points - np.array(self.size))
        return np.asarray((away <= self.tolerance).all(axis=1))


@dataclass(frozen=True)
class Polygon:
    """2D body with a straight-edged outline.

    Parameters
    ----------
    vertices
        Corners (m) in counter-clockwise order, two coordinates each. Three consecutive corners must
        not lie on one line.

    Raises
    ------
    ProblemError
        If the outline is clockwise, crosses or touches itself, has a corner of 180 degrees or a
        repeated vertex, or has more than 10,000 vertices.

    Examples
    --------
    >>> from msvalidate import Polygon
    >>> bracket = Polygon(((0, 0), (0.3, 0), (0.3, 0.1), (0.1, 0.1), (0.1, 0.3), (0, 0.3)))
    >>> round(bracket.volume, 6)  # area in m²
    0.05
    >>> bracket.reentrant.tolist()
    [[0.1, 0.1]]
    """

    vertices: tuple[tuple[float, float], ...]
    dim: ClassVar[int] = 2

    def __post_init__(self) -> None:
        if not isinstance(self.vertices, tuple) or len(self.vertices) < 3:
            given = format_value(self.vertices)
            raise ProblemError(f"polygon: {given}; give a tuple of 3 or more vertices")
        refuse_too_many("polygon", len(self.vertices), MOST_VERTICES, "vertices")
        for i, vertex in enumerate(self.vertices):
            name = f"polygon vertex {i}"
            if not isinstance(vertex, tuple) or finite_coordinates(name, vertex).shape != (2,):
                raise ProblemError(
                    f"polygon: vertex {i} is {format_value(vertex)}; give 2 coordinates"
                )
        sides = np.linalg.norm(np.roll(self.corners, -1, axis=0) - self.corners, axis=1)
        twins = np.flatnonzero(sides <= self.tolerance)
        if len(twins):
            raise ProblemError(
                f"polygon: vertex {twins[0]}, {self.vertices[twins[0]]}, and the next are one "
                "place; leave one out"
            )
        refuse_far_off("polygon", self.corners)
        flat = np.flatnonzero(np.abs(np.sin(self._turns)) < 1e-9)
        if len(flat):
            raise ProblemError(
                f"polygon: the outline does not turn at vertex {flat[0]}, "
                f"{self.vertices[flat[0]]}, or turns back; leave it out"
            )
        self._refuse_crossing()
        if not self.volume > self.tolerance * max(high - low for low, high in self.span):
            raise ProblemError(
                f"polygon: area {self.volume:g} m²; list the vertices counter-clockwise"
            )

    def __str__(self) -> str:
        sizes = " x ".join(f"{high - low:g}" for low, high in self.span)
        return f"polygon of {len(self.vertices)} vertices, {sizes} m"

    @cached_property
    def corners(self) -> Array:
        """The vertices (n, 2) in m."""
        corners = np.array(self.vertices, dtype=float)
        corners.setflags(write=False)
        return corners

    @cached_property
    def span(self) -> Span:
        """Low and high coordinate (m) along each axis."""
        low, high = self.corners.min(axis=0), self.corners.max(axis=0)
        return tuple((float(a), float(b)) for a, b in zip(low, high, strict=True))

    @property
    def volume(self) -> float:
        """Area (m²): half the sum of the cross products of following vertices."""
        x, y = (self.corners - self.corners.mean(axis=0)).T
        return float(0.5 * (x @ np.roll(y, -1) - y @ np.roll(x, -1)))

    @property
    def tolerance(self) -> float:
        """Distance (m) below which two places are one."""
        return PLACEMENT * max(high - low for low, high in self.span)

    @property
    def reentrant(self) -> Array:
        """Corners (k, 2) in m whose angle inside the body is above 180 degrees."""
        return np.asarray(self.corners[self._turns < 0])

    def on_boundary(self, places: Array) -> bool:
        """Return True if all points (k, 2) in m lie on one edge."""
        return self.edge_with(places) is not None

    def edge_with(self, places: Array) -> Array | None:
        """Ends (2, 2) in m of the edge with all points (k, 2), or None."""
        near = shapely.dwithin(self._edges[:, None], shapely.points(places), self.tolerance)
        on = near.all(axis=1)
        return shapely.get_coordinates(self._edges[on.argmax()]) if on.any() else None

    def contains(self, points: Array) -> Mask:
        """Mask (n,) of the points (n, 2) in the body, its outline included."""
        body = shapely.Polygon(self.corners)
        shapely.prepare(body)
        inside = shapely.intersects_xy(body, *points.T)
        beside = shapely.points(points[~inside])
        inside[~inside] = shapely.dwithin(body, beside, self.tolerance)
        return np.asarray(inside)

    @cached_property
    def _edges(self) -> NDArray[np.object_]:
        """Each edge (n,) as a line, the body on its left."""
        ends = np.stack([self.corners, np.roll(self.corners, -1, axis=0)], axis=1)
        return np.asarray(shapely.linestrings(ends))

    @property
    def _turns(self) -> Array:
        """Angle (n,) in rad by which the outline turns at each vertex, left positive."""
        x, y = (self.corners - np.roll(self.corners, 1, axis=0)).T
        forward = np.arctan2(y, x)
        return np.asarray((np.roll(forward, -1) - forward + np.pi) % (2 * np.pi) - np.pi)

    def _refuse_crossing(self) -> None:
        """Raise `ProblemError` for two edges that are not neighbours and share a point."""
        edges, n = self._edges, len(self.vertices)
        pairs = shapely.STRtree(edges).query(edges, predicate="dwithin", distance=self.tolerance).T
        gap = (pairs[:, 1] - pairs[:, 0]) % n
        if crossing := sorted(pairs[(gap > 1) & (gap < n - 1)].tolist()):
            i, j = crossing[0]
            raise ProblemError(f"polygon: edges {i} and {j} cross or touch")


Domain = Box | Polygon | Mesh


def corners_of(region: Part, domain: Domain) -> Array:
    """Corners (k, d) in m of a region of a domain.

    On a mesh, whose sides need not reach the ends of its span, a part of a side has the corners of
    the facets that lie in it.

    Raises `ProblemError` if the region is not of this dimension, reaches outside the body's span,
    or is no part of a mesh's sides.
    """
    _refuse_misfit(region, domain)
    corners = region.corners(domain.span)
    for axis, (low, high), x in zip(AXES, domain.span, corners.T, strict=False):
        if x.min() < low - domain.tolerance or x.max() > high + domain.tolerance:
            raise ProblemError(
                f"region {region} reaches outside the body, {low:g} <= {axis} <= {high:g}"
            )
    if isinstance(domain, Mesh) and not isinstance(region, Boundary):
        if region.is_facet:
            return domain.part(region).corners(domain.span)
        if isinstance(region, Region) and len(region.normal_axes) < domain.dim:
            return domain.places_in(region)
    return np.asarray(corners)


def measure_of(region: Part, domain: Domain) -> float:
    """Compute the length (m) or area (m²) of a region on a side.

    On a mesh it is that of the facets, as for `corners_of`.

    Raises `ProblemError` if the region is not of this dimension, or is no part of a mesh's sides.
    """
    _refuse_misfit(region, domain)
    if isinstance(domain, Mesh) and not isinstance(region, Boundary):
        region = domain.part(region)
    return region.measure(domain.span)


def _refuse_misfit(region: Part, domain: Domain) -> None:
    require_type("region", region, Part)
    require_type("domain", domain, Domain)
    if region.dim != domain.dim:
        raise ProblemError(f"region {region} has {region.dim} axes, the body {domain.dim}")


def refuse_off_body(zone: Zone, domain: Domain) -> None:
    """Raise `ProblemError` for a zone outside the body, or of another mesh's cells."""
    region = zone.region
    if isinstance(region, CellSet):
        if not (isinstance(domain, Mesh) and region.name in domain.zones) or not np.array_equal(
            domain.zone(region.name).places, region.places
        ):
            raise ProblemError(
                f"zone {region}: not of the problem's own {domain}; take its mesh.zone(name)"
            )
        return
    low, high = np.array(domain.span).T
    if isinstance(region, Region):
        meets = bool(region.overlaps(low[None], high[None], domain.tolerance)[0])
    else:
        meets = region.meets(domain.span)
    if not meets:
        raise ProblemError(f"zone {region}: outside the body, a {domain}; leave it out or move it")
