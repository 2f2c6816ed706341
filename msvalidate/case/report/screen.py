"""First screen of a case on a terminal: at most 14 lines of at most 100 characters."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Mapping, Sequence
from typing import Any

from msvalidate.case.advise.advice import constants_lines
from msvalidate.case.compare.choice import HEADS, Choice, need_rows
from msvalidate.case.compare.comparison import Comparison
from msvalidate.case.compare.quantities import POINT_STRESS
from msvalidate.case.file.case import Case
from msvalidate.case.judge.judgement import Judged
from msvalidate.case.report.headline import DISPLACEMENT
from msvalidate.case.report.page import quantity_summary
from msvalidate_check.text import WIDTH, align_table, percent
from msvalidate_check.verdict import Difference

MAX_LINES = 14
"""Lines of a first screen; its last one is the place of the page."""
MAX_QUANTITIES = 3
"""Rows of quantities; `-v` and the page have all of them."""
MAX_SENTENCE = 2
"""Lines of a sentence."""
MAX_CAUSES = 4
"""Causes of a judged field; the page has all of them."""


def case_lines(found: Comparison, chosen: Choice, verdict: Mapping[str, Any]) -> list[str]:
    """First screen of a case that was run, by its `verdict.json`."""
    lines = [
        *_wrapped(f"{found.case.name}: {verdict['headline']}"),
        *_quantity_lines(found.case, found.rows, "springs"),
        *_wrapped(verdict["recommendation"]),
        *[f"springs alone on these edges: {percent(found.alone)}"] * math.isfinite(found.alone),
        *_need_lines(chosen, found.case.unit),
        *constants_lines(
            found.advice, found.case.unit, " (default)" * ("density" in found.case.notes)
        ),
    ]
    return lines[: MAX_LINES - 1]


def field_lines(found: Judged, verdict: Mapping[str, Any], first: Sequence[str] = ()) -> list[str]:
    """First screen of a judged field: verdict, difference, causes and next step.

    Parameters
    ----------
    first
        Sentences on what else is known of the field, after the verdict.
    """
    causes = found.verdict.causes[:MAX_CAUSES]
    lines = [
        *_wrapped(f"{found.result.name}: {verdict['headline']}"),
        *(line for each in first for line in _wrapped(each)),
        *_quantity_lines(found.case, [found.displacement], "field"),
        *["Possible causes, and the difference that each of them leaves:"] * bool(causes),
        *(textwrap.shorten(f"- {percent(each.left)}: {each}", WIDTH) for each in causes),
        *_wrapped(verdict["recommendation"]),
    ]
    return lines[: MAX_LINES - 1]


def _wrapped(sentence: str) -> list[str]:
    return textwrap.wrap(sentence, WIDTH, max_lines=MAX_SENTENCE, placeholder=" …")


def _quantity_lines(case: Case, rows: Sequence[Difference], candidate: str) -> list[str]:
    """Table of the most important quantities: displacement, stress, reaction, and others."""
    known = [row for row in rows if math.isfinite(row.error)]
    stress = sorted((row for row in known if row.unit == "Pa"), key=lambda r: r.of != POINT_STRESS)
    forces = sorted((row for row in known if row.unit == "N"), key=lambda row: -row.wanted)
    first = [row for row in known if row.quantity == DISPLACEMENT] + stress[:1] + forces[:1]
    shown = [*first, *(row for row in known if row not in first)][:MAX_QUANTITIES]
    table = quantity_summary(case, shown, candidate)
    return align_table(table.heads, table.rows, table.numeric) if shown else []


def _need_lines(chosen: Choice, unit: str) -> list[str]:
    """Table of what the targets take, of springs and of elements."""
    rows = need_rows(chosen, unit)
    return align_table(HEADS, rows, (True, False, True, True, True, True)) if rows else []
