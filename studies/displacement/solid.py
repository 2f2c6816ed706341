"""Solid: how far are cubes and a bar of springs from the elastic solid, and why?

Question   Displacement of the loaded side of a clamped cube under shear and under pressure and of a
           cantilever 4 x 1 x 1, by the number of cells through the height.
Candidate  Linear equilibrium of the spring network, edges and faces shared.
Reference  Finite elements at vanishing spacing: the lattice's own cubic body, isotropic targets;
           for the cantilever beam theory.
Expected   Against its own body every lattice converges. The springs have order 2 where the body is
           smooth; the edges of a clamped side have a singular stress, which leaves a part of order
           2λ, λ = 0.745 of the edge (nu = 1/4, in planes across it strain is plane). Between the
           two lies the order that is seen; below 2λ where the two parts have opposite signs, as
           under pressure. Corners of the clamped side add a part of higher order; edges of the
           sheared side, where its traction ends at a free side, an error next to them. Of the
           cantilever's difference (19/20)/N² is the bar's stiffness in bending. Against an
           isotropic target an anisotropic lattice does not converge: its form is wrong.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd

from msvalidate.judging.candidate import DisplacementSolver, solve_springs
from msvalidate.judging.compare import farthest_value
from msvalidate.judging.evidence import Evidence, Observed, Tolerance, by_quantity
from msvalidate.judging.singularity import clamped_edge_exponent
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.problem import Array, Isotropic
from reference_fem.elasticity import elastic_tensor

from . import load_cases, orders, solid_drawing, target
from .bent_bar import section_stiffness
from .identities import COLUMNS as IDENTITIES
from .load_cases import BAND, MODULUS
from .solid_bodies import (
    CASES,
    COARSEST,
    DRAWN,
    LENGTH,
    MODELS,
    QUICK_COARSEST,
    SMOOTH,
    ElasticSolid,
    Moved,
    SolidCase,
    elastic_body,
    spring_body,
    targets,
)

QUICK_SIZES, CUBE_SIZES, BAR_SIZES = (2, 4, 8), (2, 4, 8, 16), (2, 4, 8, 12)
"""Cells through the height."""
QUICK_BODIES = (
    ("cube, shear", "cubic 18"),
    ("cube, shear", "cubic 26"),
    ("cube, pressure", "cubic 18"),
    ("cantilever", "cubic 18"),
)
SHAPE_FACTOR = 5 / 6
"""κ of a rectangular section in shear [Reissner1945]."""
CONVERGED = 5e-3
TOLERANCES = (
    Tolerance(
        "clamped cubes: order towards their own body, finest pair", 0.2, "1",
        "the edges' 2λ; the smooth part, of order 2, is a fifth of theirs at 8 cells with either "
        "sign and bends a pair by up to 0.15",
    ),
    Tolerance(
        "cantilever: order towards its own body, part of the way from 2λ to 2", 0.5, "1",
        "the smooth part, the bar's bending, and the clamp's edges have the same sign: the order "
        "is somewhere between theirs, and this holds it from both sides",
    ),
    Tolerance(
        "solids, isotropic springs, 8 cells: against their own body", BAND, "1",
        "the band of the plane: springs of the right constants stand for the body they are for",
        layer="agreement",
    ),
    Tolerance(
        "cantilever: FEM against beam theory, relative", 0.03, "1",
        "a beam's sections are free to contract, a clamped one is not: the modulus there is up to "
        "C11 = 1.2 E, over about a quarter of the height, where 3/16 of the bending energy is; a "
        "sixth of that",
    ),
    Tolerance(
        "solids: uncertainty of FEM, relative", CONVERGED, "1",
        "what the question asks of it: a sixth of the sheared cube's difference at 8 cells; cells "
        "in space stop where they get dear, and the weakest edge, of cubic 26, takes nearly all",
    ),
)  # fmt: skip
COLUMNS = {
    **load_cases.COLUMNS,
    "cells_high": IDENTITIES["cells_high"],
    "side_springs": "mean displacement of the loaded side along the load, of the candidate (m)",
    "side_homogenised": "the same of the lattice's own cubic body, by FEM (m)",
    "side_target": "the same of the target, by FEM (m)",
    "against_own_body": target.COLUMNS["against_own_body"],
    "fem_uncertainty": "largest estimated relative error of the FEM values in the row (1)",
    "side_order": "power of the spacing with which against_own_body falls from the row above, or a "
    'word: "coarsest" (nothing above), "not resolved" or "not asymptotic" as in the plane (1)',
    "twice_edge_exponent": "twice the displacement's exponent at an edge of the clamped side (1)",
    "target": target.COLUMNS["target"],
    "E_solid": "Young's modulus of the target (Pa)",
    "nu_solid": "Poisson's ratio of the target (1)",
    "model_form": target.COLUMNS["model_form"],
    "with_model_form": target.COLUMNS["with_model_form"],
    "reckoned": "how the deflection of the cantilever's end is found",
    "end_deflection": "mean deflection of the cantilever's loaded side (m)",
    "over_fem": "end_deflection over that of FEM, less 1 (1)",
    **solid_drawing.COLUMNS,
}
Key = tuple[str, str]
"""(load case, model)."""


def run(candidate: DisplacementSolver = solve_springs, setting: Setting = FULL) -> Evidence:
    """Compare the candidate's cubes and bars with elastic bodies."""
    keys = list(QUICK_BODIES if setting.quick else [(c, m) for c in CASES for m in MODELS])
    asked = [(case, MODELS[model].tensor) for case, model in keys]
    isotropic = dict(list(targets(MODELS["cubic 26"]).items())[: 1 if setting.quick else None])
    asked += [("cube, shear", elastic_tensor(material)) for material in isotropic.values()]
    start = QUICK_COARSEST if setting.quick else COARSEST
    found = setting.sweep(partial(elastic_body, start), asked, "elastic solids")
    own, of_targets = dict(zip(keys, found, strict=False)), found[len(keys) :]
    todo = [(*key, n) for key in keys for n in sizes(setting, CASES[key[0]])]
    moved = dict(
        zip(todo, setting.sweep(partial(measure, candidate), todo, "spring solids"), strict=True)
    )
    table = pd.DataFrame([row for key in keys for row in rows(key, own[key], moved)])
    tables = {
        "solid": table,
        "solid_target": target_table(table, isotropic, of_targets),
        "cantilever": cantilever(own["cantilever", "cubic 18"], table),
        "solid_shape": solid_drawing.shapes(own, moved),
    }
    return Evidence(
        tables=tables,
        observed=observe(tables),
        tolerances=TOLERANCES,
        figures={
            "solid": solid_drawing.convergence,
            "solid_shape": solid_drawing.deformed,
        },
        columns=COLUMNS,
        findings=findings(tables),
    )


def sizes(setting: Setting, case: SolidCase) -> tuple[int, ...]:
    """Cells through the height of a case's bodies."""
    if setting.quick:
        return QUICK_SIZES
    return CUBE_SIZES if case.length == 1 else BAR_SIZES


def measure(candidate: DisplacementSolver, asked: tuple[str, str, int]) -> Moved:
    """One spring body: of a load case, a model, and cells through the height."""
    case, model, cells = asked
    return spring_body(candidate, MODELS[model], CASES[case], cells)


def rows(
    key: Key, own: ElasticSolid, moved: dict[tuple[str, str, int], Moved]
) -> list[dict[str, object]]:
    """Rows of the table `solid` for one load case and model, coarsest first."""
    doubt = own.uncertainty / own.mean
    twice = 2 * clamped_edge_exponent(MODELS[key[1]].tensor)
    found: list[dict[str, object]] = []
    before: tuple[int, float] | None = None
    for (case, model, cells), body in moved.items():
        if (case, model) != key:
            continue
        away = body.mean / own.mean - 1
        order: float | str = "coarsest"
        if before is not None:
            order = orders.order(before[1], away, cells / before[0], doubt)
        row: dict[str, object] = {"case": case, "lattice": model, "cells_high": cells}
        row |= {"side_springs": body.mean, "side_homogenised": own.mean, "against_own_body": away}
        found.append(
            row | {"fem_uncertainty": doubt, "side_order": order, "twice_edge_exponent": twice}
        )
        before = cells, away
    return found


def target_table(
    table: pd.DataFrame, materials: dict[str, Isotropic], bodies: list[ElasticSolid]
) -> pd.DataFrame:
    """The sheared cube of cubic 26 against isotropic bodies."""
    sheared = table[(table["case"] == "cube, shear") & (table["lattice"] == "cubic 26")]
    found = []
    for (name, material), body in zip(materials.items(), bodies, strict=True):
        for row in sheared.to_dict("records"):
            own = row["side_homogenised"]
            doubt = max(row["fem_uncertainty"], body.uncertainty / body.mean)
            head = {key: row[key] for key in ("case", "lattice", "cells_high")}
            head |= {"target": name, "E_solid": material.E, "nu_solid": material.nu}
            head |= {"side_target": body.mean, "against_own_body": row["against_own_body"]}
            head |= {"model_form": own / body.mean - 1}
            head |= {"with_model_form": row["side_springs"] / body.mean - 1}
            found.append(head | {"fem_uncertainty": doubt})
    return pd.DataFrame(found)


def cantilever(own: ElasticSolid, solids: pd.DataFrame) -> pd.DataFrame:
    """The cantilever of cubic 18: beam theory, FEM, springs, and beam theory for the springs."""
    model, case = MODELS["cubic 18"], CASES["cantilever"]
    force, inertia = abs(case.traction[1]), 1 / 12
    bending = force * LENGTH**3 / (3 * MODULUS * inertia)
    shear = force * LENGTH / (SHAPE_FACTOR * model.tensor[5, 5])
    ends = {
        "FEM": own.mean,
        "beam theory, PL³/(3EI)": bending,
        "beam theory, PL³/(3EI) + PL/(κGA)": bending + shear,
    }
    bars = solids[(solids["case"] == case.name) & (solids["lattice"] == model.name)]
    for row in bars.to_dict("records"):
        n = row["cells_high"]
        ends[f"springs, N = {n}"] = row["side_springs"]
        ends[f"beam theory, EI of N = {n} cells"] = bending / section_stiffness(n) + shear
    found = [
        {"reckoned": name, "end_deflection": end, "over_fem": end / own.mean - 1}
        for name, end in ends.items()
    ]
    return pd.DataFrame(found)


def observe(tables: dict[str, pd.DataFrame]) -> dict[str, Observed]:
    """The judged quantities, each the worst of its rows."""
    table = tables["solid"]
    last = table.groupby(["case", "lattice"], sort=False).tail(1)
    bars = last[last["case"] == "cantilever"]
    cubes = last.drop(bars.index)
    twice = bars["twice_edge_exponent"]
    eight = table[(table["cells_high"] == DRAWN) & (table["lattice"] == "cubic 18")]
    theory = tables["cantilever"].set_index("reckoned")["over_fem"]
    doubts = [*table["fem_uncertainty"], *tables["solid_target"]["fem_uncertainty"]]
    values = (
        farthest_value(_numbers(cubes["side_order"]), cubes["twice_edge_exponent"]),
        farthest_value((_numbers(bars["side_order"]) - twice) / (SMOOTH - twice), 0.5),
        farthest_value(eight["against_own_body"], 0.0),
        farthest_value(theory["beam theory, PL³/(3EI) + PL/(κGA)"], 0.0),
        farthest_value(doubts, 0.0),
    )
    return by_quantity(TOLERANCES, values)


def _numbers(values: pd.Series) -> Array:
    """Words, which are no order, as NaN."""
    return np.asarray(pd.to_numeric(values, errors="coerce"))


def findings(tables: dict[str, pd.DataFrame]) -> tuple[str, ...]:
    """What springs do to solids."""
    table = tables["solid"]
    isotropic = table[table["lattice"] == "cubic 18"].groupby("case", sort=False)
    seen = [
        f"{case} {100 * part['against_own_body'].iloc[0]:.1f} to "
        f"{100 * part['against_own_body'].iloc[-1]:.1f} % ({part['cells_high'].iloc[0]} to "
        f"{part['cells_high'].iloc[-1]} cells)"
        for case, part in isotropic
    ]
    turned = tables["solid_target"].groupby("target", sort=False)["with_model_form"]
    forms = [f"{100 * w.iloc[0]:.0f} to {100 * w.iloc[-1]:.0f} % ({name})" for name, w in turned]
    converge = f"Springs of cubic 18 are too stiff in solids and converge: {'; '.join(seen)}."
    target_decides = (
        "The sheared cube of cubic 26 with equal springs, Zener ratio 7/3, converges to its own "
        f"body and to no isotropic one: {'; '.join(forms)}."
    )
    return converge, target_decides
