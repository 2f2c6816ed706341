"""The block that probes deform: irregular tetrahedra whose coordinates every precision holds."""

from __future__ import annotations

from functools import cached_property, lru_cache
from itertools import permutations
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from msvalidate.problem import Array, Index, Isotropic, Mask, Mesh, ProblemError
from msvalidate.problem.checks import require_type
from msvalidate.problem.records import dataclass
from msvalidate.simulators.exchange.protocol import Request, Task
from msvalidate.springs.constants.stiffness import lame

SIZE = (0.25, 0.125, 0.125)
"""Sides (m)."""
CELLS = (4, 3, 3)
"""Numbers of cells of the irregular grid.

It has 80 nodes, 12 of them inside.
"""
JITTER = 0.25
"""Largest move of a node, in sides of a grid cell: less than where cells turn inside out."""
STEP = 2.0**-12
"""Coordinates (m) are whole multiples of it. Strained by 2⁻⁸ they are of 2⁻²¹ m, and none is beyond
2⁻³ m: 18 bits, and a float32 has 24."""
SEED = 20240


def wave_speed(material: Isotropic) -> float:
    """m/s of pressure waves in a solid; of ratio .49 where its own is nearer to 1/2."""
    lam, mu = lame(3, material.E, min(material.nu, 0.49))
    return float(np.sqrt((lam + 2 * mu) / material.density))


@lru_cache(maxsize=1)
def probe_mesh() -> Mesh:
    """A block about the origin, cut into tetrahedra of many sizes and shapes.

    A grid whose nodes are moved at random, those of the surface along it; each of its cells is cut
    into the six tetrahedra that share a diagonal [Kuhn1960]. Regular meshes would hide wrong
    masses and springs: each node's faults there equal its neighbour's.
    """
    counts = np.array(CELLS) + 1
    grid = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    spacing = np.array(SIZE) / CELLS
    inner = (grid > 0) & (grid < CELLS)
    moved = np.random.default_rng(SEED).uniform(-JITTER, JITTER, grid.shape) * inner
    points = (grid + moved) * spacing - np.array(SIZE) / 2
    return Mesh(np.round(points / STEP) * STEP, _kuhn_cells(counts), "tetra")


def _kuhn_cells(counts: Index) -> Index:
    """Nodes (6 c, 4) of the tetrahedra of a grid of these many nodes along each axis."""
    strides = np.array([counts[1] * counts[2], counts[2], 1])
    firsts = np.stack(np.meshgrid(*map(np.arange, counts - 1), indexing="ij"), axis=-1)
    corner = firsts.reshape(-1, 3) @ strides
    cells = []
    for axes in permutations(range(3)):
        path = np.concatenate([[0], np.cumsum(strides[list(axes)])])
        if np.linalg.det(np.eye(3)[list(axes)]) < 0:
            path = path[[0, 2, 1, 3]]  # an odd order would be inside out
        cells.append(corner[:, None] + path)
    return np.concatenate(cells)


@dataclass(frozen=True, eq=False)
class Block:
    """A mesh of tetrahedra, what it is asked to be made of, and what follows from the two alone.

    Raises
    ------
    ProblemError
        If it is not of tetrahedra, or the material not an isotropic solid.
    """

    mesh: Mesh
    material: Isotropic

    def __post_init__(self) -> None:
        require_type("probe: material", self.material, Isotropic)
        if self.mesh.shape != "tetra":
            raise ProblemError(f"probe: cells {self.mesh.shape}; give a mesh of tetra")
        if self.material.state != "solid":
            raise ProblemError(f"probe: a material in {self.material.state}; give state solid")

    def request(self, task: Task, **options: Any) -> Request:
        """A request without weight, forces and supports except those in the options."""
        none = np.zeros(self.mesh.points.shape)
        own: dict[str, Any] = {"mass": self.lumped, "gravity": none[0], "force": none}
        own |= {"held": none.astype(bool), "value": none, "name": "probe"}
        return Request(task, self.mesh, self.material, **own | options)

    @cached_property
    def _edges(self) -> Array:
        """(c, 3, 3) m from a cell's first corner to the others, in rows."""
        corners = self.mesh.points[self.mesh.cells]
        return np.asarray(corners[:, 1:] - corners[:, :1])

    @cached_property
    def volumes(self) -> Array:
        """(c,) of the cells, m³."""
        return np.asarray(np.linalg.det(self._edges) / 6)

    @cached_property
    def slopes(self) -> Array:
        """(c, 4, 3) gradients (1/m) of the functions that are 1 on one node of a cell."""
        rest = np.swapaxes(np.linalg.inv(self._edges), 1, 2)
        return np.concatenate([-rest.sum(axis=1, keepdims=True), rest], axis=1)

    @property
    def volume(self) -> float:
        """m³."""
        return float(self.volumes.sum())

    @cached_property
    def weights(self) -> Array:
        """(n, 3) 1/m: the mean over the volume of grad u is Σ uᵢ ⊗ wᵢ, in linear cells exactly."""
        weights = np.zeros(self.mesh.points.shape)
        np.add.at(weights, self.mesh.cells, self.volumes[:, None, None] * self.slopes)
        return weights / self.volume

    @cached_property
    def lumped(self) -> Array:
        """(n,) kg: a quarter of the mass of each of its cells on each node."""
        masses = np.zeros(len(self.mesh.points))
        np.add.at(masses, self.mesh.cells, self.material.density * self.volumes[:, None] / 4)
        return masses

    @cached_property
    def consistent(self) -> csr_array:
        """(n, n) kg: ∫ ρ Nᵢ Nⱼ: ρ V/20 between two nodes of a cell, twice that on one."""
        return self._assembled(20, np.ones((4, 4)) + np.eye(4))

    @cached_property
    def one_point(self) -> csr_array:
        """(n, n) kg: the same integrated at the middle of each cell, where all N are 1/4."""
        return self._assembled(16, np.ones((4, 4)))

    def _assembled(self, parts: int, between: Array) -> csr_array:
        """Each cell's mass over `parts`, times a number between each two of its nodes."""
        local = (self.material.density * self.volumes / parts)[:, None, None] * between
        rows = np.repeat(self.mesh.cells, 4, axis=1).ravel()
        columns = np.tile(self.mesh.cells, (1, 4)).ravel()
        n = len(self.mesh.points)
        return csr_array((local.ravel(), (rows, columns)), shape=(n, n))

    @cached_property
    def inner(self) -> Mask:
        """(n,) nodes that no facet of the surface has."""
        inside = np.ones(len(self.mesh.points), dtype=bool)
        inside[self.mesh.surface] = False
        return inside

    @cached_property
    def height(self) -> float:
        """Smallest height (m) of a cell over one of its facets."""
        return float(1 / np.linalg.norm(self.slopes, axis=2).max())
