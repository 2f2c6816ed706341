"""First screen of a case on a terminal: at most 14 lines of at most 100 characters."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Sequence
from pathlib import Path

from msvalidate.case.advice import constants_lines
from msvalidate.case.choice import BEYOND, COARSEST, NONE, Choice, Need
from msvalidate.case.comparison import Comparison
from msvalidate.case.headline import (
    DISPLACEMENT,
    field_sentence,
    part_text,
    recommend,
    recommend_for_field,
    springs_sentence,
)
from msvalidate.case.judge import Judged
from msvalidate.case.quantities import POINT_STRESS
from msvalidate.case.units import quantity_text
from msvalidate_check.text import WIDTH, align_table, percent
from msvalidate_check.verdict import Difference

MAX_LINES = 14
"""Lines of a first screen."""
MAX_QUANTITIES = 3
"""Rows of quantities; `-v` and the page have all of them."""
MAX_SENTENCE = 2
"""Lines of a sentence."""
MAX_CAUSES = 4
"""Causes of a judged field; the page has all of them."""


def case_lines(found: Comparison, chosen: Choice, page: Path) -> list[str]:
    """First screen of a case that was run, with the place of its page."""
    lines = [
        *_wrapped(f"{found.case.name}: {springs_sentence(found)}"),
        *_quantity_lines(found.rows, "springs", found.case.unit),
        *_wrapped(recommend(found, chosen).sentence),
        *_need_lines(chosen, found.case.unit),
    ]
    springs = constants_lines(found.advice, found.case.unit)
    return [*lines, *springs[: MAX_LINES - 1 - len(lines)], f"page: {page}"]


def field_lines(found: Judged, page: Path, first: Sequence[str] = ()) -> list[str]:
    """First screen of a judged field: verdict, difference, causes, next step, page.

    Parameters
    ----------
    first
        Sentences on what else is known of the field, after the verdict.
    """
    causes = [each for each in found.verdict.causes if str(each)]
    some = [
        f"  {number}. {each} ({percent(each.left)} left)"
        for number, each in enumerate(causes[:MAX_CAUSES], 1)
    ]
    more = f", the likeliest {MAX_CAUSES} of {len(causes)}" if len(causes) > MAX_CAUSES else ""
    lines = [
        *_wrapped(f"{found.result.name}: {field_sentence(found)}"),
        *(line for each in first for line in _wrapped(each)),
        *_quantity_lines([found.displacement], "field", found.case.unit),
        *([f"Possible causes{more}, and the difference that each of them leaves:"] if some else []),
        *(textwrap.shorten(line.strip(), WIDTH, placeholder=" …") for line in some),
        *_wrapped(recommend_for_field(found)),
    ]
    return [*lines[: MAX_LINES - 1], f"page: {page}"]


def _wrapped(sentence: str) -> list[str]:
    return textwrap.wrap(
        sentence, WIDTH, max_lines=MAX_SENTENCE, placeholder=" …", break_on_hyphens=False
    )


def _quantity_lines(rows: Sequence[Difference], whose: str, unit: str) -> list[str]:
    """Table of the quantities that were compared, the most important ones."""
    known = [row for row in rows if math.isfinite(row.error)]
    stress = [row for row in known if row.unit == "Pa"]
    stress = [row for row in stress if row.of == POINT_STRESS] or stress
    reactions = sorted((row for row in known if row.unit == "N"), key=lambda row: -row.wanted)
    first = [row for row in known if row.quantity == DISPLACEMENT] + stress[:1] + reactions[:1]
    shown = [*first, *(row for row in known if row not in first)][:MAX_QUANTITIES]
    if not shown:
        return []
    texts = [
        (
            "largest displacement" if row.quantity == DISPLACEMENT else row.quantity,
            quantity_text(row.found, row.unit, unit),
            quantity_text(row.wanted, row.unit, unit),
            part_text(row.error, row.uncertainty),
            row.word,
        )
        for row in shown
    ]
    heads = ("quantity", whose, "elements", "difference", "verdict")
    return align_table(heads, texts, (False, True, True, True, False))


def _need_lines(chosen: Choice, unit: str) -> list[str]:
    """Table of what the targets take, of springs and of elements."""
    if not chosen.elements:
        return []
    springs = chosen.springs or (None,) * len(chosen.elements)
    rows = [
        (percent(mesh.target), *_spring_texts(need, unit), *_element_texts(mesh))
        for need, mesh in zip(springs, chosen.elements, strict=True)
    ]
    heads = ("to reach", "spacing", "springs", "time", "elements", "time")
    return align_table(heads, rows, (True, False, True, True, True, True))


def _spring_texts(need: Need | None, unit: str) -> tuple[str, str, str]:
    """Spacing, number of springs and time that a target takes."""
    if need is None:
        return "of the mesh", "", ""
    if need.where == NONE:
        return "no spacing does", "", ""
    spacing = quantity_text(need.spacing, "m", unit)
    if not need.count:
        return f"finer than tried, {spacing}".rstrip(", "), "", ""
    more = {COARSEST: " or larger", BEYOND: ", not tried"}.get(need.where, "")
    if not math.isnan(need.least):
        ends = (quantity_text(each, "m", unit).split()[0] for each in (need.least, need.most))
        more += f" ({' to '.join(ends)})"
    return f"{spacing}{more}", f"{need.count:,}", f"{need.seconds:.2g} s"


def _element_texts(need: Need) -> tuple[str, str]:
    """Number of nodes and time that a target takes."""
    if not need.count:
        return "finer than tried", ""
    fewer = " or fewer" if need.where == COARSEST else ""
    return f"{need.count:,} nodes{fewer}", f"{need.seconds:.2g} s"
