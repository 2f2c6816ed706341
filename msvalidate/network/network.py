"""A spring network from any list of points and springs: energy, force and tangent.

A spring between points i and j with d = x_j - x_i pulls along its *current* direction:
energy ½k(|d| - L0)², force on i k(|d| - L0)·d/|d|, the opposite on j. Beside the springs may stand
cells that resist a change of volume, `laws.volumes`, and springs that resist shear,
`laws.local_shear`.

This is the plain NumPy form; `msvalidate.kernels` holds the compiled one of springs and cells.
"""

from __future__ import annotations

import math
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy.sparse import bsr_array, csr_array

from msvalidate.linear_algebra.blocks import Blocks, blocks_of
from msvalidate.network.checks import (
    broadcast_values,
    check_cells,
    check_springs,
    refuse_first_bad,
)
from msvalidate.network.folds import Simplices, simplices_of
from msvalidate.network.laws import local_shear
from msvalidate.network.laws import volumes as cells
from msvalidate.network.laws.local_shear import LocalShear
from msvalidate.network.laws.volumes import Volumes
from msvalidate.network.layout import Layout, make_layout
from msvalidate.problem import LONGEST, Array, Index, Mask, ProblemError, SolverError
from msvalidate.problem.checks import (
    boolean_mask,
    finite,
    finite_coordinates,
    format_value,
    integers,
    require_type,
)
from msvalidate.problem.records import dataclass, replace


@dataclass(frozen=True, eq=False)
class Network:
    """Points joined by springs, with masses, supports and loads. Arrays are made read-only.

    `spring_network` fills in what is usual; `bodies.lattice_network` builds one from a problem.

    Parameters
    ----------
    points
        (n, d) reference positions (m): displacements count from here.
    springs
        (m, 2) pairs of different points.
    stiffness
        (m,) (N/m, thickness included), >= 0.
    rest_length
        (m,) (m), > 0.
    mass
        (n,) (kg), > 0.
    held
        (n, d) components whose displacement is prescribed.
    displacement
        (n, d) prescribed displacement (m), 0 where nothing is held.
    force
        (n, d) external force (N).
    volumes
        Cells of the same points that resist a change of volume, if there are any.
    shear
        Springs between the same points that resist shear, if there are any.
    cells
        (c, corners) points of the cells that a deformed network is looked at for folds by, in VTK
        order; by default those of `volumes`, or the triangles that springs make in the plane.

    Raises
    ------
    ProblemError
        Naming the array and its first bad entry.
    """

    points: Array
    springs: Index
    stiffness: Array
    rest_length: Array
    mass: Array
    held: Mask
    displacement: Array
    force: Array
    volumes: Volumes | None = None
    shear: LocalShear | None = None
    cells: Index | None = None

    def __post_init__(self) -> None:
        points = finite_coordinates("points", self.points, "n>0", (2, 3))
        n, d = points.shape
        springs = check_springs(self.springs, n)
        m = len(springs)
        for name, shape, checked in (
            ("points", (n, d), finite_coordinates),
            ("stiffness", (m,), finite),
            ("rest_length", (m,), finite_coordinates),
            ("mass", (n,), finite),
            ("displacement", (n, d), finite_coordinates),
            ("force", (n, d), finite),
        ):
            need = f"this network needs {shape}"
            object.__setattr__(self, name, checked(name, getattr(self, name), *shape, need=need))
        held, moved = boolean_mask("held", self.held, (n, d)), self.displacement
        refuse_first_bad(
            "stiffness", self.stiffness, self.stiffness < 0, "N/m; it must be 0 or more"
        )
        refuse_first_bad(
            "displacement", moved[~held], moved[~held] != 0, "m of what is not held; hold it too"
        )
        refuse_first_bad(
            "rest_length", self.rest_length, self.rest_length <= 0, "m; it must be above 0"
        )
        refuse_first_bad("mass", self.mass, self.mass <= 0, "kg; it must be above 0")
        small = 0 < self.stiffness.max() < np.finfo(float).tiny  # no factor has digits then
        refuse_first_bad("stiffness", self.stiffness, small & (self.stiffness > 0), "N/m; raise it")
        object.__setattr__(self, "springs", springs)
        distance = np.linalg.norm(self.vector, axis=1)
        # Below 1/LONGEST a distance is rounded away when it is squared.
        together = distance <= max(1e-14 * float(np.abs(points).max()), 1 / LONGEST)
        refuse_first_bad("spring length", distance, together, "m; its two points coincide")
        object.__setattr__(self, "held", held)
        for name, kind in (("volumes", Volumes), ("shear", LocalShear)):
            part = getattr(self, name)
            if part is not None:
                require_type(name, part, kind)
                if not np.array_equal(part.points, self.points):
                    raise ProblemError(f"{name}: of other points than the network's; give its own")
        if self.cells is not None:
            object.__setattr__(self, "cells", check_cells(self.cells, n, d))
        for array in (self.springs, self.held):
            array.setflags(write=False)

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return int(self.points.shape[1])

    @property
    def start(self) -> Array:
        """Positions (n, d) in m with the prescribed displacements imposed and all else unmoved."""
        return self.points + self.displacement

    @cached_property
    def vector(self) -> Array:
        """Vectors (m, d) in m from the first point of each spring to the second."""
        vector = self.points[self.springs[:, 1]] - self.points[self.springs[:, 0]]
        vector.setflags(write=False)
        return vector

    @cached_property
    def layout(self) -> Layout:
        """How its points and springs lie in memory for the compiled sweep."""
        cells = np.zeros((0, 1), dtype=np.intp) if self.volumes is None else self.volumes.cells
        n, d = self.points.shape
        return make_layout(n, d, self.springs, self.stiffness, self.rest_length, cells)

    @cached_property
    def blocks(self) -> Blocks:
        """The positions of each spring's blocks in the tangent."""
        return blocks_of(self.springs, len(self.points))

    @cached_property
    def simplices(self) -> Simplices | None:
        """What shows that it is folded; None where there is nothing to look at."""
        cells = self.cells
        if cells is None and self.volumes is not None:
            cells = self.volumes.cells
        return simplices_of(self.points, self.springs, cells)

    @cached_property
    def frequency_bound(self) -> float:
        """Frequency (rad/s) that none exceeds at the reference positions: Gershgorin's circles.

        ω² ≤ max over free components i of Σ_j |K_ij|/m_i: no eigenvalues are solved for.

        Source: [Gershgorin1931].
        """
        free = ~self.held.ravel()
        mass = np.repeat(self.mass, self.dim)[free]
        rows = abs(tangent(self, self.points)) @ free.astype(float)
        with np.errstate(over="ignore"):  # infinite is a bound too
            return float(np.sqrt((rows[free] / mass).max(initial=0.0)))

    def assemble_forces(self, pull: Array) -> Array:
        """Force (n, d) in N on the points by pulls (m, d) of springs on their first ends."""
        force = np.zeros(self.points.shape)
        for axis in range(self.dim):
            for end, sign in ((0, 1.0), (1, -1.0)):
                weights = sign * pull[:, axis]
                force[:, axis] += np.bincount(self.springs[:, end], weights, len(force))
        return force

    def scaled(self, factor: Array | float) -> Network:
        """The same network with every spring's stiffness times `factor`, a number or (m,).

        Raises
        ------
        ProblemError
            If the factor is of another shape, not finite, or makes a stiffness negative.
        """
        times = finite("factor of the stiffness", factor)
        if times.shape not in {(), self.stiffness.shape}:
            raise ProblemError(
                f"factor of the stiffness: shape {times.shape}; give one number or "
                f"{self.stiffness.shape}"
            )
        return replace(self, stiffness=self.stiffness * times)


def spring_network(
    points: ArrayLike,
    springs: ArrayLike,
    stiffness: ArrayLike,
    *,
    rest_length: ArrayLike | None = None,
    mass: ArrayLike = 1.0,
    held: ArrayLike | None = None,
    displacement: ArrayLike | None = None,
    force: ArrayLike | None = None,
    volumes: Volumes | None = None,
    shear: LocalShear | None = None,
    cells: ArrayLike | None = None,
) -> Network:
    """Network from any list of points and springs.

    Parameters
    ----------
    points, springs, stiffness, rest_length, mass, held, displacement, force, volumes, shear, cells
        As in `Network`. One number serves for all springs or points. Rest lengths default to the
        distances in `points`, an unstressed network; the rest defaults to none.

    Raises
    ------
    ProblemError
        If an array does not fit, a spring joins a point to itself, names a point that is not
        there or has no length, or a value is out of range.
    """
    x = finite_coordinates("points", points, "n", (2, 3))
    pairs = check_springs(springs, len(x))
    distance = np.linalg.norm(x[pairs[:, 1]] - x[pairs[:, 0]], axis=1)
    zero = np.zeros(x.shape)
    return Network(
        points=x,
        springs=pairs,
        stiffness=broadcast_values("stiffness", stiffness, len(pairs)),
        # What has no length is refused for that, not for the rest length it would be given.
        rest_length=np.where(distance > 0, distance, 1.0)
        if rest_length is None
        else broadcast_values("rest_length", rest_length, len(pairs)),
        mass=broadcast_values("mass", mass, len(x)),
        held=boolean_mask("held", zero if held is None else held, x.shape),
        displacement=finite("displacement", zero if displacement is None else displacement),
        force=finite("force", zero if force is None else force),
        volumes=volumes,
        shear=shear,
        cells=None if cells is None else integers("cells", cells),
    )


def energy(network: Network, position: Array) -> float:
    """Energy (J) stored in springs, cells and shear springs at `position` (n, d) in m."""
    _, length = spring_vectors(network, position)
    stored = float(0.5 * network.stiffness @ (length - network.rest_length) ** 2)
    stored += cells.energy(network.volumes, position) if network.volumes else 0.0
    return stored + (local_shear.energy(network.shear, position) if network.shear else 0.0)


def internal_force(network: Network, position: Array) -> Array:
    """Force (n, d) in N of all springs and cells on the points at `position` (n, d) in m."""
    vector, length = spring_vectors(network, position)
    tension = network.stiffness * (length - network.rest_length)
    force = network.assemble_forces((tension / length)[:, None] * vector)
    if network.volumes:
        force = force + cells.force(network.volumes, position)
    return force + local_shear.force(network.shear, position) if network.shear else force


def tangent(network: Network, position: Array) -> csr_array:
    """Tangent stiffness (n·d, n·d) in N/m at `position`, row n·d of point-major components.

    A spring's block is k n nᵀ + k(1 - L0/|d|)(I - n nᵀ): elastic and geometric stiffness. Cells and
    shear springs add theirs.

    Source: [Crisfield1991], chapter 3 (truss elements); derived by differentiation of
    `internal_force`.
    """
    return csr_array(tangent_blocks(network, position))


def tangent_blocks(network: Network, position: Array) -> bsr_array:
    """The tangent of `tangent`, kept as one d × d block for every two points that are joined."""
    vector, length = spring_vectors(network, position)
    n = vector / length[:, None]
    across = network.stiffness * (1 - network.rest_length / length)
    along = network.stiffness - across

    def entry(a: int, b: int) -> Array:
        # n nᵀ first, so that it is rounded alike in springs of any stiffness: long and slender
        # bodies keep two digits more.
        elastic = along * (n[:, a] * n[:, b])
        return elastic + across if a == b else elastic

    K = network.blocks.summed(network.springs, network.dim, entry)
    added = []
    if network.volumes:
        added.append(cells.tangent(network.volumes, position))
    if network.shear:
        added.append(local_shear.tangent(network.shear, position))
    if not added:
        return K
    return bsr_array(sum(added, csr_array(K)), blocksize=(network.dim, network.dim))


def mode_energy(network: Network, position: Array, motion: Array) -> float:
    """Twice the energy (J) of a small motion (n, d) in m from `position`: motionᵀ K motion.

    Summed spring by spring, each term positive, it is exact where K's own rounding would hide it;
    cells are one term each. Springs within 1e-12 of their rest length count as unstressed.
    """
    vector, length = spring_vectors(network, position)
    i, j = network.springs.T
    change = motion[j] - motion[i]
    along = (change * vector).sum(axis=1) / length
    slack = 1 - network.rest_length / length
    slack[np.abs(slack) < 1e-12] = 0.0
    across = (change**2).sum(axis=1) - along**2
    stored = float(network.stiffness @ (along**2 + slack * across))
    if network.volumes:
        stored += cells.mode_energy(network.volumes, position, motion)
    if network.shear:
        stored += local_shear.mode_energy(network.shear, position, motion)
    return stored


def spring_vectors(network: Network, position: Array) -> tuple[Array, Array]:
    """Vectors (m, d) in m of the springs at `position` (n, d) in m, and their lengths (m,) in m.

    Raises
    ------
    ProblemError
        If positions do not fit the network, or are no ordinary numbers.
    SolverError
        If a spring has no length: it pulls in no direction.
    """
    require_type("network", network, Network)
    if getattr(position, "shape", None) != network.points.shape:
        raise ProblemError(
            f"position: {format_value(position)}; give an array {network.points.shape}"
        )
    if type(position) is not np.ndarray or position.dtype != np.float64:
        position = finite_coordinates("position", position)
    vector = position[network.springs[:, 1]] - position[network.springs[:, 0]]
    length = np.linalg.norm(vector, axis=1)
    if not math.isfinite(length.sum()):  # one look for any number of springs
        finite_coordinates("position", position)
    refuse_zero_length(network, length)
    return vector, length


def refuse_zero_length(network: Network, length: Array) -> None:
    """Raise `SolverError` where a spring has no length (m,) in m."""
    if not length.all():
        spring = int(np.flatnonzero(length == 0)[0])
        raise SolverError(
            f"spring {spring} has no length: points {network.springs[spring].tolist()} have been "
            "pushed into one place, where no direction is left; reduce the load"
        )
