"""Templates of pages, and the text of docstrings as paragraphs and lists.

Everything reaches a template as plain text and is escaped there.
"""

from __future__ import annotations

import re
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from msvalidate.problem.records import dataclass

_CODE = re.compile(r"``(.+?)``|`([^`]+)`")
_UNIT = re.compile(
    r"(?<=\d) (?=[%±]|k[12]\b|([kMG]?Pa|k?N|N/m|[cmk]?m|m?J|[mµ]?s|min|k?g|kg/m³|GB)(?!\w))"
    r"|(?<=[±<=+]) (?=[\dk])| (?=[=+] )"
)
"""Gap between a number and its unit, bound or uncertainty."""


@dataclass(frozen=True)
class Block:
    """A paragraph, which has one item, or a list."""

    items: tuple[str, ...]
    listed: bool


def render_template(name: str, **values: Any) -> str:
    """HTML of a template; a value that it names and is not given is an error."""
    environment = Environment(
        loader=PackageLoader("msvalidate.bench.output"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
        finalize=_keep_units,
    )
    environment.filters["pieces"] = split_at_backticks
    return environment.get_template(name).render(**values)


def _keep_units(value: Any) -> Any:
    """Text whose numbers stay in one line with their units; markup is left as it is."""
    plain = type(value) is str and not value.startswith("data:")
    return _UNIT.sub("\N{NO-BREAK SPACE}", value) if plain else value


def paragraphs_and_lists(text: str) -> tuple[Block, ...]:
    """Paragraphs and lists of a docstring. An item starts with "- " and runs to a blank line."""
    found: list[Block] = []
    for part in re.split(r"\n\s*\n", text.strip()):
        plain, *items = re.split(r"(?:^|\n)\s*- ", part)
        if plain.strip():
            found.append(Block((_one_line(plain),), listed=False))
        if items:
            _extend_list(found, [_one_line(item) for item in items], goes_on=not plain.strip())
    return tuple(found)


def split_at_backticks(text: str) -> list[tuple[bool, str]]:
    """A text cut at its backticks: (whether it is code, words)."""
    found = []
    end = 0
    for match in _CODE.finditer(text):
        found += [(False, text[end : match.start()]), (True, match[1] or match[2])]
        end = match.end()
    return [piece for piece in [*found, (False, text[end:])] if piece[1]]


def _extend_list(found: list[Block], items: list[str], *, goes_on: bool) -> None:
    """Add items to the list before them, if nothing but blank lines lies between."""
    if goes_on and found and found[-1].listed:
        items = [*found.pop().items, *items]
    found.append(Block(tuple(items), listed=True))


def _one_line(text: str) -> str:
    return " ".join(text.split())
