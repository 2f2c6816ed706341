"""Loads: forces at places, on sides, in the volume, and weight."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

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
    """Concentrated force at one point of a body.

    Parameters
    ----------
    at
        Coordinates (m) of the point, d = 2 or 3 of them.
    force
        Force (N), d components. In 2D it is the total force over the thickness.

    Raises
    ------
    ProblemError
        If the two do not have the same 2 or 3 finite components, or `at` is no tuple.

    Examples
    --------
    >>> from msvalidate import PointForce
    >>> load = PointForce(at=(0.37, 0.2), force=(0.0, -5.0))
    >>> load.region.normal_axes
    (0, 1)
    """

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
    """Surface traction on an edge (2D) or a face (3D): a Neumann boundary condition.

    Parameters
    ----------
    region
        Side of the body or part of it: a `Region` with exactly one fixed coordinate, a segment, a
        named boundary of a `Mesh`, or the name of a side of the problem's domain.
    traction
        Force per area (Pa): d components, or a function of points (n, d) in m that returns (n, d).
        In 2D the area is the length of the edge times the thickness of the material.

    Raises
    ------
    ProblemError
        If the region is no edge or face, or the traction does not have d finite components.

    Examples
    --------
    >>> from msvalidate import Box, Traction
    >>> box = Box((0.4, 0.1))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> bending = Traction(box.side("right"), lambda x: 1e3 * (0.05 - x[:, [1]]) * [1.0, 0.0])
    """

    region: Part
    traction: tuple[float, ...] | Field

    def __init__(self, region: Part | str, traction: Sequence[float] | Field) -> None:
        object.__setattr__(self, "region", region)
        object.__setattr__(self, "traction", as_tuple(traction))
        if isinstance(region, str):  # which the problem resolves
            return
        check_region("traction", region)
        if not region.is_facet:
            raise ProblemError(
                f"traction on {region}: a traction acts on a side of the body, where exactly "
                "one coordinate is fixed; or give a Segment"
            )
        check_vector(f"traction on {region}", self.traction, region.dim)


@dataclass(frozen=True)
class BodyForce:
    """Force per volume that acts in the whole body.

    Parameters
    ----------
    force
        Force per volume (N/m³): d components, or a function of points (n, d) in m that returns
        (n, d).

    Raises
    ------
    ProblemError
        If constant components are not 2 or 3 finite numbers.

    Examples
    --------
    >>> from msvalidate import BodyForce
    >>> weight = BodyForce.gravity(density=1000.0, acceleration=(0.0, -9.81))
    >>> weight.force
    (0.0, -9810.0)
    """

    force: tuple[float, ...] | Field

    def __post_init__(self) -> None:
        if not callable(self.force):
            finite("body force", self.force, (2, 3), need="give 2 or 3 components or a field")

    @classmethod
    def gravity(cls, density: float, acceleration: tuple[float, ...]) -> BodyForce:
        """Return the weight per volume (N/m³) of a body of uniform density.

        The same expression describes any uniform acceleration. `Weight` uses the density of each
        zone.

        Parameters
        ----------
        density
            Mass density (kg/m³), > 0.
        acceleration
            Acceleration (m/s²), d components; (0.0, -9.81) acts downwards along y.

        Raises
        ------
        ProblemError
            If the density is not positive, the acceleration is not 2 or 3 finite numbers, or their
            product overflows or underflows: a weight of zero would pass for a body without weight.
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
    """Weight of a body: the density of each material times an acceleration.

    Parameters
    ----------
    acceleration
        Acceleration (m/s²), d components; (0.0, -9.81) acts downwards along y.

    Raises
    ------
    ProblemError
        If the acceleration is not a tuple of 2 or 3 finite numbers.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Weight, lattice_network, square
    >>> box = Box((0.4, 0.1))
    >>> material = Isotropic(E=1e5, nu=1 / 3, thickness=0.2)
    >>> problem = Problem(box, material, supports=(), loads=(Weight((0.0, -9.81)),))
    >>> network = lattice_network(problem, square(box, (4, 1)))
    >>> print(f"{network.force[:, 1].sum():.4f} N")  # 1000 kg/m³, 0.008 m³
    -78.4800 N
    """

    acceleration: tuple[float, ...]

    def __post_init__(self) -> None:
        finite("weight", self.acceleration, (2, 3), need="give 2 or 3 components in m/s²")
        require_type("weight: acceleration", self.acceleration, tuple)


Load = PointForce | Traction | BodyForce | Weight


def as_tuple(value: Any) -> Any:
    """Return a list or an array as a tuple, and anything else unchanged."""
    given = value.tolist() if isinstance(value, np.ndarray) else value
    return tuple(given) if isinstance(given, list) else given


def check_region(name: str, region: object) -> None:
    """Raise `ProblemError` unless a region is a `Region`, `Segment` or `Boundary`."""
    if not isinstance(region, Part):
        raise ProblemError(
            f"{name}: region {format_value(region)}; give a Region, such as box.side('left'), a "
            "Segment, or a mesh.side(name)"
        )


def check_vector(name: str, value: Sequence[float] | Field, dim: int) -> None:
    """Raise `ProblemError` for a constant that has not one component an axis."""
    if not callable(value) and finite(name, value).shape != (dim,):
        raise ProblemError(f"{name}: {format_value(value)}; give {dim} components")
