"""Regular blocks of any cell, and the springs that join the corners of their cells."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property
from itertools import combinations

import numpy as np

from msvalidate.problem import Array, Box, Index, Mesh
from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.export import lumped_mass
from msvalidate.simulators.probe.block import Block
from msvalidate.springs.constants.stiffness import spring_tensor
from msvalidate.springs.lattice.filled import fill, side_share
from msvalidate.springs.lattice.patterns import cubic18, square

SPACING = 2.0**-4
"""Spacing (m): coordinates are exact in single precision."""
PARTS: Mapping[str, list[tuple[int, ...]]] = {
    "quad": [(0, 1, 2, 3)],
    "triangle": [(a, (a + 1) % 4, -1) for a in range(4)],
    "hexahedron": [tuple(range(8))],
    "tetra": [(0, a, b, 6) for a, b in ((1, 2), (2, 3), (3, 7), (7, 4), (4, 5), (5, 1))],
}
"""Cells in each square or cube, as corners in VTK's order; tetrahedra as [Kuhn1960].

Four triangles meet in the middle of a square, its last point: equal springs are then isotropic."""


@dataclass(frozen=True, eq=False)
class Regular:
    """A regular mesh, and all springs between the corners of its cells.

    Parameters
    ----------
    mesh, box
        Cells, and the box that they fill.
    springs, kind, share
        Ends (m, 2), number of axes that a spring runs along less one (m,), and the part (m,) of it
        inside the box: 1/2 on a side, 1/4 on an edge of a solid.
    """

    mesh: Mesh
    box: Box
    springs: Index
    kind: Index
    share: Array

    def stiffness(self, constants: Array, weight: float = 0.5) -> Array:
        """Stiffness (m,) in N/m of springs with constants by kind and a boundary weight."""
        return np.asarray(constants[self.kind] * self.share ** -np.log2(weight))

    def tensor(self, constants: Array, weight: float, thickness: float) -> Array:
        """Voigt tensor (Pa) that the springs have in a uniform strain of the whole block."""
        a, b = self.mesh.points[self.springs.T]
        k = self.stiffness(constants, weight)
        return spring_tensor(b - a, k, self.box.volume * thickness)


def regular_block(shape: str, counts: tuple[int, ...], spacing: float = SPACING) -> Regular:
    """Fill a box with whole squares or cubes, each cut into cells of a shape."""
    pattern = square() if len(counts) == 2 else cubic18()
    box = Box(tuple(spacing * n for n in counts))
    lattice = fill(pattern, box, counts)
    points, cells = lattice.points, lattice.cells
    if shape == "triangle":
        cells = np.column_stack([cells, len(points) + np.arange(len(cells))])
        points = np.concatenate([points, points[lattice.cells].mean(axis=1)])
    corners = np.array(PARTS[shape])
    cells = cells[:, corners].reshape(-1, corners.shape[1])
    pairs = np.array(list(combinations(range(cells.shape[1]), 2)))
    springs = np.unique(np.sort(cells[:, pairs].reshape(-1, 2), axis=1), axis=0)
    a, b = points[springs.T]
    kind = (np.abs(b - a) > spacing / 4).sum(axis=1) - 1
    share = side_share(points, springs, box)
    return Regular(Mesh(points, cells, shape), box, springs, kind, share)


class RegularBlock(Block):
    """A regular mesh about the origin, as the probe's block."""

    def __post_init__(self) -> None:
        """Accept cells of any shape."""

    @cached_property
    def volumes(self) -> Array:
        """Volumes (c,) of the cells in m³, thickness included."""
        count = len(self.mesh.cells)
        return np.full(count, self.mesh.volume * self.material.thickness / count)

    @cached_property
    def slopes(self) -> Array:
        """Gradients (c, k, d) in 1/m of the shape functions in cell centres."""
        local = self.mesh.kind.slopes(self.mesh.kind.middle[None])[0]
        edges = np.einsum("cka,kb->cab", self.mesh.points[self.mesh.cells], local)
        return np.asarray(local @ np.linalg.inv(edges))

    @cached_property
    def lumped(self) -> Array:
        """Masses (n,) in kg, each cell's shared by its corners."""
        return lumped_mass(self.mesh, self.material)

    @cached_property
    def height(self) -> float:
        """Spacing (m)."""
        return float(np.linalg.norm(np.diff(self.mesh.points[self.mesh.cells[0, :2]], axis=0)))
