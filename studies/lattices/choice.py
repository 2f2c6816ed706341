"""Choice: which lattice to take?

Question   What each lattice is, how well bodies of it stand for that, and what they cost: a row a
           lattice and rule.
Candidate  What the other questions found.
Reference  The closed form beside the numerical constants and those of a body.
Expected   Every known lattice has its row.
"""

from __future__ import annotations

from typing import Any

import pandas as pd

from msvalidate.judging.evidence import Evidence, Observed, Tolerance

from . import cases, solids
from .cases import Case

NO_BODY = '"no body", "no corner point", "no box" or "mechanism", as in the column body of solids'
TOLERANCES = (
    Tolerance(
        "known lattices and rules without a row", 0, "1",
        "lattices are found by what their functions return, not listed",
    ),
)  # fmt: skip
MEANING = {"E": "modulus along x (N/m, Pa at a spacing of 1 m)", "nu": "Poisson's ratio (1)"}
MEANING["A"] = 'Zener\'s ratio, "none" where the solid is neither square nor cubic (1)'
COLUMNS = {
    **cases.COLUMNS,
    **{name: solids.COLUMNS[name] for name in ("E", "nu", "A", "isotropic", "omega2_m")},
    **{
        f"{name}_closed": f'{meaning}, from the closed form, "none" where there is none'
        for name, meaning in MEANING.items()
    },
    **{
        f"{name}_body": f"{meaning}, of the finest body under uniform stress, or {NO_BODY}"
        for name, meaning in MEANING.items()
    },
    **{
        f"{test}_difference": f"work of the load on the finest clamped body in {test}, over that "
        f"of the elastic body, less 1, or {NO_BODY} (1)"
        for test in ("pull", "shear")
    },
    **{
        f"{test}_order": f'order of this difference, or "not resolved", "not asymptotic", '
        f"{NO_BODY} (1)"
        for test in ("pull", "shear")
    },
    "springs_a_point": solids.COLUMNS["springs_a_point"],
    "rest_steps": f"steps to rest, as in the table cost, or {NO_BODY}",
}


def run(tables: dict[str, pd.DataFrame]) -> Evidence:
    """One table of the tables `solids`, `uniform`, `clamped`, `clamped_order` and `cost`."""
    found = pd.DataFrame([row(case, tables) for case in cases.all_cases()])
    missing = len(cases.all_cases()) - len(found.drop_duplicates(["lattice", "rule"]))
    return Evidence(
        tables={"lattices": found},
        observed={TOLERANCES[0].quantity: Observed(float(missing))},
        tolerances=TOLERANCES,
        columns=COLUMNS,
        rounding={"E_body": 1e-9, "nu_body": 1e-9, "A_body": 1e-9, "E": 1e-12, "E_closed": 1e-12}
        | {"nu_closed": 1e-12, "A_closed": 1e-12}
        | {"pull_difference": 1e-7, "shear_difference": 1e-7, "pull_order": 1e-4}
        | {"shear_order": 1e-4},
    )


def row(case: Case, tables: dict[str, pd.DataFrame]) -> dict[str, object]:
    """One row of the table `lattices`."""
    pattern = case.pattern
    own = one(tables["solids"], case)
    none = own["body"]
    found: dict[str, object] = case.head | {"axes": pattern.dim, "isotropic": own["isotropic"]}
    closed: tuple[float | str, ...] = ("none",) * 3
    if pattern.tensor is not None:
        tensor = pattern.tensor(case.constants)
        closed = solids.constants(tensor, cases.resists_shear(tensor))
    body = one(tables["uniform"], case)
    if body:
        body["E_body"] = body["E_over"] * own["E"]
        body |= {f"{name}_body": body[f"{name}_measured"] for name in ("nu", "A")}
    for name, on_paper in zip(MEANING, closed, strict=True):
        found |= {f"{name}_closed": on_paper, name: own[name]}
        found[f"{name}_body"] = body.get(f"{name}_body", none)
    for test in ("pull", "shear"):
        difference = one(tables["clamped"], case, test).get("difference", none)
        order = one(tables["clamped_order"], case, test).get("clamped_order", none)
        found |= {f"{test}_difference": difference, f"{test}_order": order}
    found |= {name: own[name] for name in ("omega2_m", "springs_a_point")}
    return found | {"rest_steps": one(tables["cost"], case).get("steps", none)}


def one(table: pd.DataFrame, case: Case, test: str | None = None) -> dict[str, Any]:
    """The last row of a case, and of a test of it; nothing where it has none."""
    mine = table[(table["lattice"] == case.pattern.name) & (table["rule"] == case.rule)]
    if test is not None:
        mine = mine[mine["test"] == test]
    return {str(key): value for key, value in mine.iloc[-1].items()} if len(mine) else {}
