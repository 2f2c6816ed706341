"""Floor 1: from a `Problem` to a network on a lattice: its springs, masses, supports and loads."""

from __future__ import annotations

import numpy as np

from msvalidate.homogenise import default_constants
from msvalidate.lattice import Lattice, boundary_weights
from msvalidate.network import Network, spring_network
from msvalidate.problem import (
    Array,
    BodyForce,
    PointForce,
    Problem,
    ProblemError,
    Traction,
    chosen,
    finite,
    instance,
    prescribed,
    shown,
    vectors_at,
)


def lattice_network(
    problem: Problem,
    lattice: Lattice,
    constants: tuple[float, ...] | None = None,
    *,
    weights: str = "shared",
    mass: str = "shared",
) -> Network:
    """Network that stands for a problem on a lattice.

    Parameters
    ----------
    problem, lattice
        The lattice must fill the problem's domain.
    constants
        Spring constants (N/m) per kind of spring; by default those of the problem's isotropic
        material, if the lattice can be it.
    weights
        Boundary rule, one of `msvalidate.lattice.WEIGHTS`.
    mass
        "shared": density × thickness × the point's share of its cells; "equal": the same total,
        evenly over the points.

    Raises
    ------
    ProblemError
        If the lattice cannot be the material, or a support or load does not meet its points.
    """
    instance("problem", problem, Problem)
    instance("lattice", lattice, Lattice)
    if lattice.domain != problem.domain:
        raise ProblemError(
            f"lattice fills a {lattice.domain}, the problem's is a {problem.domain}; "
            "build it from the problem's own"
        )
    if constants is None:
        constants = default_constants(problem.material, lattice)
    k = finite("spring constants", constants)
    if k.shape != (lattice.kinds,):
        raise ProblemError(
            f"spring constants: {shown(constants)}; give {lattice.kinds}, one a kind"
        )
    held, displacement = prescribed(problem, lattice.points)
    with np.errstate(over="ignore", invalid="ignore"):  # the network refuses what is infinite
        force, masses = _nodal_force(problem, lattice), _nodal_mass(problem, lattice, mass)
    return spring_network(
        lattice.points,
        lattice.springs,
        k[lattice.kind] * lattice.factor * boundary_weights(lattice, weights),
        mass=masses,
        held=held,
        displacement=displacement,
        force=force,
    )


def _nodal_mass(problem: Problem, lattice: Lattice, rule: str) -> Array:
    total = problem.material.density * problem.material.thickness
    chosen("mass", rule, ("shared", "equal"))
    if rule == "shared":
        return total * lattice.point_volume
    return np.full(len(lattice.points), total * lattice.domain.volume / len(lattice.points))


def _nodal_force(problem: Problem, lattice: Lattice) -> Array:
    """Loads as forces (n, d) in N on the lattice points; the thickness enters here."""
    force = np.zeros(lattice.points.shape)
    thickness = problem.material.thickness
    for load in problem.loads:
        if isinstance(load, PointForce):
            at = load.region.select(lattice.points, lattice.domain.tolerance)
            if not at.any():
                raise ProblemError(
                    f"point force at {load.region}: no lattice point there; "
                    "choose cells that put one there"
                )
            force[at] += load.force
        elif isinstance(load, Traction):
            force += thickness * _traction_force(load, lattice)
        elif isinstance(load, BodyForce):
            volume = thickness * lattice.point_volume[:, None]
            force += volume * vectors_at("body force", load.force, lattice.points)
    return force


def _traction_force(load: Traction, lattice: Lattice) -> Array:
    """Consistent forces per thickness of a traction that varies linearly along each facet."""
    body, points = lattice.domain, lattice.points
    inside = load.region.select(points, body.tolerance)
    facets = lattice.facets[inside[lattice.facets].all(axis=1)]
    corners = points[facets]
    edges = corners[:, [2**axis for axis in range(body.dim - 1)]] - corners[:, [0]]
    if facets.shape[1] == 3:
        area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1) / 2
    else:
        area = np.linalg.norm(edges, axis=2).prod(axis=1)
    wanted = load.region.measure(body.span)
    if abs(area.sum() - wanted) > 1e-9 * wanted:
        raise ProblemError(
            f"traction on {load.region}: covers no whole number of cell edges; "
            "choose cells whose edges end where the loaded part ends"
        )
    name = f"traction on {load.region}"
    traction = vectors_at(name, load.traction, corners.reshape(-1, body.dim)).reshape(corners.shape)
    shares = area[:, None, None] * np.einsum("fab,fbc->fac", _facet_shares(corners), traction)
    force = np.zeros(points.shape)
    np.add.at(force, facets, shares)
    return force


def _facet_shares(corners: Array) -> Array:
    """Parts (1 or f, corners, corners) of tractions at a facet's corners that go to each of them.

    Along an edge and over a rectangle: the consistent ones of a traction that varies linearly. Over
    a triangle: what of it lies nearest to a corner, by the way to its circumcentre, so that points
    that are alike in a lattice take alike parts of a uniform traction.
    """
    if corners.shape[1] != 3:
        line = np.array([[2.0, 1.0], [1.0, 2.0]]) / 6
        return np.asarray(line if corners.shape[1] == 2 else np.kron(line, line))[None]
    opposite = np.roll(corners, -1, axis=1) - np.roll(corners, -2, axis=1)
    square = (opposite**2).sum(axis=2)
    # Corner a takes (b² cot B + c² cot C)/8 of a triangle with sides a, b, c; 4 area cot A is
    # b² + c² - a², and 16 area² = 2 Σ a²b² - Σ a⁴.
    cotangent = square.sum(axis=1, keepdims=True) - 2 * square
    sixteen = square.sum(axis=1) ** 2 - 2 * (square**2).sum(axis=1)
    both = square * cotangent
    part = (both.sum(axis=1, keepdims=True) - both) / (2 * sixteen[:, None])
    return np.asarray(part[:, :, None] * np.eye(3))
