"""Orthotropic: are the three shears of a solid told apart?

Question   Tensor of a lattice of cubes whose springs differ along the three axes and in the three
           planes, and the shear strains of a body of it under τyz, τxz and τxy in turn.
Candidate  The homogenised solid, and static equilibrium of a block of springs.
Reference  On paper, with k_x along x and k_yz along both diagonals of a face across x, and so on:
           C11 = (k_x + k_xy + k_xz)/a, C12 = C66 = k_xy/a, C13 = C55 = k_xz/a, C23 = C44 = k_yz/a
           at a spacing a, in the order xx, yy, zz, yz, xz, xy. Elements with that tensor.
Expected   Equal: every point is a centre of symmetry, and uniform stress is exact in whole cells.
           In cubic and isotropic solids the last three entries are one number, and no row of such
           notices that two of them have changed places.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.lattice import Pattern, fill, patterns

from . import loading
from .cases import Solid

ALONG = (1.3, 0.7, 2.1)
"""Spring constants (N/m) along x, y and z."""
ACROSS = {(1, 2): 0.45, (0, 2): 0.9, (0, 1): 1.6}
"""Axes of a face -> spring constant (N/m) along both of its diagonals, no two alike."""
BOX, CELLS, SPACING = kit.Box((0.6, 0.4, 0.8)), (3, 2, 4), 0.2
STRESS = 1e-4
"""Pa, of a solid with moduli near 10 Pa."""


def run(candidate: kit.DisplacementSolver, solid: Solid, setting: kit.Setting) -> kit.Evidence:
    """Homogenise the lattice, and shear a body of it in three ways."""
    pattern, C = lattice(), on_paper()
    found = solid(pattern, pattern.rules["axes"], SPACING).tensor
    rows = [sheared(candidate, pattern, C, found, i, pair) for i, pair in enumerate(ACROSS)]
    table = pd.DataFrame(rows)
    ratios = [table[f"strain_{who}"] / table["strain_on_paper"] for who in ("springs", "fem")]
    own = (
        kit.Tolerance(
            "orthotropic cubes: tensor against that on paper, relative", 1e-10, "1",
            "a sum of a few terms, and points that do not move: rounding",
            observed=kit.Observed(float(np.abs(found - C).max() / np.abs(C).max())),
        ),
        kit.Tolerance(
            "orthotropic cubes: shear of springs and of elements over that on paper, from 1",
            1e-9, "1",
            "uniform stress is exact in both: left is rounding, 1e-16 times a condition number of "
            "up to 1e5",
            observed=kit.farthest_value(pd.concat(ratios), 1.0),
        ),
    )  # fmt: skip
    return kit.Evidence(
        tables={"orthotropic": table},
        tolerances=own,
        columns=kit.columns(__file__),
    )


def lattice() -> Pattern:
    """Cubic lattice with eighteen neighbours whose springs differ by the axes that they run along.

    The spring constants are in `factor`, beside constants of 1 for both kinds.
    """
    cubic = patterns.cubic18()
    axes = [np.flatnonzero(np.abs(v) > 0.5).tolist() for v in cubic.vectors]
    factor = np.array([ALONG[a[0]] if len(a) == 1 else ACROSS[a[0], a[1]] for a in axes])
    return replace(
        cubic, name="orthotropic cubes", factor=factor, rules={"axes": (1.0, 1.0)}, tensor=None
    )


def on_paper() -> kit.Array:
    """Voigt tensor (6, 6) in Pa, in the order xx, yy, zz, yz, xz, xy."""
    C = np.diag([*ALONG, *ACROSS.values()])
    for (a, b), k in ACROSS.items():
        C[a, a] += k
        C[b, b] += k
        C[a, b] = C[b, a] = k
    return np.asarray(C / SPACING)


def sheared(
    candidate: kit.DisplacementSolver,
    pattern: Pattern,
    C: kit.Array,
    found: kit.Array,
    i: int,
    pair: tuple[int, int],
) -> dict[str, object]:
    """Row of one shear."""
    problem = loading.uniform(BOX, kit.Anisotropic(C), pair, STRESS)
    network = lattice_network(problem, fill(pattern, BOX, CELLS), pattern.rules["axes"])
    mesh = reference_fem.box_discretisation(BOX, CELLS, "H1")
    elastic = reference_fem.solve_problem(problem, mesh).displacement
    return {
        "stress": "xyz"[pair[0]] + "xyz"[pair[1]],
        "entry_on_paper": C[3 + i, 3 + i],
        "entry": found[3 + i, 3 + i],
        "strain_on_paper": STRESS / C[3 + i, 3 + i],
        "strain_springs": shear(network.points, candidate(problem, network, "linear"), pair),
        "strain_fem": shear(mesh.points, elastic, pair),
    }


def shear(points: kit.Array, displacement: kit.Array, pair: tuple[int, int]) -> float:
    """Engineering shear strain of the linear field next to displacements (n, 3) in m."""
    level = np.column_stack([points, np.ones(len(points))])
    slope = np.linalg.lstsq(level, displacement, rcond=None)[0]
    return float(slope[pair[0], pair[1]] + slope[pair[1], pair[0]])
