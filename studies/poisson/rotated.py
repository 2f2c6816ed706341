"""Rotated: does a block cut at an angle to the lattice show the tensor's ratio?

Question   Poisson's ratio of a block of N x N cells whose sides run at an angle to the lattice, and
           the order in 1/N at which it comes to that of the bulk.
Candidate  Static equilibrium of the spring network: shared springs, traction on both ends.
Reference  The homogenised tensor, contracted with the direction of the pull. The lateral strain is
           taken at half length, between the free edges; the axial one between the ends' means.
Expected   Exact at 0 degrees. At 45 degrees the cut halves cells: half a cell keeps half of the
           diagonal along the cut and has lost the one across, so that its stiffness normal to the
           cut is k1/2, not k1/2 + 2 k2. Uniform strain leaves forces there and nowhere else: an
           effect of the edge, of first order. A zigzag edge has whole triangles, but not the
           traction on their slanted sides: first order too, and more so in a solid body of that
           outline. What an edge fails to carry acts as a point load of order 1/N where edges meet;
           its stress falls as 1/r, and the edges' answer is a term log(N)/N². The order falls to 1
           slowly: 1.20, 1.14, 1.09, 1.06 at k2 = k1/2 for pairs up to N = 40, 80, 160, 320.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs import lattice
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.directions import directional_ratio, rotate_tensor
from msvalidate.springs.constants.homogenise import interior_tensor

from . import block, direction
from .block import BOX, K1, RATIOS, SIDE

CELLS, FINEST = (5, 10, 20, 40), 80
"""The finest size is for cut blocks in the full form."""
QUICK_RATIOS = (0.5, 2.0)
"""k2/k1."""
EXACT = 1e-9
AT_AN_ANGLE = {"angle_deg": (45, 90)}
RULES = (
    kit.Rule(
        "square at 0 degrees: the tensor's ratio", EXACT, "1",
        "whole cells: exact at every size; left is the rounding of a linear solve",
        table="rotated", rows={"angle_deg": 0}, value="nu_springs", reference="nu_tensor",
    ),
    kit.Rule(
        "cut blocks: order in 1/N towards the tensor", 0.25, "1",
        "an edge effect is of order 1; the next term, log(N)/N², is 0.4 of it at N = 20 and 0.24 "
        "at 40, which adds 0.2 to the order of that pair, and less to finer ones",
        table="rotated_order", rows=AT_AN_ANGLE, reference=1.0,
        value=lambda rows: pd.to_numeric(rows["order"], errors="coerce"),
    ),
    kit.Rule(
        "cut blocks: difference to the tensor times N, finest size", 0.35, "1",
        "layers a fraction of a cell thick, of which theory says no more: 0.33 was measured at "
        "N = 40 for triangles, falling to finer ones",
        layer="regression", table="rotated", rows=AT_AN_ANGLE,
        by=("lattice", "k2"), last=1, value=lambda rows: rows["cells"] * difference(rows),
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare blocks cut along the lattice, and at an angle to it, with its tensor."""
    sizes = CELLS if setting.quick else (*CELLS, FINEST)
    ratios = QUICK_RATIOS if setting.quick else RATIOS
    cases = [("square", K1 * ratio, 0, n) for ratio in ratios for n in CELLS]
    cases += [("square", K1 * ratio, 45, n) for ratio in ratios for n in sizes]
    cases += [("triangular", 0.0, 90, n) for n in sizes]
    table = pd.DataFrame(setting.sweep(partial(measure, candidate), cases, "rotated blocks"))
    blocks = table.groupby(["lattice", "k2", "angle_deg"], sort=False)
    orders = pd.DataFrame([approach(rows) for _, rows in blocks])
    cut = pd.to_numeric(orders["order"][orders["angle_deg"] > 0], errors="coerce")
    return kit.Evidence(
        tables={"rotated": table, "rotated_order": orders},
        tolerances=RULES,
        figures={"rotated": draw},
        columns=kit.columns(__file__),
        findings=(finding(table, cut),),
    )


def measure(
    candidate: kit.DisplacementSolver, case: tuple[str, float, int, int]
) -> dict[str, object]:
    """One row of the table `rotate_tensor`: of a lattice, k2 (N/m), the pull's direction, and N."""
    name, k2, degrees, cells = case
    angle = np.deg2rad(degrees)
    grid, constants, tensor = material(name, k2, angle, cells)
    # Pulling the body at an angle is pulling the body, turned back by it, along x.
    problem = block.loaded_block("traction", rotate_tensor(tensor, -angle), body=grid.domain)
    network = lattice_network(problem, grid, constants, weights="shared")
    move = candidate(problem, network, "linear")
    size = np.ptp(grid.domain.span, axis=1)  # measured by it, the body is the unit square
    nu = block.ratio(network.points / size, move / size, "middle")
    row = {"lattice": name, "k1": K1, "k2": k2, "angle_deg": degrees, "cells": cells}
    return row | {"nu_springs": nu, "nu_tensor": directional_ratio(tensor, angle)}


def material(
    name: str, k2: float, angle: float, cells: int
) -> tuple[lattice.Lattice, tuple[float, ...], kit.Array]:
    """A block, its spring constants (N/m), and its tensor (3, 3) in N/m in the lattice's axes."""
    if name == "triangular":
        outline = lattice.zigzag_block(SIDE, (6 * cells // 5, cells))  # nearly a square
        grid = lattice.triangular(outline, SIDE / cells)
        return grid, (K1,), rotate_tensor(interior_tensor(grid, (K1,), "shared"), angle)
    cut = lattice.diagonal_square if angle else lattice.square
    return cut(BOX, cells), (K1, k2), direction.square_lattice(k2)


def difference(rows: pd.DataFrame) -> pd.Series[float]:
    """Of the block's ratio to the tensor's."""
    return rows["nu_springs"] - rows["nu_tensor"]


def approach(rows: pd.DataFrame) -> dict[str, object]:
    """One row of the table `rotated_order`, from the finest pair of one block's sizes."""
    pair = rows.iloc[-2:]
    gap = difference(pair).to_numpy()
    order: float | str = kit.observed_order(1 / pair["cells"], gap)
    if gap[0] * gap[1] <= 0:
        order = "not asymptotic"
    if np.abs(gap).max() < EXACT:
        order = "exact"
    head = ("lattice", "k1", "k2", "angle_deg", "cells")
    return {key: pair[key].iloc[-1] for key in head} | {"order": order}


def finding(table: pd.DataFrame, order: pd.Series[float]) -> str:
    """What blocks cut at an angle show."""
    square = table[(table["k2"] == 2 * K1) & (table["angle_deg"] == 45)]
    seen = [
        f"{first['nu_springs']:.4f} (N = {first['cells']}) to {last['nu_springs']:.4f} "
        f"(N = {last['cells']}), where the tensor has {last['nu_tensor']:.4f}"
        for rows in (square, table[table["lattice"] == "triangular"])
        for first, last in [(rows.iloc[0], rows.iloc[-1])]
    ]
    return (
        "A block cut at an angle to the lattice shows the tensor's ratio in the limit only, with "
        f"an error of order {order.min():.2f} to {order.max():.2f} in 1/N. At 45 degrees and "
        f"k2 = 2k1 it goes from {seen[0]}; across the rows of triangles from {seen[1]}."
    )


def draw(tables: kit.Tables) -> Figure:
    """Difference to the tensor's ratio against size; at 0 degrees it is rounding, not shown."""
    figure, (axis,) = kit.figures.new_figure(size=(4.6, 3.9))
    table = tables["rotated"]
    blocks = table[table["angle_deg"] > 0].groupby(["lattice", "k2"])
    for ((name, k2), rows), colour, marker in zip(
        blocks, kit.figures.COLOURS, kit.figures.MARKERS, strict=False
    ):
        label = f"45°, k2/k1 = {k2:g}" if name == "square" else "triangles, across rows"
        axis.loglog(rows["cells"], difference(rows).abs(), f"{marker}-", color=colour, label=label)
    sizes = np.array(sorted(set(table["cells"])))
    axis.loglog(sizes, 0.5 / sizes, "--", color="grey", label="0.5/N")
    axis.set_xticks(sizes, [str(n) for n in sizes])
    axis.set(xlabel="cells per side N (1)", ylabel="difference to the\ntensor's ratio (1)")
    axis.set_title("Blocks cut across the lattice: error of Poisson's ratio")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
