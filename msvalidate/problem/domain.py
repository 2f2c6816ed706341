"""Where: the body's domain and named parts of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from msvalidate.problem.values import AXES, Array, Mask, ProblemError, finite, positive

SIDES = {
    "left": (0, 0),
    "right": (0, 1),
    "bottom": (1, 0),
    "top": (1, 1),
    "back": (2, 0),
    "front": (2, 1),
}
"""Side name -> (axis normal to it, 0 for the low end or 1 for the high end)."""
PLACEMENT = 1e-9
"""Two places closer than this fraction of the body are the same place: far above rounding of
coordinates (1e-16), far below any spacing that fits in memory."""


@dataclass(frozen=True)
class Region:
    """The points of a body whose coordinates are as said: a point, an edge, a face or a part of it.

    Parameters
    ----------
    extent
        One entry per axis: a coordinate (m), a closed interval ``(low, high)`` (m), or None where
        any coordinate will do.
    """

    extent: tuple[float | tuple[float, float] | None, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.extent, tuple) or len(self.extent) not in {2, 3}:
            raise ProblemError(f"region: {self.extent!r}; give a tuple of 2 or 3 entries")
        for axis, entry in zip(AXES, self.extent, strict=False):
            if entry is None:
                continue
            name = f"region {self.extent!r}"
            values = finite(f"{name}, {axis}", entry)
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
    def normal_axes(self) -> tuple[int, ...]:
        """The axes along which the region has no extension: one for a face, d for a point."""
        flat = [a for a, e in enumerate(self.extent) if not (e is None or isinstance(e, tuple))]
        return tuple(flat)

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) that lie in the region to within `tolerance` (m)."""
        chosen = np.ones(len(points), dtype=bool)
        for x, entry in zip(points.T, self.extent, strict=True):
            if entry is not None:
                low, high = entry if isinstance(entry, tuple) else (entry, entry)
                chosen &= (x >= low - tolerance) & (x <= high + tolerance)
        return chosen


@dataclass(frozen=True)
class Box:
    """Axis-aligned box with one corner at the origin.

    Parameters
    ----------
    size
        Edge lengths (m): (width,  height) or (width, height, depth).
    """

    size: tuple[float, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.size, tuple) or len(self.size) not in {2, 3}:
            raise ProblemError(f"box size: {self.size!r}; give a tuple of 2 or 3 lengths")
        for axis, length in zip(AXES, self.size, strict=False):
            positive(f"box size along {axis}", length, "m")

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.size)

    @property
    def volume(self) -> float:
        """Area (m²) in the plane, volume (m³) in space."""
        return math.prod(self.size)

    @property
    def tolerance(self) -> float:
        """Distance (m) below which two places are one."""
        return PLACEMENT * max(self.size)

    def side(self, name: str) -> Region:
        """Return a whole side; names in `SIDES`. Raises `ProblemError` for any other."""
        axis, end = SIDES.get(name, (self.dim, 0))
        if axis >= self.dim:
            names = ", ".join(side for side, (a, _) in SIDES.items() if a < self.dim)
            raise ProblemError(f"side {name!r}: a {self.dim}D box has {names}")
        return Region(tuple(self.size[a] * end if a == axis else None for a in range(self.dim)))

    def bounds(self, region: Region) -> list[tuple[float, float]]:
        """Return the low and high coordinate (m) of the region along each axis.

        Raises
        ------
        ProblemError
            If the region is not of this dimension or reaches outside the box.
        """
        if region.dim != self.dim:
            raise ProblemError(f"region {region} has {region.dim} axes, the box {self.dim}")
        bounds = []
        for axis, length, entry in zip(AXES, self.size, region.extent, strict=False):
            whole = (0.0, length) if entry is None else entry
            low, high = whole if isinstance(whole, tuple) else (whole, whole)
            if low < -self.tolerance or high > length + self.tolerance:
                raise ProblemError(
                    f"region {region} reaches outside the box, 0 <= {axis} <= {length:g}"
                )
            bounds.append((low, high))
        return bounds
