"""Regions of a body, given by coordinates, by a line segment or by mesh facets."""

from __future__ import annotations

import math
from itertools import product
from typing import ClassVar

import numpy as np

from msvalidate.problem.arrays import AXES, Array, Mask, Span
from msvalidate.problem.checks import finite_coordinates, format_value, length_in_metres
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.records import dataclass
from msvalidate.problem.shapes import FACETS, facet_areas, is_on_any


@dataclass(frozen=True)
class Region:
    """Points of a body with given coordinates: a point, edge, face or part of one.

    Parameters
    ----------
    extent
        One entry per axis: a coordinate (m), a closed interval ``(low, high)`` (m), or None for any
        coordinate.

    Raises
    ------
    ProblemError
        If it is not a tuple of 2 or 3 such entries, or an interval does not have low < high.

    Examples
    --------
    >>> import numpy as np
    >>> from msvalidate import Region
    >>> lower_half_of_left_side = Region((0.0, (0.0, 0.5)))
    >>> points = np.array([[0.0, 0.2], [0.0, 0.8], [0.1, 0.2]])
    >>> lower_half_of_left_side.select(points, tolerance=1e-9).tolist()
    [True, False, False]
    """

    extent: tuple[float | tuple[float, float] | None, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.extent, tuple) or len(self.extent) not in {2, 3}:
            raise ProblemError(
                f"region: {format_value(self.extent)}; give a tuple of 2 or 3 entries"
            )
        for axis, entry in zip(AXES, self.extent, strict=False):
            if entry is None:
                continue
            name = f"region {format_value(self.extent)}"
            values = finite_coordinates(f"{name}, {axis}", entry)
            interval = isinstance(entry, tuple) and values.shape == (2,) and values[0] < values[1]
            if values.ndim and not interval:
                raise ProblemError(f"{name}: {axis} must be a number, (low, high) or None")

    def __str__(self) -> str:
        parts = []
        for axis, entry in zip(AXES, self.extent, strict=False):
            if isinstance(entry, tuple):
                parts.append(f"{entry[0]:g} <= {axis} <= {entry[1]:g}")
            elif entry is not None:
                parts.append(f"{axis} = {entry:g}")
        return f"({', '.join(parts) or 'everywhere'})"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.extent)

    @property
    def is_facet(self) -> bool:
        """True if the region is part of an edge (2D) or face (3D)."""
        return len(self.normal_axes) == 1

    @property
    def normal_axes(self) -> tuple[int, ...]:
        """Axes along which the region is flat: one for a face, d for a point."""
        flat = [a for a, e in enumerate(self.extent) if not (e is None or isinstance(e, tuple))]
        return tuple(flat)

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) in the region, within `tolerance` (m)."""
        chosen = np.ones(len(points), dtype=bool)
        for x, entry in zip(points.T, self.extent, strict=True):
            if entry is not None:
                low, high = entry if isinstance(entry, tuple) else (entry, entry)
                chosen &= (x >= low - tolerance) & (x <= high + tolerance)
        return chosen

    def on_rim(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) at the ends of the region's intervals."""
        near = np.zeros(len(points), dtype=bool)
        for x, entry in zip(points.T, self.extent, strict=True):
            if isinstance(entry, tuple):
                near |= np.minimum(np.abs(x - entry[0]), np.abs(x - entry[1])) <= tolerance
        return near & self.select(points, tolerance)

    def overlaps(self, low: Array, high: Array, tolerance: float) -> Mask:
        """Mask (n,) of the boxes that overlap the region by more than a rim.

        The boxes have low and high ends (n, d) in m.

        Along the axes where it is flat, whatever they have.
        """
        chosen = np.ones(len(low), dtype=bool)
        for a, b, entry in zip(low.T, high.T, self.extent, strict=True):
            if isinstance(entry, tuple):
                chosen &= (b > entry[0] + tolerance) & (a < entry[1] - tolerance)
        return chosen

    def corners(self, span: Span) -> Array:
        """Corners (k, d) in m of the region in a body of this span."""
        return np.array(list(product(*self._bounds(span))))

    def measure(self, span: Span) -> float:
        """Length (m), area (m²) or volume (m³) of the region; 1 for a point.

        The span is that of the body.
        """
        return math.prod(ends[1] - ends[0] for ends in self._bounds(span) if len(ends) == 2)

    def _bounds(self, span: Span) -> list[tuple[float, ...]]:
        """Along each axis the two ends (m), or the one coordinate where the region is flat."""
        bounds: list[tuple[float, ...]] = []
        for axis, entry in enumerate(self.extent):
            whole = span[axis] if entry is None else entry
            bounds.append(whole if isinstance(whole, tuple) else (whole,))
        return bounds


@dataclass(frozen=True)
class Segment:
    """Straight line segment in a 2D body, such as a side of a polygon.

    Parameters
    ----------
    start, end
        Coordinates (m) of its ends, two each.

    Raises
    ------
    ProblemError
        If they are not two different places of two coordinates each.

    Examples
    --------
    >>> from msvalidate import Segment, Support
    >>> slope = Support(Segment((0.0, 0.0), (0.37, 0.2)))
    """

    start: tuple[float, float]
    end: tuple[float, float]
    dim: ClassVar[int] = 2
    is_facet: ClassVar[bool] = True

    def __post_init__(self) -> None:
        for name, place in (("start", self.start), ("end", self.end)):
            if not isinstance(place, tuple) or finite_coordinates(
                f"segment {name}", place
            ).shape != (2,):
                raise ProblemError(
                    f"segment {name}: {format_value(place)}; give a tuple of 2 coordinates"
                )
        if self.start == self.end:
            raise ProblemError(f"segment: starts and ends at {self.start}; give two places")
        length_in_metres(f"segment {self}: its length", math.dist(self.start, self.end))

    def __str__(self) -> str:
        (x0, y0), (x1, y1) = self.start, self.end
        return f"(({x0:g}, {y0:g}) to ({x1:g}, {y1:g}))"

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, 2) on the segment, within `tolerance` (m)."""
        start = np.array(self.start)
        along = np.array(self.end) - start
        length = float(np.linalg.norm(along))
        offset = points - start
        forward = offset @ along / length
        across = (along[0] * offset[:, 1] - along[1] * offset[:, 0]) / length
        between = (forward >= -tolerance) & (forward <= length + tolerance)
        return np.asarray(between & (np.abs(across) <= tolerance))

    def corners(self, _span: Span) -> Array:
        """The two ends (2, 2) in m, whatever the body."""
        return np.array([self.start, self.end])

    def measure(self, _span: Span) -> float:
        """Length (m), whatever the body."""
        return math.dist(self.start, self.end)


@dataclass(frozen=True, eq=False)
class Boundary:
    """Facets of a mesh that form a named part of its surface.

    `Mesh.side` returns one.

    Parameters
    ----------
    name
        Name in messages.
    places
        Nodes (m) of each facet, shape (f, k, d): corners, mid-side nodes, centre node. They run
        counter-clockwise as seen from outside; in 2D the body is on the left.

    Raises
    ------
    ProblemError
        If `places` has no facet, another shape or a value that is not finite.
    """

    name: str
    places: Array
    is_facet: ClassVar[bool] = True

    def __post_init__(self) -> None:
        places = finite_coordinates(f"boundary {format_value(self.name)}: places", self.places)
        if places.ndim != 3 or places.shape[:0:-1] not in FACETS or not len(places):
            known = ", ".join(f"(f, {k}, {d})" for d, k in FACETS)
            raise ProblemError(
                f"boundary {format_value(self.name)}: places {places.shape}; give one of {known}"
            )
        object.__setattr__(self, "places", places)

    def __str__(self) -> str:
        return f"boundary {format_value(self.name)}"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.places.shape[2])

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) on the facets, within `tolerance` (m).

        The facets may be curved.
        """
        shape = FACETS[self.dim, self.places.shape[1]]
        return is_on_any(shape, self.places, np.asarray(points), tolerance)

    def corners(self, _span: Span) -> Array:
        """Every node (k, d) in m of the facets, whatever the body."""
        return np.asarray(np.unique(self.places.reshape(-1, self.dim), axis=0))

    def measure(self, _span: Span) -> float:
        """Length or area (m, m²) of the facets, whatever the body."""
        return float(facet_areas(self.places).sum())


Part = Region | Segment | Boundary
