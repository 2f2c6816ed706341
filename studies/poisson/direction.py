"""Direction: how does the lattice's ratio depend on the direction of the pull?

Question   Poisson's ratio every 5 degrees for the four constants.
Candidate  The homogenised tensor of the lattice, contracted with the direction.
Reference  Finite elements on the turned tensor: a block under uniform traction on statically
           determinate supports.
Expected   Equal, since the strain is uniform; k2/(k1 + k2) along the axes; the same in each
           direction at k2 = k1/2 only; k1/(k1 + 4 k2) along the diagonals.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.constants.directions import directional_ratio, rotate_tensor
from msvalidate.springs.constants.homogenise import interior_tensor

from . import block
from .block import BOX, K1, RATIOS

ANGLES = tuple(range(0, 91, 5))
QUICK_ANGLES = (0, 15, 30, 45, 60, 75, 90)
MESH = 2
"""Cells per side: a uniform strain is exact on any mesh."""
exact = partial(kit.Rule, limit=1e-9, unit="1", table="direction", value="nu_tensor")
RULES = (
    exact("tensor against FEM on the turned tensor", reference="nu_fem",
          because="uniform strain: rounding of a small linear solve is all that is left"),
    exact("along the axes: k2/(k1+k2)", rows={"angle_deg": (0, 90)},
          reference=lambda rows: rows["k2"] / (K1 + rows["k2"]),
          because="C12/C11 of the affine sum over springs"),
    exact("spread over directions at k2 = k1/2", rows={"k2": K1 / 2},
          value=lambda rows: np.ptp(rows["nu_tensor"]), because="isotropic: 2 C66 = C11 - C12"),
    exact("along the diagonal: k1/(k1+4k2)", rows={"angle_deg": 45},
          reference=lambda rows: K1 / (K1 + 4 * rows["k2"]),
          because="closed form: the compliance of C11 = k1 + k2, C12 = C66 = k2, turned by 45 "
          "degrees"),
)  # fmt: skip


def square_lattice(k2: float) -> kit.Array:
    """The candidate: tensor (3, 3) in N/m of the square lattice with k1 = 1 N/m."""
    return interior_tensor(lattice.square(BOX, 1), (K1, k2), "shared")


def run(
    tensor: Callable[[float], kit.Array] = square_lattice, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare the tensor's ratio with finite elements in every direction."""
    cases = list(product(RATIOS, QUICK_ANGLES if setting.quick else ANGLES))
    mesh = reference_fem.box_discretisation(BOX, MESH, "Q1")
    ratios = setting.sweep(partial(ratio_two_ways, tensor, mesh), cases, "directions")
    table = pd.DataFrame(
        {
            "lattice": "square",
            "k1": K1,
            "k2": k2,
            "angle_deg": angle,
            "nu_tensor": nu_tensor,
            "nu_fem": nu_fem,
        }
        for (k2, angle), (nu_tensor, nu_fem) in zip(cases, ratios, strict=True)
    )
    seen = table[table["k2"] == 2 * K1].set_index("angle_deg")["nu_tensor"]
    finding = (
        f"With the report's k2 = 2k1 the ratio is {seen[0]:.4f} along the axial springs and "
        f"{seen[45]:.4f} along the diagonals: one constant cannot name it. Only k2 = k1/2 gives "
        f"a ratio, 1/3, that is independent of direction."
    )
    return kit.Evidence(
        tables={"direction": table},
        tolerances=RULES,
        figures={"direction": FIGURE},
        columns=kit.columns(__file__),
        findings=(finding,),
    )


def ratio_two_ways(
    tensor: Callable[[float], kit.Array],
    mesh: reference_fem.Discretisation,
    case: tuple[float, float],
) -> tuple[float, float]:
    """Ratio in one direction from the tensor and from finite elements."""
    k2, degrees = case
    angle = np.deg2rad(degrees)
    C = tensor(k2)
    # Pulling the body at an angle is pulling the body, turned back by it, along x.
    problem = block.loaded_block("traction", rotate_tensor(C, -angle))
    move = reference_fem.solve_problem(problem, mesh).displacement
    return directional_ratio(C, angle), block.ratio(mesh.points, move, "edges")


FIGURE = kit.series(
    "direction", title="Poisson's ratio of the square lattice by direction",
    x="angle_deg", y="nu_fem", by="k2", beside={"nu_tensor": "tensor"}, line="",
    words={ratio * K1: f"FEM, k2/k1 = {ratio:g}" for ratio in RATIOS},
    labels=("direction of the pull to the axial springs (degrees)", "Poisson's ratio (1)"),
    size=(5.6, 3.6), xticks=range(0, 91, 15), ylim=(0, 0.72),
)  # fmt: skip
