"""Floor 3: a study's results as files, and back: what a page is made of, without solving again.

A study's folder holds a CSV a table, `verdict.csv`, a PNG and an SVG a figure, and `study.json`:
its question, findings, columns, captions, provenance and seconds. Tables are read back as text:
what a page shows is what the files say.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pandas as pd
from matplotlib.figure import Figure

from msvalidate.evidence import Evidence, held
from msvalidate.figures import STYLE, plain_logarithms
from msvalidate.problem import ProblemError

FORMATS = ("png", "svg")
ABOUT = "study.json"
SUFFIXES = (".csv", ".json", *(f".{kind}" for kind in FORMATS))
NUMBERS = ("observed", "reference", "error", "limit")
"""Columns of a verdict that hold numbers."""


@dataclass(frozen=True, eq=False)
class Result:
    """A study that ran: its name, docstring, evidence and judgement."""

    name: str
    question: str
    evidence: Evidence
    verdict: pd.DataFrame


@dataclass(frozen=True, eq=False)
class Stored:
    """What a study left in its folder.

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

    @property
    def held(self) -> bool:
        """Whether it finished, judged something, and all that it judged passed."""
        return not self.error and held(self.verdict)


def files(
    result: Result, origin: Mapping[str, str], *, seconds: float = 0.0, plots: bool = True
) -> dict[str, bytes]:
    """The files of a study that ran, for so many `seconds`: name -> content."""
    evidence = result.evidence
    tables = {**evidence.tables, "verdict": result.verdict}
    found = {f"{name}.csv": csv(table) for name, table in tables.items()}
    captions = {}
    for name, draw in evidence.figures.items() if plots else ():
        captions[name] = (draw.__doc__ or name).partition("\n")[0]
        with mpl.rc_context(STYLE):
            figure = draw(evidence.tables)
            _lay_out(figure)
            found |= {f"{name}.{kind}": _rendered(figure, kind) for kind in FORMATS}
    used = {column for table in evidence.tables.values() for column in table}
    about = {
        "question": result.question,
        "findings": list(evidence.findings),
        "tables": list(evidence.tables),
        "columns": {c: meaning for c, meaning in evidence.columns.items() if c in used},
        "captions": captions,
        "origin": dict(origin),
        "seconds": seconds,
        "error": "",
        "files": sorted([*found, ABOUT]),
    }
    return found | {ABOUT: _json(about)}


def known_files(folder: Path) -> set[str]:
    """Names of the files that a run left in a study's folder; none if it is no such folder."""
    try:
        return set(json.loads((folder / ABOUT).read_text(encoding="utf-8"))["files"])
    except (OSError, ValueError, KeyError, TypeError):
        return set()


def unfinished(
    folder: Path, question: str, origin: Mapping[str, str], error: str, seconds: float = 0.0
) -> dict[str, bytes]:
    """The files of a study that did not finish: those of the run before, marked, if there are."""
    about: dict[str, Any] = {"question": question, "findings": [], "tables": [], "columns": {}}
    about |= {"captions": {}, "origin": dict(origin), "seconds": seconds, "files": [ABOUT]}
    found: dict[str, bytes] = {}
    if known_files(folder):
        found = {p.name: p.read_bytes() for p in sorted(folder.iterdir())}
        about = json.loads(found[ABOUT])
    return found | {ABOUT: _json(about | {"error": error})}


def read(folder: Path) -> Stored:
    """What a study left in `folder`.

    Raises
    ------
    ProblemError
        If a file is missing or is not what a run writes.
    """
    try:
        about = json.loads((folder / ABOUT).read_text(encoding="utf-8"))
        verdict = pd.DataFrame(columns=["layer", "quantity", *NUMBERS, "verdict"])
        if (folder / "verdict.csv").is_file():
            verdict = read_csv(folder / "verdict.csv")
            # What is not a number was written as nothing.
            verdict[list(NUMBERS)] = verdict[list(NUMBERS)].replace("", "nan").astype(float)
        return Stored(
            name=folder.name,
            question=about["question"],
            findings=tuple(about["findings"]),
            columns=about["columns"],
            origin=about["origin"],
            verdict=verdict,
            tables={name: read_csv(folder / f"{name}.csv") for name in about["tables"]},
            pictures={
                name: (caption, (folder / f"{name}.svg").read_bytes())
                for name, caption in about["captions"].items()
            },
            error=about["error"],
        )
    except FileNotFoundError as error:
        missing = Path(error.filename).name
        raise ProblemError(
            f"results of {folder.name}: {missing} is missing; run it again"
        ) from error
    except (KeyError, TypeError, AttributeError, ValueError) as error:
        raise ProblemError(
            f"results of {folder.name}: not what a run writes ({error}); run it again"
        ) from error


def unreadable(name: str, error: str) -> Stored:
    """A study of whose results no more can be said than why they cannot be read."""
    nothing = pd.DataFrame(columns=["layer", "quantity", *NUMBERS, "verdict"])
    return Stored(name, "", (), {}, {}, nothing, {}, {}, error)


def csv(table: pd.DataFrame) -> bytes:
    """A table as CSV: numbers with all the digits that they need to be read back."""
    return table.to_csv(index=False, lineterminator="\n").encode()


def read_csv(path: Path | io.BytesIO) -> pd.DataFrame:
    """A CSV as text: nothing in it is read as missing."""
    return pd.read_csv(path, dtype=str, keep_default_na=False, encoding="utf-8")


def verdicts(studies: list[Stored]) -> bytes:
    """`verdict.json`: a list, one object a judged quantity; what is not finite is null.

    A study that did not finish has one object, of no layer.
    """
    keys = ("layer", "quantity", "unit", *NUMBERS, "verdict", "because")
    found = []
    for study in studies:
        if study.error:
            broken: dict[str, object] = {"layer": None, "quantity": "study finished", "unit": "1"}
            broken |= {"observed": 0.0, "reference": 1.0, "error": 1.0, "limit": 0.0}
            broken |= {"verdict": "fail", "because": study.error}
            found.append({"study": study.name} | broken)
            continue
        for row in study.verdict.to_dict("records"):
            found.append({"study": study.name} | {str(key): _finite(row[key]) for key in keys})
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


def _rendered(figure: Figure, kind: str) -> bytes:
    page = io.BytesIO()
    # A date inside the file would make two equal pictures differ.
    figure.savefig(page, format=kind, metadata={"Date": None} if kind == "svg" else None)
    return page.getvalue()
