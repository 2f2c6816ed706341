"""Sources: every key in brackets is an entry of docs/references.bib, and every entry is cited."""

from __future__ import annotations

import re
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
BIBLIOGRAPHY = (ROOT / "docs" / "references.bib").read_text(encoding="utf-8")
ENTRIES = re.findall(r"^@\w+\{(\w+),", BIBLIOGRAPHY, flags=re.M)
GROUP = re.compile(r"(?<![\w\])])\[(\w+(?:,\s+\w+)*)\](?!\()")
DATED = re.compile(r"[A-Za-z]\w*[A-Za-z](?:1[6-9]|20)\d\d")
"""A key that ends in a year: whatever is in brackets and looks like one must be an entry."""
FREE = re.compile(r"doi:|\b[A-Z][a-zé]+,? \(?(?:1[6-9]\d\d|20[0-2]\d)\b")
"""A source that stands in the text itself."""


def texts():
    """Path -> text, of code, tests, data of studies and documents."""
    folders = ("msvalidate", "reference_fem", "studies", "tests", "docs")
    paths = [path for folder in folders for path in (ROOT / folder).rglob("*.py")]
    paths += [*(ROOT / "docs").rglob("*.md"), *ROOT.glob("*.md")]
    paths += (ROOT / "studies").rglob("*.toml")
    mine = Path(__file__).resolve()
    return {
        str(path.relative_to(ROOT)): path.read_text(encoding="utf-8")
        for path in paths
        if path.resolve() != mine and path.name != "CHANGELOG.md"
    }


def cited(text):
    """Keys in brackets, of entries that there are and of others that look like one."""
    words = {word for group in GROUP.findall(text) for word in re.split(r",\s+", group)}
    return {word for word in words if word in ENTRIES or DATED.fullmatch(word)}


def test_keys_and_entries_are_the_same():
    found = {key for text in texts().values() for key in cited(text)}
    assert sorted(found - set(ENTRIES)) == []
    assert sorted(set(ENTRIES) - found) == []
    assert len(ENTRIES) == len(set(ENTRIES))


def test_sources_are_named_by_key():
    # Studies print sources in tables, which are read without the bibliography.
    wrong = [
        path
        for path, text in texts().items()
        if path.startswith(("msvalidate", "reference_fem")) and FREE.search(text)
    ]
    assert wrong == []


def test_a_key_in_brackets_is_noticed():
    text = "as in [Nobody1999], [Nye1957,\nHill1963]; not x[Nye1957], dict[Index] or [Nye](a.md)"
    assert cited(text) == {"Nobody1999", "Nye1957", "Hill1963"}
    free = ("Nobody (1999)", "Nobody and Nye 1999", "see doi:10.1000/1")
    assert [text for text in (*free, "as in [Nye1957], of 1957 points") if FREE.search(text)] == [
        *free
    ]
