"""The line of each key of a TOML file, which neither the parser nor the checker of types tells.

The text has been parsed before, so it is known to be right: what is looked for is where headers and
keys stand. A key that is not found has the line of the table that it belongs to.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

Path = tuple[str | int, ...]
"""Keys, and places in lists from 0, from the top of the file."""

_HEADER = re.compile(r"^\s*(\[{1,2})\s*([^\[\]]+?)\s*\]{1,2}")
_KEY = re.compile(
    r"""^\s*((?:[\w-]+|"[^"]*"|'[^']*')(?:\s*\.\s*(?:[\w-]+|"[^"]*"|'[^']*'))*)\s*="""
)
_PART = re.compile(r"""[\w-]+|"[^"]*"|'[^']*'""")
_INLINE = re.compile(r"([{,]\s*)([\w-]+)\s*=")


def key_lines(text: str) -> dict[Path, int]:
    """Line, from 1, of each table and key of a TOML text."""
    found: dict[Path, int] = {}
    count: Counter[str] = Counter()
    table: Path = ()
    for number, line in _logical_lines(text):
        header = _HEADER.match(line)
        if header:
            name = ".".join(_parts(header[2]))
            table = tuple(_parts(header[2]))
            if header[1] == "[[":
                table = (*table, count[name])
                count[name] += 1
            found.setdefault(table, number)
            continue
        key = _KEY.match(line)
        if key:
            path = (*table, *_parts(key[1]))
            found.setdefault(path, number)
            for inner in _INLINE.finditer(line[key.end() :]):
                found.setdefault((*path, inner[2]), number)
    return found


def line_of(lines: dict[Path, int], path: Path) -> int | None:
    """Line of a key, else of the nearest table around it; None of the file as a whole.

    Of tables of one name, [[support]], that of the first.
    """
    while path:
        for there in (path, (*path, 0)):
            if there in lines:
                return lines[there]
        path = path[:-1]
    return None


def _parts(dotted: str) -> list[str]:
    return [part.strip("\"'") for part in _PART.findall(dotted)]


def _logical_lines(text: str) -> Iterator[tuple[int, str]]:
    """Lines that begin a key or a header: not those inside strings of many lines or lists."""
    closing, depth = "", 0
    for number, line in enumerate(text.splitlines(), 1):
        if closing:
            if closing in line:
                closing = ""
            continue
        if depth == 0:
            yield number, line
        plain = re.sub(r"\"(?:[^\"\\]|\\.)*\"|'[^']*'|#.*", "", _without_long_strings(line))
        for mark in ('"""', "'''"):
            if line.count(mark) % 2:
                closing = mark
        if not _HEADER.match(line) or depth:
            depth = max(0, depth + plain.count("[") - plain.count("]"))


def _without_long_strings(line: str) -> str:
    return re.sub(r"\"\"\".*?\"\"\"|'''.*?'''", "", line)
