"""The first screen: from stored results, else the committed baseline, else nothing."""

from __future__ import annotations

import pandas as pd
import pytest

from msvalidate.output import front
from msvalidate.output.stored import Stored, nothing_judged

ROW = (
    *("a block", "square", "5", "0.0775", "0.011", "80", "0.00169"),
    *("agrees", "half", "0.92", "poisson", "t"),
)


def stored(name, table, content, error=""):
    time = {"time": "2026-01-01 00:00 UTC"}
    return Stored(name, "?", (), {}, time, nothing_judged(), {table: content}, {}, error)


def rows(*each):
    return pd.DataFrame(each, columns=front.COLUMNS, dtype=str)


def test_stored_rows_are_told_in_per_cent():
    found = front.first_screen([stored("overview", "good_for", rows(ROW))])
    (line,) = found.lines
    assert (line.coarse, line.fine, line.cost) == ("7.8 % at 5", "0.17 % at 80", "0.92 times")
    assert found.source == "the run of 2026-01-01 00:00 UTC"


def test_advice_is_the_first_row_and_those_that_differ():
    bad = ("another", "mesh edges", *ROW[2:7], "differs", *ROW[8:])
    said = front.first_screen([stored("overview", "good_for", rows(ROW, bad))]).advice
    assert "a block: square (half), 1.1 % off at 20 cells across" in said
    assert "For 1 % they take 0.92 times the cells of linear elements (Q1)." in said
    assert said.endswith("Do not use: mesh edges.")
    assert not front.first_screen([stored("overview", "good_for", rows(bad))]).advice


@pytest.mark.parametrize(
    "study",
    [
        None,
        stored("overview", "good_for", rows(ROW), error="no pivot"),
        stored("overview", "other", rows(ROW)),
    ],
)
def test_what_is_not_there_comes_from_the_committed_baseline(study):
    found = front.first_screen([study] if study else [])
    assert found.source.startswith("the committed baseline")
    assert len(found.lines) == 8


def test_damaged_rows_are_not_shown():
    damaged = rows(ROW).drop(columns="condition")
    found = front.first_screen([stored("overview", "good_for", damaged)])
    assert found.source == "the committed baseline, as what overview left is not whole"
    words = (*ROW[:3], "none", *ROW[4:9], "not asked", *ROW[10:])
    (line,) = front.first_screen([stored("overview", "good_for", rows(words))]).lines
    assert (line.coarse, line.cost) == ("none at 5", "not asked")


def test_verdicts_of_the_ledger_are_counted():
    verdicts = ["holds", "holds only if it rains", "does not hold", "holds", "not judged yet"]
    ledger = pd.DataFrame({"verdict": verdicts}, dtype=str)
    said = "2 hold, 1 hold only on a condition, 1 do not hold, 1 are not judged yet"
    assert front.first_screen([stored("claims", "ledger", ledger)]).sentences == said
