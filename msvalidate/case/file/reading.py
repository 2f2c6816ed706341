"""A case file read: what is wrong with it is told by file, line, key and value, with the remedy.

Neither the parser nor the checker of types tells lines: those of keys are looked for where it takes
a message.
"""

from __future__ import annotations

import difflib
import re
import tomllib
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, get_args, get_type_hints

import msgspec

from msvalidate.case.file.schema import SCHEMA, CaseFile
from msvalidate.case.file.units import LENGTH, UNITS, read_quantity
from msvalidate.problem import Mesh, ProblemError
from msvalidate.problem.checks import format_value, require_type
from msvalidate.problem.records import dataclass

Keys = tuple[str | int, ...]
"""Keys, and places in lists from 0, from the top of the file."""
LARGEST_FILE = 10_000_000
"""Bytes: a case file names its mesh, it does not hold it."""
_AT = re.compile(r" - at `\$(.*)`$")
_STEP = re.compile(r"\.([^.\[\]]+)|\[(\d+|\.\.\.)\]")
_UNKNOWN = re.compile(r"Object contains unknown field `(.*?)`")
_MISSING = re.compile(r"Object missing required field `(.*?)`")
_EXPECTED = re.compile(r"Expected `(.*?)`(?: of length .*?)?, got `(.*?)`")
_WORD = re.compile(r"\w+")
_ENDS = re.compile(r"""[]}"']\s*(#.*)?$""")
_NO_BRACKET = re.compile(r""""(?:[^"\\]|\\.)*"|'[^']*'|#.*""")
"""Patterns of the end of multi-line values, and of strings and comments."""
WORDS = {
    "float": "a number",
    "int": "a whole number",
    "str": "a text",
    "array": "a list",
    "object": "a table",
    "null": "nothing",
    "bool": "true or false",
    "datetime": "a date",
}
"""The checker's names of types, in words."""


@dataclass(frozen=True)
class Source:
    """A case file: its name in messages, where its mesh is looked for, content, of right types."""

    name: str
    folder: Path
    data: CaseFile
    text: str

    @contextmanager
    def at(self, *path: str | int) -> Iterator[None]:
        """Tell of what is refused inside at which line of the file it stands."""
        try:
            yield
        except CaseError:
            raise
        except ProblemError as error:
            raise self.error(path, str(error)) from error

    def error(self, path: Keys, said: str) -> CaseError:
        """An error that names file, line and key: the one that the message is about, if it is."""
        return _error(self.name, self.text, path, said)


class CaseError(ProblemError):
    """A case file that asks no question; the message names its line.

    If a side has to be chosen, the notes describe the sides of the `mesh`, of a case whose unit of
    length is `length`.
    """

    mesh: Mesh | None = None
    length = "m"


def read_source(path: str | Path) -> Source:
    """Read a case file and check its keys and types.

    Raises
    ------
    ProblemError
        If there is no such file, it is no TOML, a key is missing or unknown or its value of a wrong
        type; the message names file, line, key and remedy.
    """
    require_type("case file", path, str | Path)
    file = Path(path)
    name = format_value(file.name).strip("'")
    return parse_source(name, _read_text(file), file.resolve().parent)


def parse_source(
    name: str,
    text: str,
    folder: Path,
    change: Callable[[dict[str, Any]], None] = lambda _: None,
) -> Source:
    """The same of a case file's text: its name in messages, and where its mesh is looked for.

    `change` sets other values in what it holds. Errors are those of `read_source`.
    """
    try:
        given = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        said = " ".join(str(error).split())
        raise CaseError(f"case {name}: not TOML: {said}; mend that line") from error
    change(given)
    version = given.get("schema")
    if version is None:
        raise CaseError(f"case {name}: no schema; begin the file with schema = {SCHEMA}")
    if isinstance(version, bool) or not isinstance(version, int) or not 1 <= version <= SCHEMA:
        said = f"{format_value(version)}; this program reads schema = {SCHEMA}"
        raise _error(name, text, ("schema",), said)
    try:
        unit = _value(given, ("body", "unit"))
        metres = LENGTH.get(str(unit), unit if isinstance(unit, int | float) and unit > 0 else 1.0)
        lengths = {word: size / metres for word, size in LENGTH.items()}
        _convert_units(given, lengths)
        return Source(name, folder, msgspec.convert(given, CaseFile), text)
    except (msgspec.ValidationError, RecursionError) as error:
        raise _error(name, text, *_explained(given, str(error))) from error


def _convert_units(table: Any, lengths: Mapping[str, float], key: str = "") -> None:
    """Replace texts with a unit by numbers in the units of the file."""
    for step in [*table] if isinstance(table, dict) else range(len(table)):
        key = step if isinstance(step, str) else key
        value, units = table[step], UNITS.get(key, {})
        if isinstance(value, dict | list):
            _convert_units(value, lengths, key)
        elif isinstance(value, str):
            number = read_quantity(value, lengths if units is LENGTH else units)
            table[step] = value if number is None else number


def _read_text(file: Path) -> str:
    try:
        with file.open("rb") as opened:
            content = opened.read(LARGEST_FILE + 1)
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or str(error)
        raise CaseError(f"case {format_value(str(file))}: {why}; give a file to read") from error
    if len(content) > LARGEST_FILE:
        raise CaseError(
            f"case {format_value(file.name)}: more than {LARGEST_FILE:g} bytes; a case names its "
            "mesh, it does not hold it"
        )
    try:
        return content.decode("utf-8-sig").replace("\r\n", "\n")
    except UnicodeDecodeError as error:
        raise CaseError(
            f"case {format_value(file.name)}: byte {error.start} is no UTF-8; save it as such"
        ) from error


def _explained(given: dict[str, Any], said: str) -> tuple[Keys, str]:
    """The checker's words made ours: where, what stands there, what should, the nearest name."""
    place = _AT.search(said)
    path = _path(place[1] if place else "")
    words, value = said[: place.start()] if place else said, _value(given, path)
    unknown, missing = _UNKNOWN.match(words), _MISSING.match(words)
    expected = _EXPECTED.match(words)
    if unknown:
        path = (*path, unknown[1])
        known = _known_keys(path[:-1])
        near = difflib.get_close_matches(unknown[1], known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose {', '.join(known)}"
        homes = [table for table, keys in _tables() if unknown[1] in keys]
        told = f"no such key; {hint}"
        if homes:
            told = f"no such key here; it belongs to {' or '.join(homes)}"
    elif missing:
        path = (*path, missing[1])
        told = "missing; give it"
    elif expected and expected[1] == "array" and isinstance(value, dict):
        told = f"one table; write [[{path[-1]}]], of which there may be several"
    elif path[-1:] == ("on",) and isinstance(value, dict) and "at" in _known_keys(path[:-1]):
        told = "coordinates; name this key at, and leave on to sides by name"
    elif expected:
        wanted = [WORDS.get(kind.strip(), kind.strip()) for kind in expected[1].split("|")]
        choices = " or ".join(dict.fromkeys(word for word in wanted if word != "nothing"))
        key = next((step for step in reversed(path) if isinstance(step, str)), "")
        units = f", or a text with a unit: {', '.join(UNITS[key])}" if key in UNITS else ""
        told = f"{format_value(value)}; give {choices}{units}"
    else:
        told = f"{format_value(value)}; {words[0].lower()}{words[1:]}"
    return path, told


def _error(name: str, text: str, path: Keys, said: str) -> CaseError:
    """Error about a value of a file, with its line.

    The line is that of the first key below the path that the message names.

    Else of its own key, or of the nearest table around; of tables of one name of the first.
    """
    lines, words = key_lines(text), set(_WORD.findall(said.partition(":")[0]))
    meant = (each for each in lines if each[:-1] == path and each[-1] in words)
    around = ((*path[:end], *first) for end in range(len(path), 0, -1) for first in ((), (0,)))
    line = next((lines[each] for each in (*meant, *around) if each in lines), None)
    where = f"{name}, line {line}" if line else name
    return CaseError(f"case {where}: {_dotted(path)}{said}")


def key_lines(text: str) -> dict[Keys, int]:
    """Line, from 1, of each table and key of a TOML text that is known to be right."""
    found: dict[Keys, int] = {}
    count: Counter[Keys] = Counter()
    table: Keys = ()
    statement, began, depth = "", 1, 0
    for number, line in enumerate(text.split("\n"), 1):
        statement += f"{line}\n"
        plain = _NO_BRACKET.sub("", line)
        depth += plain.count("[") - plain.count("]")
        if number > began and (depth > 0 or not _ENDS.search(line)):
            continue
        try:
            given = tomllib.loads(statement)
        except (tomllib.TOMLDecodeError, RecursionError):
            continue  # it goes on in the next line
        is_header = statement.lstrip().startswith("[")
        for path, value in _entries(given, () if is_header else table):
            if is_header:
                table = (*path, count[path]) if isinstance(value, list) else path
                count[path] += 1
            found.setdefault(table if is_header else path, began)
        statement, began, depth = "", number + 1, 0
    return found


def _entries(given: dict[str, Any], table: Keys) -> Iterator[tuple[Keys, Any]]:
    """Keys of a table and of those in it, with their values."""
    for key, value in given.items():
        yield (*table, key), value
        if isinstance(value, dict):
            yield from _entries(value, (*table, key))


def _dotted(path: Keys) -> str:
    """Keys as messages show them: support 2, value."""
    words = ""
    for step in path:
        if isinstance(step, int):
            words += f" {step + 1}"
        else:
            words += f"{'.' if words else ''}{format_value(step).strip(chr(39))}"
    return f"{words}: " if words else ""


def _path(steps: str) -> Keys:
    """The checker's path, such as .support[1].on; "[...]" is the first that does not fit."""
    found: list[str | int] = []
    for key, place in _STEP.findall(steps):
        if key:
            found.append(key)
        elif place != "...":
            found.append(int(place))
    return tuple(found)


def _value(given: Any, path: Keys) -> Any:
    for step in path:
        try:
            given = given[step]
        except (KeyError, IndexError, TypeError):
            return None
    return given


def _known_keys(path: Keys) -> list[str]:
    """Keys of the table at a path."""
    kind: Any = CaseFile
    for step in path:
        if isinstance(step, int):
            continue
        kind = _struct_in(get_type_hints(kind)[step])
    return list(kind.__struct_fields__)


def _tables(
    kind: Any = CaseFile, where: str = "the top of the file"
) -> Iterator[tuple[str, tuple[str, ...]]]:
    """Each table of a case file, as messages name it, with its keys."""
    yield where, kind.__struct_fields__
    for name, hint in get_type_hints(kind).items():
        inner = _struct_in(hint)
        header = f"[[{name}]]" if str(hint).startswith("list") else f"[{name}]"
        if inner is not None:
            yield from _tables(inner, header if kind is CaseFile else f"{name} of {where}")


def _struct_in(hint: Any) -> Any:
    """The class of a table that a type names, in a list or beside others."""
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return hint
    for inner in get_args(hint):
        found = _struct_in(inner)
        if found is not None:
            return found
    return None
