"""Waves of endless lattices whatever their points are joined by: springs or volumes.

The rows of a point in the middle of a block are those of any point: its blocks K_j of stiffness,
one for every point that it is coupled with, make the stiffness of a wave of phases q,

    K(q) = Σ_j K_j exp(i q·c_j),

with c_j the cell that the other point is in. What is found so knows nothing of how the lattice's
own tensors and waves are made elsewhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from msvalidate import kit
from msvalidate.springs.lattice import Lattice, Pattern, fill

REACH = 3
"""Cells from the middle one to the side: more than springs and cells reach."""
PHASES = 8
"""Of waves along each axis, even, so that pi is one."""
LONG = 1e-3
"""Phase of long waves, in rad a cell: what is left of the short ones is its square."""
COUPLED = 1e-12
"""Part of the largest entry of stiffness below which it is rounding."""


@dataclass(frozen=True, eq=False)
class Stencil:
    """Stiffness that couples the points of a cell with others.

    How many points a cell has; the cell (s, d) of each other point, counted from the middle one;
    the kinds (s, 2) of the two; and the stiffness (s, d, d) in N/m.
    """

    points: int
    cell: kit.Index
    pair: kit.Index
    block: kit.Array

    def stiffness(self, phases: kit.Array) -> NDArray[np.complex128]:
        """Stiffness (q, p·d, p·d) of the waves of phases (q, d) in rad a cell."""
        n, d = self.points, self.block.shape[1]
        K = np.zeros((n, n, len(phases), d, d), dtype=complex)
        turn = np.exp(1j * (self.cell @ phases.T))
        np.add.at(K, tuple(self.pair.T), turn[:, :, None, None] * self.block[:, None])
        whole = K.transpose(2, 0, 3, 1, 4).reshape(len(phases), n * d, n * d)
        # Without what rounding leaves of its skew part.
        return np.asarray((whole + whole.conj().transpose(0, 2, 1)) / 2)

    def less(self, other: Stencil) -> Stencil:
        """What this stiffness has more than another of the same lattice."""
        cell, pair = np.vstack([self.cell, other.cell]), np.vstack([self.pair, other.pair])
        return Stencil(self.points, cell, pair, np.concatenate([self.block, -other.block]))

    @property
    def coupled(self) -> float:
        """Other points that a point is coupled with, on average."""
        large = np.abs(self.block).max(axis=(1, 2)) > COUPLED * np.abs(self.block).max()
        return float(large.sum() / self.points - 1)


def block(pattern: Pattern) -> Lattice:
    """A box with a cell in its middle that sees no side."""
    count = 2 * REACH + 1
    return fill(pattern, kit.Box(tuple(float(count * edge) for edge in pattern.size)), count)


def stencil(pattern: Pattern, lattice: Lattice, K: csr_array) -> Stencil:
    """The rows of K (n·d, n·d) that belong to the points of the middle cell of a `block`."""
    d = pattern.dim
    part = lattice.points[:, None, :] / np.array(pattern.size) - pattern.points / pattern.size
    whole = np.round(part)
    kind = np.abs(part - whole).max(axis=2).argmin(axis=1)
    cell = whole[np.arange(len(kind)), kind].astype(int) - REACH
    rows, pairs, blocks = [], [], []
    for point in np.flatnonzero((cell == 0).all(axis=1)):
        own = csr_array(K[point * d : point * d + d])
        dense = np.asarray(own.todense()).reshape(d, -1, d)
        for other in np.unique(own.indices // d):
            rows.append(cell[other])
            pairs.append((kind[point], kind[other]))
            blocks.append(dense[:, other])
    return Stencil(len(pattern.points), np.array(rows), np.array(pairs), np.array(blocks))


def phases(dim: int) -> kit.Array:
    """A grid of phases (q, d) from cell to cell, pi among them, and long waves the same way."""
    steps = 2 * math.pi / PHASES * (np.arange(PHASES) - PHASES // 2 + 1)
    # A wave and its opposite are one: half of the phases of the last axis will do.
    grid = np.array(list(product(*[steps] * (dim - 1), steps[steps >= 0])))
    grid = grid[np.abs(grid).max(axis=1) > 0]
    return np.concatenate([grid, LONG * grid])


def least_part(springs: Stencil, added: Stencil) -> float:
    """Multiple of what is added to springs, above which every wave costs energy; below zero."""
    q = phases(springs.block.shape[1])
    root = np.linalg.cholesky(springs.stiffness(q))
    half = np.linalg.solve(root, added.stiffness(q))
    ratio = np.linalg.solve(root, half.conj().transpose(0, 2, 1))
    return float(-1 / np.linalg.eigvalsh(ratio).max())


def highest(whole: Stencil) -> float:
    """Highest frequency squared times the mass of a point (N/m), over the grid of phases.

    The points of a cell are taken to be of one mass.
    """
    return float(np.linalg.eigvalsh(whole.stiffness(phases(whole.block.shape[1]))).max())
