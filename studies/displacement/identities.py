"""Identities: which networks are exactly a known discretisation, and what do they say of bending?

Question   Whether triangular springs are linear finite elements, how stiff a beam of square cells
           is in pure bending, and whether it stretches uniformly.
Candidate  Linear equilibrium of the spring network.
Reference  P1 finite elements on the lattice's own triangles; a closed form.
Expected   Equilateral triangles with springs of √3/4·E·t per triangle are P1 elements at nu = 1/3
           in plane stress: the same displacement to rounding, on each load. Square cells with
           halved edges, N through the height: EI_eff/EI = 1 + ((2 - nu)/(1 + nu))/N², and nu = 1/3.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import Lattice, square
from msvalidate.springs.network import tangent
from reference_fem.elasticity import stiffness

from . import load_cases
from .load_cases import CASES, MODULUS, THICKNESS
from .models import CAUCHY, MODELS

TRIANGULAR = next(model for model in MODELS if model.lattice == "triangular")
SQUARE = next(model for model in MODELS if model.lattice == "square" and model.is_target)
FINENESS = 5
HEIGHTS = (1, 2, 3, 4, 6, 8)
"""Cells through the height of the bent beam and the stretched square."""
LENGTH = 8
"""Heights: end effects decay as exp(-4.2·distance/height), to 1e-7 of themselves at the middle; the
consistent forces of a linear traction are the network's own pure bending and leave none."""
MOMENT = 100.0
"""N·m; the answer is linear."""
exact = partial(kit.Rule, limit=1e-9, unit="1")
RULES = (
    exact(
        "triangular springs are P1 elements: stiffness, relative", limit=1e-12, table="p1_identity",
        value="stiffness_difference",
        because="an identity; left is the rounding of sums of a few terms",
    ),
    exact(
        "triangular springs are P1 elements: displacement, relative", table="p1_identity",
        value="displacement_difference",
        because="the same identity through two linear solves, 1e-16 times a condition number of "
        "1e4 to 1e6",
    ),
    exact(
        "pure bending: EI_eff/EI against 1 + ((2 - nu)/(1 + nu))/N²", table="pure_bending",
        value="EI_ratio", reference="EI_formula",
        because="exact on a network, on a network: left is rounding, 1e-16 times a condition "
        "number of up to 1e5",
    ),
    exact(
        "uniform tension of square cells: displacement, relative", table="uniform_tension",
        value="tension_error",
        because="cells that share springs are all alike: uniform strain is exact; left is rounding",
    ),
)  # fmt: skip
TENSION = 1e-3
"""Strain of the stretched square; the answer is linear."""


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the candidate with P1 elements, and with the closed form."""
    compared = setting.sweep(partial(against_p1, candidate), CASES, "P1 elements")
    p1 = pd.DataFrame(
        {
            "case": case,
            "lattice": "triangular",
            "stiffness_difference": matrix,
            "displacement_difference": move,
        }
        for case, (matrix, move) in zip(CASES, compared, strict=True)
    )
    nu = CAUCHY.nu
    bending = pd.DataFrame(
        {
            "lattice": "square",
            "cells_high": n,
            "EI_ratio": bending_stiffness(candidate, n),
            "EI_formula": 1 + (2 - nu) / (1 + nu) / n**2,
        }
        for n in HEIGHTS
    )
    tension = pd.DataFrame(
        {
            "lattice": "square",
            "cells_high": n,
            "tension_error": uniform_tension(candidate, n),
        }
        for n in HEIGHTS
    )
    return kit.Evidence(
        tables={"p1_identity": p1, "pure_bending": bending, "uniform_tension": tension},
        tolerances=RULES,
        columns=kit.columns(__file__),
    )


def against_p1(candidate: kit.DisplacementSolver, case: str) -> tuple[float, float]:
    """Largest relative difference of stiffness and of displacement, springs against P1."""
    shape = load_cases.body("triangular", case, FINENESS)
    grid = shape.grid()
    problem = load_cases.problem(case, shape, CAUCHY)
    network = lattice_network(problem, grid, TRIANGULAR.constants)
    mesh = reference_fem.make_discretisation(grid.points, counter_clockwise(grid), "P1")
    K = stiffness(mesh, CAUCHY)
    component_major = np.arange(grid.points.size).reshape(-1, 2).T.ravel()
    springs_K = tangent(network, network.points)[component_major][:, component_major]
    matrix = abs(springs_K - K).max() / abs(K).max()
    reference = reference_fem.solve_problem(problem, mesh).displacement
    away = np.abs(candidate(problem, network, "linear") - reference).max()
    return float(matrix), float(away / np.abs(reference).max())


def counter_clockwise(grid: Lattice) -> kit.Array:
    """The lattice's triangles, turned where they run clockwise."""
    a, b, c = (grid.points[corner] for corner in grid.cells.T)
    turn = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    return np.where(turn[:, None] > 0, grid.cells, grid.cells[:, ::-1])


def bending_stiffness(candidate: kit.DisplacementSolver, cells: int) -> float:
    """EI_eff/EI of a beam 1 m high under end moments, from the curvature at its middle."""
    beam = kit.Box((float(LENGTH), 1.0))
    stress = 12 * MOMENT / THICKNESS

    def pull(points: kit.Array) -> kit.Array:
        return np.stack([stress * (points[:, 1] - 0.5), 0 * points[:, 1]], axis=1)

    def push(points: kit.Array) -> kit.Array:
        return -pull(points)

    problem = kit.Problem(
        beam,
        CAUCHY,
        (
            kit.Support(kit.Region((0.0, 0.0)), (0.0, 0.0)),
            kit.Support(kit.Region((float(LENGTH), 0.0)), (None, 0.0)),
        ),
        (kit.Traction(beam.side("right"), pull), kit.Traction(beam.side("left"), push)),
        name="pure bending",
    )
    grid = square(beam, (LENGTH * cells, cells))
    network = lattice_network(problem, grid, SQUARE.constants)
    move = candidate(problem, network, "linear")
    bottom = grid.points[:, 1] == 0
    deflection = move[bottom, 1][np.argsort(grid.points[bottom, 0], kind="stable")]
    middle = LENGTH * cells // 2
    left, centre, right = deflection[middle - 1 : middle + 2]
    curvature = (left - 2 * centre + right) * cells**2
    return float(MOMENT / abs(curvature) / (MODULUS * THICKNESS / 12))


def uniform_tension(candidate: kit.DisplacementSolver, cells: int) -> float:
    """Largest error of the displacement (x, -nu·y)·strain of a unit square pulled along x."""
    box = kit.Box((1.0, 1.0))
    left, right = box.side("left"), box.side("right")
    stress = TENSION * MODULUS
    problem = kit.Problem(
        box,
        CAUCHY,
        (kit.Support(left, (0.0, None)), kit.Support(kit.Region((0.0, 0.0)), (None, 0.0))),
        (kit.Traction(right, (stress, 0.0)),),
        name="uniform tension",
    )
    network = lattice_network(problem, square(box, cells), SQUARE.constants)
    exact = TENSION * network.points * (1.0, -CAUCHY.nu)
    move = candidate(problem, network, "linear")
    return float(np.abs(move - exact).max() / TENSION)
