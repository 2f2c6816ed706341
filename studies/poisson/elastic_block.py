"""The reference of the finite-size question: the elastic block, sampled like the networks."""

from __future__ import annotations

from math import pi, sin

import numpy as np
from scipy.optimize import brentq
from scipy.sparse import csr_matrix

import reference_fem
from msvalidate import lattice
from msvalidate.problem import Array, Problem
from msvalidate.stiffness import square_tensor
from studies.poisson import block
from studies.poisson.block import BOX, DEFINITIONS

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
    meshes: dict[int, tuple[reference_fem.Discretisation, csr_matrix]] = {}
    values: dict[tuple[object, ...], float] = {}
    quality: list[dict[str, object]] = []
    keys = [(n, definition) for n in sizes for definition in DEFINITIONS]
    for body in bodies:
        problem = block.loaded_block(loading, square_tensor(1 - body, body))

        def sampled(mesh_cells: int, problem: Problem = problem) -> Array:
            if mesh_cells not in meshes:
                mesh = reference_fem.box_discretisation(BOX, mesh_cells, "Q2", block.GRADING)
                meshes[mesh_cells] = mesh, mesh.interpolation(np.concatenate(grids))
            mesh, interpolation = meshes[mesh_cells]
            move = interpolation @ reference_fem.solve_problem(problem, mesh).displacement
            parts = list(zip(grids, np.split(move, ends), strict=True))
            ratios = [block.ratio(x, u, definition) for x, u in parts for definition in DEFINITIONS]
            return np.array([*ratios, block.axial_strain(*parts[0])])

        estimate = reference_fem.refine(sampled, COARSEST_MESH[loading], REFERENCE_ERROR)
        *ratios, strain = estimate.value
        values |= {(loading, body, *key): float(nu) for key, nu in zip(keys, ratios, strict=True)}
        if loading == "traction":
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


def corner_exponent(nu: float) -> float:
    """Exponent of the displacement at a right-angled corner between a clamped and a free edge.

    sin²(λπ/2) = ((κ + 1)² - 4λ²)/(4κ) with κ = (3 - nu)/(1 + nu) in plane stress (Williams 1952,
    doi:10.1115/1.4010553).
    """
    kappa = (3 - nu) / (1 + nu)

    def characteristic(x: float) -> float:
        return sin(x * pi / 2) ** 2 - ((kappa + 1) ** 2 - 4 * x**2) / (4 * kappa)

    return float(brentq(characteristic, 0.5, 1.0))
