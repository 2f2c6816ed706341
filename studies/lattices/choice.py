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

from msvalidate import kit

from . import cases, solids
from .cases import Case

RULES = (
    kit.Rule(
        "known lattices and rules without a row", 0, "1",
        "lattices are found by what their functions return, not listed", table="lattices",
        value=lambda rows: len(cases.all_cases()) - len(rows.drop_duplicates(["lattice", "rule"])),
    ),
)  # fmt: skip


def run(tables: dict[str, pd.DataFrame]) -> kit.Evidence:
    """One table of the tables `solids`, `uniform`, `clamped`, `clamped_order` and `cost`."""
    found = pd.DataFrame([row(case, tables) for case in cases.all_cases()])
    return kit.Evidence(tables={"lattices": found}, tolerances=RULES, columns=kit.columns(__file__))


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
    for name, on_paper in zip(("E", "nu", "A"), closed, strict=True):
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
