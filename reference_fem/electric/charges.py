"""A slab in air at its voltages: charges, and the forces on the slab.

The far boundary either lets no field through ("natural") or is a conductor without charge
("floating"). The first takes energy away from the field and the second adds some: capacitances with
them are a lower and an upper bound of that in endless air, as far as the mesh has converged. The
leading parts of both errors, those of a dipole in a square box, are opposite, so that their mean is
nearer by orders.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from msvalidate.problem import Array
from msvalidate.problem.checks import finite, require_one_of, require_type
from msvalidate.problem.records import dataclass
from reference_fem.electric.electrostatics import Dielectric, Potential, no_nodes
from reference_fem.electric.mesh import SlabMesh

Far = Literal["natural", "floating"]
FAR: tuple[Far, ...] = ("natural", "floating")
SAME = 1e-9
"""Relative difference of equal distances."""


@dataclass(frozen=True, eq=False)
class Charged:
    """A slab in air at given voltages.

    Parameters
    ----------
    mesh
        Slab and air.
    voltages
        (k,) of the electrodes (V).
    solution
        The potential on the mesh.
    """

    mesh: SlabMesh
    voltages: Array
    solution: Potential

    @property
    def totals(self) -> Array:
        """Free charge (k,) of the electrodes, per depth (C/m)."""
        return np.array([self.solution.charge[nodes].sum() for nodes in self.mesh.conductors])

    @property
    def energy(self) -> float:
        """½ΣQV = ½∫ε|E|² per depth (J/m)."""
        return self.solution.energy

    def potential(self, points: ArrayLike) -> Array:
        """Potential (p,) in V at points (p, 2) in m of slab and air."""
        return self.solution.at(points)

    def field(self, points: ArrayLike) -> Array:
        """Field (p, 2) in V/m at points (p, 2) in m, as `Potential.field`."""
        return self.solution.field(points)

    @property
    def forces(self) -> Array:
        """Maxwell's forces (m, 2) on the slab, per depth (N/m), by `SlabMesh.carried`.

        On a moved mesh, they are the energy's derivative for motions from there on; for
        displacements from another mesh, let that one carry `solution.forces`.
        """
        return self.mesh.carried(self.solution.forces)


def solve_charges(
    mesh: SlabMesh, voltages: ArrayLike | None = None, far: Far = "natural"
) -> Charged:
    """Electrostatics of a slab in air.

    Parameters
    ----------
    mesh
        As `slab_mesh` or `move_air` give it.
    voltages
        (k,) of the electrodes (V); those of the slab's statement by default.
    far
        "natural" or "floating": what holds on the far boundary.

    Raises
    ------
    ProblemError
        If the voltages are not one an electrode, or the far boundary is neither.
    SolverError
        If the solution fails its residual check.
    """
    require_type("mesh", mesh, SlabMesh)
    count = len(mesh.conductors)
    need = f"give ({count},), one an electrode"
    given = finite(
        "voltages", mesh.slab.voltages if voltages is None else voltages, count, need=need
    )
    medium, values = _medium(mesh, far), np.zeros(len(mesh.body.points))
    for nodes, voltage in zip(mesh.conductors, given, strict=True):
        values[nodes] = voltage
    return Charged(mesh, given, medium.solve(values))


def _medium(mesh: SlabMesh, far: Far) -> Dielectric:
    require_one_of("far boundary", far, FAR)
    held = np.zeros(len(mesh.body.points), dtype=bool)
    held[np.concatenate(mesh.conductors)] = True
    floating = mesh.far if far == "floating" else no_nodes()
    return Dielectric(mesh.body, mesh.permittivity, held, floating)
