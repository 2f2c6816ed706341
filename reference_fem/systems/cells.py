"""Elastic forces summed cell by cell, from differences of displacements: what `refined` solves."""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.discretisation import Discretisation
from reference_fem.mesh.gradients import Gradients
from reference_fem.stress import pressure_numbers


@dataclass(frozen=True, eq=False)
class ElasticForces:
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

    def __call__(self, u: Array) -> Array:
        """Nodal forces (d·n,) in N of displacements (d·n,) in m, component-major."""
        slope = self.gradients.of(u.reshape(self.tensor.shape[-1], -1))
        return self.gradients.gathered(self.stress(slope)).ravel()

    def stress(self, slope: Array) -> Array:
        """C:∇u times the measure (d, d, q, c), of slopes ∂u_a/∂x_i (d, d, q, c)."""
        if self.number is None:
            found = np.tensordot(self.tensor, slope, axes=2)
        else:
            found = np.empty_like(slope)
            for i, tensor in enumerate(self.tensor):
                at = self.number == i
                found[..., at] = np.tensordot(tensor, slope[..., at], axes=2)
        found *= self.gradients.measure
        return np.asarray(found)


@dataclass(frozen=True, eq=False)
class MixedForces:
    """Forces of σ = 2με + pI on nodes, and volumes of div u - p/λ, as `mixed` states them.

    Unknowns are displacements (d·n,) in m and pressures (v,) in Pa, one after the other.

    Parameters
    ----------
    body
        The mesh.
    shear
        The forces of 2με.
    inverse
        1/λ (1/Pa) of each material.
    thickness
        In m.
    """

    body: Discretisation
    shear: ElasticForces
    inverse: Array
    thickness: float

    def __post_init__(self) -> None:
        X, linear = np.asarray(self.body.basis.X), self.body.element.linear
        each = [linear.lbasis(X, i)[0] for i in range(self.body.element.corners)]
        corners, count = pressure_numbers(self.body, self.shear.number)
        soft = self.inverse[0 if self.shear.number is None else self.shear.number]
        object.__setattr__(self, "_parts", (np.array(each), corners, count, soft))

    def __call__(self, x: Array) -> Array:
        """Nodal forces (N), then volumes (m³) by corner."""
        functions, corners, count, soft = self._parts  # type: ignore[attr-defined]
        cells, d = self.shear.gradients, self.body.dim
        slope = cells.of(x[:-count].reshape(d, -1))
        pressure = functions.T @ x[-count:][corners]
        weight = self.thickness * cells.measure
        stress = self.shear.stress(slope)
        stress[range(d), range(d)] += weight * pressure
        volume = weight * (np.trace(slope) - soft * pressure)
        by_corner = np.bincount(corners.ravel(), (functions @ volume).ravel(), count)
        return np.concatenate([cells.gathered(stress).ravel(), by_corner])
