"""A run's tables against committed ones, to notice a moved number.

Folders, limits and words are those of `msvalidate_check.baseline`. Columns whose names end as
`evidence.UNGATED` says depend on the machine and are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from msvalidate.bench.judging.columns import column_key
from msvalidate.bench.judging.evidence import UNGATED, Observed, Tolerance, judge_one
from msvalidate.bench.output.stored import csv_bytes
from msvalidate.problem import ProblemError
from msvalidate_check import exchange
from msvalidate_check.baseline import (
    OF_RANGE,
    REASONS,
    RELATIVE,
    BaselineError,
    describe_move,
    differences,
    read_columns,
    reasons_with,
)

HOME = Path(__file__).resolve().parents[2]
CHECKOUT = HOME.parent / "reports" / "baseline"
"""Folder of the baseline in a checkout; a wheel contains it in the package."""
BECAUSE = (
    f"each value as it was, within {RELATIVE:g} of it, {OF_RANGE:g} of the column's range, and "
    "what the column rounds; words are exact"
)


def _is_checkout() -> bool:
    return (HOME.parent / "pyproject.toml").is_file()


def baseline_folder(form: str, home: Path | None = None) -> Path:
    """Folder of the baseline of a form, "quick" or "full", in a user's own `home` or ours."""
    return (home or (CHECKOUT if _is_checkout() else HOME / "baseline")) / form


def check_home(home: Path) -> None:
    """Refuse our own baseline as one of the user's own.

    Raises `ProblemError` if `home` is it, or lies in it.
    """
    ours = baseline_folder("").resolve()
    if ours in (home.resolve(), *home.resolve().parents):
        raise ProblemError(f"--baseline {home}: our own; leave --baseline out")


def unknown_folders(folder: Path, studies: list[str]) -> list[str]:
    """Names in a baseline folder that belong to no study, and are not compared."""
    found = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(set(found) - set(studies))


def reasons(
    home: Path | None, form: str, reason: str, names: Sequence[str] = (), moves: Sequence[str] = ()
) -> tuple[Path, bytes]:
    """Return the path of the file of reasons, and its content with one more line.

    Parameters
    ----------
    home
        Folder of a user's own baseline, None for the built-in one.
    form
        Subfolder of the baseline: "quick", "full", "case" or "simulator".
    reason
        Reason in one line.
    names
        Studies, cases or simulators that are renewed; empty if all of them are.
    moves
        Descriptions of what moved.

    Raises
    ------
    ProblemError
        If the file cannot be read, or an installed package's own baseline would be renewed.
    """
    if home is None and not _is_checkout():
        raise ProblemError(
            "check --update: an installed package's own baseline stays; give --baseline DIR"
        )
    path = (home or CHECKOUT) / REASONS
    try:
        return path, reasons_with(path, form, names, reason, moves)
    except BaselineError as error:
        raise ProblemError(str(error)) from error


def renew(
    home: Path | None,
    form: str,
    tables: Mapping[str, Mapping[str, pd.DataFrame]],
    reason: str,
    *,
    named: bool,
) -> Path:
    """Replace a baseline by tables, and return the path of the file of reasons.

    Parameters
    ----------
    home, form, reason
        As for `reasons`.
    tables
        Study, case or simulator -> its tables by name.
    named
        True if the tables of all others stay.
    """
    files = {name: baseline_files(each) for name, each in tables.items()}
    folder, moves = baseline_folder(form, home), []
    for name, contents in files.items():
        for file, content in contents.items():
            path = folder / name / file
            before = path.read_bytes() if path.is_file() else None
            moves.append(describe_move(f"{name}/{path.stem}", content, before))
    place, text = reasons(home, form, reason, list(tables) if named else [], moves)
    # The reason first: a number never moves without one. It follows at once.
    exchange.replace_folder(folder, files, keep=named, beside=(place, lambda: text))
    return place


def baseline_files(tables: Mapping[str, pd.DataFrame]) -> dict[str, bytes]:
    """Return tables as the CSV files of a baseline."""
    return {f"{name}.csv": _kept(table) for name, table in tables.items()}


def tables(study: str) -> set[str]:
    """Names of the tables that a baseline of either form has of a study."""
    return {
        path.stem
        for form in ("quick", "full")
        for path in (baseline_folder(form) / study).glob("*.csv")
    }


def compare(
    tables: Mapping[str, pd.DataFrame], folder: Path, rounding: Mapping[str, float]
) -> list[dict[str, object]]:
    """Compare tables with those of a folder of a baseline.

    Parameters
    ----------
    tables
        Name -> table.
    folder
        Folder of the study, case or simulator in the baseline.
    rounding
        Column or "table.column" -> absolute tolerance in the unit of the column.

    Returns
    -------
    list
        Rows of a verdict of layer "baseline", one per unchanged table or difference. Empty if the
        folder has no table.
    """
    kept = {path.stem: path for path in folder.glob("*.csv")}
    rows = []
    for name in sorted({*kept, *tables} if kept else ()):
        if name not in kept:
            lines = ["the table is new"]
        elif name not in tables:
            lines = ["the table is missing"]
        else:
            keys = {str(each): column_key(name, str(each), rounding) for each in tables[name]}
            absolute = {each: rounding.get(key, 0.0) for each, key in keys.items()}
            lines = _moved(tables[name], kept[name].read_bytes(), absolute)
        rows += [_row(name, line) for line in lines or [""]]
    return rows


def _moved(table: pd.DataFrame, kept: bytes, absolute: Mapping[str, float]) -> list[str]:
    """Describe how a table differs from its baseline, one line per difference."""
    try:
        reference = read_columns(kept)
    except ValueError as error:
        return [f"the baseline cannot be read: {' '.join(str(error).split())}"]
    return differences(read_columns(_kept(table)), reference, absolute=absolute)


def _row(name: str, difference: str) -> dict[str, object]:
    tolerance = Tolerance(
        f"{name}.csv", 0.0, "differences", difference or BECAUSE, layer="baseline"
    )
    return judge_one(tolerance, Observed(float(bool(difference))))


def _kept(table: pd.DataFrame) -> bytes:
    return csv_bytes(table[[column for column in table if not str(column).endswith(UNGATED)]])
