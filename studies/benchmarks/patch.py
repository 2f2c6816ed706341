"""Patch tests: is a linear displacement kept exactly on a patch of any shape?

Question   Displacement of the inner points, mean stress, and stress at the points, of a patch whose
           outline is moved by a linear field: a rectangle of five quadrilaterals and a cube of
           seven hexahedra; at a negative Poisson's ratio too.
Candidate  Linear equilibrium of springs: regular lattices in the patch's outline, and a spring on
           every edge of the irregular patch cut into triangles.
Reference  The field itself [MacNealHarder1985].
Expected   Elements are exact, for they hold every linear field. Regular lattices are, for the
           springs at an inner point balance by symmetry. At an irregular point they do not: no
           constants make springs on edges of irregular triangles an element [vanGelder1998],
           whose E·area/length² is used here.
"""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate import kit
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.constants.stiffness import CAUCHY
from msvalidate.springs.lattice import (
    fill,
    mesh_lattice,
    patterns,
    square,
    triangular,
    zigzag_block,
)

from . import cases, models
from .patch_bodies import (
    CUBE,
    GRADIENT,
    MODULUS,
    PATCH,
    THICKNESS,
    Patch,
    elastic_patch,
    problem,
    published,
    spring_patch,
)

SOURCE = "MacNeal and Harder 1985"
RATIOS = (-0.3, 1 / 4, 1 / 3)
"""Of the plane; the first tells a ratio from its size."""
SOLID_RATIOS = (-0.3, CAUCHY[3])
PLANE_ELEMENTS, SOLID_ELEMENTS = ("P1", "P2", "Q1", "Q2"), ("T1", "T2", "H1", "H2")
PER_EDGE = "springs, edges of triangles"
AT_POINTS = "stress at the point and of the component farthest off, over the exact one"
EXACT = 1e-9
MAGNIFIED = 100
"""Factor on the displacements in the picture."""
RULES = (
    kit.Rule(
        "patch tests: elements and regular lattices, relative", EXACT, "1",
        "a linear field is in their space: left is rounding, 1e-16 times a condition number of "
        "up to 1e5",
        table="patch",
        value=lambda rows: rows["against_accepted"].where(rows["method"] != PER_EDGE, 0.0),
    ),
    kit.Rule(
        "patch test: quantities that a spring on every edge of the irregular patch gets right",
        0, "1",
        "van Gelder 1998: springs on the edges of irregular triangles are no elastic body; one "
        "that passed would be another network",
        table="patch", rows={"method": PER_EDGE},
        value=lambda rows: (rows["against_accepted"].abs() <= EXACT).sum(),
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
    """Compare elements and the candidate's springs with the linear field."""
    found = [
        row
        for nu in RATIOS
        for element in PLANE_ELEMENTS
        for row in rows(elastic_patch(element, nu), f"FEM {element}", nu)
    ]
    grid = square(PATCH, (8, 4))
    for nu in RATIOS:
        asked = problem(PATCH, nu)
        patch = spring_patch(candidate, asked, models.network_of(asked, grid), len(grid.cells))
        found += rows(patch, models.method("square", nu), nu)
    nu = CAUCHY[2]
    outline = zigzag_block(PATCH.size[1], (8, 4))
    asked, grid = problem(outline, nu), triangular(outline, PATCH.size[1] / 4)
    patch = spring_patch(candidate, asked, lattice_network(asked, grid), len(grid.cells))
    found += rows(patch, "springs, triangular", nu)
    mesh = published("P")
    asked = problem(mesh, nu)
    network = lattice_network(asked, mesh_lattice(mesh), (MODULUS * THICKNESS,))
    irregular = spring_patch(candidate, asked, network, len(mesh.cells))
    found += rows(irregular, PER_EDGE, nu)
    for nu in SOLID_RATIOS:
        for element in SOLID_ELEMENTS:
            found += rows(elastic_patch(element, nu), f"FEM {element}", nu)
        asked, grid = problem(CUBE, nu), fill(patterns.cubic18(), CUBE, 3)
        patch = spring_patch(candidate, asked, models.network_of(asked, grid), len(grid.cells))
        found += rows(patch, models.method("cubic 18", nu, 3), nu)
    table = pd.DataFrame(found)
    return kit.Evidence(
        tables={"patch": table},
        drawn={"patch_points": points_table(irregular)},
        tolerances=RULES,
        columns=kit.columns(__file__),
        figures={"patch": drawn},
        findings=(finding(table),),
    )


def stress(dim: int, nu: float) -> tuple[float, float]:
    """Exact normal and shear stress (Pa), the same on all axes: Hooke's law of the strains."""
    strain, shear = GRADIENT[dim][0, 0], 2 * GRADIENT[dim][0, 1]
    mu = MODULUS / (2 * (1 + nu))
    lam = MODULUS * nu / ((1 - nu**2) if dim == 2 else ((1 + nu) * (1 - 2 * nu)))
    return lam * dim * strain + 2 * mu * strain, mu * shear


def rows(patch: Patch, method: str, nu: float) -> list[dict[str, object]]:
    """Rows of one patch."""
    dim = patch.points.shape[1]
    normal, shear = stress(dim, nu)
    name = {2: "patch, plane", 3: "patch, solid"}[dim]
    found = []
    for quantity, unit, accepted, value in (
        ("displacement of the point farthest off, over the exact one", "1", 1.0, patch.worst),
        ("mean σxx", "Pa", normal, patch.stress[0, 0]),
        ("mean τxy", "Pa", shear, (patch.stress[0, 1] + patch.stress[1, 0]) / 2),
    ):
        asked = cases.Quantity(name, quantity, unit, accepted, SOURCE, nu)
        found += cases.rows(asked, method, (patch.cells,), (float(value),))
    if patch.at_points is not None:
        exact = np.array([normal] * dim + [shear] * (patch.at_points.shape[1] - dim))
        off = (patch.at_points / exact - 1).ravel()
        asked = cases.Quantity(name, AT_POINTS, "1", 1.0, SOURCE, nu)
        found += cases.rows(asked, method, (patch.cells,), (1 + float(off[np.abs(off).argmax()]),))
    return found


def points_table(patch: Patch) -> pd.DataFrame:
    """The points of the irregular patch and how far off they are."""
    (x, y), (off_x, off_y) = patch.points.T, patch.off.T
    return pd.DataFrame(
        {"point": np.arange(len(x)), "x": x, "y": y, "off_x": off_x, "off_y": off_y}
    )


def finding(table: pd.DataFrame) -> str:
    """What passes and what does not."""
    here = table[table["method"] == PER_EDGE].set_index("quantity")["against_accepted"]
    passed = sorted(set(table["method"]) - {PER_EDGE})
    return (
        f"The patch tests are passed by {', '.join(passed)}. A spring on every edge of the "
        f"irregular patch fails: a point is {100 * abs(here.iloc[0]):.2g} % off, and the mean "
        f"stresses {100 * here.iloc[1]:.2g} and {100 * here.iloc[2]:.2g} %."
    )


def drawn(tables: kit.Tables) -> Figure:
    """The irregular patch, its field, and where a spring on every edge puts the inner points."""
    table = tables["patch_points"]
    points, off = table[["x", "y"]].to_numpy(), table[["off_x", "off_y"]].to_numpy()
    field = points @ GRADIENT[2]
    cells = published("P").cells
    moves = {"elements, and the exact field": field, PER_EDGE: field + off * np.abs(field).max()}
    figure, (axis,) = kit.figures.new_figure(size=(5.6, 3.9))
    for i, (name, move) in enumerate(moves.items()):
        place = points + MAGNIFIED * move
        axis.triplot(*place.T, cells, color=kit.figures.COLOURS[i], lw=0.9)
        axis.plot(*place.T, kit.figures.MARKERS[i], color=kit.figures.COLOURS[i], label=name)
    axis.triplot(*points.T, cells, color="#999999", lw=0.9, ls=":")
    axis.plot([], [], ":", color="#999999", label="at rest")
    corners = points[[0, 1, 2, 3]] + MAGNIFIED * field[[0, 1, 2, 3]]
    axis.plot(*corners.T, "s", color="black", mfc="none", ms=9, label="displacement prescribed")
    axis.set(xlabel="x (m)", ylabel="y (m)", aspect="equal")
    figure.suptitle(f"MacNeal and Harder's patch: displacements times {MAGNIFIED}")
    kit.figures.add_shared_legend(figure, [axis], columns=2)
    return figure
