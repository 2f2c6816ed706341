"""Held: are programs that must agree held to agree?

Question   Does an element program of order 3 or more answer elasticity, and do bonds of another
           program come to rest where our springs of the same constants do?
Candidate  NGSolve and LAMMPS, asked through files as every simulator is (`make simulators`).
Reference  Displacements of the frozen set; our springs, along their present direction.
Expected   0.0 % from order 3 on, at clamped ends and in bending too; 1e-6 of the largest
           displacement between the two networks, at small strain and at a large one.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pandas as pd

from msvalidate import kit

from .gaps import ASKED_RATIO

DATA = Path(__file__).parent / "data" / "held"
HIGH = 3
"""Order from which elements are held."""
PRINTED = 5e-4
"""What is 0.0 % when it is printed."""
UNIFORM = "block"
"""Cases between rollers, of uniform stress, begin so."""
NEAR = 1e-6
"""Of LAMMPS and our springs, over the largest displacement."""
ELEMENTS = {
    "simulator": "program, version",
    "case": "case of the frozen set",
    "asked_ratio": ASKED_RATIO,
    "order": "of the elements",
    "cells": "hexahedra",
    "error": "largest difference from elasticity, over the largest displacement (1)",
    "known": "how well elasticity is known there, over the largest displacement (1)",
    "date": "of the record; after six months it is to be made again",
}
SPRINGS = {
    "simulator": "program, version",
    "lattice": "of the springs",
    "strain": "traction at the end over the modulus (1); half as much shears",
    "points": "of the network",
    "springs": "of the network",
    "moved": "largest displacement, m",
    "difference": "largest difference from our springs, over the largest displacement (1)",
    "linear": "the same from our springs along their first direction",
    "residual": "largest force on a free point, over the largest load on one (1), as stated",
    "date": "of the record; after six months it is to be made again",
}


def run() -> kit.Evidence:
    """Both tables of records."""
    elements, springs = _record("elements"), _record("springs")
    program = f"{elements['simulator']} {elements['version']}"
    bonds = f"LAMMPS {springs['versions']['LAMMPS']}"
    rows = [
        [program, b["case"], b["nu"], b["order"], b["cells"], b["error"], b["known"],
         elements["date"]] for b in elements["bodies"]
    ]  # fmt: skip
    others = [
        [bonds, *(b[name] for name in list(SPRINGS)[1:-1]), springs["date"]]
        for b in springs["bodies"]
    ]
    tables = {
        "held_elements": pd.DataFrame(rows, columns=[*ELEMENTS]),
        "held_springs": pd.DataFrame(others, columns=[*SPRINGS]),
    }
    return kit.Evidence(
        tables=tables,
        tolerances=judge(elements["bodies"], springs["bodies"]),
        columns=ELEMENTS | SPRINGS,
    )


def judge(
    elements: list[dict[str, Any]], springs: list[dict[str, Any]]
) -> tuple[kit.Tolerance, ...]:
    """Elements by their order, in cases of uniform stress and others; springs by their laws."""
    high = [body for body in elements if body["order"] >= HIGH]
    uniform = [body["error"] for body in high if body["case"].startswith(UNIFORM)]
    low = [body for body in elements if body["order"] == 1]
    as_good = [b for b in low if not b["case"].startswith(UNIFORM) and b["error"] <= PRINTED]
    straight = [body for body in springs if body["linear"] <= NEAR]
    return (
        kit.Tolerance(
            "held: largest error of NGSolve from order 3 on, over the largest displacement",
            PRINTED, "1", "0.0 % in print; cells shrink towards what is singular at corners",
            observed=kit.Observed(max(body["error"] for body in high)),
        ),
        kit.Tolerance(
            "held: the same between rollers, in uniform stress", 1e-9, "1",
            "exact in every element: rounding of one solve, 1e-16 times a condition of 1e6",
            observed=kit.Observed(max(uniform)),
        ),
        kit.Tolerance(
            "held: bodies that bend and on which order 1 is as good", 0, "1",
            "else the comparison would not see what is not resolved",
            observed=kit.Observed(float(len(as_good))),
        ),
        kit.Tolerance(
            "held: largest difference of LAMMPS and our springs, over the largest displacement",
            NEAR, "1", "both stop where forces on free points are below 1e-12 of the largest load, "
            "and a body gives way some thousand times more than one spring",
            observed=kit.Observed(max(body["difference"] for body in springs)),
        ),
        kit.Tolerance(
            "held: networks that springs along their first direction describe as well", 0, "1",
            "else the comparison would not see that directions change",
            observed=kit.Observed(float(len(straight))),
        ),
    )  # fmt: skip


def _record(name: str) -> dict[str, Any]:
    found: dict[str, Any] = json.loads((DATA / f"{name}.json").read_text(encoding="utf-8"))
    return found
