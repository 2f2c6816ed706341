"""Energy of the volumes of cells, beside springs: any Poisson's ratio.

A cell of volume V (in the plane its area), V0 at rest, stores V0 U(J), J = V/V0, by its law
(`laws.quadratic`, U = ½ κ (J - 1)², unless another is named), and pulls its corners by
-U'(J) ∂V/∂x.

Springs at rest give an isotropic solid with λ = μ; κ = λ - μ makes any λ of it, for a uniform
strain changes V by its trace ([Golec2020] adds such an energy to springs). Only V enters, one
number a cell, so that no other motion of the cell is stiffened.

V is the sum of determinants of the corners of triangles that cover the cell's surface. A
quadrilateral face of a hexahedron is the bilinear one: the mean of its two pairs of triangles. In
the plane a triangle is an edge and the unit normal, which stands as a corner of its own: one
formula serves all cells. This is the plain NumPy form; `springs.kernels` holds the compiled one.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array, Index, ProblemError, SolverError
from msvalidate.problem.checks import finite, finite_coordinates, integers, require_type, shaped
from msvalidate.problem.records import dataclass
from msvalidate.springs.network.checks import check_cells
from msvalidate.springs.network.laws.law import CellLaw
from msvalidate.springs.network.laws.quadratic import QUADRATIC

_HEXAHEDRON = (
    (0, 3, 2, 1),
    (4, 5, 6, 7),
    (0, 1, 5, 4),
    (1, 2, 6, 5),
    (2, 3, 7, 6),
    (0, 4, 7, 3),
)


TOGETHER = 5_000
"""Cells that are computed at once."""


def _around(corners: int) -> Index:
    """Edges of a plane cell, each with the normal, which comes after the corners."""
    return np.array([(i, (i + 1) % corners, corners) for i in range(corners)])


SURFACES: dict[tuple[int, int], tuple[Index, float]] = {
    (2, 3): (_around(3), 1 / 2),
    (2, 4): (_around(4), 1 / 2),
    (3, 4): (np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)]), 1 / 6),
    (3, 8): (
        np.array(
            [t for a, b, c, d in _HEXAHEDRON for t in ((a, b, c), (a, c, d), (a, b, d), (b, c, d))]
        ),
        1 / 12,
    ),
}
"""(axes, corners) of a cell -> its surface triangles, and their weights.

The triangles (t, 3) are counter-clockwise from outside, for cells in VTK order; the weight is that
of each determinant. In 2D the third corner is the normal.
"""


@dataclass(frozen=True, eq=False)
class Volumes:
    """Cells of a network that resist a change of volume. Arrays are made read-only.

    Source: the energy at the head of this file; such energies beside springs are in [Golec2020].

    Parameters
    ----------
    points
        (n, d) reference positions (m) of the network's points.
    cells
        (c, 3 or 4) corners of triangles or quadrilaterals, counter-clockwise, or (c, 4 or 8) of
        tetrahedra or hexahedra, in VTK order.
    stiffness
        (c,) κ: N/m in the plane, thickness included, Pa in space. Below zero where the solid's
        Poisson's ratio is lower than its springs'.
    law
        What a cell stores by its volume.
    pressure
        (c,) pressure at rest, in the units of κ, of a law that has one; else 0.

    Raises
    ------
    ProblemError
        Naming the array and its first bad entry, or the cell that has no volume or less.
    """

    points: Array
    cells: Index
    stiffness: Array
    law: CellLaw = QUADRATIC
    pressure: Array | float = 0.0

    def __post_init__(self) -> None:
        need = "the points of cells are (n, 2) or (n, 3)"
        points = finite_coordinates("points", self.points, "n", (2, 3), need=need)
        n, d = points.shape
        cells = check_cells(self.cells, n, d)
        count = len(shaped("cells", cells, "c>0", cells.shape[1]))
        need = f"these cells need ({count},)"
        kappa = finite("stiffness of volumes", self.stiffness, count, need=need)
        require_type("law of cells", self.law, CellLaw)
        pressure = finite("pressure of volumes", self.pressure)
        pressure = pressure if pressure.ndim else np.full(count, float(pressure))
        pressure = finite("pressure of volumes", pressure, count, need=need)
        given = {"points": points, "cells": cells, "stiffness": kappa, "pressure": pressure}
        for name, value in given.items():
            object.__setattr__(self, name, value)
            value.setflags(write=False)
        if pressure.any() and not self.slope.any():
            raise ProblemError(f"pressure of volumes: the {self.law.name} law has none; leave it")
        small = self.rest_volume <= 1e-12 * np.ptp(points[cells], axis=1).max(axis=1) ** d
        if small.any():
            cell = int(np.flatnonzero(small)[0])
            raise ProblemError(
                f"cells: cell {cell} has volume {self.rest_volume[cell]:g}; list its corners "
                "counter-clockwise, in space in VTK order"
            )

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.points.shape[1])

    @property
    def surface(self) -> tuple[Index, float]:
        """Triangles (t, 3) of a cell's surface, and the part of each determinant that counts."""
        return SURFACES[self.dim, self.cells.shape[1]]

    @cached_property
    def corners(self) -> Array:
        """Corners (c, k, 3) in m relative to the first corner of each cell.

        In 2D the normal is included.

        Differences keep the digits that coordinates far from the origin have lost.
        """
        return _local_values(self, self.points, 1.0)

    @property
    def coefficients(self) -> tuple[Array, Array]:
        """Stiffness and pressure at rest (c,): what the law's functions take first."""
        return self.stiffness, np.asarray(self.pressure)

    @property
    def slope(self) -> Array:
        """First derivatives U'(1) (c,) of the cells' energy: minus their pressure.

        The derivatives are in the units of κ.
        """
        return self.law.at_rest(*self.coefficients)

    @property
    def curvature(self) -> Array:
        """Second derivatives U''(1) (c,) of the cells' energy at rest, in the units of κ."""
        return self.law.curvature(*self.coefficients, np.zeros(len(self.cells)))

    @cached_property
    def rest_volume(self) -> Array:
        """V0 (c,) in m² or m³."""
        a, b, c = (self.corners[:, corner] for corner in self.surface[0].T)
        V0 = np.asarray(self.surface[1] * (a * np.cross(b, c)).sum(axis=(1, 2)))
        V0.setflags(write=False)
        return V0


def cell_volumes(points: ArrayLike, cells: ArrayLike) -> Array:
    """Volumes (c,) in m³, in the plane areas in m², of cells as in `Volumes`.

    Raises `ProblemError` as for `Volumes`.
    """
    t = integers("cells", cells)
    return Volumes(finite_coordinates("points", points), t, np.zeros(t.shape[:1])).rest_volume


def dilatation(volumes: Volumes, displacement: Array, *, linear: bool = False) -> Array:
    """Relative volume change V/V0 - 1 (c,) of the cells, or its linear part.

    The displacement is (n, d) in m.

    From the moves of the corners, without the digits that V and V0 share.
    """
    triangles, part = volumes.surface
    p, q, r = triangles.T

    def grown(X: Array, u: Array) -> Array:
        x = X if linear else X + u
        # det(x, y, z) - det(X, Y, Z), one column moved after the other.
        change = u[:, p] * np.cross(x[:, q], x[:, r])
        change += X[:, p] * (np.cross(u[:, q], x[:, r]) + np.cross(X[:, q], u[:, r]))
        return np.asarray(part * change.sum(axis=(1, 2)))

    moved = _checked_moves("displacement", volumes, displacement)
    return _by_parts(grown, volumes.corners, moved) / volumes.rest_volume


def energy(volumes: Volumes, displacement: Array) -> float:
    """Energy (J) that the cells store under a displacement (n, d) in m.

    Less what is linear in it: the work of the forces at rest. Raises `SolverError` if a cell has no
    volume left and its law forbids that.
    """
    j, slope = _grown(volumes, displacement), volumes.slope
    stored = volumes.law.work(*volumes.coefficients, j)
    if slope.any():
        stored = stored + slope * (j - dilatation(volumes, displacement, linear=True))
    return float(volumes.rest_volume @ stored)


def rest_force(volumes: Volumes) -> Array:
    """Force (n, d) in N of the cells on the points at rest."""
    slope = volumes.slope
    if not slope.any():
        return np.zeros(volumes.points.shape)
    g = _gradient(volumes, volumes.corners, volumes.corners)
    return _summed(volumes, -slope[:, None, None] * g)


def tension_virial(volumes: Volumes, displacement: Array) -> Array:
    """Symmetric part (c, d, d) of the virial Σ U'(1) ∂V/∂x⊗X of cells in N·m.

    It is of first order in the displacement (n, d) in m; X are the corners.
    """
    u, X = _checked_moves("displacement", volumes, displacement), volumes.corners
    pull = _gradient(volumes, X, X) + _gradient(volumes, u, X) + _gradient(volumes, X, u)
    k, d = pull.shape[1:]
    virial = volumes.slope[:, None, None] * np.einsum("cka,ckb->cab", pull, X[:, :k, :d])
    return np.asarray((virial + virial.transpose(0, 2, 1)) / 2)


def force(volumes: Volumes, displacement: Array) -> Array:
    """Force (n, d) in N of the cells on the points, less that at rest.

    The displacement is (n, d) in m. Raises `SolverError` as `energy`.
    """
    u, X = _checked_moves("displacement", volumes, displacement), volumes.corners
    x = X + u
    j, slope = _grown(volumes, displacement), volumes.slope
    change = volumes.law.change(*volumes.coefficients, j)
    pull = change[:, None, None] * _gradient(volumes, x, x)
    if slope.any():
        pull += slope[:, None, None] * (_gradient(volumes, u, x) + _gradient(volumes, X, u))
    return -_summed(volumes, pull)


def force_change(volumes: Volumes, displacement: Array, motion: Array) -> Array:
    """First-order change (n, d) in N of `force` by a motion.

    The motion and the displacement at which it begins are (n, d) in m. Raises `SolverError` as
    `energy`.
    """
    w, x = _checked_moves("motion", volumes, motion), _displaced(volumes, displacement)
    k, d = volumes.cells.shape[1], volumes.dim
    g = _gradient(volumes, x, x)
    slope, curvature = _slopes(volumes, displacement)
    hard = curvature / volumes.rest_volume * (g * w[:, :k, :d]).sum(axis=(1, 2))
    change = hard[:, None, None] * g
    if slope.any():
        bent = _gradient(volumes, w, x) + _gradient(volumes, x, w)
        change += slope[:, None, None] * bent
    return -_summed(volumes, change)


def force_magnitudes(volumes: Volumes, displacement: Array) -> Array:
    """Sum (n,) of force magnitudes (N) of cells per point.

    The displacement is (n, d) in m. Raises `SolverError` as `energy`.
    """
    x = _displaced(volumes, displacement)
    slope, _ = _slopes(volumes, displacement)
    size = np.linalg.norm(slope[:, None, None] * _gradient(volumes, x, x), axis=2)
    return _sums_at_points(volumes, size)


def stiffness_magnitudes(volumes: Volumes) -> Array:
    """Sum (n,) of |U''(1)| |∂V/∂x|²/V0 (N/m) at each point: its cells' own stiffness."""
    g = _gradient(volumes, volumes.corners, volumes.corners)
    root = np.sqrt(np.abs(volumes.curvature)) / np.sqrt(volumes.rest_volume)
    own = ((root[:, None, None] * g) ** 2).sum(axis=2)
    return _sums_at_points(volumes, own)


def roundoff_magnitudes(volumes: Volumes, reach: float) -> Array:
    """Sum (n,) of the forces (N) of cells that bound rounding errors.

    The corners move by `reach` (m), to which the size of the cell is added.

    An eps of it is the rounding of a force: see `Network.rounding`.
    """
    size = np.linalg.norm(_gradient(volumes, volumes.corners, volumes.corners), axis=2)
    V0 = volumes.rest_volume
    j = size.sum(axis=1) * (reach + V0 ** (1 / volumes.dim)) / V0
    met = (np.abs(volumes.curvature) * j + np.abs(volumes.slope))[:, None] * size
    return _sums_at_points(volumes, met)


def tangent_entries(volumes: Volumes, displacement: Array) -> Callable[[int, int], Array]:
    """Function of two axes that returns tangent entries (c, k, k) in N/m.

    The displacement is (n, d) in m. Raises `SolverError` as `energy`.

    A cell's is (U''/V0) g gᵀ + U' H, with V's gradient g and its second derivatives H: of a
    determinant ∂²/∂p_a∂q_b = ε_abc r_c, and so on round.

    Source: the energy at the head of this file, differentiated twice.
    """
    slope, curvature = _slopes(volumes, displacement)
    x = _displaced(volumes, displacement)
    g, hard = _gradient(volumes, x, x), (curvature / volumes.rest_volume)[:, None, None]
    triangles, part = volumes.surface
    k, bent = volumes.cells.shape[1], bool(slope.any())

    def entry(a: int, b: int) -> Array:
        block = hard * g[:, :, a, None] * g[:, None, :, b]
        if bent and a != b:
            c, across = 3 - a - b, np.zeros((*x.shape[:2], x.shape[1]))
            for p, q, r in triangles:
                for first, second, third in ((p, q, r), (q, r, p), (r, p, q)):
                    across[:, first, second] += x[:, third, c]
                    across[:, second, first] -= x[:, third, c]
            sign = part if (b - a) % 3 == 1 else -part
            block += (sign * slope)[:, None, None] * across[:, :k, :k]
        return np.asarray(block)

    return entry


def _checked_moves(name: str, volumes: Volumes, moves: Array) -> Array:
    """Moves (n, d) as corners' (c, k, 3), from each cell's first; refused unless one a point."""
    require_type("volumes", volumes, Volumes)
    shape = volumes.points.shape
    return _local_values(volumes, finite(name, moves, *shape, need=f"give an array {shape}"), 0.0)


def _displaced(volumes: Volumes, displacement: Array) -> Array:
    """Corners (c, k, 3) in m of the displaced cells."""
    return volumes.corners + _checked_moves("displacement", volumes, displacement)


def _local_values(volumes: Volumes, values: Array, normal: float) -> Array:
    """Values (n, d) at the corners (c, k, 3) less the first of each; the normal as one more."""
    c, k = volumes.cells.shape
    local = values[volumes.cells] - values[volumes.cells[:, :1]]
    if volumes.dim == 3:
        return local
    padded = np.zeros((c, k + 1, 3))
    padded[:, :k, :2] = local
    padded[:, k, 2] = normal
    return padded


def _sums_at_points(volumes: Volumes, values: Array) -> Array:
    """Sums (n,) of values (c, k) at the corners of cells."""
    n = len(volumes.points)
    return np.bincount(volumes.cells.ravel(), values.ravel(), n).astype(float, copy=False)


def _summed(volumes: Volumes, pull: Array) -> Array:
    """Forces (n, d) of those at corners (c, k, d)."""
    axes = [_sums_at_points(volumes, pull[:, :, axis]) for axis in range(volumes.dim)]
    return np.stack(axes, axis=1)


def _gradient(volumes: Volumes, x: Array, y: Array) -> Array:
    """∂V/∂x (c, corners, d) in m or m² where y is x, corners (c, k, 3); its polar form else."""
    triangles, part = volumes.surface

    def slope(x: Array, y: Array) -> Array:
        g = np.zeros(x.shape)
        for p, q, r in triangles:
            g[:, p] += np.cross(x[:, q], y[:, r])
            g[:, q] += np.cross(x[:, r], y[:, p])
            g[:, r] += np.cross(x[:, p], y[:, q])
        return np.asarray(part * g[:, : volumes.cells.shape[1], : volumes.dim])

    return _by_parts(slope, x, y)


def _by_parts(work: Callable[..., Array], *arrays: Array) -> Array:
    """Work on arrays of the cells, so many at a time that what is made of them stays in a cache."""
    starts = range(0, len(arrays[0]), TOGETHER)
    parts = [work(*(array[i : i + TOGETHER] for array in arrays)) for i in starts]
    return parts[0] if len(parts) == 1 else np.concatenate(parts)


def _grown(volumes: Volumes, displacement: Array) -> Array:
    """Compute `dilatation` (c,) and check that the law allows it.

    Raises `SolverError` if a cell of a law with a barrier has no volume left.
    """
    j = dilatation(volumes, displacement)
    if volumes.law.barrier and not j.min() > -1:
        cell = int(j.argmin())
        raise SolverError(
            f"cell {cell} of the {volumes.law.name} law has no volume left (V/V0 = "
            f"{1 + j[cell]:.3g}); raise what is applied in smaller steps, or reduce it"
        )
    return j


def _slopes(volumes: Volumes, displacement: Array) -> tuple[Array, Array]:
    """U' and U'' (c,) of the displaced cells."""
    law, j = volumes.law, _grown(volumes, displacement)
    slope = volumes.slope + law.change(*volumes.coefficients, j)
    return slope, law.curvature(*volumes.coefficients, j)
