"""Which sentences of the source report hold?

The report that started this project has some sixty sentences that can be checked. Which are true,
which only where the source says so, which are false as said and true on another condition, and
which has nothing judged yet?

Each is held to bounds with a reason; and, so that a result that moves is noticed, to the verdict
that theory lets expect. Every verdict is computed from what the other studies found, and changes
when its numbers are moved past their bounds. The study runs after the others; what has not run is
read from the committed baseline.

Candidate: the results of the other studies. Reference: the bounds. Source of the sentences:
[Report].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import pandas as pd

from msvalidate.judging.evidence import (
    Evidence,
    Observed,
    Tolerance,
    by_quantity,
    gather_evidence,
)
from msvalidate.judging.sweep import FULL, Setting
from msvalidate.output.results import Results, check_results

from .controls import FAULTS, Alteration, Numbers, altered, move_past_bounds
from .reading import read
from .record import IF, NONE, SENTENCES, TOPICS, VERDICTS, Sentence

__all__ = ["FAULTS", "READS_RESULTS", "SENTENCES", "run"]
READS_RESULTS = True
ROUNDING = 2e-6
"""Of numbers, in their units: many are differences of values near 1, which the baseline of their
own studies holds to a millionth."""
TOLERANCES = (
    Tolerance(
        "sentences that stand twice, or with no verdict of the list", 0, "1",
        "the ledger has every sentence of the report that can be checked, each once",
    ),
    Tolerance(
        "computed verdicts other than theory lets expect", 0, "1",
        "a result that moved across a bound is a finding to explain, whichever way it moved",
    ),
    Tolerance(
        "computed verdicts that stay when their numbers are moved past their bounds", 0, "1",
        "a verdict that does not follow its number is no verdict",
    ),
)  # fmt: skip
COLUMNS = {
    "sentence": "its number in the ledger; 42 and 63 were no sentences of the report",
    "place": "section of the report, and what stands there",
    "phrase": "what it says, quoted",
    "verdict": f"computed: {', '.join(VERDICTS)}; where true on a condition, with that",
    "number": 'that decides, from its table, in its unit, or "none"',
    "unit": 'of number and bound, or "none"',
    "side": 'the number is to be "at most" or "at least" the bound, or "none"',
    "bound": 'within which the sentence holds, in its unit, or "none"',
    "measure": 'what the number says, or "none"',
    "study": 'whose table has the number, or "none"',
    "table": 'of that study, or "none"',
    "because": 'why that bound, or "none"',
    "theory": "why that verdict is expected; where nothing is judged, why not",
    "taken_from_here": 'this run, stored results, the committed baseline, or "none"',
    "part": 'whether the number is of the sentence "as said" or "under" its condition',
    "holds": 'whether it keeps to its bound: "yes" or "no"',
    "sentences": "how many have this verdict",
    "moved": "how many numbers are reflected in their bounds at once",
    "verdict_moved": "verdict with those numbers",
    "flips": 'whether it is another one: "yes" or "no"',
    "topic": "what the report speaks of",
    "says": "what it says, quoted",
    "found": "what the studies found, in words with their numbers",
    "studies": "that found it, as the command line names them",
}


def run(
    candidate: Results | None = None,
    setting: Setting = FULL,
    alter: Alteration | None = None,
    sentences: Sequence[Sentence] = SENTENCES,
    questions: tuple[str, ...] | None = None,
) -> Evidence:
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
    results = altered(check_results(candidate, quick=setting.quick), alter)
    return gather_evidence({"ledger": partial(judge_sentences, results, sentences)}, questions)


def judge_sentences(results: Results, sentences: Sequence[Sentence]) -> Evidence:
    """Every sentence beside what the studies found."""
    found = {sentence.number: sentence.numbers(results) for sentence in sentences}
    verdicts = {each.number: each.decide(*found[each.number]) for each in sentences}
    controls = move_past_bounds(sentences, found)
    counts = [list(verdicts.values()).count(verdict) for verdict in VERDICTS]
    wrong = [each.number for each in sentences if verdicts[each.number] != each.expected]
    unclear = len(sentences) - len(verdicts) + sum(v not in VERDICTS for v in verdicts.values())
    observed = (unclear, len(wrong), int((controls["flips"] == "no").sum()))
    topics = [topic_row(topic, results, found, wrong) for topic in TOPICS]
    return Evidence(
        tables={
            "topics": pd.DataFrame(topics),
            "ledger": pd.DataFrame(
                [ledger_row(each, results, found, verdicts[each.number]) for each in sentences]
            ),
            "numbers": pd.DataFrame([row for s in sentences for row in number_rows(s, found)]),
            "verdicts": pd.DataFrame({"verdict": VERDICTS, "sentences": counts}),
            "controls": controls,
        },
        observed=by_quantity(TOLERANCES, [Observed(float(value)) for value in observed]),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        findings=findings(counts, topics),
        rounding={"number": ROUNDING},
    )


def number_rows(sentence: Sentence, found: Numbers) -> list[dict[str, object]]:
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
            "measure": check.measure,
            "study": check.table.partition("/")[0],
            "table": check.table.partition("/")[2],
            "because": check.because,
        }
        for (part, checks), numbers in zip(kinds, found[sentence.number], strict=True)
        for check, number in zip(checks, numbers, strict=True)
    ]


def ledger_row(
    sentence: Sentence, results: Results, found: Numbers, verdict: str
) -> dict[str, object]:
    """A sentence's row of the ledger: its verdict, and the number that decides it.

    That is the first as said that does not keep to its bound; else the first.
    """
    numbers = number_rows(sentence, found)
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


def topic_row(
    topic: Mapping[str, Any], results: Results, found: Numbers, wrong: Sequence[int]
) -> dict[str, str]:
    """A topic of the report in a row; words only where its verdicts are the expected ones."""
    asked = [number for number in topic["sentences"] if number in wrong or number not in found]
    words = f"Not as theory lets expect: sentences {asked} of the ledger."
    if not asked:
        words = (
            topic["found"]
            .format(
                **{name: topic_number(of, results, found) for name, of in topic["numbers"].items()}
            )
            .replace("e-0", "e-")
            .replace("%", " %")
        )
    row = {name: topic[name] for name in ("topic", "says")}
    return {**row, "found": words, "studies": topic["studies"]}


def topic_number(of: Any, results: Results, found: Numbers) -> float:
    """A number of a topic with four digits, as its entry in the ledger names it."""
    if not isinstance(of, str):
        return float(f"{read(results, of):.4g}")
    number, part, *bound = of.split()
    if bound:
        return float(next(getattr(s, part)[0].bound for s in SENTENCES if s.number == int(number)))
    return float(f"{found[int(number)][part == 'under'][0]:.4g}")


def findings(counts: Sequence[int], topics: Sequence[Mapping[str, str]]) -> tuple[str, ...]:
    """Counts, and what a reader of the report should know first."""
    told = ", ".join(f"{n} {verdict}" for n, verdict in zip(counts, VERDICTS, strict=True))
    told = told.replace(IF, f"{IF} something else is meant")
    whole = f"Of the report's {sum(counts)} sentences: {told}."
    return (whole, *(f"{row['topic']}: {row['found']}" for row in topics))
