"""First screen of every page, and the one builder of pages.

Each page begins with a `FirstScreen`: a picture of a body, the verdict as one sentence, a summary
table and a recommendation. Template `base.html` shows it, the contents bar, and the entry of every
source whose key the page contains.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from msvalidate.bench.judging.evidence import HELD, OPEN
from msvalidate.bench.output.baseline import HOME
from msvalidate.bench.output.pictures import Picture
from msvalidate.bench.output.rendering import render_template
from msvalidate.problem.records import dataclass
from msvalidate_check.verdict import AGREES, DIFFERS

MIXED = "mixed"
"""State of a badge whose rows agree in part."""
BIBLIOGRAPHY = "references.bib"
"""File of all sources; a wheel has it inside the package."""
FIELDS = ("author", "title", "journal", "booktitle", "publisher", "school", "howpublished", "note")
"""Fields of a source that are shown, in this order; the year follows."""
_ENTRY = re.compile(r"^@\w+\{(\w+),(.*?)^\}", re.MULTILINE | re.DOTALL)
_FIELD = re.compile(r"(\w+)\s*=\s*\{((?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*)\}")
_KEYS = re.compile(r"\[(\w+(?:,\s+\w+)*)\]")


@dataclass(frozen=True)
class Summary:
    """Short table: caption, heads, rows of text, and columns of numbers."""

    caption: str
    heads: Sequence[str]
    rows: Sequence[Sequence[str]]
    numeric: Sequence[bool]


@dataclass(frozen=True)
class FirstScreen:
    """Content of the first screen of a page.

    Parameters
    ----------
    eyebrow, heading
        Kind of the page, and its title.
    badge, sentence
        State and words of the badge, by default those of the state; the verdict as one sentence.
    advice
        Recommendation; empty if the record does not decide.
    summary, picture
        Table in the user's units, and a picture of a body; None if there is none.
    remarks
        Short sentences below the verdict.
    question
        Paragraph that states what is examined; empty if the heading does.
    """

    eyebrow: str
    heading: str
    badge: tuple[str, str]
    sentence: str
    advice: str = ""
    summary: Summary | None = None
    picture: Picture | None = None
    remarks: Sequence[str] = ()
    question: str = ""


def agreement_badge(status: str, verdicts: Sequence[str], words: str) -> tuple[str, str]:
    """Insert the number of rows that agree into the words of a badge.

    The words have a pair of braces for this number and one for that of all rows. Failed or
    unfinished checks keep their own state.
    """
    agreeing = [word == AGREES for word in verdicts if word in {AGREES, DIFFERS, *OPEN}]
    if status not in {*HELD, DIFFERS} or not agreeing:
        return status, ""
    state = status if all(agreeing) or status == DIFFERS else MIXED
    return state, words.format(sum(agreeing), len(agreeing))


def render_screen(
    template: str, screen: FirstScreen, parts: Mapping[str, str], **values: Any
) -> str:
    """HTML of a page that begins with a first screen and ends with its sources.

    Parameters
    ----------
    template
        Extension of `base.html`.
    parts
        Anchor of each part -> its name in the contents bar.
    """
    return render_template(template, screen=screen, parts=parts, cited=cited_sources, **values)


def cited_sources(text: str) -> list[tuple[str, str]]:
    """Keys in brackets in a text, and their entries in the bibliography."""
    keys = {key for group in _KEYS.findall(text) for key in re.split(r",\s+", group)}
    return sorted((key, entry) for key, entry in bibliography().items() if key in keys)


@cache
def bibliography() -> dict[str, str]:
    """Key of each source -> its entry as one line."""
    checkout = HOME.parent / "docs" / BIBLIOGRAPHY
    text = (checkout if checkout.is_file() else HOME / BIBLIOGRAPHY).read_text(encoding="utf-8")
    return {key: _entry_text(dict(_FIELD.findall(body))) for key, body in _ENTRY.findall(text)}


def _entry_text(entry: Mapping[str, str]) -> str:
    shown = [
        re.sub(r"[{}]|\.$", "", " ".join(entry[name].split())) for name in FIELDS if name in entry
    ]
    return f"{'. '.join(shown)}{', ' * ('year' in entry)}{entry.get('year', '')}."
