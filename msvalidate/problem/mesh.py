"""Mesh domain: any outline in 2D or 3D, with straight or curved sides."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from copy import copy
from functools import cached_property

import numpy as np
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from msvalidate.problem.arrays import AXES, PLACEMENT, Array, Index, Mask, Span
from msvalidate.problem.cells import (
    plane_sections,
    refuse_folded,
    refuse_hanging,
    refuse_unused_points,
    surface_facets,
)
from msvalidate.problem.checks import (
    check_name,
    finite_coordinates,
    format_value,
    indices,
    integers,
    refuse_far_off,
    refuse_too_many,
    require_one_of,
)
from msvalidate.problem.errors import ProblemError
from msvalidate.problem.records import dataclass, field
from msvalidate.problem.region import Boundary, Region, Segment
from msvalidate.problem.shapes import CELLS, SHAPES, Shape, enclosed_volume, is_on_any
from msvalidate.problem.zone import CellSet


@dataclass(frozen=True, eq=False)
class Mesh:
    """Body that consists of cells of one shape, with named boundaries and zones.

    Two meshes are equal if their points, cells and shape are equal, whatever the names.

    Parameters
    ----------
    points
        Coordinates (m) of all nodes, shape (n, d).
    cells
        Node numbers of each cell, shape (c, k), in the order of VTK: corners counter-clockwise (in
        3D those of the first face as seen from the rest), mid-side nodes, face nodes, centre node.
    shape
        "triangle", "triangle6", "quad", "quad8" or "quad9" in 2D; "tetra", "tetra10", "hexahedron"
        or "hexahedron27" in 3D. Mid-side nodes may lie off the straight line: the side is then
        curved.
    boundaries
        Name -> node numbers (f, k) of facets on the surface, corners first.
    zones
        Name -> cell numbers (z,).

    Raises
    ------
    ProblemError
        If a cell is inverted, flat, folded or overlaps another one; a node coincides with another,
        belongs to no cell or lies in a cell without being one of its nodes; a boundary is empty or
        not on the surface; or a zone is empty or names a missing cell.

    Examples
    --------
    >>> from msvalidate import Mesh
    >>> mesh = Mesh(
    ...     points=[[0, 0], [1, 0], [1, 1], [0, 1]],
    ...     cells=[[0, 1, 2], [0, 2, 3]],
    ...     shape="triangle",
    ...     boundaries={"left": [[3, 0]]},
    ... )
    >>> print(mesh)
    mesh of 2 triangle cells, 1 x 1 m
    >>> print(mesh.side("left"))
    boundary 'left'
    """

    points: Array
    cells: Index
    shape: str
    boundaries: Mapping[str, Index] = field(default_factory=dict)
    zones: Mapping[str, Index] = field(default_factory=dict)

    def __post_init__(self) -> None:
        require_one_of("mesh shape", self.shape, CELLS)
        needs, d, k = f"{self.shape} needs", self.dim, len(self.kind.nodes)
        points = finite_coordinates("mesh points", self.points, "n>0", d, need=f"{needs} (n, {d})")
        self._take("points", points)
        need = f"{needs} (c, {k})"
        self._take("cells", indices("mesh cells", self.cells, len(points), "c>0", k, need=need))
        refuse_too_many("mesh", len(points))
        refuse_far_off("mesh", points)
        refuse_unused_points(self.points, self.cells, self.tolerance)
        refuse_folded(self.points, self.cells, self.kind)
        self._take("_surface", surface_facets(self.cells, self.kind))
        refuse_hanging(self.points, self.cells, self.kind, self.surface, self.tolerance)
        self._name(self.boundaries)
        self._name_zones(self.zones)

    def __str__(self) -> str:
        sizes = " x ".join(f"{high - low:g}" for low, high in self.span)
        return f"mesh of {len(self.cells)} {self.shape} cells, {sizes} m"

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Mesh):
            return NotImplemented
        return self is other or (
            self.shape == other.shape
            and np.array_equal(self.points, other.points)
            and np.array_equal(self.cells, other.cells)
        )

    def __hash__(self) -> int:
        return hash((self.shape, self.points.tobytes(), self.cells.tobytes()))

    @property
    def kind(self) -> Shape:
        """The shape of the cells: their nodes, facets and map."""
        return SHAPES[self.shape]

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return self.kind.dim

    @property
    def mean_edge(self) -> float:
        """Mean length (m) of the straight lines between neighbouring corners of facets."""
        rings = self.points[self.cells[:, np.array(self.kind.straight.rings)]]
        sides = np.linalg.norm(rings - np.roll(rings, -1, axis=2), axis=3)
        return float(sides.mean())

    @cached_property
    def span(self) -> Span:
        """Low and high coordinate (m) of the nodes along each axis.

        Curved sides may extend beyond it.
        """
        low, high = self.points.min(axis=0), self.points.max(axis=0)
        return tuple((float(a), float(b)) for a, b in zip(low, high, strict=True))

    @property
    def tolerance(self) -> float:
        """Distance (m) below which two places are one."""
        return PLACEMENT * max(high - low for low, high in self.span)

    @property
    def surface(self) -> Index:
        """Nodes (f, k) of the facets of one cell alone, counter-clockwise from outside."""
        facets: Index = self.__dict__["_surface"]
        return facets

    @cached_property
    def pieces(self) -> Index:
        """Number (n,) of the connected component of each node, from 0."""
        n, first = len(self.points), np.repeat(self.cells[:, 0], self.cells.shape[1])
        joined = csr_array((np.ones(first.size), (first, self.cells.ravel())), shape=(n, n))
        return np.asarray(connected_components(joined, directed=False)[1])

    @cached_property
    def volume(self) -> float:
        """Area (m²) or volume (m³), bent sides included."""
        return enclosed_volume(self.points[self.surface])

    def named(
        self, boundaries: Mapping[str, Index], zones: Mapping[str, Index] | None = None
    ) -> Mesh:
        """Return the same mesh with these boundaries instead, and these zones if any are given.

        Raises `ProblemError` as `Mesh`.
        """
        other = copy(self)
        other._name(boundaries)
        if zones is not None:
            other._name_zones(zones)
        return other

    def side(self, name: str) -> Boundary:
        """Return the boundary of a name. Raises `ProblemError` that lists the names for another."""
        return Boundary(name, self.points[_entry("boundary", self.boundaries, name)])

    def zone(self, name: str) -> CellSet:
        """Return the cells of a name. Raises `ProblemError` that lists the names for another."""
        cells = self.cells[_entry("zone", self.zones, name)]
        rim = surface_facets(cells, self.kind)
        return CellSet(name, self.shape, self.points[cells], self.points[rim])

    @cached_property
    def whole_surface(self) -> Boundary:
        """Every facet of the surface."""
        return Boundary("surface", self.points[self.surface])

    def on_boundary(self, places: Array) -> bool:
        """Return True if all points (k, d) in m lie on the surface."""
        return bool(self.whole_surface.select(places, self.tolerance).all())

    def contains(self, points: Array) -> Mask:
        """Mask (n,) of the points (n, d) in the body, its surface included."""
        return is_on_any(self.kind, self.points[self.cells], np.asarray(points), self.tolerance)

    def part(self, region: Region | Segment) -> Boundary:
        """Return the surface facets in a region, a side or part of it by coordinates.

        Raises `ProblemError` if no facet lies in the region, the region continues inside the body,
        or it ends between the ends of a facet.
        """
        inside = region.select(self.points, self.tolerance)
        facets = self.surface[inside[self.surface].all(axis=1)]
        if not len(facets):
            raise ProblemError(
                f"region {region}: no facet of the {self} lies there; give a part of a straight "
                f"side{self._named()}"
            )
        part = Boundary(str(region), self.points[facets])
        if isinstance(region, Segment):
            wanted, found = region.measure(self.span), part.measure(self.span)
            if abs(found - wanted) > 2 * self.tolerance:
                raise ProblemError(
                    f"region {region}: {found:g} of its {wanted:g} m are facets of the {self}; let "
                    "it end where facets do, on one straight side"
                )
            return part
        inside[facets] = False
        cut = inside.any() or self._continues_inside(region)
        if cut or self._ends_within_facets(region):
            how = "goes on inside the body" if cut else "ends between the ends of a facet"
            raise ProblemError(f"region {region}: it {how} of the {self}{self._named()}")
        return part

    def places_in(self, region: Region) -> Array:
        """Return the nodes (k, d) in m of a region inside the body.

        Raises `ProblemError` if no node lies in the region, or the region ends between two nodes.
        """
        extent = tuple(None if isinstance(entry, tuple) else entry for entry in region.extent)
        whole = self.points[Region(extent).select(self.points, self.tolerance)]
        inside = whole[region.select(whole, self.tolerance)]
        if not len(inside):
            raise ProblemError(f"region {region}: no point of the {self} lies there")
        for axis, entry in enumerate(region.extent):
            if isinstance(entry, tuple):
                reached, there = inside[:, axis], whole[:, axis]
                low, high = max(entry[0], there.min()), min(entry[1], there.max())
                if max(reached.min() - low, high - reached.max()) > self.tolerance:
                    raise ProblemError(
                        f"region {region}: the points of the {self} there run from {AXES[axis]} = "
                        f"{reached.min():g} to {reached.max():g} m; let it end at points"
                    )
        return np.asarray(inside)

    def _named(self) -> str:
        return f", or a side by name: {', '.join(self.boundaries)}" if self.boundaries else ""

    def _continues_inside(self, region: Region) -> bool:
        """Return True if cells extend through the plane of a region, within the region."""
        (axis,), room = region.normal_axes, self.tolerance
        plane = float(region.corners(self.span)[0, axis])
        x = self.points[self.cells][..., axis]
        through = (x.min(axis=1) < plane - room) & (x.max(axis=1) > plane + room)
        low, high = plane_sections(self.points[self.cells[through]], axis, plane)
        return bool(region.overlaps(low, high, room).any())

    def _ends_within_facets(self, region: Region) -> bool:
        """Return True if facets in the plane of a region extend across its rim."""
        places, room = self.points[self.surface], self.tolerance
        flat = Region(tuple(None if isinstance(e, tuple) else e for e in region.extent))
        inside = [each.select(places.reshape(-1, self.dim), room) for each in (flat, region)]
        level, whole = (each.reshape(self.surface.shape).all(axis=1) for each in inside)
        part = places[level & ~whole]
        return bool(region.overlaps(part.min(axis=1), part.max(axis=1), room).any())

    def _take(self, name: str, array: Array | Index) -> None:
        array.setflags(write=False)
        object.__setattr__(self, name, array)

    def _name(self, boundaries: object) -> None:
        self._take_named("boundaries", "facets", boundaries, self._checked)

    def _name_zones(self, zones: object) -> None:
        self._take_named("zones", "cells", zones, self._checked_cells)

    def _take_named(
        self, what: str, of: str, entries: object, checked: Callable[[object, Index], Index]
    ) -> None:
        if not isinstance(entries, Mapping):
            raise ProblemError(f"mesh {what}: {format_value(entries)}; give {of} by their names")
        found = {name: checked(name, each) for name, each in entries.items()}
        for each in found.values():
            each.setflags(write=False)
        object.__setattr__(self, what, found)

    def _checked_cells(self, name: object, numbers: Index) -> Index:
        """Numbers (z,) of a zone's cells, each once and rising.

        Raises `ProblemError` for a missing cell, an empty zone or a name that is none.
        """
        said = f"mesh zone {format_value(name)}"
        check_name("mesh zone", name)
        need = "give numbers (z,) of its cells"
        cells = indices(said, numbers, len(self.cells), "z>0", need=need, what="cells")
        return np.unique(cells)

    def _checked(self, name: object, numbers: Index) -> Index:
        """Facets (f, k) of a boundary, each once.

        Nodes are in the order of the surface. Raises `ProblemError` for a facet off the surface, an
        empty boundary or a name that is none.
        """
        said = f"mesh boundary {format_value(name)}"
        check_name("mesh boundary", name)
        k = self.surface.shape[1]
        facets = integers(
            said, numbers, "f>0", k, need=f"{self.shape} needs (f, {k}), or none of it"
        )
        both = np.sort(np.concatenate([self.surface, facets]), axis=1)
        _, first, which = np.unique(both, axis=0, return_index=True, return_inverse=True)
        at = first[which.ravel()[len(self.surface) :]]
        unknown = np.flatnonzero(at >= len(self.surface))
        if len(unknown):
            raise ProblemError(
                f"{said}: facet {facets[unknown[0]].tolist()} is not on the surface, as the side "
                "of one cell alone; leave it out"
            )
        return np.asarray(self.surface[np.unique(at)])


def _entry(what: str, named: Mapping[str, Index], name: str) -> Index:
    """Return the entry of a name; raise `ProblemError` that lists the known names."""
    if not isinstance(name, str) or name not in named:
        known = ", ".join(map(format_value, named))
        remedy = (
            f"has {known}; choose one of them" if known else f"has no {what} by name; give a Region"
        )
        raise ProblemError(f"{what} {format_value(name)}: the mesh {remedy}")
    return named[name]
