"""Stress in a network: what its springs carry, made a tensor in three ways.

A spring that pulls with f along d carries f d⊗d/|d| (N·m), its *virial*. At rest the virials sum
to that of the forces from outside, Σ F⊗x: stress times volume, whatever the stress's course. So

- `cell_stress`: the mean over a cell, (1/V) Σ f d⊗d/|d| over its springs, each as far as it is the
  cell's. Exact for uniform strain, at boundaries too; V times it sums to the body's virial exactly.
- `point_stress`: the mean of the cells around a point, weighted by what of each is the point's.
- `fitted_stress`: at any place: the strain of a polynomial through the displacements of points near
  by, times the solid's tensor. Of higher order, and the one for values at a boundary.

The virial is that of [Clausius1870] with the part of the motion left out; the mean over cells of a
network is in [BornHuang1954]. Stresses are Voigt's, xx, yy, xy or xx, yy, zz, yz, xz, xy, in Pa.
"""

from __future__ import annotations

import math
from itertools import combinations, combinations_with_replacement
from typing import Literal

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from msvalidate.problem import LONGEST, VOIGT, Array, Index, Mask, ProblemError
from msvalidate.problem.checks import (
    finite,
    finite_coordinates,
    positive_number,
    require_one_of,
    require_type,
    whole_number,
)
from msvalidate.springs.lattice import CutLattice, Lattice
from msvalidate.springs.lattice.corners import corner_volumes
from msvalidate.springs.lattice.edges import EdgeLattice
from msvalidate.springs.lattice.parts import spring_parts
from msvalidate.springs.lattice.ties import TIE
from msvalidate.springs.network import Configuration, Network
from msvalidate.springs.network.laws.volumes import Volumes, dilatation, tension_virial
from msvalidate.springs.statics.equilibrium import Equilibrium

Geometry = Literal["linear", "nonlinear"]


def spring_virial(network: Network, state: Equilibrium, geometry: Geometry = "linear") -> Array:
    """Virial (m, d, d) in N·m of each spring, f d⊗d/|d|.

    d is its vector, f its force.

    "linear": the force to first order in the displacement times the reference vector, f⊗D.
    "nonlinear": the pull and the vector at rest, of which Cauchy's stress is made.

    Source: [Clausius1870], [BornHuang1954].

    Raises
    ------
    ProblemError
        If the equilibrium is not one of this network.
    """
    require_type("network", network, Network)
    require_type("equilibrium", state, Equilibrium)
    require_one_of("geometry", geometry, ("linear", "nonlinear"))
    if state.position.shape != network.points.shape:
        raise ProblemError(
            f"stress: displacements {state.position.shape}, points {network.points.shape}; give "
            "the network's own equilibrium"
        )
    # Elongations come from displacements: positions have few digits of small ones, or none.
    if geometry == "nonlinear":
        at = Configuration(network, state.displacement)
        return np.asarray(at.force_density[:, None, None] * _dyads(at.vector, at.vector))
    vector, (i, j) = network.vector, network.springs.T
    apart = state.displacement[j] - state.displacement[i]
    strain = (apart * vector).sum(axis=1) / network.distance**2
    tension = network.pull_at_rest
    pull = tension + (network.axial_stiffness - tension) * strain
    virial = pull[:, None, None] * _dyads(vector, vector)
    if network.prestressed:  # what its turn and its growth bring
        turn = tension[:, None, None] * _dyads(apart, vector)
        virial = virial + (turn + turn.transpose(0, 2, 1)) / 2
    return np.asarray(virial)


def _dyads(a: Array, b: Array) -> Array:
    """a⊗b (m, d, d) of vectors (m, d)."""
    return np.asarray(a[:, :, None] * b[:, None, :])


def cell_stress(
    network: Network,
    lattice: Lattice,
    state: Equilibrium,
    *,
    geometry: Geometry = "linear",
    thickness: float = 1.0,
    parts: csr_array | None = None,
) -> Array:
    """Mean stress (c, 3) or (c, 6) in Pa of each cell.

    A spring belongs to the cells that both of its ends are corners of, shared out as the cells have
    volume inside the body, or on mesh edges as they gave it stiffness. In a body with zones volumes
    would mix two materials at their interface: there give the parts.

    Source: the virial, [Clausius1870], [BornHuang1954].

    Parameters
    ----------
    network, lattice
        The network must be one on the lattice.
    thickness
        Of a plane body, m.
    parts
        (m, c) part of each spring that is each cell's, as `spring_shares` of
        `msvalidate.springs.constants.zones` has it.

    Raises
    ------
    ProblemError
        If they do not belong together, or a spring runs in no cell, as in lattices whose springs
        reach from one cell to the next.
    """
    _refuse_other_lattice(network, lattice)
    volume = cell_volume(lattice) * positive_number("thickness", thickness, "m")
    if isinstance(lattice, EdgeLattice) and parts is None:
        parts = spring_parts(lattice)  # shares by volume would leave tension and pressure apart
    if parts is None:
        spring, cell = spring_cell_pairs(lattice)
        part = volume[cell] / np.bincount(spring, volume[cell], len(lattice.springs))[spring]
    else:
        if parts.shape != (len(lattice.springs), len(lattice.cells)):
            raise ProblemError(f"stress: parts {parts.shape}; give spring_shares of this lattice")
        spring, cell = parts.nonzero()
        part = parts[spring, cell]
    virial = part[:, None, None] * spring_virial(network, state, geometry)[spring]
    total = np.zeros((len(lattice.cells), *virial.shape[1:]))
    np.add.at(total, cell, virial)
    total += network.of_cells(_pressure_virial, lattice, state, geometry)
    if geometry == "nonlinear":
        volume = volume * _volume_ratio(lattice, state)
    return _voigt_components(total / volume[:, None, None])


def _pressure_virial(
    volumes: Volumes, lattice: Lattice, state: Equilibrium, geometry: Geometry
) -> Array:
    """Virial (c, d, d) in N·m of the cells' volumes: U'(J) V along each axis."""
    if not np.array_equal(volumes.cells, lattice.cells):
        raise ProblemError(
            "stress: the network's volumes are not the lattice's cells; give its own"
        )
    d = volumes.dim
    if geometry == "linear":
        grown = dilatation(volumes, state.displacement, linear=True)
        even = np.multiply.outer(volumes.rest_volume * volumes.curvature * grown, np.eye(d))
        return even + tension_virial(volumes, state.displacement)
    grown = dilatation(volumes, state.displacement)
    slope = volumes.slope + volumes.law.change(*volumes.coefficients, grown)
    return np.multiply.outer(slope * volumes.rest_volume * (1 + grown), np.eye(d))


def point_stress(lattice: Lattice, stress: Array) -> Array:
    """Average the stresses of the cells around each point.

    The result is (n, 3) or (n, 6) in Pa. The stresses of cells are (c, 3) or (c, 6) in Pa.

    Raises
    ------
    ProblemError
        If the stresses are not one a cell, or a point is no cell's corner.
    """
    require_type("lattice", lattice, Lattice)
    count = len(lattice.cells)
    given = finite("stress of the cells", stress, count, "v", need=f"the lattice has {count} cells")
    corner, n = _corner_volume(lattice), len(lattice.points)
    around = np.bincount(lattice.cells.ravel(), corner.ravel(), n)
    (alone,) = np.nonzero(around == 0)
    if len(alone):
        raise ProblemError(
            f"stress of the cells: point {alone[0]} of the {lattice.name} lattice is no cell's "
            "corner; ask fitted_stress"
        )
    total = np.zeros((n, given.shape[1]))
    np.add.at(total, lattice.cells, corner[..., None] * given[:, None])
    return np.asarray(total / around[:, None])


def _refuse_other_lattice(network: Network, lattice: Lattice) -> None:
    require_type("network", network, Network)
    require_type("lattice", lattice, Lattice)
    if not np.array_equal(network.springs, lattice.springs):
        raise ProblemError("stress: the network's springs are not the lattice's; give its own")


def fitted_stress(
    points: Array,
    displacement: Array,
    places: Array,
    tensor: Array,
    *,
    degree: int = 4,
    count: int | None = None,
) -> Array:
    """Compute stresses at given places from displacements by a local polynomial fit.

    A polynomial is fitted by least squares to the displacements of the points nearest to each
    place; the stress is the tensor times its strain. For exact displacements the strain error is of
    order r^degree, with r the distance of the farthest point of the fit. For a cut lattice, use
    interior points only (``interior_points`` of this module), since cut cells have strain errors at
    any spacing.

    Parameters
    ----------
    points, displacement
        Positions (m) and displacements (m), each of shape (n, d). In a body with zones, pass the
        points of one zone, because strains jump at interfaces.
    places
        Positions (m) where the stress is computed, shape (p, d).
    tensor
        Voigt tensor (Pa) with engineering shear strains, shape (3, 3) in 2D or (6, 6) in 3D.
    degree
        Degree of the polynomial, 1 to 4.
    count
        Minimum number of points per fit. Default: four times the number of coefficients, or √n if
        that is more.

    Returns
    -------
    ndarray
        Stresses (Pa) in Voigt notation, shape (p, 3) in 2D or (p, 6) in 3D.

    Raises
    ------
    ProblemError
        If an array does not fit the others, or the points are too few or lie on a curve of this
        degree.

    Examples
    --------
    >>> import numpy as np
    >>> from msvalidate import Box, fitted_stress, square
    >>> points = square(Box((0.4, 0.4)), 10).points
    >>> displacement = points * [1e-3, 0.0]  # uniaxial strain
    >>> tensor = 1e5 * np.array([[9.0, 3.0, 0.0], [3.0, 9.0, 0.0], [0.0, 0.0, 3.0]]) / 8
    >>> stress = fitted_stress(points, displacement, np.array([[0.2, 0.1]]), tensor)
    >>> print(", ".join(f"{component:.3f}" for component in abs(stress[0])), "Pa")
    112.500, 37.500, 0.000 Pa
    """
    given = {"points": points, "displacement": displacement, "places": places}
    x, u, at = (finite_coordinates(name, array) for name, array in given.items())
    C = finite("tensor", tensor)
    fits = x.ndim == at.ndim == 2 and x.shape[1] in VOIGT and at.shape[1] == x.shape[1]
    if not fits or u.shape != x.shape or not len(at):
        raise ProblemError(
            f"fitted stress: points {x.shape}, displacement {u.shape}, places {at.shape}; give "
            "(n, d) twice and (p, d)"
        )
    powers = _monomial_powers(x.shape[1], whole_number("degree", degree, 1, 4))
    need = len(powers)
    usual = max(4 * need, math.isqrt(len(x)))
    k = usual if count is None else whole_number("points for each fit", count, need)
    if C.shape != (len(VOIGT[x.shape[1]]),) * 2 or k > len(x):
        raise ProblemError(
            f"fitted stress: tensor {C.shape}, {k} of {len(x)} points a fit; give a Voigt tensor "
            "and no more points than there are"
        )
    near = _nearest_points(x, at, k)
    strains = [_fit_strain(x[i], u[i], place, powers) for place, i in zip(at, near, strict=True)]
    return np.asarray(np.stack(strains) @ C)


def _nearest_points(points: Array, places: Array, count: int) -> list[Index]:
    """At least so many points nearest to each place: all that are as far as the last, too."""
    tree = cKDTree(points)
    last = tree.query(places, k=[count])[0][:, 0]
    found = tree.query_ball_point(places, last * (1 + TIE), return_sorted=True)
    return [np.array(each, dtype=np.intp) for each in found]


def interior_points(lattice: CutLattice) -> Mask:
    """Mask (n,) of points with all their cells inside the body.

    Raises `ProblemError` unless the lattice is a `CutLattice`.
    """
    require_type("lattice", lattice, CutLattice)
    good = np.ones(len(lattice.points), dtype=bool)
    good[lattice.cells[lattice.fraction < 1 - 1e-9]] = False
    return good


def cell_volume(lattice: Lattice) -> Array:
    """Area (m²) or volume (m³) of each cell (c,) inside the body."""
    require_type("lattice", lattice, Lattice)
    return np.asarray(_corner_volume(lattice).sum(axis=1))


def spring_cell_pairs(lattice: Lattice) -> tuple[Index, Index]:
    """Springs and cells (q,) of which each spring is an edge or a diagonal.

    Raises
    ------
    ProblemError
        If a spring joins corners of no one cell.
    """
    require_type("lattice", lattice, Lattice)
    n = len(lattice.points)
    code = lattice.springs.min(axis=1) * n + lattice.springs.max(axis=1)
    order = np.argsort(code, kind="stable")
    pairs = [np.sort(lattice.cells[:, ends], axis=1) for ends in _pairs(lattice.cells.shape[1])]
    wanted = np.stack([pair[:, 0] * n + pair[:, 1] for pair in pairs])
    at = np.minimum(np.searchsorted(code[order], wanted), len(code) - 1)
    spring = order[at]
    there = code[spring] == wanted
    (missed,) = np.nonzero(np.bincount(spring[there], minlength=len(code)) == 0)
    if len(missed):
        raise ProblemError(
            f"stress: spring {missed[0]} of the {lattice.name} lattice joins points "
            f"{lattice.springs[missed[0]].tolist()}, corners of no one cell; ask fitted_stress"
        )
    return spring[there], np.broadcast_to(np.arange(len(lattice.cells)), there.shape)[there]


def _pairs(corners: int) -> list[list[int]]:
    return [list(pair) for pair in combinations(range(corners), 2)]


def _corner_volume(lattice: Lattice) -> Array:
    """Area (m²) or volume (m³) of each cell (c, corners) that is each of its corners'."""
    if isinstance(lattice, CutLattice):
        return lattice.corner_volume
    return corner_volumes(lattice.points, lattice.cells)


def _volume_ratio(lattice: Lattice, state: Equilibrium) -> Array:
    """Volume (c,) of each cell at rest relative to that before."""
    near = lattice.points - lattice.points[0]
    now, before = (
        corner_volumes(x, lattice.cells).sum(axis=1) for x in (near + state.displacement, near)
    )
    return np.asarray(now / before)


def _voigt_components(tensors: Array) -> Array:
    """Voigt components (c, 3) or (c, 6) of symmetric tensors (c, d, d)."""
    first, second = np.array(VOIGT[tensors.shape[-1]]).T
    return np.asarray(tensors[:, first, second])


def _monomial_powers(dim: int, degree: int) -> Index:
    """Powers (q, d) of all monomials up to a degree: 1 first, then the coordinates."""
    each = [
        np.bincount(axes, minlength=dim)
        for total in range(degree + 1)
        for axes in (
            np.array(some, dtype=np.intp)
            for some in combinations_with_replacement(range(dim), total)
        )
    ]
    return np.array(each)


def _fit_strain(x: Array, u: Array, place: Array, powers: Index) -> Array:
    """Voigt strain at a place, from a polynomial fitted to displacements.

    The fit by least squares is to displacements `u` (k, d) in m of points `x` (k, d) in m. `powers`
    (q, d) are those of its monomials. The strain is (3,) or (6,) with engineering shears.

    Raises `ProblemError` if the points do not determine the polynomial.
    """
    radius = max(np.linalg.norm(x - place, axis=1).max(), 1 / LONGEST)
    terms = (((x - place) / radius)[:, None] ** powers).prod(axis=2)
    coefficients, _, rank, _ = np.linalg.lstsq(terms, u, rcond=None)
    if rank < len(powers):
        raise ProblemError(
            f"fitted stress: the {len(x)} points nearest to {place.tolist()} lie on a curve of "
            "that degree; take more points or a lower degree"
        )
    slope = coefficients[1 : 1 + len(place)] / radius  # [a, b]: of displacement b along a
    first, second = np.array(VOIGT[len(place)]).T
    return np.asarray(np.where(first == second, 1, 2) * (slope + slope.T)[first, second] / 2)
