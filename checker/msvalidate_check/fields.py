"""Displacements in files: .csv and .npz."""

from __future__ import annotations

import csv
import zipfile
from pathlib import Path

import numpy as np

from msvalidate_check.errors import CheckError

Array = np.ndarray
LARGEST = 500_000_000
"""Bytes beyond which a file is not read."""
MOST_NUMBER = 2**53
"""Number of a node from which not each whole number is one of double precision."""
AXES = "xyz"


def read_field(path: Path) -> tuple[Array | None, Array, float | None]:
    """Points (n, d) or numbers (n,) or None, displacements (n, d), and how far they are from rest.

    Parameters
    ----------
    path
        .csv with a header: ux, uy (and uz), and x, y (and z) at rest or id. .npz with
        "displacement", and "points" or "id"; "at_rest", if it is known.

    Raises
    ------
    CheckError
        If there is no such file, or it holds no such numbers.
    """
    try:
        if path.stat().st_size > LARGEST:
            raise CheckError(f"{path.name}: {path.stat().st_size:g} bytes; the most is {LARGEST:g}")
        if path.suffix.lower() == ".npz":
            return _npz(path)
        if path.suffix.lower() == ".csv":
            return _csv(path)
    except (OSError, ValueError, zipfile.BadZipFile, EOFError) as error:
        if isinstance(error, CheckError):
            raise
        why = getattr(error, "strerror", None) or str(error).splitlines()[0]
        raise CheckError(
            f"{path.name}: {why}; give a .csv or .npz file of displacements"
        ) from error
    raise CheckError(f"{path.name or path}: give a .csv or .npz file")


def _npz(path: Path) -> tuple[Array | None, Array, float | None]:
    with np.load(path, allow_pickle=False) as file:
        if "displacement" not in file.files:
            known = ", ".join(file.files) or "nothing"
            raise CheckError(f"{path.name}: it holds {known}; name the displacements displacement")
        points = next((file[name] for name in ("points", "id") if name in file.files), None)
        rest = float(file["at_rest"]) if "at_rest" in file.files else None
        return points, file["displacement"], rest


def _csv(path: Path) -> tuple[Array | None, Array, float | None]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = list(csv.reader(file))
    head = [name.strip().lower() for name in rows[0]] if rows else []
    moves = [f"u{a}" for a in AXES if f"u{a}" in head]
    if moves[:2] != ["ux", "uy"]:
        raise CheckError(
            f"{path.name}: columns {', '.join(head) or 'none'}; name them ux, uy (, uz)"
        )
    columns = _columns(path, head, rows[1:])
    move = np.column_stack([columns[name] for name in moves])
    axes = AXES[: len(moves)]
    if all(a in columns for a in axes):
        return np.column_stack([columns[a] for a in axes]), move, None
    if "id" in columns:
        number = columns["id"]
        whole = np.isfinite(number).all() and (number == np.rint(number)).all()
        if not whole:
            raise CheckError(f"{path.name}: id that are not whole numbers; number nodes from 0")
        if (np.abs(number) >= MOST_NUMBER).any():
            most = float(np.abs(number).max())
            raise CheckError(f"{path.name}: id {most:g}; number nodes from 0")
        return number.astype(np.int64), move, None
    return None, move, None


def _columns(path: Path, head: list[str], rows: list[list[str]]) -> dict[str, Array]:
    """Name -> numbers (n,) of the columns that are read."""
    wanted = {"id", *AXES, *(f"u{a}" for a in AXES)}
    found: dict[str, list[float]] = {name: [] for name in head if name in wanted}
    for line, row in enumerate(rows, 2):
        if not row:
            continue
        if len(row) != len(head):
            raise CheckError(f"{path.name} line {line}: {len(row)} values for {len(head)} columns")
        for name, text in zip(head, row, strict=True):
            if name not in found:
                continue
            try:
                found[name].append(float(text))
            except ValueError as error:
                raise CheckError(
                    f"{path.name} line {line}: {name} {text[:30]!r}; give a number"
                ) from error
    return {name: np.array(values) for name, values in found.items()}
