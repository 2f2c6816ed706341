"""A folder of tables as they were, and how a table is held to the one that was kept.

One layout, whoever writes it: ``quick/STUDY/TABLE.csv`` and ``full/STUDY/TABLE.csv`` by
``msvalidate check --baseline``, ``pytest/TABLE.csv`` by the pytest plugin, and beside these folders
`REASONS`, which says why numbers moved. Neither touches what the other wrote. A table is text:
column -> its values, numbers with as many digits as they need to be read back.
"""

from __future__ import annotations

import csv
import io
import math
import re
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

Columns = Mapping[str, Sequence[str]]
"""A table: column -> its values as text, as many in each."""
PYTEST = "pytest"
"""Folder of the tables that tests recorded."""
REASONS = "REASONS.md"
HEADING = "# Why the numbers of this baseline moved\n\n"
RELATIVE = 1e-6
"""rtol: what other versions of the libraries and another order of sums change, with a factor of a
hundred; no digit that a reader of a table sees."""
OF_RANGE = 1e-9
"""atol over the largest distance between a column's values: a value near zero is known no better
than the large ones that it is a difference of."""
MOVES = 5
"""Maximum number of moved tables that a line of the file of reasons names."""
MISSING = {"", "nan", "inf", "-inf"}
"""No numbers: among them, failures even where the baseline has the same."""
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]*")


class BaselineError(ValueError):
    """A table, a name or a folder that cannot be one of a baseline: thing, value, remedy."""


@dataclass(frozen=True)
class Farthest:
    """The value of a column that is farthest off for its limit.

    Parameters
    ----------
    row
        Its row, the first is 0.
    seen, reference
        The value as it is, and as it was.
    limit
        The most that they may differ, in the column's unit; 0 for words, which are exact.
    off
        How many values of the column are off by more than their limits.
    words
        Whether one of the two is no number.
    """

    row: int
    seen: str
    reference: str
    limit: float
    off: int
    words: bool


def farthest(
    seen: Sequence[str],
    reference: Sequence[str],
    *,
    relative: float = RELATIVE,
    absolute: float = 0.0,
) -> Farthest | None:
    """The value of a column that is farthest off for its limit; None if all are the same words.

    Parameters
    ----------
    seen, reference
        The column as it is and as it was, as text and equally long. Numbers agree within
        absolute + `OF_RANGE` times the column's range + relative·abs(reference), words exactly.
    relative
        1.
    absolute
        In the column's unit.
    """
    if not len(seen):
        return None
    a, b = np.array([_number(v) for v in seen]), np.array([_number(v) for v in reference])
    numbers = np.isfinite(a) & np.isfinite(b)
    alike = np.array([v == w for v, w in zip(seen, reference, strict=True)])
    missing = np.array([value.lower() in MISSING for value in reference])
    wrong = np.flatnonzero(~numbers & (~alike | (missing & numbers.any())))
    if len(wrong):
        i = int(wrong[0])
        return Farthest(i, seen[i], reference[i], 0.0, len(wrong), words=True)
    if not numbers.any():
        return None
    with np.errstate(over="ignore"):  # beyond all numbers is farther than any limit
        atol = absolute + OF_RANGE * float(np.ptp(b[numbers]))
        limit = atol + relative * np.abs(b)
        error = np.abs(a - b)
        share = error / np.where(limit > 0, limit, np.finfo(float).tiny)
    i = int(np.where(numbers, share, -1.0).argmax())
    off = int(np.count_nonzero(numbers & (error > limit)))
    return Farthest(i, seen[i], reference[i], float(limit[i]), off, words=False)


def check_name(name: object) -> str:
    """The name of a table, which is that of its file.

    Raises
    ------
    BaselineError
        If it cannot be a file's name everywhere.
    """
    if not isinstance(name, str) or not NAME.fullmatch(name):
        raise BaselineError(
            f"baseline {name!r}: no name for a file; use letters, digits, '_', '-' and '.'"
        )
    return name


def make_columns(name: str, values: Mapping[str, object]) -> dict[str, list[str]]:
    """Numbers or columns of numbers or words as a table: column -> values as text.

    Parameters
    ----------
    name
        Of the table, for the message.
    values
        Column -> a number, a word, or an array (rows,) of them, in the column's unit; single values
        make one row.

    Raises
    ------
    BaselineError
        If there is no column or no row, columns differ in length, an array has more than one axis,
        or a value is not finite.
    """
    if not isinstance(values, Mapping) or not values:
        raise BaselineError(
            f"baseline {name!r}: {_short(values)} holds no numbers; give {{'column': value}}"
        )
    for column in values:
        if not isinstance(column, str) or not column.strip() or not column.isprintable():
            raise BaselineError(
                f"baseline {name!r}: {column!r} is no name of a column; give a word"
            )
    found = {column: _texts(f"{name!r}, {column}", each) for column, each in values.items()}
    lengths = {column: len(each) for column, each in found.items()}
    if len(set(lengths.values())) > 1:
        said = ", ".join(f"{column} {length}" for column, length in lengths.items())
        raise BaselineError(
            f"baseline {name!r}: columns have {said} rows; record columns of one length together"
        )
    return found


def _texts(thing: str, values: object) -> list[str]:
    """A column's values as text."""
    try:
        array = np.asarray(values)
    except ValueError:
        array = np.asarray(None)
    if array.ndim > 1:
        raise BaselineError(
            f"baseline {thing}: an array of shape {array.shape}; give each of its columns a name"
        )
    array = array.reshape(-1)
    if array.dtype.kind == "O" and all(isinstance(value, str) for value in array):
        array = array.astype(str)  # as columns of pandas hold words
    if not len(array):
        raise BaselineError(f"baseline {thing}: no row; record a column that has some")
    if array.dtype.kind == "U":
        found = [str(value) for value in array]
        wrong = [
            word for word in found if word.strip().lower() in MISSING or not word.isprintable()
        ]
        if wrong:
            raise BaselineError(
                f"baseline {thing}: {wrong[0]!r} is no word to compare; record another"
            )
        return found
    if array.dtype.kind not in "biuf":
        raise BaselineError(
            f"baseline {thing}: {_short(values)} is of type {array.dtype}; record real numbers or "
            "words"
        )
    if array.dtype.kind == "f":
        array = array.astype(float)  # of any width, as it is written
    if not np.isfinite(array).all():
        row = int(np.flatnonzero(~np.isfinite(array))[0])
        raise BaselineError(
            f"baseline {thing}: row {row} is {array[row]}; record finite numbers only"
        )
    return [repr(value) for value in array.tolist()]


def table_bytes(columns: Columns) -> bytes:
    """A table as CSV."""
    text = io.StringIO(newline="")
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return text.getvalue().encode()


def read_columns(content: bytes) -> dict[str, list[str]]:
    """A CSV as text; {} if it has not even a heading. No row is longer or shorter.

    Raises
    ------
    ValueError
        If it is no table, not UTF-8, two columns have one name, or a row has not as many values as
        there are columns.
    """
    lines = io.StringIO(content.decode("utf-8"), newline="")
    try:
        heading, *rows = [row for row in csv.reader(lines, strict=True) if row] or [[]]
    except csv.Error as error:
        raise ValueError(f"no table ({error})") from error
    if len(set(heading)) < len(heading):
        raise ValueError("two columns have one name")
    for number, row in enumerate(rows):
        if len(row) != len(heading):
            raise ValueError(f"row {number} has {len(row)} values for {len(heading)} columns")
    columns = zip(*rows, strict=True) if rows else ((),) * len(heading)
    return dict(zip(heading, map(list, columns), strict=True))


def differences(
    seen: Columns,
    reference: Columns,
    *,
    relative: float = RELATIVE,
    absolute: Mapping[str, float] | None = None,
    hint: str = "",
) -> list[str]:
    """Describe how a table differs from its baseline, one line per difference.

    Parameters
    ----------
    seen, reference
        The table as it is and as it was.
    relative
        As for `farthest`.
    absolute
        The same by column; 0 for columns that are not in it.
    hint
        Remedy for numbers that are compared with a column of zeros, which leaves no tolerance.
    """
    lines = [f"column {column}: missing" for column in reference if column not in seen]
    lines += [f"column {column}: new" for column in seen if column not in reference]
    rows, known = (len(next(iter(each.values()), ())) for each in (seen, reference))
    if rows != known:
        return [*lines, f"rows: were {known}, are {rows}"]
    for column in seen:
        if column in reference:
            room = (absolute or {}).get(column, 0.0)
            found = farthest(seen[column], reference[column], relative=relative, absolute=room)
            if found and found.off:
                exact = not found.words and not found.limit
                lines.append(f"{column}, {_moved(found)}{hint if exact else ''}")
    return lines


def _moved(found: Farthest) -> str:
    """What a value was and is, by how much it moved, and what was allowed."""
    others = "1 more row" if found.off == 2 else f"{found.off - 1} more rows"
    more = f"; and {others} moved" if found.off > 1 else ""
    said = f"row {found.row}: was {found.reference}, is {found.seen}"
    if found.words:
        return f"{said}; words are exact{more}"
    was = float(found.reference)
    error = abs(float(found.seen) - was)
    part = f" ({100 * error / abs(was):.3g} %)" if was else ""
    return f"{said}, moved by {error:.3g}{part}, allowed {found.limit:.3g}{more}"


def table_file(folder: Path, name: str) -> Path:
    """Where the baseline in a folder keeps a table that tests recorded."""
    return folder / PYTEST / f"{name}.csv"


def reasons_with(
    path: Path, what: str, names: Sequence[str], reason: str, moves: Sequence[str] = ()
) -> bytes:
    """Content of the file of reasons with one more line.

    The line has the date, the commit of the working directory if there is one, what was renewed,
    the reason and what moved by how much.

    Parameters
    ----------
    path
        The file; it may be missing.
    what
        `PYTEST`, "quick", "full" or the name of a command.
    names
        Tables or studies that were renewed; empty if all of them were.
    reason
        Reason in one line.
    moves
        Results of `describe_move`; empty ones are left out.

    Raises
    ------
    BaselineError
        If the file is not UTF-8.
    """
    try:
        text = path.read_bytes().decode("utf-8") if path.is_file() else HEADING
    except UnicodeDecodeError as error:
        raise BaselineError(
            f"{path.name}: not UTF-8 at byte {error.start}; save it as UTF-8"
        ) from error
    end = "" if text.endswith("\n") else "\n"
    whose = f"{what}; {', '.join(names)}" if names else what
    when = ", ".join(filter(None, (f"{datetime.now(UTC):%Y-%m-%d}", _commit())))
    shown = [move for move in moves if move]
    shown[MOVES:] = [f"and {len(shown) - MOVES} more tables"] if len(shown) > MOVES else []
    line = "; ".join([f"- {when}: baseline ({whose}): {reason}", *shown])
    return f"{text}{end}{line}\n".encode()


def _commit() -> str:
    """Commit of the working directory, "" outside a repository or without git."""
    try:
        answer = subprocess.run(
            ["git", "rev-parse", "--short=12", "HEAD"],
            capture_output=True,
            text=True,
            check=True,
            timeout=5.0,
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return f"commit {answer.stdout.strip()}"


def describe_move(name: str, table: bytes, reference: bytes | None) -> str:
    """Describe in a few words how a table differs from its baseline, "" if it does not.

    Parameters
    ----------
    name
        Name of the table.
    table, reference
        The table as it is and as it was, as CSV; None if the table is new.
    """
    if reference is None:
        return f"{name} is new"
    try:
        lines = differences(read_columns(table), read_columns(reference))
    except ValueError:
        return f"{name} could not be read before"
    more = f", and {len(lines) - 1} more differences" if len(lines) > 1 else ""
    return f"{name}: {lines[0]}{more}" if lines else ""


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _short(value: object) -> str:
    text = " ".join(repr(value).split())
    return text if len(text) < 40 else f"{text[:36]} …"
