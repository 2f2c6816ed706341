"""A run's tables against committed ones, to notice a moved number.

Folders, limits and words are those of `msvalidate_check.baseline`. Columns whose names end as
`evidence.UNGATED` says depend on the machine and are left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from msvalidate.bench.judging.columns import column_key
from msvalidate.bench.judging.evidence import UNGATED, Evidence, Observed, Tolerance, judge_one
from msvalidate.bench.output.stored import csv_bytes
from msvalidate.problem import ProblemError
from msvalidate_check import exchange
from msvalidate_check.baseline import (
    OF_RANGE,
    REASONS,
    RELATIVE,
    BaselineError,
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
    home: Path | None, form: str, reason: str, studies: Sequence[str] = ()
) -> tuple[Path, bytes]:
    """The file that says why a baseline was renewed, and its content with one more line.

    `home` is the folder of a baseline of the user's own, None for ours; the form "quick" or "full";
    the reason is one line, of some studies or, where none are named, of all.

    Raises `ProblemError` if it cannot be read, or an installed package's own baseline would be
    renewed.
    """
    if home is None and not _is_checkout():
        raise ProblemError(
            "check --update: an installed package's own baseline stays; give --baseline DIR"
        )
    path = (home or CHECKOUT) / REASONS
    try:
        return path, reasons_with(path, form, studies, reason)
    except BaselineError as error:
        raise ProblemError(str(error)) from error


def renew(
    home: Path | None, form: str, found: Mapping[str, Evidence], reason: str, *, named: bool
) -> Path:
    """Make what studies found the baseline of a form, and say why; the file that says so.

    All is as for `reasons`. The baselines of other studies stay if these were `named` one by one.
    """
    tables = {name: baseline_files(evidence) for name, evidence in found.items()}
    names = list(found) if named else []
    place, content = reasons(home, form, reason, names)
    # The reason first: a number never moves without one. It follows at once.
    exchange.replace_folder(
        baseline_folder(form, home), tables, keep=named, beside=(place, lambda: content)
    )
    return place


def baseline_files(evidence: Evidence) -> dict[str, bytes]:
    """A study's tables as a baseline keeps them."""
    return {f"{name}.csv": _kept(table) for name, table in evidence.tables.items()}


def tables(study: str) -> set[str]:
    """Names of the tables that a baseline of either form has of a study."""
    return {
        path.stem
        for form in ("quick", "full")
        for path in (baseline_folder(form) / study).glob("*.csv")
    }


def compare(evidence: Evidence, folder: Path) -> list[dict[str, object]]:
    """Rows of a verdict, layer "baseline": one a table that is as it was, one a difference else.

    None if there is no folder of the study in the baseline.
    """
    kept = {path.stem: path for path in folder.glob("*.csv")}
    rows = []
    for name in sorted({*kept, *evidence.tables} if kept else ()):
        if name not in kept:
            lines = ["the table is new"]
        elif name not in evidence.tables:
            lines = ["the table is missing"]
        else:
            table = evidence.tables[name]
            keys = {str(each): column_key(name, str(each), evidence.rounding) for each in table}
            rounding = {each: evidence.rounding.get(key, 0.0) for each, key in keys.items()}
            lines = _moved(table, kept[name].read_bytes(), rounding)
        rows += [_row(name, line) for line in lines or [""]]
    return rows


def _moved(table: pd.DataFrame, kept: bytes, rounding: Mapping[str, float]) -> list[str]:
    """Describe how a table differs from its baseline, one line per difference."""
    try:
        reference = read_columns(kept)
    except ValueError as error:
        return [f"the baseline cannot be read: {' '.join(str(error).split())}"]
    return differences(read_columns(_kept(table)), reference, absolute=rounding)


def _row(name: str, difference: str) -> dict[str, object]:
    tolerance = Tolerance(
        f"{name}.csv", 0.0, "differences", difference or BECAUSE, layer="baseline"
    )
    return judge_one(tolerance, Observed(float(bool(difference))))


def _kept(table: pd.DataFrame) -> bytes:
    return csv_bytes(table[[column for column in table if not str(column).endswith(UNGATED)]])
