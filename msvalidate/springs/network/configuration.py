"""A network under a displacement: energy, forces and tangent, from changes of length.

A spring between points i and j with y = x_j - x_i pulls along its *current* direction by its law's
pull p(s), force over length at s = y·y: on i by p(s)·y, the opposite on j. What s is larger by than
at the reference points,

    s - s0 = (2Y + w)·w,

Y its vector there, w the difference of two displacements, has all digits of these: a position of
1e6 m has none for a displacement of 1e-10 m. So forces are those at rest, 0 where these are in
balance, and changes: p(s0)·w + (p(s) - p(s0))·y. Cells that resist a change of volume do the same
(`laws.volumes`). This is the plain NumPy form; `msvalidate.springs.kernels` has the compiled one.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from scipy.sparse import bsr_array, csr_array

from msvalidate.linear_algebra.norms import max_abs
from msvalidate.problem import LONGEST, Array, ProblemError, SolverError
from msvalidate.problem.checks import finite_coordinates, format_value, require_type
from msvalidate.springs.network.laws import volumes as cells
from msvalidate.springs.network.network import Network


class Configuration:
    """Network with its points displaced from the reference positions.

    The displacement is (n, d) in m, by default 0.

    Attributes
    ----------
    move, vector
        (m, d) in m: what the springs' second points move more than the first, and their vectors.
    length
        (m,) in m.
    grown
        (m,) in m²: squares of the lengths less those at the reference points.

    Raises `SolverError` if a spring has no length: it pulls in no direction.
    """

    def __init__(self, network: Network, displacement: Array | None = None) -> None:
        displacement = np.zeros(network.points.shape) if displacement is None else displacement
        self.network, self.displacement = network, displacement
        i, j = network.springs.T
        self.move = displacement[j] - displacement[i]
        self.vector = network.vector + self.move
        self.length = np.linalg.norm(self.vector, axis=1)
        if not self.length.all():
            spring = int(np.flatnonzero(self.length == 0)[0])
            raise SolverError(
                f"spring {spring} has no length: points {network.springs[spring].tolist()} have "
                "been pushed into one place, where no direction is left; reduce the load"
            )
        self.grown = ((network.vector + self.vector) * self.move).sum(axis=1)

    @cached_property
    def square(self) -> Array:
        """Squares (m,) of the lengths in m²."""
        return np.asarray(self.length**2)

    @cached_property
    def pull_change(self) -> Array:
        """Force over length (m,) of each spring in N/m, less that at the reference points."""
        network = self.network
        return network.law.change(network.coefficients, network.square, self.square, self.grown)

    @cached_property
    def force_density(self) -> Array:
        """Tension (m,) of each spring over its length, in N/m: its stiffness across."""
        return self.network.pull_at_rest + self.pull_change

    @cached_property
    def axial_stiffness(self) -> Array:
        """Stiffness (m,) in N/m of each spring along itself."""
        return self.network.law.axial(self.network.coefficients, self.square)

    def energy(self) -> float:
        """Energy (J) stored in springs and cells.

        Of springs that rest at no length, what is stored beyond that at the reference points.
        """
        network, law, c = self.network, self.network.law, self.network.coefficients
        stored = law.work(c, network.square, self.square, self.grown).sum()
        if network.prestressed:
            stored += 0.5 * float(network.pull_at_rest @ (self.move**2).sum(axis=1))
            stored += float(law.stored(c, network.square) @ (network.pull_at_rest != 0))
        stored -= float((network.rest_force * self.displacement).sum())
        return float(stored) + network.of_cells(cells.energy, self.displacement)

    def force(self) -> Array:
        """Force (n, d) in N of all springs and cells on the points."""
        network = self.network
        pull = self.pull_change[:, None] * self.vector
        if network.prestressed:
            pull += network.pull_at_rest[:, None] * self.move
        force = network.assemble_forces(pull) + network.rest_force
        return force + network.of_cells(cells.force, self.displacement)

    def force_change(self, motion: Array) -> Array:
        """First-order change (n, d) in N of `force` by a motion (n, d) in m.

        It is -K times the motion.

        From the springs' own vectors: the assembled K has rounding that long bodies multiply.
        """
        i, j = self.network.springs.T
        w = motion[j] - motion[i]
        along = (self.vector * w).sum(axis=1) / self.length**2
        pull = ((self.axial_stiffness - self.force_density) * along)[:, None] * self.vector
        force = self.network.assemble_forces(pull + self.force_density[:, None] * w)
        return force + self.network.of_cells(cells.force_change, self.displacement, motion)

    def mode_energy(self, motion: Array) -> float:
        """Twice the energy (J) of a small motion (n, d) in m: motionᵀ K motion.

        Summed spring by spring, without differences of large sums: exact where K's own rounding
        would hide it. Springs in compression count below 0; cells are one term each.
        """
        i, j = self.network.springs.T
        w = motion[j] - motion[i]
        along = (self.vector * w).sum(axis=1) / self.length
        across = (w**2).sum(axis=1) - along**2
        stored = float(self.axial_stiffness @ along**2 + self.force_density @ across)
        change = self.network.of_cells(cells.force_change, self.displacement, motion)
        return stored - float(np.sum(motion * change))

    def tangent(self) -> bsr_array:
        """Tangent stiffness matrix (n·d, n·d) in N/m, sparse with d × d blocks.

        A spring's is k n nᵀ + p (I - n nᵀ): its stiffness along itself, and its pull across.

        Source: [Crisfield1991], chapter 3 (truss elements); derived by differentiation of `force`.
        """
        network, n = self.network, self.vector / self.length[:, None]
        across, along = self.force_density, self.axial_stiffness - self.force_density

        def entry(a: int, b: int) -> Array:
            # n nᵀ first, so that it is rounded alike in springs of any stiffness: long and slender
            # bodies keep two digits more.
            elastic = along * (n[:, a] * n[:, b])
            return np.asarray(elastic + across if a == b else elastic)

        K = network.blocks.summed(network.springs, network.dim, entry)
        if network.volumes is not None:
            network.blocks.add(K.data, cells.tangent_entries(network.volumes, self.displacement))
        return K

    def force_magnitudes(self) -> Array:
        """Sum (n,) of the force magnitudes (N) of springs and cells per point."""
        network, tension = self.network, np.abs(self.force_density) * self.length
        met = np.zeros(len(network.points))
        for end in (0, 1):
            met += np.bincount(network.springs[:, end], tension, len(met))
        return met + network.of_cells(cells.force_magnitudes, self.displacement)

    def largest_rotation(self, motion: Array) -> float:
        """Largest change of a spring vector in a motion (n, d), relative to its length.

        NaN counts as the largest.
        """
        i, j = self.network.springs.T
        with np.errstate(over="ignore", invalid="ignore"):
            change = np.linalg.norm(motion[j] - motion[i], axis=1) / self.length
        return float(np.nan_to_num(change, nan=np.inf).max(initial=0.0))


def configuration_at(network: Network, position: Array) -> Configuration:
    """The configuration at `position` (n, d) in m.

    Raises `ProblemError` if positions do not fit the network, or are no ordinary numbers;
    `SolverError` as for `Configuration`.
    """
    require_type("network", network, Network)
    if getattr(position, "shape", None) != network.points.shape:
        raise ProblemError(
            f"position: {format_value(position)}; give an array {network.points.shape}"
        )
    plain = type(position) is np.ndarray and position.dtype == np.float64
    if not (plain and max_abs(position) <= LONGEST):
        position = finite_coordinates("position", position)
    return Configuration(network, position - network.points)


def energy(network: Network, position: Array) -> float:
    """Energy (J) stored in springs and cells at `position` (n, d) in m."""
    return configuration_at(network, position).energy()


def internal_force(network: Network, position: Array) -> Array:
    """Force (n, d) in N of all springs and cells on the points.

    They are at `position` (n, d) in m.
    """
    return configuration_at(network, position).force()


def tangent(network: Network, position: Array) -> csr_array:
    """Tangent stiffness (n·d, n·d) in N/m at `position`.

    Component a of point i is row i·d + a.

    See `Configuration.tangent`.
    """
    return csr_array(configuration_at(network, position).tangent())


def mode_energy(network: Network, position: Array, motion: Array) -> float:
    """Quadratic form motionᵀ K motion (J), twice the energy of a small motion.

    The motion and `position` are (n, d) in m.
    """
    return configuration_at(network, position).mode_energy(motion)


def frequency_bound(network: Network) -> float:
    """Frequency (rad/s) that none exceeds at the reference positions: Gershgorin's circles.

    ω² ≤ max over free components i of Σ_j |K_ij|/m_i: no eigenvalues are solved for.

    Source: [Gershgorin1931].
    """
    free = ~network.fixed.ravel()
    mass = np.repeat(network.mass, network.dim)[free]
    rows = abs(csr_array(Configuration(network).tangent())) @ free.astype(float)
    with np.errstate(over="ignore"):  # infinite is a bound too
        return float(np.sqrt((rows[free] / mass).max(initial=0.0)))
