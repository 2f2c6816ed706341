"""Displacements in files: .csv and .npz."""

from __future__ import annotations

import csv
from array import array
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from msvalidate_check.archives import LARGEST_FILE, MOST_POINTS, read_arrays
from msvalidate_check.beside import AXES, Array
from msvalidate_check.errors import CheckError

ARRAYS = {"displacement": ("displacement",), "points": ("points", "id"), "at_rest": ("at_rest",)}
"""What is read of an archive, and by which names."""
MOST_NUMBER = 2**53
"""Number of a node from which not each whole number is one of double precision."""


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
    readers = {".npz": _npz, ".csv": _csv}
    if path.suffix.lower() not in readers:
        raise CheckError(f"{path.name or path}: give a .csv or .npz file")
    try:
        _refuse_large(path.stat().st_size)
        return readers[path.suffix.lower()](path)
    except CheckError as error:
        raise CheckError(" ".join(f"{path.name}: {error}".split())) from error
    except Exception as error:  # whatever readers stumble over
        why = getattr(error, "strerror", None) or " ".join(str(error).split())
        raise CheckError(
            f"{path.name}: {why or type(error).__name__}; give a .csv or .npz file of displacements"
        ) from error


def _refuse_large(size: int) -> None:
    if size > LARGEST_FILE:
        raise CheckError(f"{size:g} bytes; the most is {LARGEST_FILE:g}")


def _npz(path: Path) -> tuple[Array | None, Array, float | None]:
    found, there = read_arrays(path, ARRAYS)
    if "displacement" not in found:
        known = ", ".join(there) or "nothing"
        raise CheckError(f"it holds {known}; name the displacements displacement")
    points, rest = (found.get(name, ("", None))[1] for name in ("points", "at_rest"))
    if rest is not None and (rest.size != 1 or rest.dtype.kind not in "iuf"):
        raise CheckError(f"at_rest: shape {rest.shape} of {rest.dtype}; give one number")
    return points, found["displacement"][1], None if rest is None else float(rest.reshape(()))


def _csv(path: Path) -> tuple[Array | None, Array, float | None]:
    with path.open(newline="", encoding="utf-8-sig") as file:
        rows = csv.reader(file)
        head = [name.strip().lower() for name in next(rows, [])]
        moves = [f"u{a}" for a in AXES if f"u{a}" in head]
        if moves[:2] != ["ux", "uy"]:
            raise CheckError(f"columns {', '.join(head)[:80] or 'none'}; name them ux, uy (, uz)")
        columns = _columns(head, rows)
    move = np.column_stack([columns[name] for name in moves])
    axes = AXES[: len(moves)]
    if all(a in columns for a in axes):
        return np.column_stack([columns[a] for a in axes]), move, None
    if "id" in columns:
        number = columns["id"]
        whole = np.isfinite(number).all() and (number == np.rint(number)).all()
        if not whole:
            raise CheckError("id that are not whole numbers; number nodes from 0")
        if (np.abs(number) >= MOST_NUMBER).any():
            most = float(np.abs(number).max())
            raise CheckError(f"id {most:g}; number nodes from 0")
        return number.astype(np.int64), move, None
    return None, move, None


def _columns(head: list[str], rows: Iterator[list[str]]) -> dict[str, Array]:
    """Name -> numbers (n,) of the columns that are read."""
    wanted = {"id", *AXES, *(f"u{a}" for a in AXES)}
    found = {name: array("d") for name in head if name in wanted}
    twice = next((name for name in found if head.count(name) > 1), None)
    if twice is not None:
        raise CheckError(f"column {twice} is there twice; keep one")
    for line, row in enumerate(rows, 2):
        if not row:
            continue
        if len(row) != len(head):
            raise CheckError(f"line {line}: {len(row)} values for {len(head)} columns")
        if line > MOST_POINTS:
            raise CheckError(f"more than {MOST_POINTS:g} lines, the most that are read")
        for name, text in zip(head, row, strict=True):
            if name not in found:
                continue
            try:
                found[name].append(float(text))
            except ValueError as error:
                raise CheckError(f"line {line}: {name} {text[:30]!r}; give a number") from error
    return {name: np.array(values) for name, values in found.items()}
