"""Cube: what ratio does a cube of N x N x N cells show, and whose formula is it in space?

Question   Lateral over axial strain of a pulled cube of cubic cells with 18 or 26 neighbours and of
           centred cells, for every size, boundary weight and loading.
Candidate  Static equilibrium of the spring network (linear geometry).
Reference  C12/(C11 + C12) of the homogenised tensor; closed forms for equal springs; for clamped
           ends finite elements on an eighth of the cubic body, sampled at the network's points.
Expected   Where all springs lie in cells, shared ones (half in a face, a quarter on an edge) make
           every cell alike, and the tensor's ratio is exact at every size. Equal springs are N + 1
           layers where N belong: C11 = k1 m² + 2 k2 m + 4/3 k3, C12 = k2 m + 4/3 k3, m = (N + 1)/N.
           Uniform strain would then show C12/(C11 + C12), in one cell of cubic 18 k2/(2 k1 + 3 k2),
           where the plane has k2/(2 k1 + k2). It does so in one cell. In more the edges, too stiff
           for it, bulge, but the work of the layers' forces on a uniform strain still vanishes.
           BCC cells, and second neighbours in FCC, lose springs at the boundary: first order.
"""

from __future__ import annotations

from functools import partial

import pandas as pd

from msvalidate.constants.stiffness import moduli, pattern_tensor
from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.lattice import patterns
from msvalidate.problem import Anisotropic, Array

from . import block, cube_drawing
from .cube_block import (
    LATERAL,
    LATTICES,
    STRAIN,
    axial_strain,
    clamped_reference,
    ratio,
    spring_cube,
)
from .cube_layers import layers_ratio, layers_work

CELLS, QUICK_CELLS = (1, 2, 3, 5, 8), (1, 2, 3, 5)
WHOLE = ("cubic 18", "cubic 26", "FCC, nearest")
"""Lattices whose springs all lie in cells or in their faces."""
CUBIC = ("cubic 18", "cubic 26")
"""Lattices whose springs of one kind all border as many cells: `per_cell` means something."""
CLAMPED_CELLS = 3
"""Size from which the clamped cube is held to FEM: in two cells one layer of points is free."""
DRAWN = 6
"""Cells of the cube that is drawn."""
NONE = "none"
EXACT, ONE = 1e-9, "1"
TOLERANCES = (
    Tolerance(
        "cube, shared springs in whole cells: C12/(C11 + C12)", EXACT, ONE,
        "exact at every size; left is the rounding of a linear solve, 1e-16 times a condition "
        "number of up to 1e4",
    ),
    Tolerance(
        "cube, per-cell springs: the same with 4 k1 and 2 k2", EXACT, ONE,
        "exact at every size, as for shared springs",
    ),
    Tolerance(
        "cube, modulus of shared springs in whole cells, relative", EXACT, ONE,
        "the same uniform strain, measured by the traction that it takes",
    ),
    Tolerance(
        "one cubic cell of equal springs: the layers' ratio", EXACT, ONE,
        "every point is a corner, so uniform strain is exact in an isolated cell",
    ),
    Tolerance(
        "cubes of equal springs: work of the layers on a uniform strain", EXACT, ONE,
        "virtual work: an identity of sums over layers at equilibrium, whatever the shape",
    ),
    Tolerance(
        "cubes that lose springs: order in 1/N towards the tensor", 0.25, ONE,
        "an edge effect is of order 1; the next term, log(N)/N², is 0.4 of it at N = 5 and adds "
        "up to 0.2 to the order of a pair",
    ),
    Tolerance(
        "clamped cube, shared springs: difference to FEM times N", 0.03, ONE,
        "the layer of points next to each clamp, 2/N of a face, is off by a twentieth of the "
        "contraction of 0.25 to 0.35 that the clamp keeps back; further in, differences fall "
        "faster than 1/N",
        layer="agreement",
    ),
    Tolerance(
        "clamped cube: uncertainty of FEM", 2e-3, ONE,
        "a third of what the springs may be off at N = 5",
    ),
)  # fmt: skip
COLUMNS = {
    **block.COLUMNS,
    "constants": "spring constants by length, shortest first (N/m)",
    "nu_layers": "ratio of N + 1 layers for N cells in uniform strain, equal springs; "
    '"none" where springs are not equal, or cells not cubic (1)',
    "layers_work": "work of the layers' forces on a uniform strain along y, over that of the pull, "
    'ends sliding; "none" where there is no nu_layers, or no such ends (1)',
    "modulus_ratio": "traction over axial strain, over the tensor's modulus (1)",
    "lateral": "lateral strain between the means of whole side faces, or at their middle",
    "nu_fem_uncertainty": "estimated error of nu_fem (1)",
    "nu_cell_cube": "k2/(2 k1 + 3 k2), of one cell of equal springs in space (1)",
    "nu_cell_formula": "the report's k2/(2 k1 + k2) (1)",
    **cube_drawing.COLUMNS,
}


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Compare the candidate with tensors, closed forms and finite elements on every cube."""
    sizes = QUICK_CELLS if setting.quick else CELLS
    found = setting.sweep(partial(measure, candidate), cases(setting), "spring cubes")
    cubes = pd.DataFrame([row for row, _ in found])
    modulus = pd.DataFrame([row for _, row in found if row])
    held = CUBIC[:1] if setting.quick else WHOLE
    clamped = pd.concat(
        setting.sweep(partial(clamped_rows, candidate, sizes[1:]), held, "clamped cubes"),
        ignore_index=True,
    )
    tables = {
        "cube": cubes,
        "cube_modulus": modulus,
        "cube_clamped": clamped,
        "cube_cell": pd.DataFrame(one_cell(candidate, k2) for k2 in block.RATIOS),
        "cube_shape": cube_drawing.shape(candidate, DRAWN),
    }
    return Evidence(
        tables=tables,
        observed=observe(tables),
        tolerances=TOLERANCES,
        figures={"cube": cube_drawing.ratios, "cube_shape": cube_drawing.deformed},
        columns=COLUMNS,
        findings=findings(tables),
        rounding={"layers_work": 1e-12},
    )


def cases(setting: Setting) -> list[tuple[str, str, str, int]]:
    """(lattice, weights, loading, N) of every cube with free sides.

    One cell of BCC is a mechanism, and one of FCC's nearest springs just no mechanism.
    """
    found = []
    for name in LATTICES:
        rules = ["shared", "equal", *(("per_cell",) if name in CUBIC else ())]
        sizes = [n for n in (QUICK_CELLS if setting.quick else CELLS) if n > 1 or name in CUBIC]
        if setting.quick and name not in CUBIC:
            rules, sizes = rules[:1], sizes[-2:]
        for rule in rules:
            loadings = ["slide"] if rule == "per_cell" else ["slide", "traction"]
            found += [(name, rule, loading, n) for loading in loadings for n in sizes]
    return found


def measure(
    candidate: DisplacementSolver, case: tuple[str, str, str, int]
) -> tuple[dict[str, object], dict[str, object]]:
    """One row of the table `cube` and, under traction, one of `cube_modulus`."""
    name, weights, loading, cells = case
    problem, network = spring_cube(name, weights, loading, cells)
    move = candidate(problem, network, "linear")
    constants = LATTICES[name][1]
    layered = name in CUBIC and weights == "equal"
    tensor = moduli(_tensor(problem.material))
    head: dict[str, object] = {"lattice": name, "constants": ", ".join(f"{k:g}" for k in constants)}
    head |= {"weights": weights, "cells": cells}
    row: dict[str, object] = {"loading": loading, "nu_springs": ratio(network.points, move)}
    row |= {"nu_tensor": tensor.nu}
    row |= {"nu_layers": layers_ratio(constants, cells) if layered else NONE}
    work = layered and loading == "slide"
    row |= {"layers_work": layers_work(constants, cells, network.points, move) if work else NONE}
    stretched = axial_strain(network.points, move) / STRAIN
    return head | row, head | {"modulus_ratio": 1 / stretched} if loading == "traction" else {}


def _tensor(material: object) -> Array:
    if not isinstance(material, Anisotropic):
        raise TypeError("the cube's material is its tensor")
    return material.C


def clamped_rows(candidate: DisplacementSolver, sizes: tuple[int, ...], name: str) -> pd.DataFrame:
    """Rows of the table `cube_clamped`: shared springs against the elastic cube."""
    fem = clamped_reference(name, sizes)
    values = iter(zip(fem.value, fem.uncertainty, strict=True))
    rows = []
    for cells in sizes:
        problem, network = spring_cube(name, "shared", "clamped", cells)
        move = candidate(problem, network, "linear")
        for lateral in LATERAL:
            nu, doubt = next(values)
            row: dict[str, object] = {"lattice": name, "lateral": lateral, "cells": cells}
            row |= {"nu_springs": ratio(network.points, move, lateral)}
            rows.append(row | {"nu_fem": nu, "nu_fem_uncertainty": doubt})
    return pd.DataFrame(rows)


def one_cell(candidate: DisplacementSolver, k2: float) -> dict[str, float]:
    """One row of the table `cube_cell`: an isolated cell of cubic 18, all springs equal."""
    k1 = block.K1
    problem, network = spring_cube("cubic 18", "equal", "slide", 1, (k1, k2))
    row = {"k1": k1, "k2": k2}
    row |= {"nu_springs": ratio(network.points, candidate(problem, network, "linear"))}
    row |= {"nu_cell_cube": k2 / (2 * k1 + 3 * k2), "nu_cell_formula": k2 / (2 * k1 + k2)}
    return row | {"nu_tensor": moduli(pattern_tensor(patterns.cubic18(), (k1, k2))).nu}


def observe(tables: dict[str, pd.DataFrame]) -> dict[str, Observed]:
    """The judged quantities, each the worst of its rows."""
    cubes, modulus, clamped, cell = (
        tables[name] for name in ("cube", "cube_modulus", "cube_clamped", "cube_cell")
    )
    whole = cubes[cubes["lattice"].isin(WHOLE)]
    shared, per_cell = (whole[whole["weights"] == rule] for rule in ("shared", "per_cell"))
    stiff = modulus[modulus["lattice"].isin(WHOLE) & (modulus["weights"] == "shared")]
    equal = cubes[cubes["nu_layers"] != NONE]
    isolated = equal[equal["cells"] == 1]
    work = pd.to_numeric(cubes["layers_work"], errors="coerce").dropna()
    cut = cubes[~cubes["lattice"].isin(WHOLE) & (cubes["weights"] == "shared")]
    orders = [
        observed_order(1 / pair["cells"], pair["nu_springs"] - pair["nu_tensor"])
        for _, rows in cut.groupby(["lattice", "loading"])
        for pair in [rows.iloc[-2:]]
    ]
    held = clamped[clamped["cells"] >= CLAMPED_CELLS]
    cells_seen = [*isolated["nu_springs"], *cell["nu_springs"]]
    cells_due = [*isolated["nu_layers"], *cell["nu_cell_cube"]]
    values = (
        farthest_value(shared["nu_springs"], shared["nu_tensor"]),
        farthest_value(per_cell["nu_springs"], per_cell["nu_tensor"]),
        farthest_value(stiff["modulus_ratio"], 1.0),
        farthest_value(cells_seen, cells_due),
        farthest_value(work, 0.0),
        farthest_value(orders, 1.0),
        farthest_value(held["cells"] * (held["nu_springs"] - held["nu_fem"]), 0.0),
        farthest_value(held["nu_fem_uncertainty"], 0.0),
    )
    return by_quantity(TOLERANCES, values)


def findings(tables: dict[str, pd.DataFrame]) -> tuple[str, ...]:
    """What the tables say of formulas in space."""
    cell = tables["cube_cell"].set_index("k2").loc[block.K1]
    cubes = (
        tables["cube"]
        .set_index(["lattice", "weights", "loading", "cells"])
        .sort_index()["nu_springs"]
    )
    equal = cubes["cubic 18", "equal", "slide"]
    lost = [
        f"{name} {cubes[name, 'shared', 'traction', 5]:.3f}"
        for name in LATTICES
        if name not in WHOLE
    ]
    formula = (
        "In space the report's k2/(2k1+k2) is the ratio of no cube: one cell of cubic 18 shows "
        f"k2/(2k1+3k2), {cell['nu_springs']:.4f} at k2 = k1 where the report's formula says "
        f"{cell['nu_cell_formula']:.4f}, and the bulk k2/(k1+3k2), {cell['nu_tensor']:.4f}."
    )
    rule = (
        "Shared springs, half in a face and a quarter on an edge, show the bulk's ratio in a cube "
        f"of any size; equal ones {equal[1]:.4f} in one cell and {equal[5]:.4f} in 5 x 5 x 5. "
        f"Lattices that lose springs at the boundary are off at any size, in 5 cells: "
        f"{', '.join(lost)}, bulk 1/4."
    )
    return formula, rule
