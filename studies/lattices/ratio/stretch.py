"""Stretch: is any Poisson's ratio reached?

Question   E and nu of blocks with free sides under a pull, for materials from nu = -0.5 to 0.499 in
           the plane and from 0 to 0.49 in space.
Candidate  Springs that carry λ = μ, and κ = λ - μ of the volume of every cell.
Reference  The material that was asked for. Strains are slopes of the displacement, by least
           squares.
Expected   Cells that share springs are all alike, and so are their volumes: a uniform strain leaves
           no force on the points, at each size, and each ratio comes out to rounding.
"""

from __future__ import annotations

from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np
import pandas as pd

from msvalidate import kit
from msvalidate.problem.material import State
from msvalidate.springs.bodies.calibrate import calibrate
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import Lattice, fill, patterns, triangular

from .. import loading

PLANE = (-0.5, 0.0, 0.2, 1 / 3, 0.45, 0.499)
SOLID = (0.0, 0.25, 0.4, 0.49)
STRAIN = 1e-5
"""Of the pull; the answer is linear."""
EXACT = 1e-9
identity = partial(kit.Rule, limit=EXACT, unit="1", table="any_ratio")
RULES = (
    identity(
        "volume energy: nu of stretched blocks against nu asked for",
        value="nu_found", reference="nu_asked",
        because="an identity; left is rounding, 1e-16 times a condition number of at most 1e6, "
        "where κ is 500 times μ",
    ),
    identity(
        "volume energy: E of stretched blocks, relative", value="E_found", reference=1.0,
        because="an identity too, with the same rounding as nu",
    ),
    identity(
        "volume energy: displacement of stretched blocks, relative to the pull",
        value="displacement_error",
        because="uniform strain is exact at every point, not on average alone: as of nu",
    ),
)  # fmt: skip


class Block(NamedTuple):
    """A block of one lattice and the material that it should be."""

    lattice: str
    state: State
    nu: float


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Stretch blocks, and judge their constants."""
    flat: tuple[State, ...] = ("plane_stress", "plane_strain")
    blocks = [Block(*kind) for kind in product(("square", "triangular"), flat, PLANE)]
    blocks += [Block(name, "solid", nu) for name, nu in product(("cubic18", "cubic26"), SOLID)]
    table = pd.DataFrame(setting.sweep(partial(measure, candidate), blocks, "stretched blocks"))
    away = (table["nu_found"] - table["nu_asked"]).abs().max()
    ranges = ", ".join(
        f"{rows.min():g} to {rows.max():g} in {str(state).replace('_', ' ')}"
        for state, rows in table.groupby("state", sort=False)["nu_asked"]
    )
    finding = (
        f"With the volume energy free blocks have the ratio asked for, {ranges}, to {away:.0e}: "
        f"along the axes up to {table['nu_axes'].max():.4g}, where κ is "
        f"{table['kappa_over_mu'].max():.4g} times μ."
    )
    return kit.Evidence(
        {"any_ratio": table}, tolerances=RULES, columns=kit.columns(__file__), findings=(finding,)
    )


def body(name: str) -> Lattice:
    """A block of whole cells: a square, a rhombus of triangles, or a cube."""
    if name == "triangular":
        rise = np.sqrt(3) / 2
        return triangular(kit.Polygon(((0.0, 0.0), (1.0, 0.0), (1.5, rise), (0.5, rise))), 0.2)
    pattern = getattr(patterns, name)()
    return fill(pattern, kit.Box((1.0,) * pattern.dim), 5 if pattern.dim == 2 else 3)


def pull_loads(lattice: Lattice, material: kit.Material) -> kit.Problem:
    """Tractions along x of a pull; supports that take no force."""
    if isinstance(lattice.domain, kit.Box):
        return loading.uniform(lattice.domain, material, (0, 0), STRAIN)
    if not isinstance(lattice.domain, kit.Polygon):
        raise kit.ProblemError(f"pulled block: a {lattice.domain}; give a Box or a Polygon")
    corners = lattice.domain.corners
    loads = []
    for start, end in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        x, y = end - start
        pull = STRAIN * y / np.hypot(x, y)  # along x: of the normal the part along the pull
        if abs(pull) > STRAIN**2:
            side = kit.Segment(tuple(start.tolist()), tuple(end.tolist()))
            loads.append(kit.Traction(side, (pull, 0.0)))
    first, second = (kit.Region(tuple(corner.tolist())) for corner in corners[:2])
    held = (kit.Support(first, (0.0, 0.0)), kit.Support(second, (None, 0.0)))
    return kit.Problem(lattice.domain, material, held, tuple(loads), name="pull")


def measure(candidate: kit.DisplacementSolver, block: Block) -> dict[str, object]:
    """One row of the table."""
    lattice = body(block.lattice)
    found = calibrate(1.0, block.nu, lattice, block.state)
    problem = pull_loads(lattice, kit.Isotropic(1.0, block.nu, block.state))
    move = candidate(problem, lattice_network(problem, lattice, found), "linear")
    centred = lattice.points - lattice.points.mean(axis=0)
    slope, *_ = np.linalg.lstsq(centred, move - move.mean(axis=0), rcond=None)
    nu, E = -slope[-1, -1] / slope[0, 0], STRAIN / slope[0, 0]
    ratio, modulus = block.nu, 1.0
    if block.state == "plane_strain":
        nu, E = nu / (1 + nu), E * (1 - (nu / (1 + nu)) ** 2)
        ratio, modulus = block.nu / (1 - block.nu), 1 / (1 - block.nu**2)
    strains = np.array([1.0] + [-ratio] * (lattice.points.shape[1] - 1))
    exact = STRAIN / modulus * lattice.points * strains
    return {
        "lattice": lattice.name,
        "state": block.state,
        "nu_asked": block.nu,
        "nu_axes": ratio,
        "kappa_over_mu": found.volume * 2 * (1 + block.nu),
        "nu_found": nu,
        "E_found": E,
        "displacement_error": float(np.abs(move - exact).max() / np.abs(exact).max()),
    }
