"""Cube: what ratio does a cube of N x N x N cells show, and whose formula is it in space?

Question   Lateral over axial strain of a pulled cube of cubic cells with 18 or 26 neighbours and of
           centred cells, for every size, boundary weight and loading.
Candidate  Static equilibrium of the spring network (linear geometry).
Reference  C12/(C11 + C12) of the homogenised tensor; closed forms for equal springs; for clamped
           ends finite elements on an eighth of the cubic body, sampled at the network's points.
Expected   Where all springs lie in cells, shared ones (half in a face, a quarter on an edge) make
           every cell alike, and the tensor's ratio is exact at each size. Equal springs are N + 1
           layers where N belong: C11 = k1 m² + 2 k2 m + 4/3 k3, C12 = k2 m + 4/3 k3, m = (N + 1)/N.
           Uniform strain would then show C12/(C11 + C12), in one cell of cubic 18 k2/(2 k1 + 3 k2),
           where the plane has k2/(2 k1 + k2). It does so in one cell. In more the edges, too stiff
           for it, bulge, but the work of the layers' forces on a uniform strain still vanishes.
           BCC cells, and second neighbours in FCC, lose springs at the boundary: first order.
"""

from __future__ import annotations

from functools import partial

import pandas as pd

from msvalidate import kit
from msvalidate.springs.constants.stiffness import moduli, pattern_tensor
from msvalidate.springs.lattice import patterns

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
LOSING = tuple(name for name in LATTICES if name not in WHOLE)
CLAMPED_CELLS = (3, 5, 8)
"""Sizes at which the clamped cube is held to FEM: in two cells one layer of points is free."""
DRAWN = 6
"""Cells of the cube that is drawn."""
NONE = "none"
exact = partial(kit.Rule, limit=1e-9, unit="1", table="cube")
whole = partial(exact, value="nu_springs", reference="nu_tensor")
clamped = partial(kit.Rule, unit="1", table="cube_clamped")
RULES = (
    whole(
        "cube, shared springs in whole cells: C12/(C11 + C12)",
        rows={"lattice": WHOLE, "weights": "shared"},
        because="exact at every size; left is the rounding of a linear solve, 1e-16 times a "
        "condition number of up to 1e4",
    ),
    whole(
        "cube, per-cell springs: the same with 4 k1 and 2 k2", rows={"weights": "per_cell"},
        because="exact at every size, as for shared springs",
    ),
    exact(
        "cube, modulus of shared springs in whole cells, relative", table="cube_modulus",
        rows={"lattice": WHOLE, "weights": "shared"}, value="modulus_ratio", reference=1.0,
        because="the same uniform strain, measured by the traction that it takes",
    ),
    exact(
        "one cubic cell of equal springs: the layers' ratio",
        rows={"lattice": CUBIC, "weights": "equal", "cells": 1},
        value="nu_springs", reference="nu_layers",
        because="every point is a corner, so uniform strain is exact in an isolated cell",
    ),
    exact(
        "one cell of cubic 18, equal springs: k2/(2k1+3k2)", table="cube_cell",
        value="nu_springs", reference="nu_cell_cube", because="the same cell, for all constants",
    ),
    exact(
        "cubes of equal springs: work of the layers on a uniform strain",
        rows={"lattice": CUBIC, "weights": "equal", "loading": "slide"}, value="layers_work",
        because="virtual work: an identity of sums over layers at equilibrium, whatever the shape",
    ),
    kit.Rule(
        "cubes that lose springs: order in 1/N towards the tensor", 0.25, "1",
        "an edge effect is of order 1; the next term, log(N)/N², is 0.4 of it at N = 5 and adds "
        "up to 0.2 to the order of a pair",
        table="cube", rows={"lattice": LOSING, "weights": "shared"}, by=("lattice", "loading"),
        last=2, value=kit.Difference("nu_springs", "nu_tensor"),
        power_of=kit.Quotient(1, "cells"), reference=1.0,
    ),
    clamped(
        "clamped cube, shared springs: difference to FEM times N", 0.03, layer="agreement",
        rows={"cells": CLAMPED_CELLS},
        value=lambda rows: rows["cells"] * (rows["nu_springs"] - rows["nu_fem"]),
        because="the layer of points next to each clamp, 2/N of a face, is off by a twentieth of "
        "the contraction of 0.25 to 0.35 that the clamp keeps back; further in, differences fall "
        "faster than 1/N",
    ),
    clamped(
        "clamped cube: uncertainty of FEM", 2e-3, rows={"cells": CLAMPED_CELLS},
        value="nu_fem_uncertainty", because="a third of what the springs may be off at N = 5",
    ),
)  # fmt: skip


def run(
    candidate: kit.DisplacementSolver = kit.solve_springs, setting: kit.Setting = kit.FULL
) -> kit.Evidence:
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
    return kit.Evidence(
        tables=tables,
        tolerances=RULES,
        figures={"cube": cube_drawing.ratios, "cube_shape": cube_drawing.deformed},
        columns=kit.columns(__file__),
        findings=findings(tables),
    )


def cases(setting: kit.Setting) -> list[tuple[str, str, str, int]]:
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
    candidate: kit.DisplacementSolver, case: tuple[str, str, str, int]
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


def _tensor(material: object) -> kit.Array:
    if not isinstance(material, kit.Anisotropic):
        raise TypeError("the cube's material is its tensor")
    return material.C


def clamped_rows(
    candidate: kit.DisplacementSolver, sizes: tuple[int, ...], name: str
) -> pd.DataFrame:
    """Rows of the table `cube_clamped`: shared springs against the elastic cube."""
    fem = clamped_reference(name, sizes)
    values = iter(zip(fem.value, fem.uncertainty, strict=True))
    rows = []
    for cells in sizes:
        problem, network = spring_cube(name, "shared", "clamped", cells)
        move = candidate(problem, network, "linear")
        for lateral in LATERAL:
            nu, uncertainty = next(values)
            row: dict[str, object] = {"lattice": name, "lateral": lateral, "cells": cells}
            row |= {"nu_springs": ratio(network.points, move, lateral)}
            rows.append(row | {"nu_fem": nu, "nu_fem_uncertainty": uncertainty})
    return pd.DataFrame(rows)


def one_cell(candidate: kit.DisplacementSolver, k2: float) -> dict[str, float]:
    """One row of the table `cube_cell`: an isolated cell of cubic 18, all springs equal."""
    k1 = block.K1
    problem, network = spring_cube("cubic 18", "equal", "slide", 1, (k1, k2))
    row = {"k1": k1, "k2": k2}
    row |= {"nu_springs": ratio(network.points, candidate(problem, network, "linear"))}
    row |= {"nu_cell_cube": k2 / (2 * k1 + 3 * k2), "nu_cell_formula": k2 / (2 * k1 + k2)}
    return row | {"nu_tensor": moduli(pattern_tensor(patterns.cubic18(), (k1, k2))).nu}


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
        "Shared springs, half in a face and a quarter on an edge, show the bulk's ratio in the "
        f"cubes tried; equal ones {equal[1]:.4f} in one cell and {equal[5]:.4f} in 5 x 5 x 5. "
        f"Lattices that lose springs at the boundary are off, in 5 cells: "
        f"{', '.join(lost)}, bulk 1/4."
    )
    return formula, rule
