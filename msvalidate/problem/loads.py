"""Loads: forces at places, on sides, in the volume, and weight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from msvalidate.problem.arrays import Field
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    format_value,
    positive_number,
    require_type,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.records import dataclass
from msvalidate.problem.region import Part, Region


@dataclass(frozen=True)
class PointForce:
    """Force (N) of d components at one place (m)."""

    at: tuple[float, ...]
    force: tuple[float, ...]

    def __post_init__(self) -> None:
        force = finite("point force", self.force)
        place = finite_coordinates("place of a point force", self.at)
        if place.shape != force.shape or place.shape not in {(2,), (3,)}:
            raise ProblemError(
                f"point force {format_value(self.force)} at {format_value(self.at)}: give 2 or 3 "
                f"numbers each"
            )
        require_type("place of a point force", self.at, tuple)

    @property
    def region(self) -> Region:
        """The point as a region."""
        return Region(self.at)


@dataclass(frozen=True)
class Traction:
    """Force per area (Pa) on a face (d = 3) or an edge (d = 2) of the body, or on a part of it.

    The region has exactly one flat axis, or is a segment or boundary. The traction has d components
    (Pa), or is a field of points (n, d) -> (n, d).
    """

    region: Part
    traction: tuple[float, ...] | Field

    def __post_init__(self) -> None:
        check_region("traction", self.region)
        if not self.region.is_facet:
            raise ProblemError(
                f"traction on {self.region}: a traction acts on a side of the body, where exactly "
                "one coordinate is fixed; or give a Segment"
            )
        check_vector(f"traction on {self.region}", self.traction, self.region.dim)


@dataclass(frozen=True)
class BodyForce:
    """Force per volume (N/m³): d components, or a field of points (n, d) -> (n, d)."""

    force: tuple[float, ...] | Field

    def __post_init__(self) -> None:
        if not callable(self.force):
            finite("body force", self.force, (2, 3), need="give 2 or 3 components or a field")

    @classmethod
    def gravity(cls, density: float, acceleration: tuple[float, ...]) -> BodyForce:
        """Weight of a body of one density (kg/m³), or what else accelerates all of its mass alike.

        The acceleration has d components (m/s²), such as (0.0, -9.81): downwards along y. `Weight`
        has the density of each zone.

        Raises `ProblemError` if the density is not above zero, the acceleration not 2 or 3 finite
        numbers, or their product beyond the largest number or below the smallest: a weight that is
        none would pass for a body without weight.
        """
        rho = positive_number("gravity: density", density, "kg/m³")
        need = "give 2 or 3 components in m/s², such as (0.0, -9.81)"
        g = finite("gravity", acceleration, (2, 3), need=need)
        with np.errstate(over="ignore", under="ignore"):
            weight = rho * g
        size = np.abs(weight[g != 0])
        if not ((size >= np.finfo(float).tiny) & (size < np.inf)).all():
            raise ProblemError(
                f"gravity: density {rho:g} kg/m³ by {format_value(acceleration)} m/s² is no "
                "ordinary number; choose units in which it is"
            )
        return cls(tuple(weight.tolist()))


@dataclass(frozen=True)
class Weight:
    """Weight of a body: the density of its material, or of each zone's, times an acceleration.

    That has d components (m/s²), such as (0.0, -9.81): downwards along y.
    """

    acceleration: tuple[float, ...]

    def __post_init__(self) -> None:
        finite("weight", self.acceleration, (2, 3), need="give 2 or 3 components in m/s²")
        require_type("weight: acceleration", self.acceleration, tuple)


Load = PointForce | Traction | BodyForce | Weight


def check_region(name: str, region: object) -> None:
    """Raise `ProblemError` unless it is a part of a body."""
    if not isinstance(region, Part):
        raise ProblemError(
            f"{name}: region {format_value(region)}; give a Region, such as box.side('left'), a "
            "Segment, or a mesh.side(name)"
        )


def check_vector(name: str, value: Sequence[float] | Field, dim: int) -> None:
    """Raise `ProblemError` for a constant that has not one component an axis."""
    if not callable(value) and finite(name, value).shape != (dim,):
        raise ProblemError(f"{name}: {format_value(value)}; give {dim} components")
