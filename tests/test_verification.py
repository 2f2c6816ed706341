"""docs/verification.md: what its command makes of the committed baseline, and nothing else."""

from __future__ import annotations

import re
import runpy
import shutil
from pathlib import Path

import pandas as pd
import pytest

ROOT = Path(__file__).resolve().parents[1]
PAGE = (ROOT / "docs" / "verification.md").read_text(encoding="utf-8")
MADE = runpy.run_path(str(ROOT / "docs" / "write_verification.py"))
MOST_ROWS = 60


@pytest.mark.skipif(
    tuple(map(int, pd.__version__.split(".")[:2])) < (3, 1),
    reason="older pandas reads the last digit of some numbers otherwise",
)
def test_it_is_made_of_the_baseline():
    assert MADE["page"]() == PAGE, "python docs/write_verification.py"


def test_its_rows_are_few_and_every_source_is_an_entry():
    rows = [line for line in PAGE.splitlines() if "](studies/" in line]
    entries = re.findall(r"^@\w+\{(\w+),", (ROOT / "docs/references.bib").read_text("utf-8"), re.M)
    keys = {key for row in rows for key in re.findall(r"\[(\w+)\](?!\()", row.split("|")[1])}
    assert 30 < len(rows) <= MOST_ROWS
    assert sorted(keys - set(entries)) == []


def test_a_moved_number_is_another_page_and_a_lost_row_is_refused(tmp_path):
    copy = tmp_path / "full"
    shutil.copytree(MADE["BASELINE"], copy)
    cook = copy / "benchmarks/cook.csv"
    text = cook.read_text(encoding="utf-8")
    cook.write_text(text.replace(",23.96503970846857,", ",23.9,"), encoding="utf-8")
    assert MADE["page"](copy) != PAGE
    cook.write_text(text.replace("FEM Q2", "FEM Q3"), encoding="utf-8")
    with pytest.raises(SystemExit, match="benchmarks/cook: 0 rows"):
        MADE["page"](copy)
