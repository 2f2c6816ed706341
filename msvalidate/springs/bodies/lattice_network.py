"""From a `Problem` to a network on a lattice: springs, masses, supports, loads, and contacts."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

import numpy as np

from msvalidate.problem import (
    SIDES,
    Array,
    BodyForce,
    Box,
    Contact,
    Index,
    Mesh,
    PointForce,
    Problem,
    ProblemError,
    Traction,
    Weight,
    measure_of,
    prescribed_displacements,
    vectors_at,
)
from msvalidate.problem.checks import require_one_of, require_type
from msvalidate.problem.records import replace
from msvalidate.springs.constants.zones import OneOrEach, choose_constants, constants_by_zone
from msvalidate.springs.lattice import CutLattice, Lattice, VoronoiLattice, boundary_weights
from msvalidate.springs.lattice.corners import quadrilateral_shares
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.network import Body, Network, spring_network
from msvalidate.springs.network.laws.linear import LINEAR
from msvalidate.springs.network.laws.logarithmic import LOGARITHMIC
from msvalidate.springs.network.laws.quadratic import QUADRATIC
from msvalidate.springs.network.laws.volumes import Volumes
from msvalidate.springs.network.laws.zero_length import ZERO_LENGTH
from msvalidate.springs.statics.contact import ContactCandidates

Kind = TypeVar("Kind", bound=Lattice)
RIGHT = 1e-9
"""Negative cotangent up to which an obtuse angle counts as right.

Rounding of coordinates is 1e-16.
"""


def lattice_network(
    problem: Problem,
    lattice: Lattice,
    constants: OneOrEach | None = None,
    *,
    volume: float = 0.0,
    weights: str = "shared",
    mass: str = "shared",
) -> Network:
    """Build the network of a problem on a lattice that fills the body.

    Parameters
    ----------
    problem
        Boundary value problem in d dimensions.
    lattice
        Lattice with n points that fills the domain of the problem.
    constants
        Spring constants (N/m, thickness included; Pa for 3D mesh edges) per kind, or a calibration;
        with zones a tuple of one per material. Default: the constants of the problem's
        isotropic material by springs alone, or with a volume energy if these do not suffice.
    volume
        Stiffness κ of the volume energy of every cell (N/m with the thickness in 2D, Pa in 3D).
    weights
        Rule for the boundary weights: "shared" (1/2 on a side, 1/4 on an edge of a solid; the
        consistent rule), "equal" (1 for all) or "per_cell" (each cell contributes its own springs).
    mass
        "shared": the density times the volume that belongs to each point. "equal": the same total
        mass, distributed evenly. Both are lumped masses.

    Returns
    -------
    Network
        Network with n points, its supports and the nodal forces (n, d) in N of all loads.

    Raises
    ------
    ProblemError
        If the lattice fills another domain or cannot represent the material, a support or load does
        not coincide with lattice points, or the problem has contacts.

    Examples
    --------
    >>> from msvalidate import Box, Isotropic, Problem, Support, Traction, lattice_network, square
    >>> box = Box((0.4, 0.1))
    >>> clamp = Support(box.side("left"), (0.0, 0.0))
    >>> pull = Traction(box.side("right"), (100.0, 0.0))
    >>> material = Isotropic(E=1e5, nu=1 / 3, thickness=0.2)
    >>> problem = Problem(box, material, supports=(clamp,), loads=(pull,))
    >>> network = lattice_network(problem, square(box, (4, 1)))
    >>> network.force.sum(axis=0).round(9).tolist()  # 100 Pa on 0.1 m x 0.2 m
    [2.0, 0.0]
    """
    require_type("problem", problem, Problem)
    require_type("lattice", lattice, Lattice)
    if isinstance(lattice, CutLattice):
        raise ProblemError(f"lattice {lattice.name}: its points miss the outline; give cut_network")
    constants = choose_constants(problem, lattice, constants, volume)
    k, kappa, pressure, density = constants_by_zone(problem, lattice, constants, volume)
    require_one_of("mass", mass, ("shared", "equal"))
    weight = boundary_weights(lattice, weights)
    held, displacement = prescribed_displacements(problem, lattice.points)
    with np.errstate(over="ignore", invalid="ignore"):  # the network refuses what is infinite
        shared = density * problem.material.thickness * lattice.point_volume
        force = nodal_force(problem, lattice, shared, _applied_force)
    volumes = _volumes(lattice, kappa, pressure)
    network = spring_network(
        lattice.points,
        lattice.springs,
        k * lattice.factor * weight,
        mass=shared if mass == "shared" else np.full(len(shared), shared.mean()),
        fixed=held,
        displacement=displacement,
        force=force,
        volumes=volumes,
        cells=lattice.cells,
        law=ZERO_LENGTH if volumes is not None and volumes.law is LOGARITHMIC else LINEAR,
        body=Body(problem, lattice, constants),
    )
    if not network.law.rests:
        _refuse_unbalanced(network, lattice.name, weights)
    return network


def _refuse_unbalanced(network: Network, name: str, weights: str) -> None:
    """Raise `ProblemError` where tension and pressure leave a force on a point at rest."""
    moved = np.flatnonzero(network.rest_force.any(axis=1))
    if len(moved):
        raise ProblemError(
            f"lattice {name}, weights {weights!r}: springs and cells are out of balance at point "
            f"{moved[0]} at rest, as where the body's sides cut springs; take weights 'shared' and "
            "square, triangular or cubic, or a mesh's edges by 'cotangent'"
        )


def _volumes(lattice: Lattice, kappa: Array, pressure: Array) -> Volumes | None:
    """The lattice's cells, where they resist a change of volume."""
    if not (kappa.any() or pressure.any()):
        return None
    law = LOGARITHMIC if pressure.any() else QUADRATIC
    cells = Volumes(lattice.points, lattice.cells, kappa, law, pressure)
    covered, whole = cells.rest_volume.sum(), lattice.domain.volume
    if abs(covered - whole) > 1e-9 * whole:
        raise ProblemError(
            f"volume stiffness: the cells of the {lattice.name} lattice cover {covered:.6g} of "
            f"{whole:.6g}; take a lattice whose cells fill the body, or leave it at 0"
        )
    return cells


Applied = Callable[[PointForce | Traction, Kind], Array]
"""Function of a load and a lattice that returns nodal forces (n, d).

They are in N for a point force, in N per thickness for a traction.
"""


def nodal_force(problem: Problem, lattice: Kind, mass: Array, applied: Applied[Kind]) -> Array:
    """Compute the nodal forces (n, d) in N of all loads.

    The masses of the points are (n,) in kg; the thickness is included here.
    """
    if problem.contacts:
        raise ProblemError(f"{problem.name}: has a contact; take contact_network, or leave it out")
    force = np.zeros(lattice.points.shape)
    thickness = problem.material.thickness
    for load in problem.loads:
        if isinstance(load, BodyForce):
            volume = thickness * lattice.point_volume[:, None]
            force += volume * vectors_at("body force", load.force, lattice.points)
        elif isinstance(load, Weight):
            force += np.outer(mass, load.acceleration)
        else:
            force += (1.0 if isinstance(load, PointForce) else thickness) * applied(load, lattice)
    return force


def _applied_force(load: PointForce | Traction, lattice: Lattice) -> Array:
    """Forces (n, d) of a point force, or per thickness of a traction."""
    if isinstance(load, PointForce):
        at = load.region.select(lattice.points, lattice.domain.tolerance)
        if not at.any():
            raise ProblemError(
                f"point force at {load.region}: no lattice point there; "
                "choose cells that put one there"
            )
        return np.outer(at, load.force)
    return side_force(load, lattice)


def side_force(load: Traction, lattice: Lattice) -> Array:
    """Forces (n, d) per thickness of a traction."""
    body = lattice.domain
    if isinstance(body, Box) and isinstance(lattice, VoronoiLattice):
        for area, (name, (axis, end)) in zip(lattice.side_area.T, SIDES.items(), strict=False):
            corners = body.side(name).corners(body.span)
            if load.region.select(corners, body.tolerance).all():
                return _force_by_points(load, lattice.points, area, axis, body.span[axis][end])
    return _force_by_facets(load, lattice)


def _force_by_points(load: Traction, points: Array, area: Array, axis: int, place: float) -> Array:
    """Forces of a traction on a whole side at `place` (m), of which each point has an area (n,).

    They sum to a uniform traction's own force, and springs as facet area over length need just
    these to carry a hydrostatic strain. But a point is not in the middle of its part of a side, and
    may lie behind it: moments, and sums of a linear traction, are off by the square of the spacing,
    and a tangential traction's moment by how deep points that have a part lie on average.
    """
    (taking,) = np.nonzero(area)
    on_side = points[taking]
    on_side[:, axis] = place  # tractions need not be known inside the body
    force = np.zeros(points.shape)
    traction = vectors_at(f"traction on {load.region}", load.traction, on_side)
    force[taking] = area[taking, None] * traction
    return force


def _force_by_facets(load: Traction, lattice: Lattice) -> Array:
    """Forces of a traction that varies linearly along each of the facets that it covers."""
    body, points, name = lattice.domain, lattice.points, f"traction on {load.region}"
    inside = load.region.select(points, body.tolerance)
    facets = lattice.facets[inside[lattice.facets].all(axis=1)]
    # Both ends of a facet may be on parts that it joins, as on two sides of a mesh's corner.
    facets = facets[load.region.select(points[facets].mean(axis=1), body.tolerance)]
    corners = points[facets]
    edges = corners[:, [2**axis for axis in range(body.dim - 1)]] - corners[:, [0]]
    twisted = isinstance(body, Mesh) and facets.shape[1] == 4  # no rectangles, perhaps not flat
    if facets.shape[1] == 3:
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    elif twisted:
        parts = quadrilateral_shares(corners)
        area = parts.sum(axis=(1, 2))
        parts /= area[:, None, None]
    else:
        area = np.linalg.norm(edges, axis=2).prod(axis=1)
    wanted = measure_of(load.region, body)
    if abs(area.sum() - wanted) > 1e-9 * wanted:
        raise ProblemError(
            f"{name}: covers no whole number of cell edges; "
            "choose cells whose edges end where the loaded part ends"
            if lattice.regular
            else f"{name}: an irregular lattice ({lattice.name}) has no facets that "
            "end where it does; load a whole side"
        )
    traction = vectors_at(name, load.traction, corners.reshape(-1, body.dim)).reshape(corners.shape)
    if isinstance(lattice, EdgeLattice) and lattice.rule == "cotangent" and facets.shape[1] == 3:
        parts = (1 + np.eye(3))[None] / 12  # consistent: these springs are linear elements
    elif facets.shape[1] == 3:
        parts = _triangle_shares(facets, corners, area, regular=lattice.regular)
    elif not twisted:
        parts = _facet_shares(facets.shape[1])
    shares = area[:, None, None] * np.einsum("fab,fbc->fac", parts, traction)
    force = np.zeros(points.shape)
    np.add.at(force, facets, shares)
    return force


def _facet_shares(corners: int) -> Array:
    """Consistent distribution (1, corners, corners) of tractions over a facet.

    The consistent ones of a traction that varies linearly along an edge, or over a rectangle along
    both of its edges.
    """
    line = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
    return np.asarray(line if corners == 2 else np.kron(line, line))[None]


def _triangle_shares(facets: Index, corners: Array, area: Array, *, regular: bool) -> Array:
    """Distribution (f, 3, 3) of tractions at the corners of triangles.

    The consistent parts, (1 + δ)/12, give corners a third of a uniform traction each, so that
    points with more triangles get more, though they be alike in the lattice. What is alike is the
    area nearest to a point. Its parts of a triangle meet at the circumcentre, a height h above each
    edge, and from thirds to them the resultant on an area A moves by Δ, the sum of - L h² n/(6 A)
    over edges of length L and inward normal n. That is done with the traction in the middle of the
    edge, and with the lesser h of the two triangles that meet there: the moves cancel, and neither
    force nor moment of a linear traction changes. Triangles with an obtuse angle keep thirds, for
    their circumcentre is outside and parts would be negative. At the loaded part's rim a regular
    lattice goes on as its mirror image; another has no neighbour to cancel a move, and makes none.
    """
    following, last = np.roll(np.arange(3), -1), np.roll(np.arange(3), -2)
    edge = corners[:, last] - corners[:, following]  # opposite to each corner, all one way round
    product = np.einsum("fac,fbc->fab", edge, edge)
    square = np.einsum("faa->fa", product)
    cotangent = (square.sum(axis=1, keepdims=True) - 2 * square) / (4 * area[:, None])
    acute = (cotangent >= -RIGHT).all(axis=1, keepdims=True)
    height = np.where(acute, square * cotangent**2 / 4, 0.0)  # h²
    ends = np.sort(np.stack([facets[:, following], facets[:, last]], axis=2).reshape(-1, 2))
    _, which, times = np.unique(ends, axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    least = np.full(len(times), np.inf)
    np.minimum.at(least, which, height.ravel())
    if not regular:
        least[times == 1] = 0.0
    # A resultant moves by Δ with forces A Δ·∇λ at the corners, where ∇λ is n L/(2A) of the edge
    # opposite, and n L n' L' is the product of the edges: Δ·∇λ = -(edge·edge') h²/(12 A²).
    move = product * least[which].reshape(-1, 1, 3) / (12 * area[:, None, None] ** 2)
    middle = (1 - np.eye(3)) / 2
    return np.asarray((1 + np.eye(3)) / 12 - move @ middle)


# Contacts ---------------------------------------------------------------------------------------


def contact_network(
    problem: Problem, lattice: Lattice, *options: Any, **named: Any
) -> tuple[Network, tuple[ContactCandidates, ...]]:
    """Network of a problem, and for each of its contacts the points that may touch.

    Parameters
    ----------
    problem, lattice
        As for `lattice_network`, which gets what else is given.

    Raises
    ------
    ProblemError
        As `lattice_network`, or if the points of the lattice are not where the surface is, or none
        is on the part that may touch, or the centre of a disc or ball is in the body.
    """
    touching = touching_points(problem, lattice)
    return lattice_network(replace(problem, contacts=()), lattice, *options, **named), touching


def touching_points(problem: Problem, lattice: Lattice) -> tuple[ContactCandidates, ...]:
    """For each contact of a problem the lattice's points that may touch; errors as above."""
    if isinstance(lattice, CutLattice | VoronoiLattice):
        raise ProblemError(
            f"contact: points of the {lattice.name} lattice are not where the surface is; take a "
            "lattice that fills a box, or the edges of a mesh"
        )
    return tuple(_touching(problem, lattice, contact) for contact in problem.contacts)


def _touching(problem: Problem, lattice: Lattice, contact: Contact) -> ContactCandidates:
    """Points (c,) that have a share of the part of the surface that may touch."""
    one = np.eye(lattice.points.shape[1])[0]
    area = side_force(Traction(contact.region, tuple(one)), lattice)[:, 0]
    points = np.flatnonzero(area > 0)
    share = problem.material.thickness * area[points]
    return ContactCandidates(
        points, share, contact.obstacle, contact.depth, contact.force, contact.friction
    )
