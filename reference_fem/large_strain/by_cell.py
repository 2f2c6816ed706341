"""Laws at large strain of materials, and of each material of a mesh."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import Array, Index, Isotropic, Material, Problem, ProblemError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass, replace
from reference_fem.elasticity import elastic_tensor, full_tensor
from reference_fem.large_strain.hyperelastic import (
    Law,
    NeoHookean,
    StVenantKirchhoff,
    stress_by_gradient,
)
from reference_fem.large_strain.plane_stress import PlaneStress
from reference_fem.materials import CellMaterials, materials_of
from reference_fem.mesh.discretisation import Discretisation


@dataclass(frozen=True, eq=False)
class CellLaws:
    """Several laws of one dimension: a law whose gradients F are those of all cells in turn.

    Parameters
    ----------
    laws
        Two or more.
    number
        (c,) index into them of each cell; its functions take as many F a cell, (c·q, d, d).
    """

    laws: tuple[Law, ...]
    number: Index

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return self.laws[0].dim

    def energy(self, F: Array) -> Array:
        """W (c·q,) in J/m³."""
        return self._of_cells(F, lambda law, part: law.energy(part))

    def stress(self, F: Array) -> Array:
        """P (c·q, d, d) in Pa."""
        return self._of_cells(F, lambda law, part: law.stress(part))

    def stress_by_gradient(self, H: Array) -> Array:
        """P (c·q, d, d) in Pa of displacement gradients, as exactly as each law can."""
        return self._of_cells(H, stress_by_gradient)

    def tangent(self, F: Array) -> Array:
        """A (c·q, d, d, d, d) in Pa."""
        return self._of_cells(F, lambda law, part: law.tangent(part))

    def _of_cells(self, F: Array, function: Callable[[Law, Array], Array]) -> Array:
        """Each law's function of the gradients of its cells, in the order of F."""
        each, left = divmod(len(F), len(self.number))
        if left:
            raise ProblemError(
                f"laws by cell: {len(F)} gradients for {len(self.number)} cells; give as many each"
            )
        number = np.repeat(self.number, each)
        parts = [(number == i, function(law, F[number == i])) for i, law in enumerate(self.laws)]
        found = np.empty((len(F), *parts[0][1].shape[1:]))
        for at, values in parts:
            found[at] = values
        return found


def each_law(law: Law) -> tuple[Law, ...]:
    """The laws that there are in a body, of which there may be one."""
    return law.laws if isinstance(law, CellLaws) else (law,)


def neo_hookean(material: Material) -> Law:
    """The neo-Hookean law of an isotropic material.

    Raises
    ------
    ProblemError
        If it is not isotropic, or incompressible.
    """
    require_type("material", material, Isotropic)
    assert isinstance(material, Isotropic)  # noqa: S101  for the types
    if material.state == "plane_stress":
        solid = replace(material, state="solid", thickness=1.0)
        return PlaneStress(neo_hookean(solid))
    C = elastic_tensor(material)
    return NeoHookean(float(C[-1, -1]), float(C[0, 1]), material.dim)


def st_venant_kirchhoff(material: Material) -> StVenantKirchhoff:
    """The St Venant-Kirchhoff law with a material's stiffness, in its plane state or in space.

    Raises
    ------
    ProblemError
        If the material is incompressible and not in plane stress.
    """
    return StVenantKirchhoff(full_tensor(elastic_tensor(material)))


def laws_of(
    problem: Problem, body: Discretisation, law: Callable[[Material], Law] = neo_hookean
) -> Law:
    """The law at large strain of a problem's material, or of each zone's.

    Parameters
    ----------
    problem, body
        What is asked, and the mesh.
    law
        Material -> law.

    Raises
    ------
    ProblemError
        If the law is not for a material, or a zone ends inside a cell.
    """
    material = materials_of(problem, body)
    if isinstance(material, CellMaterials):
        return CellLaws(tuple(law(one) for one in material.materials), material.number)
    return law(material)
