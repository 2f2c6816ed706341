"""Direction: how does the lattice's ratio depend on the direction of the pull?

Question   Poisson's ratio every 5 degrees for the four constants.
Candidate  The homogenised tensor of the lattice, contracted with the direction.
Reference  Finite elements on the turned tensor: a block under uniform traction on statically
           determinate supports.
Expected   Equal, since the strain is uniform; k2/(k1 + k2) along the axes; the same in every
           direction at k2 = k1/2 only; k1/(k1 + 4 k2) along the diagonals.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import product

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

import reference_fem
from msvalidate import lattice
from msvalidate.constants.directions import directional_ratio, rotate_tensor
from msvalidate.constants.homogenise import interior_tensor
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tables, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.output import figures
from msvalidate.problem import Array

from . import block
from .block import BOX, K1, RATIOS

ANGLES = tuple(range(0, 91, 5))
QUICK_ANGLES = (0, 15, 30, 45, 60, 75, 90)
MESH = 2
"""Cells per side: a uniform strain is exact on any mesh."""
UNIFORM = 1e-9
TOLERANCES = (
    Tolerance(
        "tensor against FEM on the turned tensor", UNIFORM, "1",
        "uniform strain: rounding of a small linear solve is all that is left",
    ),
    Tolerance("along the axes: k2/(k1+k2)", UNIFORM, "1", "C12/C11 of the affine sum over springs"),
    Tolerance("spread over directions at k2 = k1/2", UNIFORM, "1", "isotropic: 2 C66 = C11 - C12"),
    Tolerance(
        "along the diagonal: k1/(k1+4k2)", UNIFORM, "1",
        "closed form: the compliance of C11 = k1 + k2, C12 = C66 = k2, turned by 45 degrees",
    ),
)  # fmt: skip
COLUMNS = {
    **block.COLUMNS,
    "nu_fem": "Poisson's ratio of the elastic body, by finite elements (1)",
}


def square_lattice(k2: float) -> Array:
    """The candidate: tensor (3, 3) in N/m of the square lattice with k1 = 1 N/m."""
    return interior_tensor(lattice.square(BOX, 1), (K1, k2), "shared")


def run(tensor: Callable[[float], Array] = square_lattice, setting: Setting = FULL) -> Evidence:
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
    axes = table[table["angle_deg"].isin([0, 90])]
    isotropic = table[table["k2"] == K1 / 2]["nu_tensor"]
    diagonal = table[table["angle_deg"] == 45]
    values = (
        farthest_value(table["nu_tensor"], table["nu_fem"]),
        farthest_value(axes["nu_tensor"], axes["k2"] / (K1 + axes["k2"])),
        Observed(float(isotropic.max() - isotropic.min())),
        farthest_value(diagonal["nu_tensor"], K1 / (K1 + 4 * diagonal["k2"])),
    )
    seen = table[table["k2"] == 2 * K1].set_index("angle_deg")["nu_tensor"]
    finding = (
        f"With the report's k2 = 2k1 the ratio is {seen[0]:.4f} along the axial springs and "
        f"{seen[45]:.4f} along the diagonals: one constant cannot name it. Only k2 = k1/2 gives "
        f"the same ratio, 1/3, in every direction."
    )
    return Evidence(
        tables={"direction": table},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"direction": draw},
        columns=COLUMNS,
        findings=(finding,),
    )


def ratio_two_ways(
    tensor: Callable[[float], Array],
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


def draw(tables: Tables) -> Figure:
    """Ratio against the direction, a curve for each k2/k1."""
    figure, (axis,) = figures.new_figure(size=(4.6, 3.6))
    for (k2, rows), colour, marker in zip(
        tables["direction"].groupby("k2"), figures.COLOURS, figures.MARKERS, strict=False
    ):
        angle = rows["angle_deg"]
        axis.plot(angle, rows["nu_tensor"], color=colour, label=f"k2/k1 = {k2:g}")
        axis.plot(angle, rows["nu_fem"], marker, color=colour, mfc="white", label="_")
    axis.plot([], [], "-", color="grey", label="homogenised tensor")
    axis.plot([], [], "o", color="grey", mfc="white", label="FEM, turned tensor")
    axis.set_xlabel("direction of the pull to the axial springs (degrees)")
    axis.set_ylabel("Poisson's ratio (1)")
    axis.set_xticks(range(0, 91, 15))
    axis.set_ylim(0, 0.72)
    axis.set_title("Poisson's ratio of the square lattice by direction")
    figures.add_shared_legend(figure, [axis], columns=3)
    return figure
