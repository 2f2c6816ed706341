"""The first screen: from stored results, else the committed baseline, else nothing."""

from __future__ import annotations

import math

import pandas as pd
import pytest

from msvalidate.bench.output import front
from msvalidate.bench.output.stored import Stored, nothing_judged

ROW = {
    "body": "a block", "springs": "square", "material": "yes",
    "across_coarse": "5", "error_coarse": "0.0775",
    "error_at_20": "0.011", "across_fine": "80", "error_fine": "0.00169",
    "uncertainty_fine": "0.0001", "verdict": "agrees", "condition": "half",
    "study": "poisson", "table": "t",
}  # fmt: skip


def stored(name, table, content, error="", form="full"):
    origin = {"time": "2026-01-01 00:00 UTC", "form": form}
    return Stored(name, "?", (), {}, origin, nothing_judged(), {table: content}, {}, error)


def rows(*each):
    return pd.DataFrame(each, dtype=str)


def test_stored_rows_are_told_in_per_cent():
    found = front.first_screen([stored("overview", "good_for", rows(ROW))])
    (line,) = found.lines
    assert line.fine == "0.17 % at 80"
    assert 0 < line.fine_at < line.coarse_at < 100
    assert found.source == "the full run of 2026-01-01 00:00 UTC"


def test_advice_is_the_first_row_and_those_that_differ():
    bad = ROW | {"body": "another", "springs": "mesh edges", "verdict": "differs"}
    thin = bad | {"body": "bracket", "uncertainty_fine": "0.00017"}
    found = front.first_screen([stored("overview", "good_for", rows(ROW, bad, thin))])
    said = found.advice
    assert found.lines[2].fine == "0.17 ± 0.017 % at 80", "a tenth of it is the reference's own"
    for words in ("k2 = k1/2", "boundary springs half", "ratio is then 1/3", "finite elements if"):
        assert words in said
    assert said.endswith("error of about 1.1 % with 20 cells across. Do not use: mesh edges.")
    assert not front.first_screen([stored("overview", "good_for", rows(bad))]).advice


@pytest.mark.parametrize(
    "study",
    [
        None,
        stored("overview", "good_for", rows(ROW), error="no pivot"),
        stored("overview", "other", rows(ROW)),
        stored("overview", "good_for", rows(ROW), form="quick"),
    ],
)
def test_what_is_not_there_comes_from_the_committed_baseline(study):
    found = front.first_screen([study] if study else [])
    assert found.source.startswith("the committed baseline")
    assert len(found.lines) == 10


def test_damaged_rows_are_not_shown():
    damaged = rows(ROW).drop(columns="condition")
    found = front.first_screen([stored("overview", "good_for", damaged)])
    assert found.source == f"{front.COMMITTED}, as what overview left is not whole"
    words = ROW | {"error_coarse": "none"}
    (line,) = front.first_screen([stored("overview", "good_for", rows(words))]).lines
    assert math.isnan(line.coarse_at)


def test_the_reports_topics_and_verdicts_come_from_the_stored_ledger():
    topics = pd.DataFrame([("a", "b", "no", "c", "poisson")], columns=front.TOPIC, dtype=str)
    verdicts = ["true", "false as said, true if", "false"]
    ours = stored("claims", "topics", topics)
    ours.tables["verdicts"] = pd.DataFrame({"verdict": verdicts, "sentences": [2, 1, 1]}, dtype=str)
    found = front.first_screen([ours])
    assert found.topics == (front.Topic("a", "b", "no", "c", "poisson"),)
    assert found.sentences == "2 true; 1 false as worded, true if read otherwise; 1 false"
    quick = stored("claims", "topics", topics, form="quick")
    committed = front.first_screen([quick])
    assert committed == front.first_screen([]), "headlines are of full mode"
    assert len(committed.topics) == 8
    assert all(words in committed.sentences for words in front.SHORTER.values())


def test_the_ledger_is_told_in_four_columns():
    row = {"sentence": "18", "phrase": "k2 = 2k1", "verdict": "false", "study": "s", "table": "t"}
    judged = row | dict(
        zip(front.MEASURED, ("0.38888", "1", "at most", "0.01", "off 1/2"), strict=True)
    )
    none = row | dict.fromkeys(front.MEASURED, "none")
    tiny = judged | {"number": "3e-16", "unit": "m"}
    found = front.ledger(pd.DataFrame([judged, none, tiny]))
    assert found[0].sentence == "18. k2 = 2k1"
    assert [entry.number for entry in found] == [
        "0.389: off 1/2 (at most 0.01)", "", "0 m: off 1/2 (at most 0.01)"
    ]  # fmt: skip
