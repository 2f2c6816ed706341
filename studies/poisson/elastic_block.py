"""The reference of the finite-size question: the elastic block, sampled like the networks."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache, partial

import numpy as np
from scipy.sparse import csr_matrix

import reference_fem
from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.constants.stiffness import square_tensor

from . import block
from .block import BOX, DEFINITIONS

REFERENCE_ERROR = 1e-4
"""Asked of the reference's own estimate; its true error is a fifth of that where checked."""
COARSEST_MESH = {"slide": 2, "traction": 2, "clamped": 14}
"""Cells per side to start from; uniform strain is exact on any mesh."""


def reference(
    bodies: tuple[float, ...], cells: tuple[int, ...], loading: str
) -> tuple[dict[tuple[object, ...], float], list[dict[str, object]]]:
    """Ratios of the elastic bodies at every size's points, and how good they are."""
    sizes = [n for n in cells if not (loading == "clamped" and n == 1)]
    grids = [block.edge_points(lattice.square(BOX, n).points) for n in sizes]
    ends = np.cumsum([len(grid) for grid in grids])[:-1]
    sample = cache(partial(Sampler.of, loading, np.concatenate(grids)))
    values: dict[tuple[object, ...], float] = {}
    quality: list[dict[str, object]] = []
    keys = [(n, definition) for n in sizes for definition in DEFINITIONS]
    for body in bodies:
        tensor = square_tensor(1 - body, body)

        def sampled(mesh: int, tensor: kit.Array = tensor) -> kit.Array:
            move = sample(mesh).displacement(tensor)
            parts = list(zip(grids, np.split(move, ends), strict=True))
            ratios = [block.ratio(x, u, definition) for x, u in parts for definition in DEFINITIONS]
            return np.array([*ratios, block.axial_strain(*parts[0])])

        estimate = reference_fem.refine(sampled, COARSEST_MESH[loading], REFERENCE_ERROR)
        *ratios, strain = estimate.value
        values |= {(loading, body, *key): float(nu) for key, nu in zip(keys, ratios, strict=True)}
        if loading == "traction":
            problem = block.loaded_block(loading, tensor)
            values["modulus", body] = block.end_traction(problem) / strain
        quality.append(
            {
                "loading": loading,
                "C12_over_C11": body,
                "mesh": estimate.cells,
                "uncertainty": float(estimate.uncertainty.max()),
                "trust": ", ".join(sorted(set(estimate.status[:-1]))),
            }
        )
    return values, quality


@dataclass(frozen=True, eq=False)
class Sampler:
    """Displacements at given points of the block, on one mesh, for any tensor.

    The clamped block is symmetric about both its middle lines, so a quarter of it is solved, on the
    same mesh as a quarter of the whole would have, and folded out: a fifth of the cost.

    Parameters
    ----------
    loading, mesh
        The block's loading, and the mesh of the block or its quarter.
    interpolation
        (p, n) from nodal values to the points, folded into the quarter if it is one.
    side
        (p, 2) of 1 and -1: on which side of the middle lines each point lies; 1 for a whole block.
    """

    loading: str
    mesh: reference_fem.Discretisation
    interpolation: csr_matrix
    side: kit.Array

    @classmethod
    def of(cls, loading: str, points: kit.Array, cells: int) -> Sampler:
        """Sampler on a mesh with `cells` per side of the whole block."""
        if loading != "clamped":
            mesh = reference_fem.box_discretisation(BOX, cells, "Q2", block.GRADING)
            return cls(loading, mesh, mesh.interpolation(points), np.ones_like(points))
        away = points - block.SIDE / 2
        mesh = reference_fem.box_discretisation(
            block.QUARTER, cells // 2, "Q2", block.GRADING, "high"
        )
        side = np.where(away < 0, -1.0, 1.0)
        return cls(loading, mesh, mesh.interpolation(np.abs(away)), side)

    def displacement(self, tensor: kit.Array) -> kit.Array:
        """Displacement (p, 2) in m at the points; of a quarter, relative to the block's middle."""
        make = block.clamped_quarter if self.loading == "clamped" else self._whole
        move = reference_fem.solve_problem(make(tensor), self.mesh).displacement
        return np.asarray(self.side * (self.interpolation @ move))

    def _whole(self, tensor: kit.Array) -> kit.Problem:
        return block.loaded_block(self.loading, tensor)
