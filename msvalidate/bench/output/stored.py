"""A study's results as files, and back: what a page is made of, without solving again.

A study's folder holds a CSV a table, `verdict.csv`, a PNG and an SVG a figure, and `study.json`:
its question, findings, columns, captions, provenance and seconds (`About`). Tables are read back
as text: what a page shows is what the files say. What is read back is held to one schema, types and
all: years may lie between, or an editor. A field that is added later has a default, so that old
results still read.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.bench.judging.compare import Layer
from msvalidate.bench.judging.evidence import Evidence, all_passed
from msvalidate.bench.output.figures import add_title, figure_style, plain_logarithms
from msvalidate.bench.output.pictures import shorten_paths
from msvalidate.problem import ProblemError
from msvalidate.problem.records import dataclass, field
from msvalidate_check.baseline import read_columns

FORMATS = ("png", "svg")
ABOUT, VERDICT = "study.json", "verdict.csv"
SUFFIXES = (".csv", ".json", *(f".{kind}" for kind in FORMATS))
NUMBERS = ("observed", "reference", "error", "limit")
"""Columns of a verdict that hold numbers."""


Name = Annotated[str, msgspec.Meta(pattern=r"^[^./\\\x00][^/\\\x00]*$")]
"""Name of a file in a study's folder, and in no other folder."""


class About(msgspec.Struct, frozen=True):
    """Content of `study.json`: the fields of `Stored`, and names of files.

    Parameters
    ----------
    question, findings, columns, origin, error
        As in `Stored`.
    tables
        Names, in the order of the study.
    captions
        Name of a figure -> what it shows.
    files
        All that the run wrote into the folder.
    seconds
        That the study itself took.
    labels
        Column, or "table.column" -> head of the column for a reader.
    cover
        Name of the picture that the page shows first; "" for the first one.
    """

    question: str
    findings: tuple[str, ...]
    columns: dict[str, str]
    origin: dict[str, str]
    tables: tuple[Name, ...]
    captions: dict[Name, str]
    files: tuple[Name, ...]
    error: str = ""
    seconds: float = 0.0
    labels: dict[str, str] = {}
    cover: str = ""


class Written(msgspec.Struct, frozen=True):
    """Files that a run wrote into a folder, as listed in its `study.json`."""

    files: tuple[Name, ...]


class Row(msgspec.Struct, frozen=True):
    """A row of `verdict.csv`; what is no finite number is NaN."""

    layer: Layer
    quantity: str
    unit: str
    observed: float
    reference: float
    error: float
    limit: float
    verdict: Literal["pass", "fail", "agrees", "differs", "not resolved", "not at rest"]
    because: str
    rows: int = 1
    at: str = ""


@dataclass(frozen=True, eq=False)
class Result:
    """A study that ran: its name, docstring, evidence and judgement."""

    name: str
    question: str
    evidence: Evidence
    verdict: pd.DataFrame


@dataclass(frozen=True, eq=False)
class Stored:
    """Stored result of a study.

    Parameters
    ----------
    name, question
        Its name and its whole docstring.
    findings
        Sentences that say what was found.
    columns
        Column -> meaning and unit.
    origin
        Provenance, label -> value.
    verdict
        One row a judged quantity: layer, quantity, unit, observed, reference, error, limit,
        verdict, because. Numbers are floats.
    tables
        Name -> table of text.
    pictures
        Name -> (caption, SVG).
    error
        Why a later run did not finish, or "": results are then of the run before it.
    seconds
        That the study itself took; 0 in results of old, which do not say.
    labels
        Column, or "table.column" -> head of the column for a reader.
    cover
        Name of the picture that the page shows first; "" for the first one.
    """

    name: str
    question: str
    findings: tuple[str, ...]
    columns: Mapping[str, str]
    origin: Mapping[str, str]
    verdict: pd.DataFrame
    tables: Mapping[str, pd.DataFrame]
    pictures: Mapping[str, tuple[str, bytes]]
    error: str = ""
    seconds: float = 0.0
    labels: Mapping[str, str] = field(default_factory=dict)
    cover: str = ""

    @property
    def held(self) -> bool:
        """True if the study finished, judged something, and all of it passed."""
        return not self.error and all_passed(self.verdict)


def result_files(
    result: Result, origin: Mapping[str, str], *, seconds: float = 0.0, plots: bool = True
) -> dict[str, bytes]:
    """The files of a study that ran, for so many `seconds`: name -> content."""
    evidence = result.evidence
    tables = {**evidence.tables, "verdict": result.verdict}
    found = {f"{name}.csv": csv_bytes(table) for name, table in tables.items()}
    captions = {}
    tables = {**evidence.tables, **evidence.drawn}
    for name, draw in evidence.figures.items() if plots else ():
        captions[name] = (draw.__doc__ or name).partition("\n")[0]
        found |= draw_files(name, captions[name], partial(draw, tables))
    about = About(
        question=result.question,
        findings=tuple(evidence.findings),
        columns={c: str(meaning) for c, meaning in evidence.columns.items()},
        origin=dict(origin),
        tables=tuple(evidence.tables),
        captions=captions,
        files=tuple(sorted([*found, ABOUT])),
        seconds=seconds,
        labels=dict(evidence.labels),
        cover=evidence.cover,
    )
    return found | {ABOUT: _json(msgspec.to_builtins(about))}


def draw_files(
    name: str, caption: str, draw: Callable[[], Figure], *, margin: float | None = None
) -> dict[str, bytes]:
    """A figure in each of `FORMATS`, its caption above it: name of the file -> content.

    The figure is trimmed to a white margin (inches) if one is given.
    """
    with figure_style():
        figure = draw()
        add_title(figure, caption)
        _lay_out(figure)
        return {f"{name}.{kind}": _render_figure(figure, kind, margin) for kind in FORMATS}


def known_files(folder: Path) -> set[str]:
    """Names of the files that a run left in a study's folder; none if it is no such folder."""
    try:
        return set(msgspec.json.decode((folder / ABOUT).read_bytes(), type=Written).files)
    except (OSError, ValueError, msgspec.MsgspecError, RecursionError):
        return set()


def unfinished_files(
    folder: Path, question: str, origin: Mapping[str, str], error: str, seconds: float = 0.0
) -> dict[str, bytes]:
    """The files of a study that did not finish: those of the run before, marked, if there are."""
    try:
        about = _about(folder)
        found = {name: _content(folder / name) for name in about.files}
    except (OSError, ValueError):  # none, or damaged: nothing that could be shown
        about = About(question, (), {}, dict(origin), (), {}, (ABOUT,), seconds=seconds)
        found = {}
    return found | {ABOUT: _json(msgspec.to_builtins(msgspec.structs.replace(about, error=error)))}


def read_result(folder: Path) -> Stored:
    """Read the stored result of a study from `folder`.

    Raises
    ------
    ProblemError
        If a file is missing or is not what a run writes.
    """
    try:
        about = _about(folder)
        return Stored(
            name=folder.name,
            question=about.question,
            findings=about.findings,
            columns=about.columns,
            origin=about.origin,
            verdict=_verdict(folder / VERDICT) if VERDICT in about.files else nothing_judged(),
            tables={name: _table(folder / f"{name}.csv") for name in about.tables},
            pictures={
                name: (caption, _content(folder / f"{name}.svg"))
                for name, caption in about.captions.items()
            },
            error=about.error,
            seconds=about.seconds,
            labels=about.labels,
            cover=about.cover,
        )
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise ProblemError(
            f"results of {folder.name}: {missing} is missing; run it again"
        ) from error
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else " ".join(str(error).split())
        raise ProblemError(
            f"results of {folder.name}: not what a run writes ({why}); run it again"
        ) from error


def _content(path: Path) -> bytes:
    """Content of a regular file; reading a pipe could block."""
    if path.exists() and not path.is_file():
        raise ValueError(f"{path.name} is no file")
    return path.read_bytes()


def _about(folder: Path) -> About:
    try:
        return msgspec.json.decode((folder / ABOUT).read_bytes(), type=About)
    except (ValueError, msgspec.MsgspecError, RecursionError) as error:
        raise ValueError(f"{ABOUT}: {error}") from error


def _table(path: Path) -> pd.DataFrame:
    try:
        return read_csv(path)
    except ValueError as error:
        raise ValueError(f"{path.name}: {error}") from error


def _verdict(path: Path) -> pd.DataFrame:
    """A judgement; what is not a number was written as nothing."""
    rows = _table(path).to_dict("records")
    for row in rows:
        row |= {name: row[name] or "nan" for name in NUMBERS if name in row}
    try:
        found = msgspec.convert(rows, list[Row], strict=False)
    except msgspec.ValidationError as error:
        raise ValueError(f"{path.name}: {error}") from error
    return _read_rows(found)


def _read_rows(rows: list[Row]) -> pd.DataFrame:
    columns = [field.name for field in msgspec.structs.fields(Row)]
    return pd.DataFrame([msgspec.structs.asdict(row) for row in rows], columns=columns)


def nothing_judged() -> pd.DataFrame:
    """A verdict without rows."""
    return _read_rows([])


def unreadable_result(name: str, error: str) -> Stored:
    """A study of whose results no more can be said than why they cannot be read."""
    return Stored(name, "", (), {}, {}, nothing_judged(), {}, {}, error)


def csv_bytes(table: pd.DataFrame) -> bytes:
    """A table as CSV: numbers with all the digits that they need to be read back."""
    return table.to_csv(index=False, lineterminator="\n").encode()


def read_csv(path: Path | io.BytesIO) -> pd.DataFrame:
    """A CSV as text: nothing in it is read as missing, and no row is longer or shorter.

    Raises
    ------
    ValueError
        If it is no table, not UTF-8, or a row has not as many values as there are columns;
        `pandas.errors.EmptyDataError` if there is no heading.
    """
    content = path.getvalue() if isinstance(path, io.BytesIO) else _content(path)
    columns = read_columns(content)
    if not columns:
        raise pd.errors.EmptyDataError("not even a heading")
    return pd.DataFrame(columns, dtype=str)


def verdict_json(studies: list[Stored]) -> bytes:
    """`verdict.json`: a list, one object a judged quantity; what is not finite is null.

    Each has the seconds that its study took; those of results that do not say are null. A study
    that did not finish has one object, of no layer. Rows of a candidate name it.
    """
    keys = ("layer", "quantity", "unit", *NUMBERS, "verdict", "because", "rows", "at")
    found: list[dict[str, object]] = []
    for study in studies:
        whose = {key: study.origin[key] for key in ("candidate",) if key in study.origin}
        if study.error:
            broken: dict[str, object] = {"layer": None, "quantity": "study finished", "unit": "1"}
            broken |= {"observed": 0.0, "reference": 1.0, "error": 1.0, "limit": 0.0}
            broken |= {"verdict": "fail", "because": study.error, "seconds": None}
            found.append({"study": study.name} | whose | broken)
            continue
        for row in study.verdict.to_dict("records"):
            judged = {str(key): _finite(row[key]) for key in keys}
            found.append(
                {"study": study.name} | whose | judged | {"seconds": study.seconds or None}
            )
    return _json(found)


def _finite(value: object) -> object:
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _json(content: object) -> bytes:
    return (json.dumps(content, indent=1, ensure_ascii=False, allow_nan=False) + "\n").encode()


def _lay_out(figure: Figure) -> None:
    """Lay out once, not again for each format."""
    plain_logarithms(figure)
    engine = figure.get_layout_engine()
    if engine is not None:
        engine.execute(figure)
        figure.set_layout_engine(None)  # "none" would still draw every figure twice a format


def _render_figure(figure: Figure, kind: str, margin: float | None) -> bytes:
    page = io.BytesIO()
    # A date inside the file would make two equal pictures differ.
    trim: Any = {} if margin is None else {"bbox_inches": "tight", "pad_inches": margin}
    date = {"Date": None} if kind == "svg" else None
    figure.savefig(page, format=kind, metadata=date, **trim)
    return shorten_paths(page.getvalue()) if kind == "svg" else page.getvalue()
