"""From a `Problem` to a network on a lattice cut to its body.

Supports and loads meet the outline, which is not where the lattice's points are.

**Loads** do the work that they do on the motion interpolated in the cells, linear along each axis:
their resultants are exact. A lattice cut along its own lines gets what `lattice_network` gives.
The other way that offers itself, a pressure on the area vectors Σ f ∫∇N dA of the points with f the
part of a cell inside, makes a uniform pressure exact, but no other stress; in a ring under pressure
its displacements were no better, and it can do pressures only.

**Supports** along a lattice line hold the line's points, as far as its cells reach. Supports along
any other line hold every point of the cells that it runs through. A displacement prescribed as a
field that goes on to both sides of the outline as the body's own does is then met to second order,
a linear one exactly; one number all along it, such as a clamp's 0, to first order in the spacing.
In space that is so of a prism's walls; any other part of a surface, and loads on it, are met as
`springs.bodies.cut_solid` has it.

The diagonals of a cut cell pull at points on both sides of the outline, which no rule for their
stiffness mends: uniform stress leaves forces of the order of stress × spacing at the points of cut
cells. Their sum and their moment are zero in each cell, so most of what they do dies out within a
few cells. What is left acts as an outline moved by a small part of the spacing: displacements err
by the lattice's own second order plus a first order that is small (relative, of a ring of radius 1
under pressure some 0.2 h² + 0.006 h; of a unit square turned against the lattice and pulled, where
nothing else errs, 0.05 h^1.26), and unevenly, for outline and cells meet anew at each spacing.
Strains of the cells at the outline are wrong by up to a tenth and stay so: stresses there are to be
found from the displacements of points of whole cells (`stress.fitted_stress`).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import (
    Array,
    Boundary,
    Mask,
    Part,
    PointForce,
    Problem,
    ProblemError,
    Region,
    Support,
    Traction,
    corners_of,
    measure_of,
    prescribed_displacements_at,
    vectors_at,
)
from msvalidate.problem.checks import require_type
from msvalidate.springs.bodies.cut_solid import fixed_points, traction_on_solid
from msvalidate.springs.bodies.lattice_network import nodal_force
from msvalidate.springs.constants.zones import OneOrEach, choose_constants, constants_by_zone
from msvalidate.springs.lattice.cut import CutLattice
from msvalidate.springs.lattice.outline import crossed_cells, outline, straight_pieces
from msvalidate.springs.network import Body, Network, spring_network
from msvalidate.springs.network.laws.volumes import Volumes

GAUSS = (0.5 - 0.5 / np.sqrt(3), 0.5 + 0.5 / np.sqrt(3))
"""Gauss points on a piece within one cell, exact for a linear traction."""


def cut_network(
    problem: Problem,
    lattice: CutLattice,
    constants: OneOrEach | None = None,
    *,
    volume: float = 0.0,
) -> Network:
    """Build the network of a problem on a lattice that is cut to the body.

    In 2D, a support along a lattice line fixes the points of that line; any other support fixes
    every point of the cells that it crosses. A curved or inclined boundary adds a small error of
    first order in the spacing to the displacements.

    Parameters
    ----------
    problem
        Boundary value problem in d dimensions.
    lattice
        Lattice with n points, cut to the domain of the problem by `cut_lattice`.
    constants
        Spring constants (N/m) per kind, or a calibration, or with zones a tuple of one per
        material. Default: the constants of the problem's isotropic material.
    volume
        Stiffness κ of the volume energy of a whole cell (N/m in 2D, Pa in 3D). A cut cell has the
        fraction that lies inside the body.

    Returns
    -------
    Network
        Network with n points.

    Raises
    ------
    ProblemError
        If the lattice is not cut to the domain or cannot represent the material, a support lies on
        no lattice point, or supports fix every point.

    Examples
    --------
    >>> from msvalidate import Isotropic, Polygon, Problem, Region, Support, Weight
    >>> from msvalidate import cut_lattice, cut_network, patterns
    >>> wedge = Polygon(((0.0, 0.0), (0.3, 0.0), (0.0, 0.3)))
    >>> clamp = Support(Region((None, 0.0)), (0.0, 0.0))
    >>> weight = Weight((0.0, -9.81))
    >>> problem = Problem(wedge, Isotropic(E=1e5, nu=1 / 3), supports=(clamp,), loads=(weight,))
    >>> network = cut_network(problem, cut_lattice(patterns.square(), wedge, spacing=0.1))
    >>> print(f"{network.mass.sum():.6f} kg")  # 1000 kg/m³, 0.045 m², 1 m thick
    45.000000 kg
    """
    require_type("problem", problem, Problem)
    require_type("lattice", lattice, CutLattice)
    constants = choose_constants(problem, lattice, constants, volume)
    k, kappa, pressure, density = constants_by_zone(problem, lattice, constants, volume)
    if pressure.any():
        raise ProblemError(
            "cut network: springs of no rest length and cells that an outline cuts are out of "
            "balance at rest; take route 'volume energy', or a mesh's edges by 'cotangent'"
        )
    held, displacement = prescribed_displacements_at(
        problem, lattice.points, support_selector(lattice)
    )
    if held.all():
        raise ProblemError(
            f"cut network: its supports hold every point at a spacing of {lattice.spacing:g} m; "
            "choose a smaller one"
        )
    with np.errstate(over="ignore", invalid="ignore"):  # the network refuses what is infinite
        mass = density * problem.material.thickness * lattice.point_volume
        force = nodal_force(problem, lattice, mass, _applied_force)
    volumes = Volumes(lattice.points, lattice.cells, kappa * lattice.fraction)
    return spring_network(
        lattice.points,
        lattice.springs,
        k * lattice.factor,
        mass=mass,
        fixed=held,
        displacement=displacement,
        force=force,
        volumes=volumes if kappa.any() else None,
        cells=lattice.cells,
        body=Body(problem, lattice, constants),
    )


# Supports -----------------------------------------------------------------------------------------


def support_selector(lattice: CutLattice) -> Callable[[Support], Mask]:
    """Return a function that selects the points that a support fixes.

    The function takes a `Support` and returns a mask (n,). It raises `ProblemError` if no lattice
    line runs along a support across an axis, or if the region is no part of the body.
    """

    def fixed_mask(support: Support) -> Mask:
        region = support.region
        if isinstance(region, Region) and not region.is_facet:
            return np.asarray(region.select(lattice.points, lattice.domain.tolerance))
        if lattice.points.shape[1] == 3 and not _is_wall(region, lattice):
            return fixed_points(region, lattice)
        corners = corners_of(region, lattice.domain)
        flat = np.flatnonzero(np.ptp(corners, axis=0) <= lattice.domain.tolerance)
        if len(flat):
            return _on_lattice_line(support, lattice, corners, int(flat[0]))
        return _points_along(region, lattice)

    return fixed_mask


def _on_lattice_line(support: Support, lattice: CutLattice, corners: Array, axis: int) -> Mask:
    """Points of a lattice line across an axis, of all cells that have body at the part."""
    x, room = lattice.points, lattice.domain.tolerance
    on = np.abs(x[:, axis] - corners[0, axis]) <= room
    if not on.any():
        place = f"{'xyz'[axis]} = {corners[0, axis]:g} m"
        raise ProblemError(
            f"support on {support.region}: no line of the cut lattice runs along {place}; choose "
            "a spacing at which one does"
        )
    past = np.maximum(corners.min(axis=0) - x, x - corners.max(axis=0))
    past[:, axis] = 0.0
    furthest = past.max(axis=1)
    # Points of cells along the part; past the outline a whole cell more, for one that ends at a
    # point of the lattice there may be cut too.
    near = furthest < lattice.spacing - room
    beyond = (furthest <= lattice.spacing + room) & ~near & on
    beyond[beyond] = ~lattice.domain.contains(x[beyond])
    return np.asarray(on & (near | beyond))


def _points_along(region: Part, lattice: CutLattice) -> Mask:
    """Points of the cells that a part of the outline runs through."""
    pieces = straight_pieces(region, lattice.domain)
    cells = crossed_cells(pieces, lattice.points[lattice.cells[:, 0], :2], lattice.spacing)
    held = np.zeros(len(lattice.points), dtype=bool)
    held[lattice.cells[cells]] = True
    if lattice.points.shape[1] == 3:  # a wall may not reach from the bottom to the top
        z = corners_of(region, lattice.domain)[:, 2]
        room = lattice.domain.tolerance
        held &= (lattice.points[:, 2] > z.min() - room) & (lattice.points[:, 2] < z.max() + room)
    return held


def _is_wall(region: Part, lattice: CutLattice) -> bool:
    """Return True if a region is a vertical wall of a prism.

    The outline alone then describes it.
    """
    if lattice.by_surface or not isinstance(region, Boundary):
        return False
    size = np.ptp(region.places, axis=1)
    room = lattice.domain.tolerance
    return bool((size[:, 2] > room).all() and (np.ptp(region.places, axis=(0, 1)) > room).all())


# Loads --------------------------------------------------------------------------------------------


def _applied_force(load: PointForce | Traction, lattice: CutLattice) -> Array:
    """Forces (n, d) of a point force, or per thickness of a traction."""
    if isinstance(load, PointForce):
        places, vectors = _nearest_in_body(load, lattice), np.array([load.force])
    elif lattice.points.shape[1] == 3:
        of_end = _is_end(load, lattice)
        return _end_forces(load, lattice) if of_end else traction_on_solid(load, lattice)
    else:
        places, vectors = _traction_forces(load, lattice)
    points, weights = lattice.weights_at(places)
    force = np.zeros(lattice.points.shape)
    np.add.at(force, points, weights[..., None] * vectors[:, None])
    return force


def _nearest_in_body(load: PointForce, lattice: CutLattice) -> Array:
    """The place (1, d) in m of a point force: beyond the body a cell's motion means nothing."""
    place = np.array([load.at])
    if not lattice.domain.contains(place).all():
        raise ProblemError(
            f"point force at {load.region}: outside the body, as in a hole; choose a place in it"
        )
    return place


def _traction_forces(load: Traction, lattice: CutLattice) -> tuple[Array, Array]:
    """Places (q, 2) in m and forces (q, 2) in N per thickness that a traction amounts to."""
    ends = _split_at_lattice_lines(straight_pieces(load.region, lattice.domain), lattice)
    along = ends[:, 1] - ends[:, 0]
    places = np.concatenate([ends[:, 0] + s * along for s in GAUSS])
    length = np.tile(np.linalg.norm(along, axis=1) / 2, 2)
    traction = vectors_at(f"traction on {load.region}", load.traction, places)
    return places, length[:, None] * traction


def _is_end(load: Traction, lattice: CutLattice) -> bool:
    """Return True if a traction acts on a whole end of a prism."""
    z = corners_of(load.region, lattice.domain)[:, 2]
    if lattice.by_surface or np.ptp(z) > lattice.domain.tolerance:
        return False
    whole = (1 - 1e-9) * outline(lattice.domain).area
    return bool(measure_of(load.region, lattice.domain) >= whole)


def _end_forces(load: Traction, lattice: CutLattice) -> Array:
    """Forces (n, 3) in N of a traction on an end, as it is at the lattice's points.

    Exact in sum for one that is linear.
    """
    x, z = lattice.points, corners_of(load.region, lattice.domain)[:, 2].mean()
    there = np.abs(x[lattice.cells, 2] - z) <= lattice.domain.tolerance
    # A cell's part of the end: each corner's volume twice over the height.
    area = np.where(there, 2 * lattice.corner_volume / lattice.spacing, 0.0)
    of_point = np.bincount(lattice.cells.ravel(), area.ravel())[:, None]
    (taking,) = np.nonzero(of_point[:, 0])
    force = np.zeros(x.shape)
    at_points = vectors_at(f"traction on {load.region}", load.traction, x[taking])
    force[taking] = of_point[taking] * at_points
    return force


def _split_at_lattice_lines(pieces: Array, lattice: CutLattice) -> Array:
    """Ends (p, 2, 2) in m of the parts of straight lines (q, 2, 2) between lines of the lattice."""
    low, high = np.moveaxis((pieces - lattice.points[0]) / lattice.spacing, 1, 0)
    each = np.arange(len(pieces))
    piece, at = [each, each], [np.zeros(len(pieces)), np.ones(len(pieces))]
    for a, b in zip(low.T, high.T, strict=True):
        first, last = np.ceil(np.minimum(a, b)), np.floor(np.maximum(a, b))
        count = np.where(a != b, np.maximum(last - first + 1, 0), 0).astype(int)
        of = np.repeat(each, count)
        line = first[of] + np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count)
        piece.append(of)
        at.append((line - a[of]) / (b - a)[of])
    owner, part = np.concatenate(piece), np.clip(np.concatenate(at), 0, 1)
    order = np.lexsort([part, owner])
    owner, part = owner[order], part[order][:, None]
    places = (1 - part) * pieces[owner, 0] + part * pieces[owner, 1]
    (start,) = np.nonzero((owner[1:] == owner[:-1]) & (part[1:, 0] > part[:-1, 0]))
    return np.stack([places[start], places[start + 1]], axis=1)
