"""Version 2: what was wrong in version 1, mended from its files alone.

    python -m cases.make errata

The answers of the programs are not needed: version 1 keeps what each told of its own error and how
far the two ways are apart.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases.make.answer import Answer
from cases.make.balance import known_by_balance
from cases.make.closed_forms import closed_form
from cases.make.confirmed import (
    ELEMENTS,
    SAFETY,
    Confirmation,
    as_stated,
    own_uncertainty,
    rounded_up,
)
from cases.make.files import (
    case_toml,
    cells_csv,
    confirmed_csv,
    displacement_csv,
    nodal_meshes,
    quantities_csv,
)
from cases.make.statements import Statement
from cases.make.versions import Row, home, homes, read_answers, read_rows

TEXT = Path(__file__).with_name("errata.md")
"""Of ERRATA.md, with places for numbers."""


def mended(chosen: Iterable[Statement]) -> tuple[dict[str, bytes], list[Confirmation]]:
    """Name -> content of the files that differ from version 1's, and what confirms the values."""
    table = read_rows("confirmed.csv", homes(1))
    rows: list[Confirmation] = []
    files: dict[str, bytes] = {}
    for statement in chosen:
        own = [_confirmation(statement, r) for r in table if r["case"] == statement.name]
        answers = {}
        for nu, old in read_answers(statement, homes(1)).items():
            exact = closed_form(statement, nu)
            answer = old if exact is None else replace(exact, order=old.order, nodes=old.nodes)
            answers[nu] = as_stated(answer, [row for row in own if row.nu == nu])
        rows += own
        files |= {f"{statement.name}/{k}": v for k, v in _files(statement, answers).items()}
    files["confirmed.csv"] = confirmed_csv(rows)
    return {k: v for k, v in files.items() if v != (home(1) / k).read_bytes()}, rows


def _files(statement: Statement, answers: dict[float, Answer]) -> dict[str, bytes]:
    """The files of a case that errata may change."""
    files = {"quantities.csv": quantities_csv(statement, answers)}
    if all(answer.exact for answer in answers.values()):
        files["displacement.csv"] = displacement_csv(statement, answers)
    if "[[region]]" in statement.text:
        files["case.toml"] = case_toml(statement).encode()
        files |= {f"{mesh.kind}_cells.csv": cells_csv(mesh) for mesh in nodal_meshes(statement)}
    return files


def _confirmation(statement: Statement, row: Row) -> Confirmation:
    """A row of version 1's table, by the rule of version 2."""
    way, second, told = row["by"], row["other by"], float(row["estimate"])
    return Confirmation(
        row["case"], float(row["nu"]), row["quantity"], float(row["size"]), way, second,
        own_uncertainty(way, told), own_uncertainty(second, float(row["other uncertainty"])),
        float(row["difference"]),
        way == ELEMENTS and known_by_balance(statement, row["quantity"], told),
    )  # fmt: skip


def _off_by_rounding(chosen: Iterable[Statement]) -> tuple[int, int]:
    """Components of displacements and of quantities that version 1 rounded too far."""
    moves = quantities = 0
    for statement in chosen:
        for nu, old in read_answers(statement, homes(1)).items():
            exact = closed_form(statement, nu)
            if exact is None:
                continue
            away = np.abs(exact.displacement - old.displacement)
            moves += int((away > old.uncertainty["displacement"]).sum())
            for key, value in exact.quantities.items():
                off = np.abs(value - old.quantities[key])
                quantities += int((off > old.uncertainty[key]).sum())
    return moves, quantities


def errata_text(chosen: Iterable[Statement], rows: list[Confirmation]) -> str:
    """What was wrong, by how much, and who found it."""
    moved, moved_quantities = _off_by_rounding(chosen)
    table = read_rows("confirmed.csv", homes(1))
    old = {(r["case"], float(r["nu"]), r["quantity"]): float(r["uncertainty"]) for r in table}
    told = {row: old[row.case, row.nu, row.quantity] for row in rows}
    elements = [row for row in rows if row.way == ELEMENTS]
    moves = [row for row in elements if row.quantity == "displacement"]
    failed = [
        r for r in table
        if float(r["difference"]) > float(r["estimate"]) + float(r["other uncertainty"])
    ]  # fmt: skip
    return TEXT.read_text(encoding="utf-8").format(
        beyond=sum(row.difference > told[row] for row in moves),
        displacements=len(moves),
        worst=max(row.difference / told[row] for row in moves),
        safety=SAFETY,
        widened=sum(row.stated > rounded_up(row.own) for row in elements),
        all=len(elements),
        balanced=sum(row.balanced for row in rows),
        moved=moved,
        moved_quantities=moved_quantities,
        failed="; ".join(f"{r['case']} of ratio {r['nu']}, {r['quantity']}" for r in failed),
        confirmed=sum(row.is_confirmed for row in rows),
        all_ways=len(rows),
    )


def unchanged(files: dict[str, bytes]) -> dict[str, bytes]:
    """Name -> content of version 1's files that stay."""
    there = [path for path in home(1).rglob("*") if path.is_file() and path.name != "SHA256SUMS"]
    named = {path.relative_to(home(1)).as_posix(): path for path in there}
    return {name: path.read_bytes() for name, path in named.items() if name not in files}
