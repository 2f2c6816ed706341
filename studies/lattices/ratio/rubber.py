"""Rubber: do springs with the volume energy lock as nu goes to 1/2?

Question   Deflection of a block held at its left side and sheared at its right one, so that it
           bends, of small strain, for nu to 0.4999: its difference from elasticity, and its order.
Candidate  Square and cubic lattices with κ of every cell's volume.
Reference  Mixed finite elements (displacement of the second degree, pressure of the first) on three
           graded meshes, extrapolated; in plane stress, where nothing locks, Q2. Beside it
           displacement elements on the lattice's own cells.
Expected   The order that the clamped side's end allows, or more while bending leaves more, up to 2,
           for any nu: lattices of one volume a cell do not lock.
"""

from __future__ import annotations

from functools import cache, partial
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.judging.candidate import DisplacementSolver
from msvalidate.judging.compare import farthest_value, observed_order
from msvalidate.judging.evidence import Evidence, Tables, Tolerance, by_quantity, merge
from msvalidate.judging.singularity import clamped_free_exponent
from msvalidate.judging.sweep import Setting
from msvalidate.output import figures
from msvalidate.problem import Isotropic
from msvalidate.problem.material import State
from reference_fem.elasticity import elastic_tensor

from .. import cases, elastic
from . import locking
from .bent import (
    ELEMENTS,
    HALVES,
    LATTICES,
    RATIOS,
    SPRINGS,
    Bent,
    deflection,
    reference,
)
from .locking import FINE

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
"""Words for the models in the figure."""
QUICK_RATIOS: dict[State, tuple[float, ...]] = {
    "plane_strain": (0.45, 0.499),
    "plane_stress": (0.45, 0.499),
    "solid": (0.45, 0.499),
}
SIZES = {2: (4, 8, 16, 32), 3: (2, 4, 8)}
QUICK = {2: (4, 8, 16), 3: (2, 4)}
"""Cells through the height."""
MESHES = {2: (8, 16, 32), 3: (2, 4, 8)}
QUICK_MESHES = {2: (3, 6, 12), 3: (1, 2, 4)}
"""Of the reference, cells through the height, graded to the corners."""
WORDS = {"plane_strain": "plane strain", "plane_stress": "plane stress", "solid": "space"}
TOLERANCES = (
    Tolerance(
        "deflection by mixed elements: uncertainty, relative", 0.01, "1",
        "half of what an extrapolation adds, 2 % on 4 cells of a cube at most: a tenth of the "
        "lattices' difference there",
    ),
    Tolerance(
        "volume energy: orders of the finest pair, out of twice the clamped end's exponent to 2",
        0.03, "1",
        "the end adds an error of the first, bending one of order 2, both of one sign: the order "
        "of their sum lies between. The reference is uncertain by 1 % of the difference in the "
        "plane, by 2 % on the cube: log2(1.02) = 0.03. Where a quarter is missing, orders by "
        "deflection and by stiffness differ: one of them, or what is between, has to lie there",
    ),
)  # fmt: skip
COLUMNS = {
    "state": "plane_stress or plane_strain in the plane, solid in space",
    "nu_rubber": "Poisson's ratio of the nearly incompressible material (1)",
    "model": "lattice with the volume energy of its cells, or of their halves, or a displacement "
    "element on as many cells",
    "cells_through": "cells through the height of the bent block",
    "deflection": "mean displacement of the loaded side along the load, of 1 N/m² on a modulus of "
    "1 Pa (m)",
    "deflection_mixed": "the same of the elastic body by mixed elements, Q2 in plane stress, "
    "extrapolated (m)",
    "deflection_uncertainty": "of deflection_mixed, relative: half of what extrapolation added (1)",
    "deflection_difference": "deflection over deflection_mixed, less 1 (1)",
    "twice_exponent_rubber": "twice the exponent of the displacement where the clamped side ends, "
    "in space of a section across it (1)",
    "rubber_order": "slope of log|deflection_difference| against log(1/cells_through) between the "
    "finest two sizes (1)",
    "rubber_order_stiffness": "the same of deflection_mixed over deflection, less 1: the part by "
    "which the block is too stiff (1)",
    "order_outside": "by how much both orders lie below twice_exponent_rubber or above 2, 0 if "
    "neither (1)",
}


def blocks(setting: Setting) -> list[Bent]:
    """Every block, the sizes of one kind one after another."""
    ratios, sizes = (QUICK_RATIOS, QUICK) if setting.quick else (RATIOS, SIZES)
    found = []
    for state, values in ratios.items():
        d = 3 if state == "solid" else 2
        lattices = LATTICES[d][:1] if setting.quick else LATTICES[d]
        models = (*lattices, *ELEMENTS[d]) + ((HALVES,) if state == "plane_strain" else ())
        found += [
            Bent(state, nu, model, n)
            for nu in values
            for model in models
            for n in (sizes[d] if model in LATTICES[d] else [c for c in sizes[d] if c <= 16])
        ]
    return found


def run(candidate: DisplacementSolver, setting: Setting) -> Evidence:
    """Bend blocks near nu = 1/2, and judge them."""
    wanted = blocks(setting)
    kinds = list(dict.fromkeys((b.state, b.nu) for b in wanted))
    meshes = QUICK_MESHES if setting.quick else MESHES
    mixed = setting.sweep(partial(reference, meshes), kinds, "mixed elements")
    found = setting.sweep(partial(deflection, candidate), wanted, "bent blocks")
    table = measure(wanted, found, dict(zip(kinds, mixed, strict=True)))
    orders = approach(table)
    outside = orders["order_outside"][orders["model"].isin(SPRINGS)]
    values = (farthest_value(table["deflection_uncertainty"], 0.0), farthest_value(outside, 0.0))
    bending = Evidence(
        tables={"rubber": table, "rubber_orders": orders},
        observed=by_quantity(TOLERANCES, values),
        tolerances=TOLERANCES,
        figures={"rubber": draw},
        columns=COLUMNS,
        rounding={"deflection": 1e-8, "deflection_mixed": 1e-6, "deflection_uncertainty": 1e-8}
        | {"deflection_difference": 1e-7}
        | dict.fromkeys(("rubber_order", "rubber_order_stiffness", "order_outside"), 1e-4),
        findings=findings(table),
    )
    return merge(bending, locking.run(table))


def measure(
    wanted: list[Bent], found: list[float], mixed: dict[tuple[State, float], elastic.Reference]
) -> pd.DataFrame:
    """The table `rubber`."""
    rows: list[dict[str, Any]] = []
    for block, value in zip(wanted, found, strict=True):
        right = mixed[block.state, block.nu]
        rows.append(
            dict(zip(("state", "nu_rubber", "model", "cells_through"), block, strict=True))
            | {
                "deflection": value,
                "deflection_mixed": right.work,
                "deflection_uncertainty": right.uncertainty,
                "deflection_difference": value / right.work - 1,
            }
        )
    return pd.DataFrame(rows)


def approach(table: pd.DataFrame) -> pd.DataFrame:
    """The table `rubber_orders`."""
    rows: list[dict[str, object]] = []
    for (state, nu, model), mine in table.groupby(["state", "nu_rubber", "model"], sort=False):
        pair = mine.iloc[-2:]
        lacking = pair["deflection_difference"]
        low = end_order(str(state), pair["nu_rubber"].iloc[0])
        by_deflection, by_stiffness = (
            observed_order(1 / pair["cells_through"], part)
            for part in (lacking, lacking / (1 + lacking))
        )
        rows.append(
            {"state": state, "nu_rubber": nu, "model": model, "twice_exponent_rubber": low}
            | {"rubber_order": by_deflection, "rubber_order_stiffness": by_stiffness}
            | {"order_outside": outside(by_deflection, by_stiffness, low)}
        )
    return pd.DataFrame(rows)


def outside(one: float, other: float, low: float) -> float:
    """By how much all from one order to the other lies below `low` or above 2; 0 if it does not."""
    return max(0.0, low - max(one, other), min(one, other) - 2)


@cache
def end_order(state: str, nu: float) -> float:
    """Twice the exponent of the displacement at the clamped side's end."""
    plane: State = "plane_stress" if state == "plane_stress" else "plane_strain"
    return 2 * clamped_free_exponent(elastic_tensor(Isotropic(1.0, nu, plane)), np.pi / 2)


def findings(table: pd.DataFrame) -> tuple[str, ...]:
    """How far off every model is at the largest ratio."""
    said = []
    for state, mine in table.groupby("state", sort=False):
        nu = mine["nu_rubber"].max()
        finest = mine[mine["nu_rubber"] == nu].groupby("model", sort=False).last().reset_index()
        told = ", ".join(
            f"{row['model']} {row['deflection_difference']:+.2%} ({row['cells_through']} cells)"
            for _, row in finest.iterrows()
        )
        said.append(
            f"Bent blocks in {WORDS[str(state)]} at nu = {nu:g}, deflection against "
            f"{'Q2' if state == 'plane_stress' else 'mixed'} elements: {told}."
        )
    return tuple(said)


def draw(tables: Tables) -> Figure:
    """Differences against the ratio at one size, and against the size at the largest ratio."""
    table = tables["rubber"]
    states = [s for s in ("plane_strain", "solid") if s in set(table["state"])]
    figure, axes = figures.new_figure(2, len(states), size=(3.3, 2.9), sharey=True)
    models = list(dict.fromkeys(table["model"]))
    for (left, right), state in zip(zip(axes[::2], axes[1::2], strict=True), states, strict=True):
        mine = table[table["state"] == state]
        size, most = FINE[3 if state == "solid" else 2], mine["nu_rubber"].max()
        for model, own in mine.groupby("model", sort=False):
            style = cases.style(models.index(str(model)))
            label = MODELS.get(str(model), str(model))
            fine, last = own[own["cells_through"] == size], own[own["nu_rubber"] == most]
            gap = fine["deflection_difference"].abs()
            left.loglog(1 - 2 * fine["nu_rubber"], gap, label=label, **style)
            right.loglog(
                last["cells_through"], last["deflection_difference"].abs(), label=label, **style
            )
        left.set_xlabel("1 - 2 nu (1)")
        cells = np.array(sorted(set(mine["cells_through"])), dtype=float)
        right.set_xticks(cells, [f"{n:g}" for n in cells])
        right.set_xlabel("cells through the height (1)")
        words = WORDS[state]
        left.set_title(f"{words}, {size} cells")
        right.set_title(f"{words}, nu = {most:g}")
        left.set_ylabel("deflection lost (1)")
    figure.suptitle("Bent blocks near nu = 1/2: what locks")
    figures.add_shared_legend(figure, axes, columns=2)
    return figure
