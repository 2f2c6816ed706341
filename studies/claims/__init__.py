"""Statements of the source report, judged

The ledger lists 63 sentences of the report that started this project. Which are true, which only
where the source says so, which are false as said and true on another condition? Sentences that
quote the work of others, draw an analogy, choose a definition or state an intention are background
and have no verdict.

Each is held to bounds with a reason; and, so that a result that moves is noticed, to the verdict
that theory lets expect. Every verdict is computed from what the other studies found, and changes
when its numbers are moved past their bounds. The study runs after the others; what has not run is
read from the committed baseline.

Candidate: the results of the other studies. Reference: the bounds. Source of the sentences:
[Report].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence, Set
from functools import partial
from typing import Any

import pandas as pd

from msvalidate import kit

from .claims_controls import FAULTS, Alteration, Numbers, altered, move_past_bounds
from .reading import last_sizes, read
from .record import BACKGROUND, IF, NONE, SENTENCES, TOPICS, VERDICTS, Sentence

__all__ = ["FAULTS", "READS_RESULTS", "SENTENCES", "run"]
READS_RESULTS = True
ROUNDING = 2e-6
"""Of numbers, in their units: many are differences of values near 1, which the baseline of their
own studies holds to a millionth."""
FLIPS = kit.Rule(
    "computed verdicts that stay when their numbers are moved past their bounds", 0, "1",
    "a verdict that does not follow its number is no verdict",
    table="controls", value=lambda rows: rows["flips"] == "no",
)  # fmt: skip


def run(
    candidate: kit.Results | None = None,
    setting: kit.Setting = kit.FULL,
    alter: Alteration | None = None,
    sentences: Sequence[Sentence] = SENTENCES,
    questions: tuple[str, ...] | None = None,
) -> kit.Evidence:
    """The ledger: the one question of this study.

    Parameters
    ----------
    candidate
        What the studies found; None reads the committed baseline of the setting's form.
    alter
        A change to one table, for negative controls.
    sentences
        Of the report.
    questions
        "ledger", or None.
    """
    results = altered(kit.check_results(candidate, quick=setting.quick), alter)
    return kit.gather_evidence({"ledger": partial(judge_sentences, results, sentences)}, questions)


def judge_sentences(results: kit.Results, sentences: Sequence[Sentence]) -> kit.Evidence:
    """Every sentence beside what the studies found."""
    found = {sentence.number: sentence.numbers(results) for sentence in sentences}
    verdicts = {each.number: each.decide(*found[each.number]) for each in sentences}
    controls = move_past_bounds(sentences, found)
    counts = [list(verdicts.values()).count(verdict) for verdict in VERDICTS]
    wrong = [each.number for each in sentences if verdicts[each.number] != each.expected]
    unclear = len(sentences) - len(verdicts) + sum(v not in VERDICTS for v in verdicts.values())
    counted = (
        kit.Tolerance(
            "sentences that stand twice, or with no verdict of the list", 0, "1",
            "the ledger has every sentence of the report that can be checked, each once",
            observed=kit.Observed(float(unclear)),
        ),
        kit.Tolerance(
            "computed verdicts other than theory lets expect", 0, "1",
            "a result that moved across a bound is a finding to explain, whichever way it moved",
            observed=kit.Observed(float(len(wrong))),
        ),
    )  # fmt: skip
    expected, quoted = set(verdicts) - set(wrong), results.in_full_mode()
    topics = [topic_row(topic, quoted, expected) for topic in TOPICS]
    return kit.Evidence(
        tables={
            "topics": pd.DataFrame(topics),
            "ledger": pd.DataFrame(
                [ledger_row(each, results, found, verdicts[each.number]) for each in sentences]
            ),
            "numbers": pd.DataFrame(
                [row for s in sentences for row in number_rows(s, results, found)]
            ),
            "verdicts": pd.DataFrame({"verdict": VERDICTS, "sentences": counts}),
            "controls": controls,
        },
        tolerances=(*counted, FLIPS),
        columns=kit.columns(__file__),
        findings=findings(counts, verdicts, topics),
    )


def number_rows(
    sentence: Sentence, results: kit.Results, found: Numbers
) -> list[dict[str, object]]:
    """Every number of a sentence beside its bound, those as said first."""
    kinds = zip(("as said", "under"), (sentence.said, sentence.under), strict=True)
    return [
        {
            "sentence": sentence.number,
            "part": part,
            "number": number,
            "unit": check.unit,
            "side": check.side,
            "bound": check.bound,
            "holds": "yes" if check.holds(number) else "no",
            "measure": check.measure.format(last=last_sizes(results, check.query)),
            "study": check.table.partition("/")[0],
            "table": check.table.partition("/")[2],
            "because": check.because,
        }
        for (part, checks), numbers in zip(kinds, found[sentence.number], strict=True)
        for check, number in zip(checks, numbers, strict=True)
    ]


def ledger_row(
    sentence: Sentence, results: kit.Results, found: Numbers, verdict: str
) -> dict[str, object]:
    """A sentence's row of the ledger: its verdict, and the number that decides it.

    That is the first as said that does not keep to its bound; else the first.
    """
    numbers = number_rows(sentence, results, found)
    missed = [row for row in numbers if row["holds"] == "no" and row["part"] == "as said"]
    names = ("number", "unit", "side", "bound", "measure", "study", "table", "because")
    decides = next(iter([*missed, *numbers]), dict.fromkeys(names, NONE))
    return {
        "sentence": sentence.number,
        "place": sentence.place,
        "phrase": sentence.phrase,
        "verdict": sentence.words(verdict),
        **{name: decides[name] for name in names},
        "theory": sentence.theory,
        "taken_from_here": results.source(str(decides["study"])) if numbers else NONE,
    }


def topic_row(topic: Mapping[str, Any], quoted: kit.Results, expected: Set[int]) -> dict[str, str]:
    """A topic in a row: numbers of full mode, if its verdicts in this run are the expected ones."""
    moved = [number for number in topic["sentences"] if number not in expected]
    verdict, words = "moved", f"Not as theory lets expect: sentences {moved} of the ledger."
    if not moved:
        verdict = topic["verdict"]
        numbers = {name: topic_number(of, quoted) for name, of in topic["numbers"].items()}
        words = topic["found"].format(**numbers).replace("e-0", "e-").replace("%", " %")
    row = {name: topic[name] for name in ("topic", "says")}
    return {**row, "topic_verdict": verdict, "found": words, "studies": topic["studies"]}


def topic_number(of: Any, quoted: kit.Results) -> float:
    """A number of a topic with four digits, as its entry in the ledger names it."""
    query = of
    if isinstance(of, str):
        number, part, *bound = of.split()
        check = next(getattr(s, part)[0] for s in SENTENCES if s.number == int(number))
        if bound:
            return float(check.bound)
        query = check.query
    return float(f"{read(quoted, query):.4g}")


def findings(
    counts: Sequence[int], verdicts: Mapping[int, str], topics: Sequence[Mapping[str, str]]
) -> tuple[str, ...]:
    """Counts, the sentences without a verdict, and what a reader should know first."""
    background = [str(number) for number, verdict in verdicts.items() if verdict == BACKGROUND]
    told = ", ".join(f"{n} {verdict}" for n, verdict in zip(counts, VERDICTS, strict=True))
    told = told.replace(IF, f"{IF} something else is meant")
    whole = f"Of the report's {sum(counts)} sentences: {told} ({', '.join(background)})."
    return (whole, *(f"{row['topic']} ({row['topic_verdict']}): {row['found']}" for row in topics))
