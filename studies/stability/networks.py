"""The networks of the study: blocks of springs, clamped on one side, and their linear motion.

Stiffness of axial springs 1 N/m, density 1 kg/m², side 1 m: what is asked are ratios.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import eigsh

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.homogenise import interior_tensor
from msvalidate.springs.dynamics.spectrum import extreme_frequencies
from msvalidate.springs.lattice import Lattice, square, triangular, zigzag_block
from msvalidate.springs.network import tangent

CONSTANTS = {"square": (1.0, 0.5), "triangular": (1.0,)}
"""Spring constants (N/m) by kind: isotropic."""
REPORTED = (1.0, 2.0)
"""The report's "incompressible" square lattice: k2 = 2 k1 (N/m)."""
DENSE = 200
"""Degrees of freedom up to which a dense matrix is the faster one in products."""
LOWEST_PART, RANDOM_PART = 0.1, 1e-3
"""Amplitudes of the lowest mode and of the rest in the start, where the highest mode's is 1."""


@dataclass(frozen=True)
class Body:
    """A body that moves: a single "oscillator", or a lattice of so many points a side."""

    lattice: str
    points: int = 1


OSCILLATOR = Body("oscillator")


@dataclass(frozen=True, eq=False)
class Linear:
    """Linear motion of the free components of a body: x'' = -K x / m - c x'.

    Parameters
    ----------
    matrix
        (n, n) in 1/s²: -K/m, which gives accelerations.
    mass
        (n, 1) in kg.
    omega
        Lowest and highest frequency (rad/s).
    lowest, highest
        Modes (n, 1) in m, of one unit of energy each (½ φᵀKφ = 1 J).
    """

    matrix: kit.Array | csr_array
    mass: kit.Array
    omega: tuple[float, float]
    lowest: kit.Array
    highest: kit.Array

    def acceleration(self, x: kit.Array) -> kit.Array:
        """Acceleration (n, columns) in m/s² of springs at displacements (n, columns) in m."""
        return np.asarray(self.matrix @ x)

    def start(self, seed: int) -> kit.Array:
        """Displacement (n, 1) in m: the two extreme modes and a small random part.

        The lowest mode decays the slowest: with little energy it hides the growth of others the
        least.
        """
        noise = np.random.default_rng(seed).normal(size=self.mass.shape)
        size = RANDOM_PART * np.abs(self.highest).max()
        return np.asarray(LOWEST_PART * self.lowest + self.highest + size * noise)

    @cached_property
    def inertia(self) -> kit.Array:
        """Masses (n,) in kg."""
        return self.mass[:, 0]


def clamped(
    body: Body,
    constants: tuple[float, ...] | None = None,
    *,
    weights: str = "shared",
    traction: tuple[float, float] = (0.0, 0.0),
) -> tuple[Lattice, kit.Network]:
    """Square lattice, or triangles of a zigzag block, and its network, clamped on the left side.

    `traction` (N/m²) acts on the right side.
    """
    sides = body.points - 1
    if body.lattice == "square":
        domain: kit.Domain = kit.Box((1.0, 1.0))
        grid = square(kit.Box((1.0, 1.0)), sides)
    else:
        outline = zigzag_block(1.0, (2 * round(sides / math.sqrt(3)), sides))
        domain, grid = outline, triangular(outline, 1 / sides)
    k = CONSTANTS[body.lattice] if constants is None else constants
    width = domain.span[0][1]
    problem = kit.Problem(
        domain,
        kit.Anisotropic(interior_tensor(grid, k, "shared")),
        (kit.Support(kit.Segment((0.0, 1.0), (0.0, 0.0)), (0.0, 0.0)),),
        (kit.Traction(kit.Segment((width, 0.0), (width, 1.0)), traction),) if any(traction) else (),
        name=f"{body.lattice}, clamped on the left",
    )
    return grid, lattice_network(problem, grid, k, weights=weights)


def free_components(network: kit.Network) -> kit.Index:
    """Numbers (f,) of the components that are not held, point by point."""
    return np.flatnonzero(~network.fixed.ravel())


def linear(body: Body) -> Linear:
    """The linear motion of a body."""
    if body == OSCILLATOR:
        one = np.ones((1, 1))
        return Linear(-one, one, (1.0, 1.0), one, one)
    _, network = clamped(body)
    free = free_components(network)
    mass = np.repeat(network.mass, network.dim)[free]
    stiffness = tangent(network, network.points)[free][:, free]
    lowest, highest = modes(stiffness, mass)
    omega = extreme_frequencies(network, tolerance=1e-8)
    matrix = csr_array(diags_array(-1 / mass) @ stiffness)
    small = len(free) <= DENSE
    return Linear(matrix.toarray() if small else matrix, mass[:, None], omega, lowest, highest)


def modes(stiffness: csr_array, mass: kit.Array) -> tuple[kit.Array, kit.Array]:
    """Lowest and highest mode (n, 1) in m of one unit of energy each; signs are fixed."""
    root = diags_array(1 / np.sqrt(mass))
    matrix = csr_array(root @ stiffness @ root)
    if matrix.shape[0] <= DENSE:
        _, vectors = eigh(matrix.toarray())
        found = (vectors[:, 0], vectors[:, -1])
    else:
        start = np.random.default_rng(0).normal(size=matrix.shape[0])
        low = eigsh(matrix, k=1, sigma=0, v0=start)[1][:, 0]
        found = (low, eigsh(matrix, k=1, which="LA", v0=start, tol=1e-8)[1][:, 0])
    scaled = []
    for vector in found:
        shape = vector / np.sqrt(mass)
        shape = shape / np.sqrt(0.5 * shape @ (stiffness @ shape))
        # The first large component, not the largest: points of a symmetric body share that.
        large = int((np.abs(shape) > 0.5 * np.abs(shape).max()).argmax())
        scaled.append((shape * np.sign(shape[large]))[:, None])
    return scaled[0], scaled[1]
