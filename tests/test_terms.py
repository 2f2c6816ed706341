"""Terms that a reader searches for stand under the heading that docs/terms.toml names."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
TERMS = tomllib.loads((ROOT / "docs" / "terms.toml").read_text("utf-8"))


def missing(terms, read):
    """Return the terms whose page has no such heading, or whose section does not use the term."""
    wrong = []
    for term, (page, heading) in terms.items():
        sections = re.split(r"^#+ (.+)$", read(page), flags=re.MULTILINE)
        text = " ".join(
            dict(zip(sections[1::2], sections[2::2], strict=True)).get(heading, "").split()
        )
        if term.lower() not in text.lower():
            wrong.append(term)
    return wrong


def test_each_term_is_used_where_the_table_says():
    assert missing(TERMS, lambda page: (ROOT / page).read_text("utf-8")) == []


def test_a_missing_heading_or_term_is_noticed():
    pages = {"page.md": "# Damping\nThe damping\nratio.\n## Step\nNothing of it.\n"}
    places = {"Damping": "damping ratio", "Step": "time step", "Other": "other"}
    terms = {term: ("page.md", heading) for heading, term in places.items()}
    assert missing(terms, pages.get) == ["time step", "other"]
