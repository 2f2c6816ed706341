"""Bounds of the stiffness tensor of an irregular network (Hill-Mandel condition).

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

import math
from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array, diags_array
from scipy.spatial import Delaunay, QhullError

from msvalidate.linear_algebra.factor import factorise
from msvalidate.problem import VOIGT, Array, Index, Mask, ProblemError
from msvalidate.problem.cells import surface_facets
from msvalidate.problem.normals import nearest_on_facets
from msvalidate.problem.records import ReadOnly, dataclass
from msvalidate.problem.shapes import STRAIGHT, area_vectors, enclosed_volume
from msvalidate.springs.constants.cell_at_rest import AFFORDED, elongations, stiffness_of
from msvalidate.springs.constants.stiffness import (
    ALIKE,
    AXES_OF,
    cubic_part,
    invariant_moduli,
    voigt_directions,
    young_and_ratio,
)
from msvalidate.springs.lattice.ties import break_ties
from msvalidate.springs.lattice.triangulation import signed_volumes

LONGEST_EDGE = 4.0
"""Longest edge of a simplex relative to the mean spring."""
CUTS = (1, 2, 4)
"""Windows along each axis into which a piece is divided."""
ANSWERED = 0.5
"""Minimum fraction of the volume that windows of one size cover."""
HINGED = 100.0
"""Motion of a hinged point under uniform stress, relative to the median."""
SHIFT = 1e-9
"""Relative stiffness added to each component, for motions without stiffness."""
CORRECTIONS = 4
"""Number of solutions by the shifted stiffness."""
TOO_SMALL = (
    "points.csv: joined points with an inside are missing; give a larger piece, or a periodic "
    "sample and its --period"
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
        """Lowest and highest E (N/m or Pa), nu and Zener ratio, (2, 3).

        They are those of all isotropic tensors between the isotropic parts, and of all cubic ones.
        """
        d, ends = AXES_OF[len(self.lower)], (self.lower, self.upper)
        K, mu = np.transpose([invariant_moduli(each) for each in ends])
        C = np.array([cubic_part(each) for each in ends])
        across = (C[:, 0, 0] - C[:, 0, 1])[::-1]
        with np.errstate(divide="ignore", invalid="ignore"):  # a lower bound of zero
            zener = 2 * C[:, -1, -1] / across
        E, nu = young_and_ratio(d, K, mu)[0], young_and_ratio(d, K, mu[::-1])[1]
        return np.column_stack([E, nu, zener])


class _Network(NamedTuple):
    """Points (n, d), springs (m, 2), their stiffness (m,), and simplices with volumes of points.

    B and stretch are the elongations (m, n·d) by motions and (m, v) by unit strains.
    """

    x: Array
    springs: Index
    k: Array
    B: csr_array
    stretch: Array
    simplices: Index
    volume: Array


def tensor_bounds(points: Array, springs: Index, stiffness: Array) -> tuple[TensorBounds, ...]:
    """Compute bounds of the effective tensor of a piece by window size.

    The first window is the whole inside, as far as a factor is affordable. A piece too small for an
    inside is a window itself, with springs missing at its surface. For a chain (d = 1) both bounds
    are its stiffness from end to end times its length, EA in N.

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
    stay = ~idle[springs].any(axis=1)
    x, pairs, k = points[~idle], (np.cumsum(~idle) - 1)[springs[stay]], stiffness[stay]
    n, d = x.shape
    vector = x[pairs[:, 1]] - x[pairs[:, 0]]
    length = np.linalg.norm(vector, axis=1)
    normal = vector / length[:, None]
    B, stretch = elongations(n, pairs, normal), length[:, None] * voigt_directions(normal)
    if d == 1:
        inner = np.delete(np.arange(n), [x.argmin(), x.argmax()])
        e = _relax(B[:, inner], k, stretch)
        EA = e.T @ (k[:, None] * e) / np.ptp(x)
        return (TensorBounds(EA, EA, 1, n, 0),)
    simplices, volume = point_simplices(x, length.sum() / max(len(pairs), 1))
    network = _Network(x, pairs, k, B, stretch, simplices, volume)
    longest = np.zeros(n)
    np.maximum.at(longest, pairs.ravel(), np.repeat(length, 2))
    surface = surface_facets(simplices, STRAIGHT[d, d + 1])
    depth = nearest_on_facets(x[surface], x)[1]
    # Points that lie deeper than their springs are long have all their springs.
    inside = np.flatnonzero((depth >= longest * (1 - ALIKE)) & (volume > 0))
    away = np.abs((x - x.mean(axis=0)) / np.ptp(x, axis=0)).max(axis=1)[inside]
    inside = inside[np.argsort(away, kind="stable")[: AFFORDED[d] // d]]
    rows: list[TensorBounds] = []
    place = x[inside] - x[inside].min(axis=0, initial=np.inf)
    place /= place.max(axis=0, initial=np.finfo(float).tiny)
    for cuts in CUTS:
        cell = np.minimum(cuts * place, cuts - 1).astype(int)
        parts = [inside[(cell == each).all(axis=1)] for each in product(range(cuts), repeat=d)]
        windows = [window for part in parts for window in _window(network, part)]
        if not windows and not rows:  # the piece itself
            windows, inside = [*_window(network, np.arange(n))], np.arange(n)
        share = np.array([each.volume for each in windows])
        if share.sum() <= ANSWERED * volume[inside].sum():
            break
        upper, compliance = np.average([one.tensors for one in windows], axis=0, weights=share)
        lower, size = np.linalg.inv(compliance), len(inside) / cuts**d
        rows.append(TensorBounds((lower + lower.T) / 2, upper, len(windows), size, idle.sum()))
        if len(inside) == n:
            break
    if not rows:
        raise ProblemError(TOO_SMALL)
    return tuple(rows)


def idle_points(points: Array, springs: Index) -> Mask:
    """Return the mask (n,) of points whose springs carry no force.

    Without a load on a point, springs in independent directions carry none. Springs to other idle
    points do not count.
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


def point_simplices(points: Array, mean_length: float) -> tuple[Index, Array]:
    """Delaunay simplices (s, d + 1) of points (n, d), and their volumes (n,).

    Simplices run over gaps of the springs, whose mean length is given (m), but not over hollows.

    Raises
    ------
    ProblemError
        If the points span no body.
    """
    n, d = points.shape
    try:
        cells = Delaunay(break_ties(points)).simplices.astype(np.intp)
    except (QhullError, ValueError) as error:
        raise ProblemError(TOO_SMALL) from error
    x = points[cells]
    edge = np.linalg.norm(x[:, :, None] - x[:, None], axis=3).max(axis=(1, 2))
    cells = cells[edge <= LONGEST_EDGE * mean_length]
    turned = signed_volumes(break_ties(points)[cells]) < 0
    cells[turned] = cells[turned][:, [1, 0, *range(2, d + 1)]]
    if not len(cells):
        raise ProblemError(TOO_SMALL)
    part = signed_volumes(points[cells]) / math.factorial(d + 1)
    return cells, np.asarray(np.bincount(cells.ravel(), np.repeat(part, d + 1), n), dtype=float)


class _Window(NamedTuple):
    """Volume, and tensors (2, v, v): upper bound, and inverse of the lower one."""

    volume: float
    tensors: Array


def _window(network: _Network, inside: Index) -> Iterator[_Window]:
    """Yield the bounds of a window of points, if it has an inside."""
    x, springs, k, B, stretch, simplices, volumes = network
    n, d = x.shape
    member = np.isin(np.arange(n), inside)
    firm = member
    while True:
        firm = firm & ~idle_points(x, springs[firm[springs].all(axis=1)])
        both = firm[springs].all(axis=1)
        whole = np.asarray(firm[simplices].all(axis=1))
        if not whole.any():
            return
        moving = np.flatnonzero(np.repeat(firm, d))
        facets = surface_facets(simplices[whole], STRAIGHT[d, d + 1])
        volume, load = _uniform_stress(x, facets)
        u = _displacement(B[both][:, moving], k[both], load[moving])
        motion = np.abs(u).max(axis=1).reshape(-1, d).max(axis=1)
        hinged = np.flatnonzero(firm)[motion > HINGED * np.median(motion)]
        if not len(hinged):
            break
        firm[hinged] = False
    free = firm.copy()
    free[springs[~both]] = False
    free[facets] = False
    if not free.any():
        return
    # Half of a spring with one point in the window is its own, and follows the strain.
    part, e = np.where(both, 1.0, member[springs].mean(axis=1)), stretch.copy()
    e[both] = _relax(B[both][:, np.flatnonzero(np.repeat(free, d))], k[both], stretch[both])
    size, work = float(volumes[member].sum()), load[moving].T @ u
    upper = e.T @ ((part * k)[:, None] * e) / size
    yield _Window(size, np.array([upper, (work + work.T) / 2 * size / volume**2]))


def _uniform_stress(x: Array, facets: Index) -> tuple[float, Array]:
    """Volume within facets, and forces (n·d, v) due to unit stress components.

    The volume is in m² or m³, and the forces per unit of stress in m or m². The corners of a facet
    have equal parts of its force.
    """
    d = x.shape[1]
    area = np.zeros(x.shape)
    np.add.at(area, facets, area_vectors(x[facets])[1].sum(axis=1, keepdims=True) / d)
    load = np.zeros((*x.shape, len(VOIGT[d])))
    for component, (p, q) in enumerate(VOIGT[d]):
        load[:, p, component], load[:, q, component] = area[:, q], area[:, p]
    return enclosed_volume(x[facets]), load.reshape(x.size, -1)


def _relax(B: csr_array, k: Array, stretch: Array) -> Array:
    """Elongations (m, v) of least energy, from those without motions of the points."""
    return np.asarray(stretch - B @ _displacement(B, k, B.T @ (k[:, None] * stretch)))


def _displacement(B: csr_array, k: Array, load: Array) -> Array:
    """Displacement (f, v) by balanced loads (f, v); large where no spring resists it."""
    K = stiffness_of(B, k)
    own, u = K.diagonal(), np.zeros(load.shape)
    least = SHIFT * own.max(initial=np.finfo(float).tiny)
    factor = factorise(csr_array(K + diags_array(SHIFT * np.maximum(own, least))))
    for _ in range(CORRECTIONS):
        u += factor.solve(load - K @ u)
    return u
