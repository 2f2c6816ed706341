"""Pictures of docs/studies: named, drawn by what the study offers, small, shown on their page."""

from __future__ import annotations

import re
import runpy
import tomllib
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
STUDIES = ROOT / "docs" / "studies"
PICTURES = tomllib.loads((ROOT / "docs" / "pictures.toml").read_text("utf-8"))
PAGES = sorted(page.stem for page in STUDIES.glob("*.md"))
DRAWING = runpy.run_path(str(ROOT / "docs" / "draw_pictures.py"))
LARGEST, TOGETHER = 80_000, 3_000_000
WIDE, HIGH = 550, 540
"""Points (1/72 inch): as wide as a page, as high as a screen."""
WITHOUT = {"index", "claims", "cost", "overview"}
"""The ledger is its own picture, and times, which the others show, are in no baseline."""
FOUND = {path.relative_to(STUDIES).as_posix(): path for path in STUDIES.rglob("*.svg")}


def test_every_picture_is_there_and_no_other():
    assert set(FOUND) == {f"{study}/{name}.svg" for study in PICTURES for name in PICTURES[study]}


def test_pages_have_two_to_four():
    assert set(PAGES) - set(PICTURES) == WITHOUT
    assert {s: n for s, n in PICTURES.items() if not (2 <= len(n) <= 4)} == {}


@pytest.mark.parametrize("study", PICTURES)
def test_pictures_are_drawn_by_the_study_and_shown_with_what_they_show(study):
    offered = dict(DRAWING["drawings"](study))
    shown = [
        (name, f"{study}/{name}.svg", DRAWING["caption"](offered[name])) for name in PICTURES[study]
    ]
    page = (STUDIES / f"{study}.md").read_text(encoding="utf-8")
    assert re.findall(r"^!\[(.*)\]\((.*)\)\n\n\*(.*)\*$", page, re.MULTILINE) == shown


def test_they_are_small():
    sizes = {name: path.stat().st_size for name, path in FOUND.items()}
    assert {name: size for name, size in sizes.items() if size > LARGEST} == {}
    assert sum(sizes.values()) <= TOGETHER
    for name, path in FOUND.items():
        size = re.search(r'width="([\d.]+)pt" height="([\d.]+)pt"', path.read_text("utf-8"))
        assert float(size[1]) <= WIDE, name
        assert float(size[2]) <= HIGH, name
