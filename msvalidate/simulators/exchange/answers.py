"""Answers of adapters, read strictly from their folders.

An answer is complete or rejected.
"""

from __future__ import annotations

import csv
import re
import zipfile
from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import Annotated, Any

import msgspec
import numpy as np
import pandas as pd

from msvalidate.case.judge.results import refuse_wide
from msvalidate.problem import AXES, Array, ProblemError
from msvalidate.problem.checks import format_value, numbers
from msvalidate.simulators.exchange.protocol import (
    LARGEST,
    Answer,
    ForcesAt,
    MassKind,
    Precision,
    Request,
    SimulatorError,
    ask,
)
from msvalidate.springs.bodies.mesh_file import read_points


def read_table(path: Path, columns: Sequence[str]) -> Array:
    """Numbers (n, k) in a CSV file with a header, in the order of its column `id` if it has one.

    Parameters
    ----------
    path
        The file.
    columns
        Those wanted, in this order.

    Raises
    ------
    ProblemError
        If there is no such file, a column is missing, an entry is no number, or `id` does not
        number the rows from 0. NaN, written so, is a number here.
    """
    said = f"table {format_value(path.name)}"
    try:
        with path.open(newline="", encoding="utf-8-sig") as lines:
            refuse_wide(lines)
        # As texts, whose numbers Python reads exactly: the library's own way differs by version.
        text = pd.read_csv(
            path, skipinitialspace=True, encoding="utf-8-sig", keep_default_na=False, dtype=str
        )
    except OSError as error:
        raise ProblemError(f"{said}: {error.strerror}; write it") from error
    except (csv.Error, ValueError) as error:
        why = " ".join(str(error).split())
        raise ProblemError(f"{said}: not a table: {format_value(why)}; write it again") from error
    text.columns = [str(name).strip() for name in text.columns]
    missing = [name for name in columns if name not in text.columns]
    if missing:
        there = ", ".join(map(str, text.columns))
        raise ProblemError(f"{said}: no column {missing[0]}; it has {format_value(there)}")
    found = np.empty((len(text), len(columns)))
    for place, name in enumerate(columns):
        found[:, place] = _numbers(said, name, text[name].to_list())
    if "id" in text.columns:
        return _by_id(said, _numbers(said, "id", text["id"].to_list()), found)
    return found


def _numbers(said: str, name: str, texts: list[str]) -> Array:
    found = np.empty(len(texts))
    for row, each in enumerate(texts):
        try:
            found[row] = float(each)
        except (TypeError, ValueError) as error:
            shown = format_value(each)
            raise ProblemError(
                f"{said}: {name} in row {row + 1}: {shown}; give a number"
            ) from error
    return found


def _by_id(said: str, number: Array, rows: Array) -> Array:
    order = np.argsort(number, kind="stable")
    wrong = np.flatnonzero(number[order] != np.arange(len(rows)))
    if len(wrong):
        at = wrong[0]
        raise ProblemError(
            f"{said}: id {number[order][at]:g} where {at} is due; number each row once, from 0"
        )
    return np.ascontiguousarray(rows[order])


ABOUT = "result.json"
RESULTS = ("result.npz", "result.csv", "result.vtu")
NO_NUMBER = re.compile(r'"(\w+)"\s*:\s*\[?\s*(-?NaN|-?Infinity)\b')
"""A key of it whose value Python writes where there is no number, which is no JSON."""
LARGEST_ABOUT = 1_000_000
"""Bytes of `result.json`."""
Amount = Annotated[float, msgspec.Meta(ge=0, le=LARGEST)]
Part = Annotated[float, msgspec.Meta(ge=0, lt=0.1)]
"""Relative accuracy to which a step is solved.

No law can be read from steps with a larger one.
"""
LARGEST_EMPTY, BYTES_A_NODE = 10_000_000, 2_000
"""Bytes that a result may have: of its own, and for each node."""
SAME_PLACE = 1e-6
"""Tolerance of points of a .vtu file relative to the body's size.

They may be in float32.
"""
COLUMNS = {"displacement": "u", "position": "", "velocity": "v", "force": "f"}
"""Array -> what its columns begin with in a table, before x, y and z."""


class AtRest(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """Distance of an answer from equilibrium, as stated by its program.

    Parameters
    ----------
    residual
        Largest force on a free node that nothing balances, N.
    largest_speed
        Of any node, m/s.
    change_when_twice_as_long
        Largest change of a node's displacement when run twice as long, m.
    """

    residual: Amount | None = None
    largest_speed: Amount | None = None
    change_when_twice_as_long: Amount | None = None


class About(msgspec.Struct, forbid_unknown_fields=True, omit_defaults=True):
    """The keys of `result.json`: as `Answer.about` tells them."""

    simulator: str
    version: str
    law: str
    precision: Precision
    settings: dict[str, tuple[Any, str]] = {}
    steps: Annotated[int, msgspec.Meta(ge=0)] | None = None
    dt: Amount | None = None
    mass: MassKind | None = None
    forces_at: ForcesAt | None = None
    solves_to: Part | None = None
    at_rest: AtRest = msgspec.field(default_factory=AtRest)
    seconds: Amount | None = None
    notes: str | list[str] = ""


class Declared(msgspec.Struct, omit_defaults=True):
    """Keys of `result.json` as the answer to "declare"; other keys are left unread."""

    cells: list[str] = []
    dimension: int | None = None


def read_answer(folder: str | Path, request: Request) -> Answer:
    """Read the answer of an adapter to a request from its folder.

    Raises
    ------
    SimulatorError
        If `result.json` or the result is missing, is too large, is no such file, lacks a key, has
        one that is not known or of a wrong type, or an array is of another shape or not finite.
    """
    place = Path(folder)
    try:
        if request.task == "declare":
            return Answer(about=_read_about(place / ABOUT, Declared))
        about = _read_about(place / ABOUT)
        arrays = _read_arrays(place, request)
    except ProblemError as error:
        raise SimulatorError(f"answer: {error}") from error
    answer = Answer(**arrays, about=about)
    return ask(lambda _: answer, request)


def _read_about(path: Path, keys: type[msgspec.Struct] = About) -> dict[str, Any]:
    if not path.is_file():
        raise SimulatorError(f"answer: no {ABOUT}; an adapter writes it beside its result")
    _refuse_large(path, LARGEST_ABOUT)
    try:
        about = msgspec.json.decode(path.read_bytes(), type=keys)
    except (msgspec.DecodeError, RecursionError, UnicodeDecodeError) as error:
        why = " ".join(str(error).split())
        if no_number := NO_NUMBER.search(path.read_text(encoding="utf-8", errors="replace")):
            raise SimulatorError(
                f"answer: {ABOUT}: {no_number[1]} is {no_number[2]}; did it diverge?"
            ) from error
        known = f"; the keys are {', '.join(keys.__struct_fields__)}" if "field" in why else ""
        raise SimulatorError(f"answer: {ABOUT}: {why}{known}") from error
    return dict(msgspec.to_builtins(about))


def _refuse_large(path: Path, most: int, size: int | None = None) -> None:
    """Raise `SimulatorError` for a file of more bytes, or whose content is of more."""
    size = path.stat().st_size if size is None else size
    if size > most:
        raise SimulatorError(f"answer: {path.name}: {size:g} bytes; the most is {most:g}")


def _read_arrays(place: Path, request: Request) -> dict[str, Array]:
    there = [name for name in RESULTS if (place / name).is_file()]
    if len(there) != 1:
        said = " and ".join(there) or "no result"
        raise SimulatorError(f"answer: {said}; write one of {', '.join(RESULTS)}")
    path = place / there[0]
    most = LARGEST_EMPTY + BYTES_A_NODE * len(request.mesh.points)
    _refuse_large(path, most)
    readers: dict[str, Callable[[Path, Request, int], dict[str, Array]]] = {
        ".npz": _read_npz,
        ".csv": _read_csv,
        ".vtu": _read_vtu,
    }
    return readers[path.suffix](path, request, most)


def _way(
    request: Request, there: Collection[str], said: str, spelt: Callable[[Sequence[str]], str]
) -> Sequence[str]:
    """Arrays of the first way to answer a request that is there; ways are told as `spelt`."""
    moved: Sequence[str] = ("position", "velocity")
    ways = [["displacement"]] if request.task == "rest" else [moved, ["force"]]
    for way in ways:
        if all(name in there for name in way):
            return way
    needed = " or ".join(map(spelt, ways))
    raise SimulatorError(f"answer: {said}; a {request.task} needs {needed}")


def _take(said: str, there: dict[str, Any], request: Request) -> dict[str, Array]:
    """Arrays of the first way to answer that is there."""
    held = format_value(", ".join(map(str, there)) or "nothing")
    way = _way(request, there, f"{said} holds {held}", " and ".join)
    return {name: numbers(f"{said}: {name}", there[name]) for name in way}


def _read_npz(path: Path, request: Request, most: int) -> dict[str, Array]:
    try:
        with zipfile.ZipFile(path) as packed:
            _refuse_large(path, most, sum(each.file_size for each in packed.infolist()))
        with np.load(path, allow_pickle=False) as content:
            there = {name: content[name] for name in content.files if name in COLUMNS}
    except SimulatorError:
        raise
    except Exception as error:  # whatever the readers of archives and arrays stumble over
        why = format_value(str(error) or type(error).__name__)
        raise SimulatorError(f"answer: {path.name}: not whole arrays ({why})") from error
    return _take(path.name, there, request)


def _read_csv(path: Path, request: Request, _most: int) -> dict[str, Array]:
    axes = AXES[: request.mesh.dim]
    columns = {name: [f"{start}{a}" for a in axes] for name, start in COLUMNS.items()}
    with path.open(encoding="utf-8-sig", errors="replace") as lines:
        header = [name.strip() for name in lines.readline(LARGEST_ABOUT).split(",")]
    there = [name for name, each in columns.items() if all(column in header for column in each)]
    said = f"{path.name} has columns {format_value(', '.join(header))}"
    way = _way(request, there, said, lambda way: ",".join(",".join(columns[n]) for n in way))
    return {name: read_table(path, columns[name]) for name in way}


def _read_vtu(path: Path, request: Request, _most: int) -> dict[str, Array]:
    points, data = read_points(path)
    nodes, dim = request.mesh.points, request.mesh.dim
    if points.shape[0] != len(nodes):
        raise SimulatorError(
            f"answer: {path.name}: {len(points)} points; the request has {len(nodes)} nodes"
        )
    size = max(high - low for low, high in request.mesh.span)
    if np.abs(points[:, :dim] - nodes).max() > SAME_PLACE * size:
        raise SimulatorError(
            f"answer: {path.name}: its points are not the nodes; give those of points.csv, at "
            "rest and in their order"
        )
    there = {name: np.asarray(data[name]) for name in COLUMNS if name in data}
    if dim == 2:  # a third component that is not 0 stays, and is refused as one too many
        there = {
            name: each[:, :2] if each.ndim == 2 and not each[:, 2:].any() else each
            for name, each in there.items()
        }
    return _take(path.name, there, request)
