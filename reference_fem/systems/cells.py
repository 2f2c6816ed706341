"""Elastic forces summed cell by cell: the equations that `refined` solves."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import Gradients, gradients_at_points
from reference_fem.stress import pressure_numbers
from reference_fem.systems.refined import change_by_rewriting

EPS = float(np.finfo(float).eps)


@dataclass(frozen=True, eq=False)
class ElasticCells:
    """Forces of σ = C:ε on nodes.

    Parameters
    ----------
    gradients
        Of the mesh.
    tensor
        C (d, d, d, d) in Pa, thickness included; (m, d, d, d, d) of several materials.
    number
        (c,) which of several tensors is a cell's; None of one for all.
    """

    gradients: Gradients
    tensor: Array
    number: Index | None = None
    positive = True

    def strain(self, u: Array, rest: Array | None = None) -> Array:
        """Symmetric gradient (s, q, c), shears doubled, of displacements (d, n) in m."""
        G = self.gradients.of(u, rest)
        return np.array([G[a, a] if a == b else G[a, b] + G[b, a] for a, b in self._pairs])

    def stress(self, strain: Array) -> Array:
        """C:ε times the measure (s, q, c)."""
        if self.number is None:
            voigt = self._voigt(self.tensor)
            found = (voigt @ strain.reshape(len(strain), -1)).reshape(strain.shape)
        else:
            found = np.empty_like(strain)
            for i, tensor in enumerate(self.tensor):
                at = self.number == i
                found[..., at] = np.tensordot(self._voigt(tensor), strain[..., at], axes=1)
        return np.asarray(found * self.gradients.measure)

    def forces(self, stress: Array) -> Array:
        """Nodal forces (d, n) in N of stresses (s, q, c) that hold the measure."""
        return self.gradients.gathered(self._full(stress))

    def noise(self, u: Array, rest: Array, force: Array, number: int) -> Array:
        """Forces (d, n) in N as rounding makes them: sample of a number."""
        return change_by_rewriting(self, u, rest, force, number)

    @property
    def dim(self) -> int:
        """Number of axes."""
        return int(self.tensor.shape[-1])

    @property
    def _pairs(self) -> list[tuple[int, int]]:
        d = self.dim
        return [(a, a) for a in range(d)] + [(a, b) for a in range(d) for b in range(a + 1, d)]

    def _voigt(self, tensor: Array) -> Array:
        return np.array([[tensor[a, b, c, e] for c, e in self._pairs] for a, b in self._pairs])

    def _full(self, stress: Array) -> Array:
        """Stress (d, d, q, c) of its parts (s, q, c)."""
        d = self.dim
        full = np.empty((d, d, *stress.shape[1:]))
        for part, (a, b) in zip(stress, self._pairs, strict=True):
            full[a, b] = full[b, a] = part
        return full


@dataclass(frozen=True, eq=False)
class MixedCells:
    """Forces of σ = 2με + pI on nodes, and volumes of div u - p/λ, as `mixed` states them.

    Unknowns are displacements (d, n) in m and pressures (v,) in Pa, one after the other.

    Parameters
    ----------
    shear
        The forces of 2με.
    inverse
        1/λ (1/Pa), one for all or (c,).
    thickness
        In m.
    functions, corners
        (k, q) values of the pressure's functions in a cell, and (k, c) the pressures that they
        belong to.
    count
        Number of pressures.
    """

    shear: ElasticCells
    inverse: float | Array
    thickness: float
    functions: Array
    corners: Index
    count: int
    positive = False

    def strain(self, u: Array, rest: Array | None = None) -> tuple[Array, Array]:
        """Strain (s, q, c) and pressure (q, c)."""
        less = None if rest is None else self._displacement(rest)
        pressure = u[-self.count :] if rest is None else u[-self.count :] + rest[-self.count :]
        strain = self.shear.strain(self._displacement(u), less)
        return strain, self.functions.T @ pressure[self.corners]

    def stress(self, strain: tuple[Array, Array]) -> tuple[Array, Array]:
        """Stress (s, q, c) and what volumes are wrong by (q, c), times the measure."""
        d, weight = self.shear.dim, self.thickness * self.shear.gradients.measure
        stress = self.shear.stress(strain[0])
        stress[:d] += weight * strain[1]
        return stress, weight * (strain[0][:d].sum(axis=0) - self.inverse * strain[1])

    def forces(self, stress: tuple[Array, Array]) -> Array:
        """Nodal forces (N), then volumes (m³)."""
        volumes = self._by_corner(self.functions @ stress[1])
        return np.concatenate([self.shear.forces(stress[0]).ravel(), volumes])

    def noise(self, u: Array, rest: Array, force: Array, number: int) -> Array:
        """Forces (N) and volumes (m³) as rounding makes them: sample of a number."""
        return change_by_rewriting(self, u, rest, force, number)

    def _displacement(self, u: Array) -> Array:
        return u[: -self.count].reshape(self.shear.dim, -1)

    def _by_corner(self, each: Array) -> Array:
        found = np.bincount(self.corners.ravel(), each.ravel(), self.count)
        return np.asarray(found, dtype=float)


def mixed_cells(
    body: Discretisation, lame: list[tuple[float, float]], thickness: float, number: Index | None
) -> MixedCells:
    """The equations of mixed elements of μ (Pa), 1/λ (1/Pa) and thickness (m).

    Of one material, or of several with the number (c,) of each cell's.
    """
    unit = np.eye(body.dim)
    straight = np.einsum("ac,be->abce", unit, unit)
    tensors = [thickness * mu * (straight + straight.swapaxes(2, 3)) for mu, _ in lame]
    inverse: float | Array = lame[0][1]
    if number is not None:
        inverse = np.array([each for _, each in lame])[number]
    X, linear = np.asarray(body.basis.X), body.element.linear
    functions = np.array([linear.lbasis(X, i)[0] for i in range(body.element.corners)])
    tensor = tensors[0] if number is None else np.array(tensors)
    shear = ElasticCells(gradients_at_points(body), tensor, number)
    corners, count = pressure_numbers(body, number)
    return MixedCells(shear, inverse, thickness, functions, corners, count)


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

    def noise(self, u: Array, rest: Array, force: Array, number: int) -> Array:  # noqa: ARG002
        """Forces (d, n) in N as the rounding of entries makes them, with random signs."""
        size = (abs(self.K) @ np.abs(u).ravel()).reshape(u.shape)
        signs = np.random.default_rng(number).uniform(-1, 1, u.shape)
        return np.asarray(EPS * size * signs)
