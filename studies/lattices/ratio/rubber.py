"""Rubber: do springs with the volume energy lock as nu goes to 1/2?

Question   Deflection of a block held at its left side and sheared at its right one, so that it
           bends, of small strain, for nu to 0.4999: its difference from elasticity, its order, and
           what is lost from nu = 0.45 to the largest.
Candidate  Square and cubic lattices with κ of every cell's volume, or of its halves'.
Reference  Mixed finite elements (displacement of the second degree, pressure of the first) on three
           graded meshes, extrapolated; in plane stress, where nothing locks, Q2. Beside it
           displacement elements on the lattice's own cells, and conditions of volume at nu = 1/2,
           counted over the freedoms of the points.
Expected   The order that the clamped side's end allows, or more while bending leaves more, up to 2,
           for each nu. One volume a cell is one condition for every two (plane) or three (space)
           freedoms of the points, as many as the solid has: no locking. Two triangles a square, of
           a volume each, make as many conditions as freedoms: such cells lock, as linear elements
           do. So does Q1, which resists the change of volume at every point of its cell.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np
import pandas as pd

import reference_fem
from msvalidate import kit
from msvalidate.bench.judging.singularity import clamped_free_exponent
from msvalidate.problem.material import State
from msvalidate.springs.bodies.calibrate import calibrate_material
from msvalidate.springs.bodies.lattice_network import lattice_network
from msvalidate.springs.network import tangent
from reference_fem.elasticity import elastic_tensor, stiffness

from . import stretch
from .bent import ELEMENTS, HALVES, LATTICES, RATIOS, SPRINGS, Bent, deflection, reference

MODELS = {
    "square": "springs + volume energy, square",
    HALVES: "springs + volumes of half cells, square",
    "cubic18": "springs + volume energy, cubic 18",
    "cubic26": "springs + volume energy, cubic 26",
    "P1": "elements, linear triangles (P1)",
    "Q1": "elements, bilinear squares (Q1)",
    "T1": "elements, linear tetrahedra (T1)",
    "H1": "elements, trilinear cubes (H1)",
}
"""Words for the models."""
SIZES = {2: (4, 8, 16, 32), 3: (2, 4, 8)}
QUICK = {2: (4, 8, 16), 3: (2, 4)}
"""Cells through the height."""
MESHES = {2: (8, 16, 32), 3: (2, 4, 8)}
QUICK_MESHES = {2: (3, 6, 12), 3: (1, 2, 4)}
"""Of the reference, cells through the height, graded to the corners."""
WORDS = {"plane_strain": "plane strain", "plane_stress": "plane stress", "solid": "space"}
FINE = {"plane_strain": 16, "plane_stress": 16, "solid": 4}
"""Cells through the height, at which it is decided what locks."""
RUBBER = 0.4
"""Least ratio that is called nearly incompressible."""
LOCKS = 0.05
"""Of the deflection, which a model loses more of, from the least such ratio to the largest, if it
locks."""
CONDITIONS = {"square": 1 / 2, HALVES: 1.0, "Q1": 3 / 2, "P1": 1.0, "cubic18": 1 / 3}
CONDITIONS |= {"cubic26": 1 / 3, "H1": 7 / 3, "T1": 2.0}
"""Conditions of volume over freedoms: a cell of Q1 has 3 of them (its dilatation is linear), of H1
7, triangles and tetrahedra one, of which there are 2 and 6 for every point."""


def orders_outside(rows: pd.DataFrame) -> list[float]:
    """By how much the orders of pairs of sizes lie below twice the end's exponent or above 2.

    What is missing of the deflection has one order, that part of the stiffness which is too much
    another: the true one is one of them, or between.
    """
    found = []
    for (state, nu, _), pair in rows.groupby(["state", "nu_rubber", "model"], sort=False):
        lacking = pair["deflection_difference"]
        low, *orders = (
            end_order(str(state), nu),
            *(
                kit.observed_order(1 / pair["cells_through"], part)
                for part in (lacking, lacking / (1 + lacking))
            ),
        )
        found.append(max(0.0, low - max(orders), min(orders) - 2))
    return found


@cache
def end_order(state: str, nu: float) -> float:
    """Twice the exponent of the displacement at the clamped side's end."""
    plane: State = "plane_stress" if state == "plane_stress" else "plane_strain"
    return 2 * clamped_free_exponent(elastic_tensor(kit.Isotropic(1.0, nu, plane)), np.pi / 2)


KIND = ("state", "nu_rubber", "model")
RULES = (
    kit.Rule(
        "deflection by mixed elements: uncertainty, relative", 0.01, "1",
        "half of what an extrapolation adds, 2 % on 4 cells of a cube at most: a tenth of the "
        "lattices' difference there",
        table="rubber", value="deflection_uncertainty",
    ),
    kit.Rule(
        "volume energy: orders of the finest pair, out of twice the clamped end's exponent to 2",
        0.03, "1",
        "the end adds an error of the first, bending one of order 2, both of one sign: the order "
        "of their sum lies between. The reference is uncertain by 1 % of the difference in the "
        "plane, by 2 % on the cube: log2(1.02) = 0.03. Where a quarter is missing, orders by "
        "deflection and by stiffness differ: one of them, or what is between, has to lie there",
        table="rubber", rows={"model": tuple(SPRINGS)}, by=KIND, last=2, value=orders_outside,
    ),
    kit.Rule(
        "volume energy: part of the deflection lost from nu = 0.45 to the largest", 0.03, "1",
        "at 1/2 the clamped end's exponent is 0.595, at 0.45 0.64: differences of 0.14 at 4 cells "
        "of a cube change by 1 - 4^-0.09, 12 % of themselves",
        table="rubber_locking", rows={"model": tuple(SPRINGS)}, value="lost",
    ),
    kit.Rule(
        "models that lock in plane strain and space, or do not, against expectation", 0, "1",
        "conditions of volume for every freedom tell: half of them, or a third, in cells of one "
        "volume; one and more in halves, tetrahedra, and cells that resist at every point",
        table="rubber_locking", rows={"state": ("plane_strain", "solid")},
        value=lambda rows: rows["locks"] == "yes",
        reference=lambda rows: rows["volumes_a_freedom"] >= 1,
    ),
)  # fmt: skip
FIGURE = kit.series(
    "rubber", title="Bent blocks near nu = 1/2: what locks, springs or elements (P1, Q1, T1, H1)",
    x="cells_through", y="deflection_difference",
    labels=("cells through the height (1)", "deflection lost (1)"),
    rows={"state": ("plane_strain", "solid"), "nu_rubber": (0.45, 0.499)}, by="model",
    panel=("state", "nu_rubber"), log="xy", across=2,
    words=WORDS | {0.45: "nu = 0.45", 0.499: "nu = 0.499", HALVES: "half squares"},
)  # fmt: skip


def run(candidate: kit.DisplacementSolver, setting: kit.Setting) -> kit.Evidence:
    """Bend blocks near nu = 1/2, and judge them and who locks."""
    blocks = list_blocks(setting)
    kinds = list(dict.fromkeys((b.state, b.nu) for b in blocks))
    meshes = QUICK_MESHES if setting.quick else MESHES
    mixed = setting.sweep(partial(reference, meshes), kinds, "mixed elements")
    right = dict(zip(kinds, mixed, strict=True))
    found = setting.sweep(partial(deflection, candidate), blocks, "bent blocks")
    table = pd.DataFrame(
        dict(zip((*KIND, "cells_through"), block, strict=True))
        | {"deflection": value, "deflection_mixed": right[block[:2]].work}
        | {"deflection_uncertainty": right[block[:2]].uncertainty}
        for block, value in zip(blocks, found, strict=True)
    )
    table["deflection_difference"] = table["deflection"] / table["deflection_mixed"] - 1
    return judge_blocks(table)


def judge_blocks(table: pd.DataFrame) -> kit.Evidence:
    """What the table `rubber` says."""
    locks = locking(table)
    p1 = kit.Tolerance(
        "triangular lattice with its triangles' volumes, plane strain: stiffness from P1's, "
        "relative to its largest entry", 1e-12, "1",
        "springs are P1 elements of λ = μ, and a linear element's dilatation is its area's: an "
        "identity; left is rounding",
        observed=kit.farthest_value([differ_from_p1(nu) for nu in RATIOS["plane_strain"]], 0.0),
    )  # fmt: skip
    return kit.Evidence(
        {"rubber": table, "rubber_locking": locks},
        tolerances=(*RULES, p1),
        figures={"rubber": FIGURE},
        columns=kit.columns(__file__),
        findings=findings(table, locks),
    )


def list_blocks(setting: kit.Setting) -> list[Bent]:
    """Every block, the sizes of one kind one after another."""
    sizes = QUICK if setting.quick else SIZES
    found = []
    for state, ratios in RATIOS.items():
        d = 3 if state == "solid" else 2
        lattices = LATTICES[d][:1] if setting.quick else LATTICES[d]
        models = (*lattices, *ELEMENTS[d]) + ((HALVES,) if state == "plane_strain" else ())
        found += [
            Bent(state, nu, model, n)
            for nu in ((0.45, 0.499) if setting.quick else ratios)
            for model in models
            for n in (sizes[d] if model in LATTICES[d] else [c for c in sizes[d] if c <= 16])
        ]
    return found


def locking(table: pd.DataFrame) -> pd.DataFrame:
    """The table `rubber_locking`."""
    fine = table[
        (table["nu_rubber"] > RUBBER) & (table["cells_through"] == table["state"].map(FINE))
    ]
    rows = []
    for (state, model), mine in fine.groupby(["state", "model"], sort=False):
        ends = mine.sort_values("nu_rubber", kind="stable")["deflection_difference"]
        lost = ends.iloc[-1] - ends.iloc[0]
        rows.append(
            {"state": state, "model": model, "volumes_a_freedom": CONDITIONS[str(model)]}
            | {"lost": lost, "locks": "yes" if lost < -LOCKS else "no"}
        )
    return pd.DataFrame(rows)


def differ_from_p1(nu: float) -> float:
    """Largest difference in stiffness of triangles with volumes from linear elements on them."""
    lattice = stretch.body("triangular")
    mesh = reference_fem.make_discretisation(lattice.points, lattice.cells, "P1")
    order = np.arange(lattice.points.size).reshape(-1, 2).T.ravel()
    material = kit.Isotropic(1.0, nu, "plane_strain")
    problem = stretch.pull_loads(lattice, material)
    network = lattice_network(problem, lattice, calibrate_material(material, lattice))
    K = stiffness(mesh, material)
    own = tangent(network, network.points)[order][:, order]
    return float(abs(own - K).max() / abs(K).max())


def findings(table: pd.DataFrame, locks: pd.DataFrame) -> tuple[str, ...]:
    """How far off every model is at the largest ratio, and who locks."""
    sentences = []
    for state, mine in table.groupby("state", sort=False):
        nu = mine["nu_rubber"].max()
        finest = mine[mine["nu_rubber"] == nu].groupby("model", sort=False).last().reset_index()
        differences = ", ".join(
            f"{row['model']} {row['deflection_difference']:+.2%} ({row['cells_through']} cells)"
            for _, row in finest.iterrows()
        )
        sentences.append(
            f"Bent blocks in {WORDS[str(state)]} at nu = {nu:g}, deflection against "
            f"{'Q2' if state == 'plane_stress' else 'mixed'} elements: {differences}."
        )
    locked = list(dict.fromkeys(locks["model"][locks["locks"] == "yes"]))
    free = "; ".join(m for m in locks["model"].unique() if m in SPRINGS and m not in locked)
    sentences.append(
        f"Volume energy of whole cells that does not lock: {free or 'none'}. What locks, in plane "
        f"strain and space: {'; '.join(locked)}. Equilateral triangles with a volume each are P1 "
        "elements exactly, and lock as those do."
    )
    return tuple(sentences)
