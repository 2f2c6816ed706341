"""The study `claims`: verdicts follow numbers, every link is there, forms agree."""

import re
from functools import cache
from io import StringIO

import pandas as pd
import pytest
from msvalidate.studies.claims import reading, record

from msvalidate.bench.judging.evidence import Evidence
from msvalidate.bench.judging.sweep import Setting
from msvalidate.bench.output.baseline import baseline_folder
from msvalidate.bench.output.front import first_screen
from msvalidate.bench.output.results import THIS_RUN, Results
from msvalidate.bench.output.stored import Result
from msvalidate.cli.run import summary_lines
from msvalidate.problem import ProblemError
from msvalidate.studies import claims
from tests.table import stored_rows, table

QUICK = Setting(quick=True)
SMALL = record.Check({"from": "a/b"}, "a number", "1", record.AT_MOST, 2, "small")
LARGE = record.Check({"from": "a/b"}, "another", "1", record.AT_LEAST, 5, "large")
FORMS = ("quick", "full")
ROWS = pd.DataFrame(
    {"body": ["a", "a", "b", "b"], "cells": [2, 4, 2, 4], "error": [0.4, 0.1, 0.2, -0.3]}
)


def sentence(said=(SMALL,), under=(LARGE,), expected=record.TRUE, **words):
    return record.Sentence(1, "1", "A phrase.", expected, "theory", said, "large", under, **words)


def results(study, **tables):
    """Results of a run of one study in its small form, some of its tables others."""
    where = baseline_folder("quick") / study
    found = {path.stem: pd.read_csv(path) for path in where.glob("*.csv")} if study else {}
    return Results("quick", run={study: found | tables})


@cache
def committed(form):
    """Evidence of the ledger of the committed tables."""
    return claims.run(setting=Setting(quick=form == "quick"))


def row(evidence, number):
    """A sentence's row of the ledger."""
    return evidence.tables["ledger"].set_index("sentence").loc[number]


@table(
    ("of", "said", "under", "verdict"),
    [
        (sentence(), [2], [0], record.TRUE),
        (sentence(), [2.1], [5], record.IF),
        (sentence(stated=True), [2.1], [5], record.WHERE),
        (sentence(), [2.1], [4.9], record.FALSE),
        (sentence(under=()), [2.1], [], record.FALSE),
        (sentence(said=(SMALL, LARGE)), [2, 4], [4], record.FALSE),
        (sentence(said=(), misprint=True), [], [5], record.IF),
        (sentence(said=(), misprint=True), [], [4], record.FALSE),
        (sentence(said=(), under=()), [], [], record.NOT_YET),
        (sentence(said=(), under=(), expected=record.BACKGROUND), [], [], record.BACKGROUND),
    ],
)
def test_verdicts_follow_numbers(of, said, under, verdict):
    assert of.decide(said, under) == verdict


@table(("check", "number"), [(c, n) for c in (SMALL, LARGE) for n in (-3, 0, 2, 5, 7)])
def test_a_number_moved_past_its_bound_changes_sides(check, number):
    assert check.holds(check.moved(number)) != check.holds(number)


@table(
    ("query", "number"),
    stored_rows("ledger_queries"),
)
def test_a_number_is_read_as_it_is_asked_for(query, number):
    found = reading.read(results("", rows=ROWS), {"from": "/rows", **query})
    assert found == pytest.approx(number, rel=1e-12)


@table(
    ("query", "words"),
    [
        ({"column": "error"}, "4 numbers"),
        ({"column": "error", "where": {"body": "c"}}, "no row with"),
        ({"column": "size"}, "no column size"),
        ({"column": "body", "take": "max"}, "are no numbers"),
    ],
)
def test_what_cannot_be_read_is_told_in_one_line(query, words):
    with pytest.raises(ProblemError, match=words) as told:
        reading.read(results("", rows=ROWS), {"from": "/rows", **query})
    assert "\n" not in str(told.value)


def test_sentences_are_those_of_the_report_each_once_with_its_reasons():
    numbers = [each.number for each in claims.SENTENCES]
    assert numbers == [n for n in range(1, 67) if n not in {42, 63, 65}]
    for each in claims.SENTENCES:
        assert bool(each.condition) == bool(each.under), each.number
        assert each.judged == (each.expected not in {record.NOT_YET, record.BACKGROUND})
        for check in (*each.said, *each.under):
            assert all((baseline_folder(f) / f"{check.table}.csv").is_file() for f in FORMS)


def test_no_words_of_the_report_are_judged_twice():
    parts = [(s.number, part) for s in claims.SENTENCES for part in s.phrase.split(" … ")]
    whole = [(number, part) for number, part in parts if len(part.split()) > 4]
    twice = {(a, b) for a, part in whole for b, other in parts if a != b and part in other}
    assert twice == {(33, 34)}, "two figures have the same caption"


@table("number", [58, 59])
def test_problems_that_remain_are_true_where_the_error_is_large(number):
    (of,) = (each for each in claims.SENTENCES if each.number == number)
    assert of.phrase.startswith("problems still remain")
    assert {check.side for check in of.said} == {record.AT_LEAST}


@table("form", FORMS)
def test_a_statement_has_one_bound_in_the_ledger_and_in_its_study(form):
    judged = [c for s in claims.SENTENCES for c in (*s.said, *s.under) if "statement" in named(c)]
    judged = [check for check in judged if check.table == "actuator/figure8_statements"]
    assert judged
    rows = pd.read_csv(baseline_folder(form) / "actuator/figure8_statements.csv")
    for check in judged:
        (bound,) = rows["bound"][rows["statement"] == named(check)["statement"]]
        assert bound == check.bound, check.measure


def named(check):
    return check.query.get("where", {})


def test_the_committed_ledger_is_made_of_the_committed_tables():
    for form in FORMS:
        found = committed(form).tables
        for name, made in found.items():
            kept = pd.read_csv(baseline_folder(form) / "claims" / f"{name}.csv")
            text = made[list(kept)].astype(object).to_csv(index=False)
            pd.testing.assert_frame_equal(pd.read_csv(StringIO(text)), kept, atol=2e-6)


def test_queries_have_known_words_and_one_bound():
    words = {"from", "column", "where", "between", "without", "last", "sum", "over", "less", "take"}
    words |= {"by", "times", "skip", "least", "equal"}
    checks = {"measure", "unit", "because", "at_most", "at_least"}
    for each in claims.SENTENCES:
        for check in (*each.said, *each.under):
            assert set(check.query) <= words | checks, each.number
    for topic in record.TOPICS:
        for query in topic["numbers"].values():
            assert isinstance(query, str) or set(query) <= words, topic["topic"]


def test_small_and_full_form_come_to_the_same_verdicts():
    small, full = (pd.read_csv(baseline_folder(form) / "claims/ledger.csv") for form in FORMS)
    assert small["verdict"].tolist() == full["verdict"].tolist()


def test_numbers_of_this_run_come_before_those_of_the_baseline():
    advice = pd.read_csv(baseline_folder("quick") / "damping/advice.csv")
    ours = row(committed("quick"), 27)
    assert ours["number"] == pytest.approx(1313 / 588)  # of the plate to 1e-6, as in `damping`
    theirs = row(claims.run(results("damping", advice=advice.assign(steps=7.0)), setting=QUICK), 27)
    assert (theirs["number"], theirs["verdict"]) == (1, record.TRUE)
    assert theirs["taken_from_here"] == THIS_RUN


def test_a_topic_says_nothing_where_a_verdict_of_its_sentences_moved():
    moved = claims.run(results("convergence", growth_of_factors=factors(3.1)), setting=QUICK)
    told = moved.tables["topics"].set_index("topic")["found"]
    assert told["O(n) against O(n⁹)"].startswith("Not as theory lets expect: sentences [2]")
    assert "6.348 V" in told["the actuator"]


# --- headlines: the report's topics on README and on the first screen of the page -----------------

TOPICS = pd.read_csv(baseline_folder("full") / "claims/topics.csv")
STOPS = baseline_folder("quick") / "damping/stop_rule.csv"
QUALIFIED = {
    "k2/(2k1 + k2)": "in a single square element",
    "four integrators": "In the testing spring-mass system",
    "damping": "In our spring-mass system",
    "load cases": "under the spring-mass assumption",
    "O(n) against O(n⁹)": "In the optimal situation",
    "the actuator": "when voltage has a higher value",
}
"""Topic -> the condition that the report itself states in the sentence quoted."""


def test_a_headline_reads_the_same_in_both_forms():
    quick = committed("quick").tables["topics"]
    pd.testing.assert_frame_equal(quick, TOPICS)
    moved = results("damping", stop_rule=pd.read_csv(STOPS).assign(error_over_asked=7.0))
    told = claims.run(moved, setting=QUICK).tables["topics"]
    pd.testing.assert_frame_equal(told, quick)
    told = claims.run(Results("full", run=moved.run)).tables["topics"]
    assert "up to 7 times" in told["found"][0]


@table("found", list(TOPICS["found"]))
def test_a_headline_names_the_sample_of_an_extreme_and_the_error_of_a_price(found):
    assert not re.search("finest|coarsest|largest of all", found)
    if re.search(r"up to [\d.]+ (times|%)", found):
        assert re.search(r"\d+ (runs|cases|bodies)", found)
    if "times the steps" in found or "critical's steps" in found:
        assert re.search(r"to an error of 1e-3, [\d.]+ to 1e-6", found)


@table("topic", record.TOPICS)
def test_a_quotation_is_of_a_sentence_of_the_ledger_and_keeps_its_qualifier(topic):
    phrases = [each.phrase for each in claims.SENTENCES if each.number in topic["sentences"]]
    parts = topic["says"].split(" … ")
    assert any(all(part in phrase for part in parts) for phrase in phrases)
    assert QUALIFIED.get(topic["topic"], "") in topic["says"]


def test_the_terminal_prints_the_verdict_and_the_decisive_sentence_of_every_topic():
    findings = claims.findings([0] * 6, {}, TOPICS.to_dict("records"))
    result = Result("claims", "?", Evidence({}, findings=findings), pd.DataFrame())
    printed = " ".join(" ".join(summary_lines(result)).split())
    for topic in first_screen([]).topics:
        assert f"{topic.topic} ({topic.verdict}): {topic.sentence}" in printed


def factors(exponent):
    """Growth of factors with another exponent."""
    found = pd.read_csv(baseline_folder("quick") / "convergence/growth_of_factors.csv")
    return found.assign(exponent=exponent)


def test_a_missing_row_is_told_in_one_line_with_its_sentence():
    alone = pd.DataFrame({"scheme": ["leapfrog"], "leaves_at_step": ["x"], "distance": ["x"]})
    one = [each for each in claims.SENTENCES if each.number == 32]
    few = Results("quick", run={"stability": {"figure3": alone}})
    with pytest.raises(ProblemError, match=r"^sentence 32, from stability/figure3: .*no row"):
        claims.run(few, setting=QUICK, sentences=one)
