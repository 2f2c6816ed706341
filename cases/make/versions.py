"""The frozen versions as text, and how they are written: once, all files or none.

Version 2 holds the files that differ from version 1's alone: a file of it replaces that of 1.
"""

from __future__ import annotations

import csv
import hashlib
import os
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from cases.make.answer import Answer
from cases.make.confirmed import Confirmation
from cases.make.statements import Statement

Row = dict[str, str]
CASES = Path(__file__).resolve().parents[1]
VERSIONS = (1, 2)
"""All that are frozen, the last one the set's."""
SUMS = "SHA256SUMS"


def home(version: int = VERSIONS[-1]) -> Path:
    """The folder of a version."""
    return CASES / f"v{version}"


def homes(version: int = VERSIONS[-1]) -> tuple[Path, ...]:
    """Folders of the set as of a version, newest first: the first that has a file counts."""
    return tuple(home(v) for v in range(version, 0, -1))


def set_path(name: str, folders: tuple[Path, ...]) -> Path:
    """Where a file of the set is, such as "cook_plane_strain/displacement.csv"."""
    there = [folder / name for folder in folders]
    return next((path for path in there if path.is_file()), there[-1])


def read_rows(name: str, folders: tuple[Path, ...]) -> list[Row]:
    """Rows of a table of the set."""
    with set_path(name, folders).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def read_answers(statement: Statement, folders: tuple[Path, ...]) -> dict[float, Answer]:
    """What the set says of a case, by ratio, as it is written."""
    tables = {
        name: read_rows(f"{statement.name}/{name}.csv", folders)
        for name in ("displacement", "quantities", "made")
    }
    found = {}
    for nu in statement.ratios:
        own = {
            name: [row for row in rows if float(row["nu"]) == nu] for name, rows in tables.items()
        }
        found[nu] = _answer(statement.dim, own)
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


def refuse_frozen(folder: Path) -> int:
    """2 with a word why, if a version is there; else 0."""
    if not folder.exists():
        return 0
    say(f"{folder.name}: frozen; it is never written again. Errata make a new version")
    return 2


def refuse_unconfirmed(rows: list[Confirmation]) -> int:
    """1 with a line each, if two ways contradict each other in a value; else 0."""
    wrong = [row for row in rows if not row.is_confirmed]
    for row in wrong:
        say(
            f"NOT CONFIRMED {row.case} nu {row.nu:g} {row.quantity}: {row.way} and "
            f"{row.second_way} are {row.difference:.2e} apart, and tell {row.own:.2e} and "
            f"{row.second_own:.2e} of themselves"
        )
    return 1 if wrong else 0


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
    for name, content in sorted(
        everything.items(), key=lambda item: item[0].removeprefix("../v1/")
    ):
        yield f"{digest(content)}  {name}\n"


def digest(content: bytes) -> str:
    """SHA-256, as text."""
    return hashlib.sha256(content).hexdigest()


def say(text: str) -> None:
    """A line of progress."""
    print(text, file=sys.stderr, flush=True)  # noqa: T201
