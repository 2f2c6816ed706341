"""Bounds of the stiffness tensor of an irregular network, by the condition of Hill and Mandel.

A window is a set of points that have all their springs. Points own their parts of the Delaunay
simplices around them, and springs belong to their two points by halves, so that windows share out
the volume and the energy.

- Upper bound: points that a spring or a simplex joins to a point outside follow the uniform strain
  (kinematic uniform boundary conditions).
- Lower bound: springs to points outside are cut, and a uniform traction acts on the surface of the
  window's simplices (static uniform boundary conditions). Each point carries the force on its part
  of the facets around it: forces and moments are balanced, and they work on the mean strain.

The motion of the upper bound is one of those among which the lower bound's energy is the least: of
one window the bounds are ordered. The means over windows hold the effective tensor of a network
that is the same everywhere, and come closer as windows grow. Sources: [Hill1963], [Huet1990].
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array
from scipy.spatial import Delaunay, QhullError

from msvalidate.problem import VOIGT, Array, Index, Mask, ProblemError
from msvalidate.problem.normals import nearest_on_facets
from msvalidate.problem.records import ReadOnly, dataclass
from msvalidate.springs.constants.cell_at_rest import (
    AFFORDED,
    elongations,
    relax_freely,
    shifted_solver,
)
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    AXES_OF,
    cubic_part,
    invariant_moduli,
    voigt_directions,
    young_and_ratio,
)

LONGEST_EDGE = 4.0
"""Longest edge of a simplex relative to the mean spring: longer ones span hollows."""
CUTS = (1, 2, 4)
"""Windows along each axis into which a piece is divided."""
ANSWERED = 0.5
"""Part of the volume that windows of one size must cover."""
HINGED = 100.0
"""Motion under a uniform stress, relative to the median, of points on hinges."""
CORRECTIONS = 4
"""Solutions by the shifted stiffness, each of which leaves a small part of the load."""
TOO_SMALL = (
    "springs: nothing repeats between points inside, and no window has points inside that are "
    "joined to such points alone, so there are no bounds either; give a larger piece, or a "
    "periodic sample and its --period"
)


@dataclass(frozen=True, eq=False)
class TensorBounds(ReadOnly):
    """Bounds of an effective stiffness tensor from windows of one size.

    Parameters
    ----------
    lower, upper
        Voigt tensors, (1, 1) in N, (3, 3) in N/m or (6, 6) in Pa; upper - lower is positive
        semidefinite.
    windows, points
        Number of windows, and mean number of points in each.
    idle
        Number of points of the piece that were left out: their springs carry no force.
    """

    lower: Array
    upper: Array
    windows: int
    points: float
    idle: int

    @property
    def moduli(self) -> Array:
        """Lowest and highest value (2, 3) of E (N/m or Pa), nu and the Zener ratio.

        They are those of all isotropic tensors between the isotropic parts, and of all cubic ones.
        """
        d = AXES_OF[len(self.lower)]
        (K, mu), (K_upper, mu_upper) = map(invariant_moduli, (self.lower, self.upper))
        soft, stiff = cubic_part(self.lower), cubic_part(self.upper)
        shear = 2 * np.array([soft[-1, -1], stiff[-1, -1]])
        across = np.array([stiff[0, 0] - stiff[0, 1], soft[0, 0] - soft[0, 1]])
        E = [young_and_ratio(d, *each)[0] for each in ((K, mu), (K_upper, mu_upper))]
        nu = [young_and_ratio(d, *each)[1] for each in ((K, mu_upper), (K_upper, mu))]
        with np.errstate(divide="ignore", invalid="ignore"):  # a lower bound of zero
            return np.column_stack([E, nu, shear / across])


class PointSimplices(NamedTuple):
    """Delaunay simplices of a body's points.

    Parameters
    ----------
    corners, vectors
        (s, d + 1) points, and (s, d + 1, d) volume times gradient of their shape functions.
    volume
        (n,) of each point: its part of the simplices around it.
    surface
        (f, d) facets of one simplex only.
    """

    corners: Index
    vectors: Array
    volume: Array
    surface: Index


class _Window(NamedTuple):
    volume: float
    upper: Array
    compliance: Array
    points: int


def tensor_bounds(points: Array, springs: Index, stiffness: Array) -> tuple[TensorBounds, ...]:
    """Compute bounds of the effective tensor of a piece, for one size of windows after another.

    The first window is the whole inside, as far as a factor is affordable. Of a chain (d = 1) both
    bounds are the stiffness from end to end.

    Parameters
    ----------
    points, springs, stiffness
        (n, d) in m, (m, 2), and (m,) > 0 in N/m; unstressed.

    Raises
    ------
    ProblemError
        If the piece is too small.
    """
    idle = idle_points(points, springs) & (points.shape[1] > 1)
    stay, number = ~idle[springs].any(axis=1), np.cumsum(~idle) - 1
    x, pairs, k = points[~idle], number[springs[stay]], stiffness[stay]
    n, d = x.shape
    if not len(pairs):
        raise ProblemError(TOO_SMALL)
    vector = x[pairs[:, 1]] - x[pairs[:, 0]]
    length = np.linalg.norm(vector, axis=1)
    B = elongations(n, pairs, vector / length[:, None])
    stretch = length[:, None] * voigt_directions(vector / length[:, None])
    if d == 1:
        ends = [x.argmin(), x.argmax()]
        e = relax_freely(B[:, np.delete(np.arange(n), ends)], k, stretch)
        EA = np.array([[k @ e[:, 0] ** 2 / np.ptp(x)]])
        return (TensorBounds(EA, EA, 1, n, 0),)
    network = _Network(x, pairs, k, B, stretch, point_simplices(x, float(length.mean())))
    longest = np.zeros(n)
    np.maximum.at(longest, pairs.ravel(), np.repeat(length, 2))
    depth = nearest_on_facets(x[network.simplices.surface], x)[1]
    inside = np.flatnonzero((depth >= longest * (1 - ALIKE)) & (network.simplices.volume > 0))
    if not len(inside):
        raise ProblemError(TOO_SMALL)
    low, high = x[inside].min(axis=0), x[inside].max(axis=0)
    place = (x[inside] - low) / np.where(high > low, high - low, 1.0)
    near = np.argsort(np.abs(place - 0.5).max(axis=1), kind="stable")[: AFFORDED[d] // d]
    inside, place = inside[near], place[near]
    low, high = place.min(axis=0), place.max(axis=0)
    rows = []
    for cuts in CUTS:
        cell = np.minimum(cuts * (place - low) / np.where(high > low, high - low, 1.0), cuts - 1)
        windows = [
            window
            for each in product(range(cuts), repeat=d)
            for window in _window(network, inside[(cell.astype(int) == each).all(axis=1)])
        ]
        volume = np.array([each.volume for each in windows])
        if volume.sum() < ANSWERED * network.simplices.volume[inside].sum():
            break
        part = volume / volume.sum()
        upper = np.einsum("w,wij->ij", part, [each.upper for each in windows])
        lower = np.linalg.inv(np.einsum("w,wij->ij", part, [each.compliance for each in windows]))
        size = float(np.mean([each.points for each in windows]))
        rows.append(TensorBounds((lower + lower.T) / 2, upper, len(windows), size, idle.sum()))
    if not rows:
        raise ProblemError(TOO_SMALL)
    return tuple(rows)


def idle_points(points: Array, springs: Index) -> Mask:
    """Return the mask (n,) of points whose springs carry no force without a load on a point.

    Their springs run in independent directions; springs to other idle points do not count.
    """
    n, d = points.shape
    idle = np.zeros(n, dtype=bool)
    vectors = points[springs[:, 1]] - points[springs[:, 0]]
    normal = vectors / np.linalg.norm(vectors, axis=1)[:, None]
    dyads = normal[:, :, None] * normal[:, None]
    while True:
        there = ~idle[springs].any(axis=1)
        ends = springs[there].ravel()
        spread = np.zeros((n, d, d))
        np.add.at(spread, ends, np.repeat(dyads[there], 2, axis=0))
        rank = (np.linalg.eigvalsh(spread) > ALIKE).sum(axis=1)
        more = (rank == np.bincount(ends, minlength=n)) & ~idle
        if not more.any():
            return idle
        idle |= more


def point_simplices(points: Array, mean_length: float) -> PointSimplices:
    """Delaunay simplices of points (n, d) in m whose springs have a mean length (m).

    Raises
    ------
    ProblemError
        If the points span no body.
    """
    n, d = points.shape
    try:
        corners = Delaunay(points).simplices
    except (QhullError, ValueError) as error:
        raise ProblemError("points.csv: the points span no body; give a thicker piece") from error
    x = points[corners]
    edge = np.linalg.norm(x[:, :, None] - x[:, None], axis=3).max(axis=(1, 2))
    corners = corners[edge <= LONGEST_EDGE * mean_length]
    if not len(corners):
        raise ProblemError("springs: they are far shorter than gaps between points; add springs")
    x = points[corners]
    edges = x[:, 1:] - x[:, :1]
    if d == 2:
        turned = np.stack([edges[..., 1], -edges[..., 0]], axis=-1)
        vectors = np.stack([turned[:, 1], -turned[:, 0]], axis=1) / 2
    else:
        a, b, c = edges.transpose(1, 0, 2)
        vectors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1) / 6
    vectors = (
        vectors * np.copysign(1.0, np.einsum("sd,sd->s", edges[:, 0], vectors[:, 0]))[:, None, None]
    )
    vectors = np.concatenate([-vectors.sum(axis=1, keepdims=True), vectors], axis=1)
    # By the divergence theorem the sum of place times vector is the volume, along each axis.
    volume = np.repeat(np.einsum("sjd,sjd->s", x, vectors) / d / (d + 1), d + 1)
    facets = np.concatenate([np.delete(corners, j, axis=1) for j in range(d + 1)])
    facets, count = np.unique(np.sort(facets, axis=1), axis=0, return_counts=True)
    own = np.asarray(np.bincount(corners.ravel(), volume, n), dtype=float)
    return PointSimplices(corners, vectors, own, facets[count == 1])


class _Network(NamedTuple):
    """Points (n, d), springs (m, 2), their stiffness (m,), and simplices.

    B and stretch are the elongations (m, n·d) by motions and (m, v) by unit strains.
    """

    x: Array
    springs: Index
    k: Array
    B: csr_array
    stretch: Array
    simplices: PointSimplices


def _window(network: _Network, inside: Index) -> Iterator[_Window]:
    """Yield the bounds of a window of points, if it has an inside."""
    x, springs, k, B, stretch, simplices = network
    n, d = x.shape
    member = np.isin(np.arange(n), inside)
    firm = member
    while True:
        firm = firm & ~idle_points(x, springs[firm[springs].all(axis=1)])
        both = firm[springs].all(axis=1)
        whole = np.asarray(firm[simplices.corners].all(axis=1))
        if not whole.any():
            return
        moving = np.flatnonzero(np.repeat(firm, d))
        volume, load = _uniform_stress(x, simplices, whole)
        u = _displacement(B[both][:, moving], k[both], load[moving])
        motion = np.abs(u).max(axis=1).reshape(-1, d).max(axis=1)
        hinged = np.flatnonzero(firm)[motion > HINGED * np.median(motion)]
        if not len(hinged):
            break
        firm[hinged] = False
    free = firm.copy()
    free[springs[~both]] = False
    free[simplices.corners[~whole]] = False
    if not free.any():
        return
    # A spring with one point in the window counts half there, and follows the strain.
    part = np.where(both, 1.0, member[springs].mean(axis=1))
    e = stretch.copy()
    columns = np.flatnonzero(np.repeat(free, d))
    e[both] = relax_freely(B[both][:, columns], k[both], stretch[both])
    size = float(simplices.volume[member].sum())
    work = load[moving].T @ u
    yield _Window(
        size,
        np.einsum("m,mv,mw->vw", part * k, e, e) / size,
        (work + work.T) / 2 * size / volume**2,
        int(member.sum()),
    )


def _uniform_stress(x: Array, simplices: PointSimplices, whole: Mask) -> tuple[float, Array]:
    """Volume of some simplices, and the forces (n·d, v) of a unit of each component of stress."""
    d = x.shape[1]
    corners, vectors = simplices.corners[whole], simplices.vectors[whole]
    total = np.zeros(x.shape)
    np.add.at(total, corners, vectors)
    load = np.zeros((*x.shape, len(VOIGT[d])))
    for component, (p, q) in enumerate(VOIGT[d]):
        load[:, p, component], load[:, q, component] = total[:, q], total[:, p]
    volume = float(np.einsum("sjd,sjd->", x[corners], vectors)) / d
    return volume, load.reshape(x.size, -1)


def _displacement(B: csr_array, k: Array, load: Array) -> Array:
    """Displacement (f, v) by balanced loads (f, v); large where no spring resists it."""
    K, solve = shifted_solver(B, k)
    u = np.zeros(load.shape)
    for _ in range(CORRECTIONS):
        u += solve(load - K @ u)
    return u
