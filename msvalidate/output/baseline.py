"""A run's tables against committed ones, to notice a moved number.

A table is compared with its baseline column by column: numbers within
atol + rtol·|reference|, atol scaled to the column's range, words exactly. A missing or extra
table, column or row is a failure, and so are values that are not finite. Columns whose names end
as `evidence.UNGATED` says depend on the machine and are left out.
"""

from __future__ import annotations

import io
import math
import re
from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from msvalidate.judging.evidence import UNGATED, Evidence, Observed, Tolerance, judge_one
from msvalidate.output.stored import csv_bytes, read_csv
from msvalidate.problem import ProblemError
from msvalidate_check import exchange
from msvalidate_check.baseline import (
    OF_RANGE,
    REASONS,
    RELATIVE,
    BaselineError,
    farthest,
    reason_line,
    reasons_with,
)

HOME = Path(__file__).resolve().parents[1]
CHECKOUT = HOME.parent / "reports" / "baseline"
"""Where a checkout keeps it; a wheel carries it inside the package."""
CHANGELOG = HOME.parent / "CHANGELOG.md"
UNRELEASED = "## Unreleased"
HEADING = "### Numbers"
REASON = (
    f"the value as it was, within {RELATIVE:g} of it, {OF_RANGE:g} of the column's range, and what "
    "the column rounds"
)


def baseline_folder(form: str, home: Path | None = None) -> Path:
    """Folder of the baseline of a form, "quick" or "full", in a user's own `home` or ours."""
    checkout = (HOME.parent / "pyproject.toml").is_file()
    return (home or (CHECKOUT if checkout else HOME / "baseline")) / form


def check_home(home: Path) -> None:
    """Refuse our own baseline as one of the user's own: CHANGELOG.md says why that moves.

    Raises
    ------
    ProblemError
        If `home` is it, or lies in it.
    """
    ours = baseline_folder("").resolve()
    if ours in (home.resolve(), *home.resolve().parents):
        raise ProblemError(f"--baseline {home}: our own; leave --baseline out")


def recorded_faults(study: str) -> pd.DataFrame | None:
    """What a study's faults move in its small form, see `judging.suspects`; None if unknown."""
    path = baseline_folder("faults") / f"{study}.csv"
    try:
        return pd.read_csv(path) if path.is_file() else None
    except ValueError:  # damaged: nothing to go by
        return None


def unknown_folders(folder: Path, studies: list[str]) -> list[str]:
    """What is in a baseline's folder of a form and no study's: nothing is compared with it."""
    found = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(set(found) - set(studies))


def reason_file(home: Path | None) -> Path:
    """The file that says why a baseline was renewed, in a `home` of the user's own or ours."""
    return home / REASONS if home else CHANGELOG


def reason_entry(home: Path | None, form: str, reason: str, studies: Sequence[str] = ()) -> bytes:
    """The file of reasons with one more line: see `changelog_entry` for ours.

    Parameters
    ----------
    home
        The folder of a baseline of the user's own, whose file need not be there; None for ours.
    form, reason, studies
        As for `changelog_entry`.

    Raises
    ------
    ProblemError
        If it cannot be read, or ours is missing or has no heading for it.
    """
    if home is None:
        return changelog_entry(form, reason, studies)
    try:
        return reasons_with(reason_file(home), form, studies, reason)
    except BaselineError as error:
        raise ProblemError(str(error)) from error


def changelog_entry(form: str, reason: str, studies: Sequence[str] = ()) -> bytes:
    """The changelog with one more line that says why the baseline of a form was renewed.

    Parameters
    ----------
    form
        "quick" or "full".
    reason
        Why, in one line.
    studies
        Those whose baseline was renewed; none for all of them.

    Raises
    ------
    ProblemError
        If there is none to write to (an installed package has no baseline of its own), it is not
        UTF-8, or has no heading for it.
    """
    if not CHANGELOG.is_file():
        raise ProblemError("check --update: no CHANGELOG.md to write to; run from a checkout")
    try:
        text = CHANGELOG.read_bytes().decode("utf-8")
    except UnicodeDecodeError as error:
        raise ProblemError(
            f"CHANGELOG.md: not UTF-8 at byte {error.start}; save it as UTF-8"
        ) from error
    heading = re.search(rf"^{UNRELEASED}[ \t]*(\r?\n)", text, re.MULTILINE)
    if not heading:
        raise ProblemError(f"CHANGELOG.md: no heading {UNRELEASED!r}; add it")
    end = heading[1]  # of a line, as the file has it
    entry = f"{reason_line(form, studies, reason)}{end}"
    later = re.compile(r"^## ", re.MULTILINE).search(text, heading.end())
    numbers = re.compile(rf"^{HEADING}[ \t]*\r?\n(?:[ \t]*\r?\n)?", re.MULTILINE).search(
        text, heading.end(), later.start() if later else len(text)
    )
    place = numbers.end() if numbers else heading.end()
    added = entry if numbers else f"{end}{HEADING}{end}{end}{entry}"
    return (text[:place] + added + text[place:]).encode()


def renew(
    home: Path | None, form: str, found: Mapping[str, Evidence], reason: str, *, named: bool
) -> Path:
    """Make what studies found the baseline of a form, and say why; the file that says so.

    Parameters
    ----------
    home, form, reason
        As for `reason_entry`.
    found
        Study -> what it found.
    named
        Whether the baselines of other studies stay, as these were named one by one.
    """
    tables = {name: baseline_files(evidence) for name, evidence in found.items()}
    place, names = reason_file(home), list(found) if named else []
    # The reason first: a number never moves without one. It follows at once.
    exchange.replace_folder(
        baseline_folder(form, home),
        tables,
        keep=named,
        beside=(place, lambda: reason_entry(home, form, reason, names)),
    )
    return place


def baseline_files(evidence: Evidence) -> dict[str, bytes]:
    """A study's tables as a baseline keeps them."""
    return {
        f"{name}.csv": csv_bytes(_compared_columns(table))
        for name, table in evidence.tables.items()
    }


def tables(study: str) -> set[str]:
    """Names of the tables that a baseline of either form has of a study."""
    return {
        path.stem
        for form in ("quick", "full")
        for path in (baseline_folder(form) / study).glob("*.csv")
    }


def compare(evidence: Evidence, folder: Path) -> list[dict[str, object]]:
    """Rows of a verdict, layer "baseline": one a column, and one for what is missing or extra.

    Parameters
    ----------
    evidence
        What a study found.
    folder
        The study's folder in the baseline; an empty list if there is none.
    """
    if not any(folder.glob("*.csv")):
        return []
    known = {path.stem for path in folder.glob("*.csv")}
    rows = [_compare_names("tables", known, set(evidence.tables))]
    for name in sorted(known & set(evidence.tables)):
        try:
            reference = read_csv(folder / f"{name}.csv")
        except pd.errors.EmptyDataError:  # not even a heading
            reference = pd.DataFrame()
        except ValueError as error:
            because = f"the baseline cannot be read: {' '.join(str(error).split())}"
            rows.append(judge_one(_tolerance(f"{name}.csv", 0.0, because), Observed(math.nan)))
            continue
        rows += compare_tables(name, evidence.tables[name], reference, evidence.rounding)
    return rows


def compare_tables(
    name: str, table: pd.DataFrame, reference: pd.DataFrame, rounding: Mapping[str, float]
) -> list[dict[str, object]]:
    """Rows of a verdict for one table.

    Parameters
    ----------
    name
        The table's.
    table
        As a study made it.
    reference
        As text; see `stored.read_csv`.
    rounding
        Column -> size below which its values are rounding.
    """
    seen = read_csv(io.BytesIO(csv_bytes(_compared_columns(table))))
    names, known = [str(column) for column in seen], [str(column) for column in reference]
    rows = [
        _compare_names(f"{name}.csv: columns", set(known), set(names)),
        judge_one(
            _tolerance(f"{name}.csv: rows", 0.0, "no row may be missing or extra, and none at all"),
            Observed(len(table), len(reference) or math.nan),
        ),
    ]
    if len(table) != len(reference) or reference.empty:
        return rows
    for column in [column for column in names if column in known]:
        values = list(seen[column]), list(reference[column])
        rows.append(_compare_column(f"{name}.csv: {column}", *values, rounding.get(column, 0.0)))
    return rows


def _compare_column(
    quantity: str, seen: list[str], reference: list[str], rounding: float
) -> dict[str, object]:
    """The judgement of one column: its words, or its value that is farthest off for its limit."""
    found = farthest(seen, reference, absolute=rounding)
    if found is None:
        return judge_one(_tolerance(quantity, 0.0, "words are exact"), Observed(0.0))
    if found.words:
        because = f"row {found.row}: {found.seen!r} where the baseline has {found.reference!r}; "
        because += "words are exact"
        return judge_one(_tolerance(quantity, 0.0, because), Observed(found.off, 0.0))
    tolerance = _tolerance(quantity, found.limit, f"row {found.row}: {REASON}")
    return judge_one(tolerance, Observed(float(found.seen), float(found.reference)))


def _compare_names(quantity: str, known: set[str], found: set[str]) -> dict[str, object]:
    """The judgement of two sets of names."""
    missing, extra = sorted(known - found), sorted(found - known)
    because = "none may be missing or extra"
    because += f"; missing: {', '.join(missing)}" if missing else ""
    because += f"; extra: {', '.join(extra)}" if extra else ""
    off = len(missing) + len(extra)
    observed = Observed(off if known else math.nan, 0.0)
    return judge_one(_tolerance(f"{quantity}: missing or extra", 0.0, because), observed)


def _tolerance(quantity: str, limit: float, because: str) -> Tolerance:
    return Tolerance(quantity, limit, "as in the table", because, layer="baseline")


def _compared_columns(table: pd.DataFrame) -> pd.DataFrame:
    return table[[column for column in table if not str(column).endswith(UNGATED)]]
