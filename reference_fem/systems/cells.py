"""Elastic forces summed cell by cell: the equations that `refined` solves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from scipy.sparse import csr_matrix

from msvalidate.problem import Array
from reference_fem.mesh.gradients import Gradients

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class ElasticCells:
    """Forces of σ = C:ε on nodes.

    Parameters
    ----------
    gradients
        Of the mesh.
    tensor
        C (d, d, d, d) in Pa, thickness included.
    """

    gradients: Gradients
    tensor: Array
    positive = True

    def strain(self, u: Array, rest: Array | None = None) -> Array:
        """Symmetric gradient (s, q, c), shears doubled, of displacements (d, n) in m."""
        G = self.gradients.of(u, rest)
        return np.array([G[a, a] if a == b else G[a, b] + G[b, a] for a, b in self._pairs])

    def stress(self, strain: Array) -> Array:
        """C:ε times the measure (s, q, c)."""
        found = (self._voigt @ strain.reshape(len(strain), -1)).reshape(strain.shape)
        return np.asarray(found * self.gradients.measure)

    def forces(self, stress: Array) -> Array:
        """Nodal forces (d, n) in N of stresses (s, q, c) that hold the measure."""
        return self.gradients.gathered(self._full(stress))

    def sized(self, stress: Array) -> tuple[Array, Array]:
        """As `forces`, and the sizes (d, n) in N of what the cells bring to them."""
        return self.gradients.sized(self._full(stress))

    def noise(self, u: Array, sums: Array) -> Array:
        """Forces (d, n) in N as rounding makes them, with random signs.

        Gradients are rounded relative to what cancels in strains: the turning of a cell. Sums at
        nodes, and loads, are rounded relative to their terms.
        """
        signs = np.random.default_rng(0)
        turning = np.abs(self.gradients.of(u)).max(axis=(0, 1))
        size = np.abs(self._voigt).sum(axis=1)[:, None, None] * turning * self.gradients.measure
        wrong = EPS * size * signs.uniform(-1, 1, size.shape)
        return np.asarray(self.forces(wrong) + EPS * sums * signs.uniform(-1, 1, sums.shape))

    @property
    def _pairs(self) -> list[tuple[int, int]]:
        d = len(self.tensor)
        return [(a, a) for a in range(d)] + [(a, b) for a in range(d) for b in range(a + 1, d)]

    @property
    def _voigt(self) -> Array:
        return np.array([[self.tensor[a, b, c, e] for c, e in self._pairs] for a, b in self._pairs])

    def _full(self, stress: Array) -> Array:
        """Stress (d, d, q, c) of its parts (s, q, c)."""
        d = len(self.tensor)
        full = np.empty((d, d, *stress.shape[1:]))
        for part, (a, b) in zip(stress, self._pairs, strict=True):
            full[a, b] = full[b, a] = part
        return full


@dataclass(frozen=True, eq=False)
class Entries:
    """Forces K u of a matrix as it stands, whose entries are rounded.

    Parameters
    ----------
    K
        Stiffness (d·n, d·n) in N/m, component-major.
    """

    K: csr_matrix
    positive = True

    def strain(self, u: Array, rest: Array | None = None) -> Array:
        """The displacements (d, n) in m."""
        return u if rest is None else u + rest

    def stress(self, strain: Array) -> Array:
        """K u (d, n) in N."""
        return np.asarray(self.K @ strain.ravel()).reshape(strain.shape)

    def forces(self, stress: Array) -> Array:
        """The same."""
        return stress

    def sized(self, stress: Array) -> tuple[Array, Array]:
        """The same, twice: what adds up to them is known where the displacements are."""
        return stress, np.abs(stress)

    def noise(self, u: Array, sums: Array) -> Array:
        """Forces (d, n) in N as the rounding of entries makes them, with random signs."""
        size = (abs(self.K) @ np.abs(u).ravel()).reshape(u.shape) + sums
        return np.asarray(EPS * size * np.random.default_rng(0).uniform(-1, 1, u.shape))
