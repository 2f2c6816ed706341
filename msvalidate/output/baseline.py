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

import numpy as np
import pandas as pd

from msvalidate.judging.evidence import UNGATED, Evidence, Observed, Tolerance, judge_one
from msvalidate.output.stored import csv_bytes, read_csv
from msvalidate.problem import ProblemError

HOME = Path(__file__).resolve().parents[1]
CHECKOUT = HOME.parent / "reports" / "baseline"
"""Where a checkout keeps it; a wheel carries it inside the package."""
CHANGELOG = HOME.parent / "CHANGELOG.md"
UNRELEASED = "## Unreleased"
HEADING = "### Numbers"
RELATIVE = 1e-6
"""rtol: what other versions of the libraries and another order of sums change, with a factor of a
hundred; no digit that a reader of a table sees."""
OF_RANGE = 1e-9
"""atol over the largest distance between a column's values: a value near zero is known no better
than the large ones that it is a difference of."""
MISSING = {"", "nan", "inf", "-inf"}
"""No numbers: among them, failures even where the baseline has the same."""
REASON = (
    f"the value as it was, within {RELATIVE:g} of it, {OF_RANGE:g} of the column's range, and what "
    "the column rounds"
)


def baseline_folder(form: str) -> Path:
    """Folder of the baseline of a form, "quick" or "full"."""
    return (CHECKOUT if (HOME.parent / "pyproject.toml").is_file() else HOME / "baseline") / form


def recorded_faults(study: str) -> pd.DataFrame | None:
    """What a study's faults move in its small form, see `judging.suspects`; None if unknown."""
    path = baseline_folder("faults") / f"{study}.csv"
    try:
        return pd.read_csv(path) if path.is_file() else None
    except ValueError:  # damaged: nothing to go by
        return None


def unknown_folders(form: str, studies: list[str]) -> list[str]:
    """Folders of a baseline that belong to no study, so that nothing is compared with them."""
    folder = baseline_folder(form)
    found = [path.name for path in folder.iterdir()] if folder.is_dir() else []
    return sorted(set(found) - set(studies))


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
    what = f"{form}; {', '.join(studies)}" if studies else form
    entry = f"- Baseline ({what}): {reason}{end}"
    later = re.compile(r"^## ", re.MULTILINE).search(text, heading.end())
    numbers = re.compile(rf"^{HEADING}[ \t]*\r?\n(?:[ \t]*\r?\n)?", re.MULTILINE).search(
        text, heading.end(), later.start() if later else len(text)
    )
    place = numbers.end() if numbers else heading.end()
    added = entry if numbers else f"{end}{HEADING}{end}{end}{entry}"
    return (text[:place] + added + text[place:]).encode()


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
    a, b = np.array([_number(v) for v in seen]), np.array([_number(v) for v in reference])
    numbers = np.isfinite(a) & np.isfinite(b)
    alike = np.array([v == w for v, w in zip(seen, reference, strict=True)])
    missing = np.array([value.lower() in MISSING for value in reference])
    wrong = np.flatnonzero(~numbers & (~alike | (missing & numbers.any())))
    if len(wrong):
        i = wrong[0]
        because = f"row {i}: {seen[i]!r} where the baseline has {reference[i]!r}; words are exact"
        return judge_one(_tolerance(quantity, 0.0, because), Observed(len(wrong), 0.0))
    if not numbers.any():
        return judge_one(_tolerance(quantity, 0.0, "words are exact"), Observed(0.0))
    atol = rounding + OF_RANGE * float(np.ptp(b[numbers]))
    limit = atol + RELATIVE * np.abs(b)
    share = np.abs(a - b) / np.where(limit > 0, limit, np.finfo(float).tiny)
    i = int(np.where(numbers, share, -1.0).argmax())
    tolerance = _tolerance(quantity, float(limit[i]), f"row {i}: {REASON}")
    return judge_one(tolerance, Observed(float(a[i]), float(b[i])))


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


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan
