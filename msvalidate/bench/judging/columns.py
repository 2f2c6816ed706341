"""Meanings of table columns: those of all studies, and those of one study."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path

from msvalidate.problem.records import dataclass

FILE = "columns.toml"


@dataclass(frozen=True)
class Column:
    """Meaning of a column, with its unit.

    Parameters
    ----------
    means
        In words; those in double quotes may stand among its numbers, as `words` may.
    words
        That may stand among its numbers.
    rounding
        Size, in its unit, below which its values are rounding, or how far a run stops from its
        limit: what another machine may give instead.
    label
        Head of the column for a reader; "" for the column's own name.
    """

    means: str
    words: tuple[str, ...] = ()
    rounding: float = 0.0
    label: str = ""

    def __str__(self) -> str:
        return self.means + "".join(f', or "{word}"' for word in self.words)


def column_key(table: str, column: str, known: Mapping[str, object]) -> str:
    """Key of a column in a file of columns: "table.column" or "column"."""
    key = f"{table}.{column}"
    return key if key in known else column


def common_columns() -> Mapping[str, Column]:
    """Columns whose meaning is one for all studies."""
    return _read(Path(__file__).with_name(FILE))


def read_columns(source: str) -> Mapping[str, Column]:
    """Columns of the study that a source file, or a folder above it, belongs to.

    Raises
    ------
    FileNotFoundError
        If neither the file's folder nor the one above has a file of columns.
    ValueError
        If that is no TOML, or an entry is neither a text nor a table of `Column`.
    """
    folder = Path(source).resolve().parent
    places = [place / FILE for place in (folder, folder.parent) if (place / FILE).is_file()]
    if not places:
        raise FileNotFoundError(f"{folder}: no {FILE}, which says what columns mean")
    return _read(places[0])


@cache
def _read(path: Path) -> Mapping[str, Column]:
    found = {}
    for name, entry in tomllib.loads(path.read_text("utf-8")).items():
        given = entry if isinstance(entry, dict) else {"means": entry}
        try:
            found[name] = Column(**given | {"words": tuple(given.get("words", ()))})
        except TypeError as error:
            raise ValueError(
                f"{path}: {name}: {error}; give means, words, rounding, label"
            ) from error
    return found
