"""Displacements from anywhere: .vtu, .csv and .npz files, their names and units."""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from msvalidate.problem import AXES, Array, Index, ProblemError
from msvalidate.problem.checks import (
    finite_number,
    format_value,
    integers,
    numbers,
    require_type,
    shaped,
)
from msvalidate.problem.records import dataclass
from msvalidate.springs.bodies.mesh_file import read_points
from msvalidate_check.archives import read_arrays
from msvalidate_check.checking import ACCURACY
from msvalidate_check.errors import CheckError
from msvalidate_check.points import refuse_extreme as refuse_sizes

LARGEST_FILE = 2_000_000_000
"""Bytes beyond which a file is not read."""
MOST_POINTS = 3_000_000
MOST_COLUMNS = 1000
"""Values in a line of a table, beyond which its reader takes minutes and gigabytes."""
IDS = ("id", "node", "point", "index")
PLACES = ("points", "x", "position", "positions", "coordinates")
MOVES = ("displacement", "displacements", "u", "disp")
REST = "at_rest"
"""Key of .npz files for the relative residual motion."""
PLACES_OF_ARRAYS = {"points": PLACES, "id": IDS, "rest": (REST,)}
"""Arrays of a .npz file besides displacements, and their possible names."""


@dataclass(frozen=True, eq=False)
class Result:
    """Displacements as a file has them, in its own unit.

    Parameters
    ----------
    name
        The file's, as messages show it.
    displacement
        (n, d).
    points
        (n, d) at rest, or None.
    id
        (n,) numbers of the case's points, from 0, or None.
    rest
        What the file says of how much they would still change, over the largest; NaN if nothing.
    accuracy
        How far displacements may be off by their digits, over the largest.
    known
        What solvers that are known not to be converged give there, by what they are of: functions
        of Poisson's ratio, (n, d) in m.
    """

    name: str
    displacement: Array
    points: Array | None
    id: Index | None
    rest: float
    accuracy: float = ACCURACY
    known: Mapping[str, Callable[[float], Array]] = field(default_factory=dict)


def read_result(path: str | Path, dim: int, field: str | None = None) -> Result:
    """Displacements in a file.

    Parameters
    ----------
    path
        .csv with a header: id or x, y, z; and ux, uy, uz. .npz with displacement (n, d), and points
        (n, d) or id (n,). .vtu with points and a vector field.
    dim
        Axes of the case: a third component of plane results is left out if it is 0.
    field
        Name of the field, where there are several.

    Raises
    ------
    ProblemError
        If there is no such file, it holds no such field, or a value is no number.
    """
    require_type("result file", path, str | Path)
    file = Path(path)
    said = f"result {format_value(file.name)}"
    readers = {".csv": _read_csv, ".npz": _read_npz, ".vtu": _read_vtu}
    if file.suffix.lower() not in readers:
        raise ProblemError(f"{said}: give one of {', '.join(readers)}")
    _refuse_unreadable(file)
    try:
        given = readers[file.suffix.lower()](file, field)
        return _result(file.name, given, dim)
    except (ProblemError, CheckError) as error:
        text = str(error)
        raise ProblemError(text if text.startswith("result ") else f"{said}: {text}") from error


def _refuse_unreadable(file: Path) -> None:
    try:
        size = file.stat().st_size
        with file.open("rb"):
            pass
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise ProblemError(
            f"result {format_value(str(file))}: {why}; give a file to read"
        ) from error
    if size > LARGEST_FILE:
        raise ProblemError(f"{size:g} bytes; the most is {LARGEST_FILE:g}")


def _result(name: str, given: Mapping[str, Any], dim: int) -> Result:
    move = numbers("displacement", given["displacement"])
    move = _plane(shaped("displacement", move, "n>0", (2, 3)), dim, "displacement")
    if len(move) > MOST_POINTS:
        raise ProblemError(f"{len(move):g} points; the most is {MOST_POINTS:g}")
    refuse_extreme("displacement", move)
    points = given.get("points")
    if points is not None:
        at = shaped("points", numbers("points", points), len(move), (2, 3))
        points = _plane(at, dim, "points")
        refuse_extreme("points", points)
    number = given.get("id")
    if number is not None:
        number = integers("id", number, len(move))
    if points is None and number is None:
        raise ProblemError("neither places nor id: give x, y (and z), or the points' numbers")
    rest = given.get("rest")
    residual_motion = math.nan if rest is None else finite_number(REST, rest, least=0.0)
    return Result(name, move, points, number, residual_motion)


def refuse_extreme(name: str, array: Array) -> None:
    """Refuse numbers that are not finite, or whose squares are not numbers."""
    try:
        refuse_sizes(name, array)
    except CheckError as error:
        raise ProblemError(str(error)) from error


def _plane(array: Array, dim: int, what: str) -> Array:
    """Without a third component where the case has none."""
    if array.shape[1] == dim:
        return array
    if dim == 3:
        raise ProblemError(f"{what}: 2 components, the case has 3; give x, y and z")
    if np.ptp(array[:, 2]) if what == "points" else array[:, 2].any():
        raise ProblemError(f"{what}: out of the plane too, and the case is plane; leave z out")
    return np.ascontiguousarray(array[:, :2])


def _read_csv(file: Path, field: str | None) -> dict[str, Any]:
    if field is not None:
        raise ProblemError("--field: a table has columns, no fields; leave it out")
    try:
        text = file.read_text(encoding="utf-8-sig")
        refuse_wide(io.StringIO(text, newline=""))
        table = pd.read_csv(io.StringIO(text), skipinitialspace=True, comment="#")
    except UnicodeDecodeError as error:
        raise ProblemError(f"byte {error.start} is no UTF-8; save it as such") from error
    except (csv.Error, ValueError) as error:
        raise ProblemError(
            f"not a table: {' '.join(str(error).split())}; write it again"
        ) from error
    names = {re.sub(r"\s+", "", str(column)).lower(): column for column in table.columns}
    for name, column in names.items():
        first, _, number = name.rpartition(".")
        if number.isdigit() and first in names:  # as the library renames the second of a name
            raise ProblemError(f"column {names[first]!r} is there twice ({column}); keep one")
    found: dict[str, Any] = {}
    move = _columns(names, [f"u{a}" for a in AXES], [f"u_{a}" for a in AXES], ["u", "v", "w"])
    if len(move) < 2:
        raise ProblemError(
            f"columns {', '.join(map(str, table.columns))}; name displacements ux, uy (and uz)"
        )
    found["displacement"] = _table_numbers(table, move)
    at = _columns(names, list(AXES))
    if len(at) >= 2:
        found["points"] = _table_numbers(table, at)
    numbered = [names[name] for name in IDS if name in names]
    if numbered:
        found["id"] = _table_numbers(table, numbered[:1])[:, 0]
    return found


def refuse_wide(lines: Iterable[str]) -> None:
    """Raise `ValueError`, or what the CSV reader does, of too wide a table before it is read."""
    widest = max(map(len, csv.reader(lines)), default=0)
    if widest > MOST_COLUMNS:
        raise ValueError(f"{widest} values in a line, at most {MOST_COLUMNS} are read")


def _columns(names: Mapping[str, Any], *choices: Sequence[str]) -> list[Any]:
    """Columns of the first choice of names of which two are there."""
    for choice in choices:
        there = [names[name] for name in choice if name in names]
        if len(there) >= 2:
            return there
    return []


def _table_numbers(table: pd.DataFrame, columns: Sequence[Any]) -> Array:
    part = table[list(columns)].apply(pd.to_numeric, errors="coerce")
    part = part.mask(table[list(columns)].map(lambda value: isinstance(value, bool)))
    bad = np.argwhere(part.isna().to_numpy())
    if len(bad):
        row, column = bad[0]
        given = table[columns[column]].iloc[row]
        said = f"{columns[column]} in row {row + 1}: {format_value(given)}"
        raise ProblemError(f"{said}; give a number")
    return np.asarray(part.to_numpy(dtype=float))


def _read_npz(file: Path, field: str | None) -> dict[str, Any]:
    wanted = {"displacement": (field,) if field else MOVES} | PLACES_OF_ARRAYS
    arrays, there = read_arrays(file, wanted, MOST_POINTS)
    if "displacement" not in arrays:
        known, names = ", ".join(map(format_value, there)) or "nothing", wanted["displacement"]
        choice = " or ".join(names[:2])
        raise ProblemError(f"no displacement: it holds {known}; name one of them {choice}")
    return {what: _as_numbers(array, name) for what, (name, array) in arrays.items()}


def _as_numbers(array: np.ndarray, name: str) -> np.ndarray:
    if array.dtype.kind not in "iuf":
        raise ProblemError(f"{name}: {array.dtype}; give numbers")
    return array.astype(float) if array.dtype.itemsize < 8 or array.dtype.kind != "f" else array


def _read_vtu(file: Path, field: str | None) -> dict[str, Any]:
    points, data = read_points(file)
    vectors = {
        name: values
        for name, values in data.items()
        if np.ndim(values) == 2 and np.shape(values)[1] in (2, 3)
    }
    lower = {name.lower(): name for name in vectors}
    if field is not None:
        move = field if field in vectors else None
    else:
        move = next((lower[name] for name in MOVES if name in lower), None)
        if move is None and len(vectors) == 1:
            (move,) = vectors
    if move is None:
        known = ", ".join(map(format_value, vectors)) or "none"
        raise ProblemError(f"vector fields {known}; name the displacements by --field")
    return {"displacement": vectors[move], "points": points}
