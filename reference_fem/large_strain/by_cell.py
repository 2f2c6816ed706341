"""A law at large strain for each material of a mesh."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from msvalidate.problem import Array, Index, Material, Problem, ProblemError
from msvalidate.problem.records import dataclass
from reference_fem.large_strain.hyperelastic import Law, neo_hookean
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


def stress_by_gradient(law: Law, H: Array) -> Array:
    """P (q, d, d) in Pa of displacement gradients (q, d, d), as exactly as the law can."""
    exact = getattr(law, "stress_by_gradient", None)
    if exact is not None:
        return np.asarray(exact(H))
    return np.asarray(law.stress(np.eye(law.dim) + H))


def each_law(law: Law) -> tuple[Law, ...]:
    """The laws that there are in a body, of which there may be one."""
    return law.laws if isinstance(law, CellLaws) else (law,)


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
