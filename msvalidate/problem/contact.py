"""Contact: a rigid obstacle that the surface of a body may touch but not penetrate.

A contact is no support: it pushes and never pulls, and what solves for rest asks supports to hold
every rigid motion beside it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np

from msvalidate.problem.arrays import Array
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    finite_number,
    format_value,
    positive_number,
    require_one_of,
    require_type,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.loads import check_region
from msvalidate.problem.records import dataclass
from msvalidate.problem.region import Part

OBSTACLES: Mapping[str, tuple[int, ...]] = {
    "half_space": (2, 3),
    "disc": (2,),
    "ball": (3,),
    "parabola": (2,),
    "paraboloid": (3,),
}
"""Shape of an obstacle -> number of axes of the bodies that may touch it.

Parabolas are the shapes of Hertz contact for discs: their gap and force act along the axis.
"""
ROUND = {"disc": "ball", "ball": "disc", "parabola": "paraboloid", "paraboloid": "parabola"}
"""Shape of an obstacle -> the same shape in the other dimension."""
SECOND_MOMENT = {2: 4.0, 3: 2.5}
"""Ratio of a² to the mean squared distance for pressures √(a² - x²), by axes."""


@dataclass(frozen=True)
class Obstacle:
    """Rigid obstacle that does not rotate.

    Parameters
    ----------
    shape
        Name in `OBSTACLES`.
    at
        Coordinates (m) of the foremost point, which touches a perpendicular plane first.
    towards
        Direction of its motion into the body, of any length.
    radius
        Radius of curvature (m) at the foremost point; None for a half-space.

    Raises
    ------
    ProblemError
        If the shape is unknown, `at` and `towards` do not have one finite number per axis,
        `towards` is zero, or the radius is not positive, missing, or given for a half-space.
    """

    shape: str
    at: tuple[float, ...]
    towards: tuple[float, ...]
    radius: float | None = None

    def __post_init__(self) -> None:
        require_one_of("obstacle", self.shape, OBSTACLES)
        axes = OBSTACLES[self.shape]
        need = "give 2 or 3 numbers, as many as the body has axes"
        if other := ROUND.get(self.shape):
            need = f"give {axes[0]} numbers; for a body in {5 - axes[0]}D take a {other}"
        at = f"{self.shape}: at {format_value(self.at)}"
        towards = f"{self.shape}: towards {format_value(self.towards)}"
        d = len(finite_coordinates(at, self.at, axes, need=need))
        if not finite(towards, self.towards, d, need=need).any():
            raise ProblemError(f"{self.shape}: towards has no length; give the way into the body")
        if (self.shape == "half_space") != (self.radius is None):
            need = "leave it out" if self.radius is not None else "give one in m"
            raise ProblemError(f"{self.shape}: radius {format_value(self.radius)}; {need}")
        if self.radius is not None:
            positive_number(f"{self.shape}: radius", self.radius, "m")

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.at)

    @property
    def axis(self) -> Array:
        """Unit vector (d,) along which the obstacle moves: its normal at the foremost point."""
        towards = np.array(self.towards, dtype=float)
        return np.asarray(towards / np.linalg.norm(towards))

    @property
    def is_round(self) -> bool:
        """True for a disc or ball, whose normal varies along the surface.

        The gap and force of all other shapes act along `axis`.
        """
        return self.shape in {"disc", "ball"}

    def gap(self, points: Array, depth: float = 0.0) -> Array:
        """Compute the gap (m) between points (n, d) and the obstacle, negative inside it.

        The obstacle is lowered by `depth` (m).

        Of a parabola the distance along its axis.
        """
        from_top = points - np.array(self.at) - depth * self.axis
        along = from_top @ self.axis
        if self.radius is None:
            return np.asarray(along)
        square = (from_top**2).sum(axis=1)
        if not self.is_round:
            return np.asarray(along + (square - along**2) / (2 * self.radius))
        # |x - c| - R without the cancellation: x - c is R·axis more than x from the top.
        out = np.linalg.norm(from_top + self.radius * self.axis, axis=1)
        return np.asarray((square + 2 * self.radius * along) / (out + self.radius))

    def normal(self, points: Array, depth: float = 0.0) -> Array:
        """Unit vectors (n, d) out of it at points (n, d): along them it pushes."""
        if not self.is_round or self.radius is None:
            return np.tile(self.axis, (len(points), 1))
        from_centre = points - np.array(self.at) + (self.radius - depth) * self.axis
        return np.asarray(from_centre / np.linalg.norm(from_centre, axis=1)[:, None])

    def across(self, points: Array) -> Array:
        """Vectors (n, d) in m from the axis of the obstacle to points (n, d)."""
        off = points - np.array(self.at)
        return np.asarray(off - np.outer(off @ self.axis, self.axis))

    def half_width(self, points: Array, force: Array) -> float:
        """Estimate the half-width or radius (m) of a Hertz contact patch from its forces.

        The forces (n,) act at points (n, d).

        a² = 4 Σ f x²/Σ f in the plane, 5/2 Σ f r²/Σ f in space, about the line on which it is
        lowered: second moments of pressures √(a² - x²). 0 where nothing touches.
        """
        total = float(force.sum())
        moment = float(force @ (self.across(points) ** 2).sum(axis=1))
        # Consistent forces of one node's pressure alone may have a moment below 0.
        return math.sqrt(SECOND_MOMENT[self.dim] * max(moment / total, 0.0)) if total else 0.0

    def centre(self, depth: float = 0.0) -> Array:
        """Centre (1, d) in m of a disc or ball lowered by `depth` (m)."""
        return np.atleast_2d(np.array(self.at) + (depth - (self.radius or 0.0)) * self.axis)


@dataclass(frozen=True)
class Contact:
    """Possible contact of a side with an obstacle that is lowered or pressed.

    Parameters
    ----------
    region
        Part of the surface, as for a load.
    obstacle
        Rigid obstacle.
    depth
        Distance (m) by which the obstacle is lowered from its position.
    force
        Force (N, over the whole thickness) along its direction instead of a depth, or None.
    friction
        Coefficient of friction in motions, >= 0; static contact is frictionless.

    Raises
    ------
    ProblemError
        If the region is no part of a side, region and obstacle differ in dimension, depth and force
        are both given, the force is not positive, or another value is out of range.
    """

    region: Part
    obstacle: Obstacle
    depth: float = 0.0
    force: float | None = None
    friction: float = 0.0

    def __post_init__(self) -> None:
        check_region("contact", self.region)
        name = f"contact on {self.region}"
        require_type(f"{name}: obstacle", self.obstacle, Obstacle)
        if not self.region.is_facet:
            raise ProblemError(f"{name}: no part of a side; give one, such as box.side('top')")
        if self.region.dim != self.obstacle.dim:
            raise ProblemError(
                f"{name}: an obstacle in {self.obstacle.dim}D for a body in {self.region.dim}D"
            )
        depth = finite_number(f"{name}: depth", self.depth)
        if self.force is not None:
            positive_number(f"{name}: force", self.force, "N")
            if depth:
                raise ProblemError(f"{name}: depth and force both; give one, the other follows")
        finite_number(f"{name}: friction", self.friction, least=0)
