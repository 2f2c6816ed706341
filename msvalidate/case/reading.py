"""A case file read: what is wrong with it is told by file, line, key and value, with the remedy."""

from __future__ import annotations

import difflib
import re
import tomllib
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path as FilePath
from typing import Any, get_args, get_type_hints

import msgspec

from msvalidate.case.lines import Path, key_lines, line_of
from msvalidate.case.schema import SCHEMA, CaseFile
from msvalidate.problem import ProblemError
from msvalidate.problem.checks import format_value, require_type
from msvalidate.problem.records import dataclass

LARGEST_FILE = 10_000_000
"""Bytes: a case file names its mesh, it does not hold it."""
_AT = re.compile(r" - at `\$(.*)`$")
_STEP = re.compile(r"\.([^.\[\]]+)|\[(\d+|\.\.\.)\]")
_UNKNOWN = re.compile(r"Object contains unknown field `(.*?)`")
_MISSING = re.compile(r"Object missing required field `(.*?)`")
_EXPECTED = re.compile(r"Expected `(.*?)`(?: of length .*?)?, got `(.*?)`")
_WORD = re.compile(r"\w+")
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
    """A case file's content, and where its keys stand.

    Parameters
    ----------
    name
        Of the file, as messages show it.
    folder
        Where the mesh is looked for.
    data
        What the file holds, of right types.
    lines
        Line of each key.
    """

    name: str
    folder: FilePath
    data: CaseFile
    lines: dict[Path, int]

    @contextmanager
    def at(self, *path: str | int) -> Iterator[None]:
        """Tell of what is refused inside at which line of the file it stands."""
        try:
            yield
        except CaseError:
            raise
        except ProblemError as error:
            raise self.error(path, str(error)) from error

    def error(self, path: Path, said: str) -> CaseError:
        """An error that names file, line and key: the one that the message is about, if it is."""
        inner = self._key_meant(path, said)
        line = line_of(self.lines, (*path, inner) if inner else path)
        return CaseError(_message(self.name, line, path, said))

    def _key_meant(self, path: Path, said: str) -> str:
        """A key of the table at a path that a message begins with, or ""."""
        words = set(_WORD.findall(said.partition(":")[0]))
        keys = [each[-1] for each in self.lines if each[:-1] == path]
        return next((str(key) for key in keys if key in words), "")


class CaseError(ProblemError):
    """A case file that asks no question; the message names its line."""


def read_source(path: str | FilePath) -> Source:
    """Read a case file and check its keys and types.

    Raises
    ------
    ProblemError
        If there is no such file, it is no TOML, a key is missing or unknown or its value of a wrong
        type; the message names file, line, key and remedy.
    """
    require_type("case file", path, str | FilePath)
    file = FilePath(path)
    name = format_value(file.name).strip("'")
    return parse_source(name, _read_text(file), file.resolve().parent)


def parse_source(
    name: str,
    text: str,
    folder: FilePath,
    change: Callable[[dict[str, Any]], None] = lambda _: None,
) -> Source:
    """The same of a case file's text: its name in messages, and where its mesh is looked for.

    `change` sets other values in what it holds.

    Raises
    ------
    ProblemError
        As `read_source`.
    """
    try:
        given = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        raise CaseError(f"case {name}: not TOML: {_one_line(error)}; mend that line") from error
    change(given)
    lines = key_lines(text)
    _check_version(name, given, lines)
    try:
        data = msgspec.convert(given, CaseFile)
    except (msgspec.ValidationError, RecursionError) as error:
        raise _explained(name, given, lines, str(error)) from error
    return Source(name, folder, data, lines)


def _read_text(file: FilePath) -> str:
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


def _check_version(name: str, given: dict[str, Any], lines: dict[Path, int]) -> None:
    version = given.get("schema")
    if version is None:
        raise CaseError(f"case {name}: no schema; begin the file with schema = {SCHEMA}")
    if isinstance(version, bool) or not isinstance(version, int) or not 1 <= version <= SCHEMA:
        said = f"{format_value(version)}; this program reads schema = {SCHEMA}"
        raise CaseError(_message(name, line_of(lines, ("schema",)), ("schema",), said))


def _explained(name: str, given: dict[str, Any], lines: dict[Path, int], said: str) -> CaseError:
    """The checker's words made ours: what stands there, what should, and the nearest name."""
    place = _AT.search(said)
    path = _path(place[1] if place else "")
    words = said[: place.start()] if place else said
    unknown, missing = _UNKNOWN.match(words), _MISSING.match(words)
    expected = _EXPECTED.match(words)
    if unknown:
        path = (*path, unknown[1])
        known = _known_keys(path[:-1])
        near = difflib.get_close_matches(unknown[1], known, n=1)
        hint = f"did you mean {near[0]}?" if near else f"choose {', '.join(known)}"
        told = f"no such key; {hint}"
    elif missing:
        path = (*path, missing[1])
        told = "missing; give it"
    elif expected and expected[1] == "array" and isinstance(_value(given, path), dict):
        told = f"one table; write [[{path[-1]}]], of which there may be several"
    elif expected:
        wanted = [WORDS.get(kind.strip(), kind.strip()) for kind in expected[1].split("|")]
        choices = " or ".join(dict.fromkeys(word for word in wanted if word != "nothing"))
        told = f"{format_value(_value(given, path))}; give {choices}"
    else:
        told = f"{format_value(_value(given, path))}; {words[0].lower()}{words[1:]}"
    return CaseError(_message(name, line_of(lines, path), path, told))


def _message(name: str, line: int | None, path: Path, said: str) -> str:
    where = f"{name}, line {line}" if line else name
    return f"case {where}: {_dotted(path)}{said}"


def _dotted(path: Path) -> str:
    """Keys as messages show them: support 2, value."""
    words = ""
    for step in path:
        if isinstance(step, int):
            words += f" {step + 1}"
        else:
            words += f"{'.' if words else ''}{format_value(step).strip(chr(39))}"
    return f"{words}: " if words else ""


def _path(steps: str) -> Path:
    """The checker's path, such as .support[1].on; "[...]" is the first that does not fit."""
    found: list[str | int] = []
    for key, place in _STEP.findall(steps):
        if key:
            found.append(key)
        elif place != "...":
            found.append(int(place))
    return tuple(found)


def _value(given: Any, path: Path) -> Any:
    for step in path:
        try:
            given = given[step]
        except (KeyError, IndexError, TypeError):
            return None
    return given


def _known_keys(path: Path) -> list[str]:
    """Keys of the table at a path."""
    kind: Any = CaseFile
    for step in path:
        if isinstance(step, int):
            continue
        kind = _struct_in(get_type_hints(kind)[step])
    return list(kind.__struct_fields__)


def _struct_in(hint: Any) -> Any:
    """The class of a table that a type names, in a list or beside others."""
    if isinstance(hint, type) and issubclass(hint, msgspec.Struct):
        return hint
    for inner in get_args(hint):
        found = _struct_in(inner)
        if found is not None:
            return found
    return None


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
