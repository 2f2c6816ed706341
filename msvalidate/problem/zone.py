"""Zones, the regions of a body that consist of another material."""

from __future__ import annotations

import math

import numpy as np

from msvalidate.problem.arrays import Array, Mask, Span
from msvalidate.problem.checks import (
    finite_coordinates,
    format_value,
    length_in_metres,
    require_one_of,
    require_type,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.material import Isotropic, Material
from msvalidate.problem.records import dataclass
from msvalidate.problem.region import Region
from msvalidate.problem.shapes import CELLS, FACETS, SHAPES, is_on_any


@dataclass(frozen=True)
class Ball:
    """Disc (2D) or ball (3D), the region of a `Zone`.

    Parameters
    ----------
    centre
        Coordinates (m) of the centre, d = 2 or 3 of them.
    radius
        Radius (m), > 0.

    Raises
    ------
    ProblemError
        If the centre is not a tuple of 2 or 3 coordinates, or the radius is not positive.

    Examples
    --------
    >>> import numpy as np
    >>> from msvalidate import Ball
    >>> disc = Ball(centre=(0.5, 0.5), radius=0.2)
    >>> disc.select(np.array([[0.5, 0.6], [0.9, 0.9]]), tolerance=1e-9).tolist()
    [True, False]
    """

    centre: tuple[float, ...]
    radius: float

    def __post_init__(self) -> None:
        place = finite_coordinates("ball: centre", self.centre)
        if not isinstance(self.centre, tuple) or place.shape not in {(2,), (3,)}:
            raise ProblemError(
                f"ball: centre {format_value(self.centre)}; give a tuple of 2 or 3 coordinates"
            )
        length_in_metres("ball: radius", self.radius)

    def __str__(self) -> str:
        place = ", ".join(f"{x:g}" for x in self.centre)
        return f"({'disc' if self.dim == 2 else 'ball'} of radius {self.radius:g} at ({place}))"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return len(self.centre)

    def depth(self, points: Array) -> Array:
        """Depth (n,) in m of the points (n, d) below the surface, negative outside."""
        return np.asarray(self.radius - np.linalg.norm(points - np.array(self.centre), axis=1))

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) in it to within `tolerance` (m)."""
        return np.asarray(self.depth(points) >= -tolerance)

    def on_rim(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) within `tolerance` (m) of its surface."""
        return np.asarray(np.abs(self.depth(points)) <= tolerance)

    def meets(self, span: Span) -> bool:
        """Return True if the ball overlaps the bounding box of a body."""
        low, high = np.array(span).T
        return bool(self.depth(np.clip([self.centre], low, high))[0] > 0)


@dataclass(frozen=True, eq=False)
class CellSet:
    """Named cells of a mesh, as the region of a `Zone`; `Mesh.zone` returns one.

    Parameters
    ----------
    name
        Name in messages.
    shape
        Cell shape, a name in `SHAPES`.
    places
        Nodes (m) of the cells, shape (c, k, d).
    rim
        Nodes (m) of the facets that belong to only one of these cells, shape (f, k, d).

    Raises
    ------
    ProblemError
        If the shape is unknown, there is no cell, or an array does not fit the shape.
    """

    name: str
    shape: str
    places: Array
    rim: Array

    def __post_init__(self) -> None:
        said = f"cell set {format_value(self.name)}"
        require_one_of(f"{said}: shape", self.shape, CELLS)
        for which in ("places", "rim"):
            given = finite_coordinates(f"{said}: {which}", getattr(self, which))
            object.__setattr__(self, which, given)
        kind = SHAPES[self.shape]
        wanted = (len(kind.nodes), kind.dim), (kind.facets.shape[1], kind.dim)
        if (self.places.shape[1:], self.rim.shape[1:]) != wanted or not len(self.places):
            raise ProblemError(
                f"{said}: places {self.places.shape} and rim {self.rim.shape}; take mesh.zone(name)"
            )

    def __str__(self) -> str:
        return f"cells {format_value(self.name)}"

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.places.shape[2])

    def select(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) in the cells to within `tolerance` (m)."""
        return is_on_any(SHAPES[self.shape], self.places, points, tolerance)

    def on_rim(self, points: Array, tolerance: float) -> Mask:
        """Mask (n,) of the points (n, d) within `tolerance` (m) of where the cells end."""
        return is_on_any(FACETS[self.dim, self.rim.shape[1]], self.rim, points, tolerance)


@dataclass(frozen=True)
class Zone:
    """Region of a body that consists of a different material.

    Parameters
    ----------
    region
        A `Region` with an extent along each axis, such as Region(((0.0, 0.5), None)); a `Ball`; or
        named cells of a mesh, `Mesh.zone`.
    material
        Material of the zone. `Problem` requires the state and thickness of the body's material.

    Raises
    ------
    ProblemError
        If the region is flat along an axis, or material and region differ in dimension.

    Examples
    --------
    >>> from msvalidate import Isotropic, Region, Zone
    >>> stiff_half = Zone(Region(((0.5, 1.0), None)), Isotropic(E=1e6, nu=0.3))
    >>> stiff_half.region.dim
    2
    """

    region: Region | Ball | CellSet
    material: Material

    def __post_init__(self) -> None:
        if not isinstance(self.region, Region | Ball | CellSet):
            raise ProblemError(
                f"zone: region {format_value(self.region)}; give a Region of intervals, a Ball or "
                "a mesh.zone(name)"
            )
        if isinstance(self.region, Region) and self.region.normal_axes:
            raise ProblemError(
                f"zone: region {self.region} has no extent along each axis; give intervals "
                "(low, high), or None for the whole"
            )
        require_type(f"zone {self.region}: material", self.material, Material)
        if self.material.dim != self.region.dim:
            raise ProblemError(
                f"zone {self.region}: a {self.material.dim}D material in {self.region.dim}D"
            )


def refuse_other_state(zone: Zone, material: Material) -> None:
    """Raise `ProblemError` unless a zone's material has a body's dimension, state and thickness."""
    own, said = zone.material, f"zone {zone.region}"
    if own.dim != material.dim:
        raise ProblemError(f"{said}: {own.dim}D, the body {material.dim}D")
    states = [m.state for m in (own, material) if isinstance(m, Isotropic)]
    if len(set(states)) > 1:  # a tensor has no state of its own
        raise ProblemError(
            f"{said}: material in {states[0]}, the body in {states[1]}; give both one state"
        )
    if not math.isclose(own.thickness, material.thickness, rel_tol=1e-12):
        raise ProblemError(
            f"{said}: {own.thickness:g} m thick, the body {material.thickness:g} m; give both one "
            "thickness"
        )
