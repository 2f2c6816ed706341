"""Stretch: is any Poisson's ratio reached?

Question   E and nu of blocks with free sides under a pull, for materials from nu = -0.5 to 0.499 in
           the plane and from 0 to 0.49 in space.
Candidate  Springs that carry λ = μ, and κ = λ - μ of the volume of every cell.
Reference  The material that was asked for. Strains are slopes of the displacement, by least
           squares.
Expected   Cells that share springs are all alike, and so are their volumes: a uniform strain leaves
           no force on any point, at any size, and every ratio comes out to rounding.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numpy as np
import pandas as pd

from msvalidate.bodies.calibrate import calibrate
from msvalidate.bodies.lattice_network import lattice_network
from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Tolerance, by_quantity
from msvalidate.judging.sweep import Setting
from msvalidate.lattice import Lattice, fill, patterns, triangular
from msvalidate.problem import (
    Array,
    Box,
    Isotropic,
    Material,
    Polygon,
    Problem,
    ProblemError,
    Region,
    Segment,
    Support,
    Traction,
)
from msvalidate.problem.material import State

from .. import cases, loading

PLANE = (-0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499)
SOLID = (0.0, 0.25, 0.4, 0.49)
STRAIN = 1e-5
"""Of the pull; the answer is linear."""
EXACT = 1e-9
TOLERANCES = (
    Tolerance(
        "volume energy: nu of stretched blocks against nu asked for", EXACT, "1",
        "an identity; left is rounding, 1e-16 times a condition number of at most 1e6, where κ is "
        "500 times μ",
    ),
    Tolerance(
        "volume energy: E of stretched blocks, relative", EXACT, "1",
        "an identity too, with the same rounding as nu",
    ),
    Tolerance(
        "volume energy: displacement of stretched blocks, relative to the pull", EXACT, "1",
        "uniform strain is exact at every point, not on average alone: as of nu",
    ),
)  # fmt: skip
COLUMNS = {
    "lattice": cases.COLUMNS["lattice"],
    "state": "plane_stress or plane_strain in the plane, solid in space",
    "nu_asked": "Poisson's ratio of the material that was asked for (1)",
    "nu_axes": "the same along the lattice's own axes, in the plane: nu/(1 - nu) in plane "
    "strain (1)",
    "kappa_over_mu": "stiffness of a cell's volume over the shear modulus (1)",
    "nu_found": "Poisson's ratio of the material, from the block's strains (1)",
    "E_found": "modulus of the material from the block's strain, over that asked for (1)",
    "displacement_error": "largest displacement from that of the uniform strain, over the pull's "
    "end displacement (1)",
}


class Block(NamedTuple):
    """A block of one lattice and the material that it should be."""

    lattice: str
    state: State
    nu: float


def blocks() -> list[Block]:
    """Every block that is stretched."""
    flat: tuple[State, ...] = ("plane_stress", "plane_strain")
    plane = [
        Block(name, state, nu)
        for name in ("square", "triangular")
        for state in flat
        for nu in PLANE
    ]
    return plane + [Block(name, "solid", nu) for name in ("cubic18", "cubic26") for nu in SOLID]


def run(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Stretch blocks, and judge their constants."""
    rows = setting.sweep(partial(measure, candidate), blocks(), "stretched blocks")
    table = pd.DataFrame(rows)
    values = (
        farthest_value(table["nu_found"], table["nu_asked"]),
        farthest_value(table["E_found"], 1.0),
        farthest_value(table["displacement_error"], 0.0),
    )
    return Evidence(
        tables={"any_ratio": table},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        rounding=dict.fromkeys(("nu_found", "E_found", "displacement_error"), 1e-11),
        findings=findings(table),
    )


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """How far the ratios went, and how well they were met."""
    away = (table["nu_found"] - table["nu_asked"]).abs().max()
    told = ", ".join(
        f"{rows.min():g} to {rows.max():g} in {str(state).replace('_', ' ')}"
        for state, rows in table.groupby("state", sort=False)["nu_asked"]
    )
    return (
        (
            f"With the volume energy free blocks have the ratio asked for, {told}, to {away:.0e}: "
            f"along the axes up to {table['nu_axes'].max():.4g}, where κ is "
            f"{table['kappa_over_mu'].max():.4g} times μ."
        ),
    )


def body(name: str) -> Lattice:
    """A block of whole cells: a square, a rhombus of triangles, or a cube."""
    if name == "triangular":
        rise = np.array([0.5, np.sqrt(3) / 2])
        corners = [np.zeros(2), np.array([1.0, 0.0]), np.array([1.0, 0.0]) + rise, rise]
        return triangular(Polygon(tuple(tuple(corner.tolist()) for corner in corners)), 0.2)
    pattern = getattr(patterns, name)()
    cells = 5 if pattern.dim == 2 else 3
    return fill(pattern, Box((1.0,) * pattern.dim), cells)


def pull_loads(lattice: Lattice, material: Material) -> Problem:
    """Tractions along x of a pull; supports that take no force."""
    d = lattice.points.shape[1]
    stress = np.zeros((d, d))
    stress[0, 0] = STRAIN
    if isinstance(lattice.domain, Box):
        return loading.uniform(lattice.domain, material, (0, 0), STRAIN)
    if not isinstance(lattice.domain, Polygon):
        raise ProblemError(f"pulled block: a {lattice.domain}; give a Box or a Polygon")
    corners = lattice.domain.corners
    loads = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = end - start
        normal = np.array([along[1], -along[0]]) / np.linalg.norm(along)
        if abs(normal[0]) > loading.STRAIN:
            side = Segment(tuple(start.tolist()), tuple(end.tolist()))
            loads.append(Traction(side, tuple((stress @ normal).tolist())))
    first, second = (Region(tuple(corner.tolist())) for corner in corners[:2])
    held = (Support(first, (0.0, 0.0)), Support(second, (None, 0.0)))
    return Problem(lattice.domain, material, held, tuple(loads), name="pull")


def measure(candidate: DisplacementSolver, block: Block) -> dict[str, object]:
    """One row of the table."""
    lattice = body(block.lattice)
    d = lattice.points.shape[1]
    found = calibrate(1.0, block.nu, lattice, block.state)
    kappa = found.volume
    problem = pull_loads(lattice, Isotropic(1.0, block.nu, block.state))
    network = lattice_network(problem, lattice, found)
    move = candidate(problem, network, "linear")
    along, across = strains(lattice.points, move)
    nu, E = -across / along, STRAIN / along
    if block.state == "plane_strain":
        nu, E = nu / (1 + nu), E * (1 - (nu / (1 + nu)) ** 2)
    ratio = block.nu / (1 - block.nu) if block.state == "plane_strain" else block.nu
    modulus = 1 / (1 - block.nu**2) if block.state == "plane_strain" else 1.0
    exact = STRAIN / modulus * lattice.points * np.array([1.0] + [-ratio] * (d - 1))
    return {
        "lattice": lattice.name,
        "state": block.state,
        "nu_asked": block.nu,
        "nu_axes": ratio,
        "kappa_over_mu": kappa * 2 * (1 + block.nu),
        "nu_found": nu,
        "E_found": E,
        "displacement_error": float(np.abs(move - exact).max() / np.abs(exact).max()),
    }


def strains(points: Array, move: Array) -> tuple[float, float]:
    """Strain along x and along the last axis: slopes of the displacement, by least squares."""
    centred = points - points.mean(axis=0)
    slope, *_ = np.linalg.lstsq(centred, move - move.mean(axis=0), rcond=None)
    return float(slope[0, 0]), float(slope[-1, -1])
