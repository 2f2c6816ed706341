"""Potentials as sums of two numbers each, and what follows from them cell by cell.

Where one permittivity is 1e12 times another, potentials in its cells differ by 1e-12 of themselves,
and what flows there is these differences times 1e12: of a potential that is one number, four digits
are left of it. Two numbers hold the difference, and sums over cells keep it: of potentials less
that of the cell's first node, which a matrix of rounded entries would not give.
"""

from __future__ import annotations

import numpy as np

from msvalidate.problem import Array, Index
from msvalidate.problem.records import dataclass
from reference_fem.mesh.assembly import basis_gradients, sum_to_nodes
from reference_fem.mesh.discretisation import Discretisation


@dataclass(frozen=True, eq=False)
class Pair:
    """Potentials (n,) in V as sums of a number and what it lacks. Arrays are read-only."""

    value: Array
    rest: Array

    def __post_init__(self) -> None:
        for array in (self.value, self.rest):
            array.setflags(write=False)

    def plus(self, change: Array) -> Pair:
        """The sum with potentials (n,) that are smaller, or that this one has none of."""
        value = self.value + change
        kept = value - self.value  # Knuth's sum of two numbers, with what it rounds away
        lost = (self.value - (value - kept)) + (change - kept)
        rest = self.rest + lost
        both = value + rest
        return Pair(both, rest - (both - value))


class Fluxes:
    """Sums over the cells of a mesh with a permittivity (c,) each.

    Parameters
    ----------
    body
        The mesh.
    permittivity
        Of the cells, in any unit.
    """

    def __init__(self, body: Discretisation, permittivity: Array) -> None:
        self._slope, measure = basis_gradients(body.basis)
        self._weight = permittivity[:, None] * measure
        self._nodes: Index = body.cell_nodes.T
        self._count = len(body.points)

    def gradients(self, potential: Pair) -> Array:
        """∇φ (d, c, q) at the cells' points."""
        of_value, of_rest = potential.value[self._nodes], potential.rest[self._nodes]
        apart = (of_value - of_value[0]) + (of_rest - of_rest[0])
        return np.asarray(np.einsum("kacq,kc->acq", self._slope, apart))

    def nodal(self, potential: Pair) -> Array:
        """∫ε ∇φ·∇φi (n,): charges at the nodes."""
        flux = self._weight * self.gradients(potential)
        each = np.einsum("kacq,acq->kc", self._slope, flux)
        return sum_to_nodes(self._nodes, each[None], self._count)[:, 0]

    def energy(self, potential: Pair) -> float:
        """∫ε|∇φ|², twice the energy."""
        return float((self._weight * (self.gradients(potential) ** 2).sum(axis=0)).sum())
