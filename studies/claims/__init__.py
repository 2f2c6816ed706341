"""Which sentences of the source report hold?

The report that started this project has 65 sentences that can be checked. Which hold as they stand,
which only on a condition, which not, and which has nothing judged yet?

Each is held to a bound with a reason; and, so that a result that moves is noticed, to the verdict
that theory lets expect. Every verdict is computed from what the other studies found, and changes
when its number is moved past its bound. The study runs after the others; what has not run is read
from the committed baseline.

Candidate: the results of the other studies. Reference: the bounds. Source of the sentences:
[Report].
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

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

from . import drawing, told
from .controls import FAULTS, Alteration, altered, move_past_bounds
from .record import FAILS, HOLDS, NONE, NOT_YET, ONLY_IF, VERDICTS, Check, Claim, kind
from .sentences import CLAIMS, SENTENCES

__all__ = ["CLAIMS", "FAULTS", "READS_RESULTS", "run"]
READS_RESULTS = True
ROUNDING = 2e-6
"""Of numbers, in their units: many are differences of values near 1, which the baseline of their
own studies holds to a millionth."""
TOLERANCES = (
    Tolerance(
        "sentences without a row of their own", 0, "1",
        "the ledger has every sentence of the report that can be checked, each once",
    ),
    Tolerance(
        "computed verdicts other than theory lets expect", 0, "1",
        "a result that moved across a bound is a finding to explain, whichever way it moved",
    ),
    Tolerance(
        "computed verdicts that stay when their number is moved past its bound", 0, "1",
        "a verdict that does not follow its number is no verdict",
    ),
)  # fmt: skip
COLUMNS = {
    "sentence": "its number in the ledger",
    "place": "section of the report, and what stands there",
    "statement": "what it says, in our words",
    "condition": "on which the sentence may hold where it does not as it stands",
    "study": 'whose table has the number, or "none"',
    "table": 'of that study, or "none"',
    "measure": 'what the number says, or "none"',
    "number": 'from that table, in its unit, or "none"',
    "unit": 'of number and bound, or "none"',
    "bound": 'within which the sentence holds, in its unit, or "none"',
    "side": 'the number is to be "at most" or "at least" the bound, or "none"',
    "verdict": f'computed: "{HOLDS}", "{ONLY_IF}" and the condition, "{FAILS}", or "{NOT_YET}"',
    "because": "why that bound; where nothing is judged, why not",
    "theory": 'what lets expect the sentence to hold or not, or "none"',
    "taken_from_here": 'this run, stored results, the committed baseline, or "none"',
    "sentences": "how many have this verdict",
    "part": 'what was moved: the number of the sentence "as it stands" or of its "condition"',
    "moved": "the number reflected in its bound, in its unit",
    "verdict_moved": "verdict with that number",
    "flips": 'whether it is another one: "yes" or "no"',
}


def run(
    candidate: Results | None = None,
    setting: Setting = FULL,
    alter: Alteration | None = None,
    claims: Sequence[Claim] = CLAIMS,
    questions: tuple[str, ...] | None = None,
) -> Evidence:
    """The ledger: the one question of this study.

    Parameters
    ----------
    candidate
        What the studies found; None reads the committed baseline of the setting's form.
    alter
        A change to one table, for negative controls.
    claims
        The sentences.
    questions
        "ledger", or None.
    """
    results = altered(check_results(candidate, quick=setting.quick), alter)
    return gather_evidence({"ledger": partial(judge_sentences, results, claims)}, questions)


def judge_sentences(results: Results, claims: Sequence[Claim]) -> Evidence:
    """Every sentence beside what the studies found."""
    plain = {c.number: c.check.number(results, c.number) for c in claims if c.check}
    under = {c.number: c.conditional.number(results, c.number) for c in claims if c.conditional}
    ledger = pd.DataFrame(
        [ledger_row(c, results, plain.get(c.number), under.get(c.number)) for c in claims]
    )
    controls = move_past_bounds(claims, plain, under)
    return Evidence(
        tables={
            "ledger": ledger,
            "conditions": pd.DataFrame(
                [
                    condition_row(c, c.conditional, under[c.number], results)
                    for c in claims
                    if c.conditional
                ]
            ),
            "verdicts": count_verdicts(ledger),
            "controls": controls,
        },
        observed=by_quantity(TOLERANCES, observe(claims, ledger, controls)),
        tolerances=TOLERANCES,
        columns=COLUMNS,
        findings=findings(ledger, plain, under),
        figures={"ledger": drawing.draw},
        rounding={"number": ROUNDING, "moved": 2 * ROUNDING},
    )


def ledger_row(
    claim: Claim, results: Results, plain: float | None, under: float | None
) -> dict[str, object]:
    """A sentence's row of the ledger."""
    row: dict[str, object] = {
        "sentence": claim.number,
        "place": claim.place,
        "statement": claim.statement,
    }
    if claim.check is None or plain is None:
        words = dict.fromkeys(
            ("study", "table", "measure", "number", "unit", "bound", "side"), NONE
        )
        why = {"because": claim.theory, "theory": NONE, "taken_from_here": NONE}
        return row | words | {"verdict": NOT_YET} | why
    return row | {
        **checked(claim.check, plain),
        "verdict": claim.decide(plain, under),
        "because": claim.check.because,
        "theory": claim.theory,
        "taken_from_here": results.source(claim.check.study),
    }


def checked(check: Check, number: float) -> dict[str, object]:
    """Cells of a check and its number."""
    return {
        "study": check.study,
        "table": check.table,
        "measure": check.measure,
        "number": number,
        "unit": check.unit,
        "bound": float(check.bound),
        "side": check.side,
    }


def condition_row(claim: Claim, check: Check, number: float, results: Results) -> dict[str, object]:
    """A condition's row, met or not."""
    return {
        "sentence": claim.number,
        "condition": claim.condition,
        **checked(check, number),
        "verdict": HOLDS if check.holds(number) else FAILS,
        "because": check.because,
        "taken_from_here": results.source(check.study),
    }


def count_verdicts(ledger: pd.DataFrame) -> pd.DataFrame:
    """How many sentences have each verdict, conditions apart."""
    kinds = ledger["verdict"].map(kind)
    counts = [int((kinds == verdict).sum()) for verdict in VERDICTS]
    return pd.DataFrame({"verdict": VERDICTS, "sentences": counts})


def unexpected(claims: Sequence[Claim], ledger: pd.DataFrame) -> list[int]:
    """Numbers of the sentences whose computed verdict is another than theory lets expect."""
    found = ledger["verdict"].map(kind)
    return [
        claim.number
        for claim, verdict in zip(claims, found, strict=True)
        if claim.check and verdict != claim.expected
    ]


def observe(
    claims: Sequence[Claim], ledger: pd.DataFrame, controls: pd.DataFrame
) -> list[Observed]:
    """What the tolerances judge, in their order."""
    found = list(ledger["sentence"])
    missing = sum(found.count(number) != 1 for number in range(1, SENTENCES + 1))
    return [
        Observed(float(missing)),
        Observed(float(len(unexpected(claims, ledger)))),
        Observed(float((controls["flips"] == "no").sum())),
    ]


def findings(
    ledger: pd.DataFrame, plain: dict[int, float], under: dict[int, float]
) -> tuple[str, ...]:
    """Counts, and what a reader of the report should know first."""
    table = count_verdicts(ledger)
    counts = dict(zip(table["verdict"], table["sentences"], strict=True))
    held = f"{counts[HOLDS]} hold as they stand, {counts[ONLY_IF]} on a condition only"
    rest = f"{counts[FAILS]} do not hold, and {counts[NOT_YET]} are not judged yet"
    whole = f"Of the report's {len(ledger)} checkable sentences {held}, {rest}."
    return (whole, *told.tell(plain, under))
