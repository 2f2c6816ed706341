"""Material of each cell of a mesh: one material, or several by zones."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from msvalidate.problem import (
    SHAPES,
    Index,
    Isotropic,
    Mask,
    Material,
    Problem,
    ProblemError,
    materials_of_cells,
)
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import ReadOnly, dataclass
from reference_fem.mesh.discretisation import Discretisation


@dataclass(frozen=True, eq=False)
class CellMaterials(ReadOnly):
    """Several materials of one dimension, state and thickness, and which each cell is of.

    Parameters
    ----------
    materials
        Two or more, each of some cells.
    number
        (c,) index into them of each cell.
    """

    materials: tuple[Material, ...]
    number: Index

    @property
    def dim(self) -> int:
        """Number of axes, 2 or 3."""
        return self.materials[0].dim

    @property
    def thickness(self) -> float:
        """Out-of-plane thickness (m) of a plane body; 1 of a solid."""
        return self.materials[0].thickness


Materials = Material | CellMaterials
"""Materials of the cells of a body."""


def materials_of(problem: Problem, body: Discretisation) -> Materials:
    """Materials of the cells of a problem's mesh.

    Raises
    ------
    ProblemError
        If a zone holds no cell, or ends inside one.
    """
    if not problem.zones:
        return problem.material
    shape = SHAPES[body.element.shape]
    number = materials_of_cells(problem, body.points[body.cells], shape)
    used, own = np.unique(number, return_inverse=True)
    materials = tuple(problem.materials[i] for i in used)
    return CellMaterials(materials, own.ravel()) if len(used) > 1 else materials[0]


def by_material(law: Materials, body: Discretisation) -> Iterator[tuple[Material, Mask | None]]:
    """Each material, and the cells (c,) that are of it: None for all.

    Raises
    ------
    ProblemError
        If there is not one material a cell, or it is of another dimension than the body.
    """
    require_type("body", body, Discretisation)
    require_type("material", law, Materials)
    if law.dim != body.dim:
        raise ProblemError(f"material: {law.dim}D, the body {body.dim}D")
    if not isinstance(law, CellMaterials):
        yield law, None
        return
    if law.number.shape != (len(body.cells),):
        raise ProblemError(
            f"materials: of {law.number.shape} cells; the mesh has {len(body.cells)}"
        )
    for i, material in enumerate(law.materials):
        yield material, law.number == i


def lame_constants(material: Isotropic) -> tuple[float, float]:
    """Lamé's μ and λ in Pa; λ infinite at nu = 1/2, in plane stress 2λμ/(λ + 2μ) in its place.

    Source: Hooke's law, [TimoshenkoGoodier1970], article 6.
    """
    E, nu = material.E, material.nu
    mu = E / (2 * (1 + nu))
    if material.state == "plane_stress":
        return mu, E * nu / (1 - nu**2)
    return mu, E * nu / ((1 + nu) * (1 - 2 * nu)) if nu < 0.5 else math.inf


def numbers_of(law: Materials) -> Index | None:
    """Index (c,) of each cell's material, where there are several."""
    return law.number if isinstance(law, CellMaterials) else None


def each_material(law: Materials) -> tuple[Material, ...]:
    """The materials, of which there may be one."""
    return law.materials if isinstance(law, CellMaterials) else (law,)
