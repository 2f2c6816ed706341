"""Parameter sweeps of case files: keys set to each of several values, one row per combination.

The row of a combination is a file of its own. Its name is a key that follows from every byte that
the row depends on: case file, mesh, values, sources of this program and versions of libraries. So a
sweep that was killed continues, and one that is repeated is read instead of solved.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
import sys
import time
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Future
from functools import cache, partial
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import msgspec
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bench.output.figures import add_shared_legend, new_figure, series_style
from msvalidate.bench.output.provenance import LIBRARIES
from msvalidate.case.compare.comparison import compare_case
from msvalidate.case.file.building import build_case, mesh_path
from msvalidate.case.file.reading import parse_source, read_source
from msvalidate.case.report.headline import overall
from msvalidate.problem import ProblemError, SolverError
from msvalidate.problem.checks import format_value
from msvalidate.problem.records import dataclass
from msvalidate_check import exchange

PACKAGES = ("msvalidate", "reference_fem", "msvalidate_check")
COMPUTING = (*LIBRARIES, "cvxopt", "gmsh", "llvmlite", "meshio", "msgspec", "pyamg", "shapely")
"""Distributions whose versions a row depends on."""
SOLVED, REFUSED, FAILED, LATE, DIED = "solved", "refused", "failed", "too long", "died"
CHANGED = (
    "the case, mesh or program differs from that of the sweep's start; sweep again, on a cluster "
    "with workers that were started since"
)
ROWS = "rows"
"""Folder of the files of rows."""
BARE = re.compile(r"((?:^|[,\[\s])[+-]?)\.(?=\d)")
"""A number without a digit before its point, which TOML lacks."""
MOST = 100_000
"""Combinations in a sweep."""
MOST_LINES = 8
"""In the picture."""


class Row(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Result of a combination as its file stores it; difference and uncertainty if solved."""

    outcome: str
    verdict: str = ""
    difference: float | None = None
    uncertainty: float | None = None
    message: str = ""
    seconds: float = 0.0


@dataclass(frozen=True)
class Combination:
    """A case file with some of its keys set to other values.

    Parameters
    ----------
    file
        The case file.
    values
        Keys, as "springs.cells" or "load.1.pressure", and their values.
    label
        Name of the file in tables and messages.
    """

    file: Path
    values: tuple[tuple[str, Any], ...]
    label: str = ""

    def change(self, given: dict[str, Any]) -> None:
        """Set the keys in a file's content; tables that are not there are made."""
        for name, value in self.values:
            *path, last = name.split(".")
            at: Any = given
            try:
                for step in path:
                    at = at[_place(at, step)] if isinstance(at, list) else at.setdefault(step, {})
                at[_place(at, last) if isinstance(at, list) else last] = value
            except (IndexError, ValueError, AttributeError, TypeError) as error:
                raise ProblemError(
                    f"--set {name}: no such place in {self.file.name}; give a key as "
                    "springs.cells, of lists by number from 1, as load.1.pressure"
                ) from error

    @property
    def folder(self) -> Path:
        """Folder in which the run looks for the mesh: that of the file, not of a link to it."""
        return self.file.resolve().parent

    @property
    def text(self) -> str:
        """Text of the case file."""
        return self.file.read_text(encoding="utf-8-sig").replace("\r\n", "\n")

    @property
    def key(self) -> str:
        """Digest of all bytes that the row follows from, in 32 hexadecimal digits."""
        digest = hashlib.sha256(program_stamp().encode() + self.text.encode())
        given = tomllib.loads(self.text)
        self.change(given)
        mesh = given.get("body", {}).get("mesh") if isinstance(given.get("body"), dict) else None
        if isinstance(mesh, str):
            try:
                digest.update(mesh_path(self.folder, mesh).read_bytes())
            except (ProblemError, OSError, ValueError) as error:
                digest.update(str(error).encode())  # a refused row, until the file is there
        digest.update(json.dumps([self.label or self.file.name, self.values], default=str).encode())
        return digest.hexdigest()[:32]


def _place(items: list[Any], number: str) -> int:
    """Index of an item by its number from 1; raises ValueError if there is none."""
    return range(1, len(items) + 1).index(int(number))


@cache
def program_stamp() -> str:
    """Digest of this program: its sources and tables, and versions of what it computes with."""
    versions = [sys.version, *((name, _version(name)) for name in COMPUTING)]
    digest = hashlib.sha256(repr(versions).encode())
    for path in program_files():
        digest.update(path.name.encode() + path.read_bytes())
    return digest.hexdigest()


def program_files() -> list[Path]:
    """Sources and tables of the packages that a run takes part of."""
    homes = [Path(str(spec.origin)).parent for spec in map(find_spec, PACKAGES) if spec]
    return [
        path
        for home in homes
        for path in sorted(home.rglob("*"))
        if path.suffix in {".py", ".toml"}
    ]


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:
        return ""


def read_values(words: Sequence[str]) -> dict[str, list[Any]]:
    """Keys and their values, of words as ``springs.cells=8,16``.

    Raises `ProblemError` if a word is none, or a key comes twice.
    """
    result: dict[str, list[Any]] = {}
    for word in words:
        name, is_there, right = word.partition("=")
        values = _toml_values(right) or [
            value for part in right.split(",") for value in _toml_values(part) or [part.strip()]
        ]
        if not (is_there and name and all(name.split(".")) and values and "" not in values):
            said = f"--set {format_value(word)}"
            raise ProblemError(f"{said}: give key=value,value, as springs.cells=8,16,32")
        if name in result:
            raise ProblemError(f"--set {name}: comes twice; give all its values in one")
        if len({json.dumps(value, default=str) for value in values}) < len(values):
            raise ProblemError(f"--set {name}: a value comes twice; give each once")
        result[name] = values
    return result


def _toml_values(text: str) -> list[Any]:
    """Values with commas between them, as TOML has them; none if one of them is no such value."""
    try:
        return list(tomllib.loads(BARE.sub(r"\g<1>0.", f"values = [{text}]"))["values"])
    except tomllib.TOMLDecodeError:
        return []


def combinations(files: Sequence[Path], values: Mapping[str, list[Any]]) -> list[Combination]:
    """Each file with each combination of values, the last key the fastest.

    Raises `ProblemError` if a file is no case or comes twice, a key is none of its places, or the
    combinations are too many.
    """
    if len(files) * math.prod(map(len, values.values())) > MOST:
        raise ProblemError(f"--set: more than {MOST} combinations; give fewer values")
    names = [file.name for file in files]
    if len(set(names)) < len(names):
        top = os.path.commonpath([file.absolute().parent for file in files])
        names = [file.absolute().relative_to(top).as_posix() for file in files]
    result = []
    for file, name in zip(files, names, strict=True):
        if names.count(name) > 1:
            raise ProblemError(f"case {format_value(name)}: comes twice; name it once")
        read_source(file)
        choices = product(*values.values())
        result += [Combination(file, tuple(zip(values, c, strict=True)), name) for c in choices]
        result[-1].change(tomllib.loads(result[-1].text))
    return result


def solve(request: Combination, key: str) -> Row:
    """The row of a combination whose key was `key` when the sweep began."""
    began, values = time.monotonic(), dict[str, Any]()
    try:
        source = parse_source(request.label, request.text, request.folder, request.change)
        with np.errstate(over="ignore", invalid="ignore"):
            case = build_case(source)
            if request.key != key:
                return Row(DIED, message=CHANGED)
            result = compare_case(case)
        first = result.rows[0]
        values = {"difference": first.error, "uncertainty": first.uncertainty}
        values["verdict"] = overall(result.rows)
        outcome, message = SOLVED, " ".join(each.sentence for each in result.limitations[:1])
    except Exception as error:  # noqa: BLE001  a row, whatever it was
        kinds = {ProblemError: REFUSED, SolverError: FAILED}
        outcome = next((word for kind, word in kinds.items() if isinstance(error, kind)), DIED)
        message = str(error) if outcome != DIED else f"{type(error).__name__}: {error}"
    values |= {"message": " ".join(message.split()), "seconds": round(time.monotonic() - began, 3)}
    return Row(outcome, **values)


def finished_row(future: Future[Row]) -> Row:
    """The row of a combination whose call has ended; raises `SolverError` if the cluster has."""
    error = future.exception()
    if isinstance(error, SolverError):
        raise error
    if isinstance(error, TimeoutError):
        return Row(LATE, message="longer than --limit")
    return Row(DIED, message=" ".join(str(error).split())) if error else future.result()


def read_rows(folder: Path, keys: Iterable[str]) -> tuple[dict[str, Row], list[Path]]:
    """Rows in a folder by key, and files that are no records; late and dead rows are left out."""
    rows, damaged = {}, []
    for key in keys:
        path = folder / f"{key}.json"
        try:
            row = msgspec.json.decode(path.read_bytes(), type=Row)
        except FileNotFoundError:
            continue
        except (OSError, ValueError, RecursionError):  # msgspec's errors are ValueErrors
            damaged.append(path)
            continue
        if row.outcome in {SOLVED, REFUSED, FAILED}:
            rows[key] = row
    return rows, damaged


def write_row(folder: Path, key: str, row: Row) -> None:
    """Write the file of a row, in one step."""
    exchange.write(folder, {})
    exchange.replace_file(folder / f"{key}.json", partial(msgspec.json.encode, row))


def sweep_table(keys: Mapping[str, Combination], rows: Mapping[str, Row]) -> pd.DataFrame:
    """The table of all combinations whose rows are known, in their order."""
    return pd.DataFrame(
        {"file": each.label, **dict(each.values), **msgspec.structs.asdict(rows[key])}
        for key, each in keys.items()
        if key in rows
    )


def draw_sweep(table: pd.DataFrame, names: Sequence[str]) -> Figure:
    """Difference of the first quantity against the first key of numbers, a line for each other."""
    x = next((name for name in names if table[name].dtype.kind in "iuf"), None)
    figure, (axis,) = new_figure(size=(5.6, 3.8))
    shown = table[table["outcome"] == SOLVED]
    others = [n for n in ("file", *names) if n != x and table[n].map(str).nunique() > 1]
    labels = [", ".join(f"{n} {row[n]}" for n in others) for row in shown.to_dict("records")]
    for place, (label, own) in enumerate([*shown.groupby(labels, sort=False)][:MOST_LINES]):
        along = own[x] if x else range(1, len(own) + 1)
        axis.plot(along, 100 * own["difference"], label=label or None, **series_style(place))
    axis.set(xlabel=x or "combination", ylabel="difference from elasticity (%)", yscale="log")
    if others:
        add_shared_legend(figure, [axis], 2)
    return figure
