"""The frozen versions as text, and how they are written: once, all files or none.

Version 2 holds the files that differ from version 1's alone: a file of it replaces that of 1.
"""

from __future__ import annotations

import csv
import hashlib
import os
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from cases.make.answer import Answer
from cases.make.closed_forms import closed_form
from cases.make.statements import Statement

Row = dict[str, str]
CASES = Path(__file__).resolve().parents[1]
VERSIONS = (1, 2)
"""All that are frozen, the last one the set's."""
SUMS = "SHA256SUMS"


def home(version: int = VERSIONS[-1]) -> Path:
    """The folder of a version."""
    return CASES / f"v{version}"


def set_path(name: str, version: int = VERSIONS[-1]) -> Path:
    """Where a file of the set is as of a version, such as "cook_plane_strain/displacement.csv"."""
    there = [home(v) / name for v in range(version, 0, -1)]
    return next((path for path in there if path.is_file()), there[-1])


def read_rows(name: str, version: int = VERSIONS[-1]) -> list[Row]:
    """Rows of a table of the set as of a version."""
    with set_path(name, version).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_answers(statement: Statement, version: int = VERSIONS[-1]) -> dict[float, Answer]:
    """What a version says of a case, by ratio."""
    tables = {
        name: read_rows(f"{statement.name}/{name}.csv", version)
        for name in ("displacement", "quantities", "made")
    }
    found = {}
    for nu in statement.ratios:
        own = {
            name: [row for row in rows if float(row["nu"]) == nu] for name, rows in tables.items()
        }
        answer = _answer(statement.dim, own)
        found[nu] = replace(answer, exact=version > 1 and closed_form(statement, nu) is not None)
    return found


def _answer(d: int, own: dict[str, list[Row]]) -> Answer:
    def columns(before: str, after: str = "") -> np.ndarray:
        names = [f"{before}u{axis}{after}" for axis in "xyz"[:d]]
        return np.array([[float(row[name]) for name in names] for row in own["displacement"]])

    quantities: dict[str, list[float]] = {}
    for row in own["quantities"]:
        if row["value"]:
            quantities.setdefault(row["quantity"], []).append(float(row["value"]))
    (made,) = own["made"]
    return Answer(
        columns(""),
        columns("E_d", "_dE"),
        columns("d", "_dnu"),
        {name: np.array(values) for name, values in quantities.items()},
        {row["quantity"]: float(row["uncertainty"]) for row in own["quantities"]},
        float(made["order seen"] or "nan"),
        int(made["nodes of the finest mesh of elements"]),
    )


def write_version(folder: Path, files: dict[str, bytes], older: dict[str, bytes]) -> None:
    """All files of a version at once, and checksums of the set: beside, then renamed.

    `older` are those of version 1 that stay, by name.
    """
    new = folder.with_name(f"{folder.name}.new-{os.getpid()}")
    for name, content in files.items():
        path = new / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (new / SUMS).write_text("".join(_sums(files, older)), encoding="utf-8")
    new.replace(folder)


def _sums(files: dict[str, bytes], older: dict[str, bytes]) -> Iterator[str]:
    everything = files | {f"../v1/{name}": content for name, content in older.items()}
    for name, content in sorted(everything.items(), key=lambda item: item[0].removeprefix("../v1/")):
        yield f"{digest(content)}  {name}\n"


def digest(content: bytes) -> str:
    """SHA-256, as text."""
    return hashlib.sha256(content).hexdigest()
